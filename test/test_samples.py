"""Samples: arrays that fit together, chosen by name and joined without guessing."""

from hda_msgs_json.samples import (
    join_joint_samples, join_wrench_samples, JointSamples, NumberSamples, SamplesError,
    TextSamples, WrenchSamples)
import numpy as np
import pytest


def joints(names: str, start: int, count: int) -> JointSamples:
    """Return samples of one-letter names; the numbers say column and row."""
    stamps = np.arange(start, start + count)
    position = stamps[:, np.newaxis] + np.array([ord(name) * 100.0 for name in names])
    return JointSamples(stamps, tuple(names), position, -position, 2 * position, 'base')


def test_names_are_selected_in_the_order_asked_for() -> None:
    """Columns follow the names in every array; the rest stays."""
    chosen = joints('abc', 5, 3).select(['c', 'a'])
    assert (chosen.names, chosen.frame_id, list(chosen.stamps)) == (('c', 'a'), 'base', [5, 6, 7])
    np.testing.assert_array_equal(chosen.position, joints('ca', 5, 3).position)
    np.testing.assert_array_equal(chosen.effort, joints('ca', 5, 3).effort)


def test_missing_names_are_named_with_the_present_ones() -> None:
    """The error says what lacks and what is there."""
    with pytest.raises(SamplesError, match="have no 'x', 'y'; they name 'a', 'b'"):
        joints('ab', 0, 1).select(['x', 'a', 'y'])
    with pytest.raises(SamplesError, match='they name nothing'):
        joints('', 0, 1).select(['x'])


def test_rows_are_views() -> None:
    """A slice of a recording costs no copy."""
    samples = joints('ab', 0, 10)
    part = samples.rows(slice(2, 5))
    assert list(part.stamps) == [2, 3, 4]
    assert np.shares_memory(part.velocity, samples.velocity)


def test_joined_parts_keep_their_names_apart() -> None:
    """Each part fills the columns of its names; the others are NaN there."""
    joined = join_joint_samples([joints('ab', 0, 2), joints('ca', 10, 1)])
    assert joined.names == ('a', 'b', 'c')
    assert list(joined.stamps) == [0, 1, 10]
    np.testing.assert_array_equal(joined.select('ab').rows(slice(0, 2)).position,
                                  joints('ab', 0, 2).position)
    np.testing.assert_array_equal(np.isnan(joined.effort), [[0, 0, 1], [0, 0, 1], [0, 1, 0]])
    assert len(join_joint_samples([])) == len(join_wrench_samples([])) == 0


def test_wrenches_of_two_frames_are_not_joined() -> None:
    """Forces in different frames are no one signal; an empty part has no say."""
    base, tool, empty = (
        WrenchSamples(np.arange(n), frame, np.ones((n, 3)), np.ones((n, 3)))
        for n, frame in ((2, 'base'), (1, 'tool'), (0, 'nowhere')))
    assert join_wrench_samples([empty, base, base]).frame_id == 'base'
    with pytest.raises(SamplesError, match='must be in one frame'):
        join_wrench_samples([base, tool])


@pytest.mark.parametrize('make, error', [
    (lambda: JointSamples(np.arange(2), ('a',), *np.zeros((3, 2, 2))),
     r'JointSamples.position must have the shape \(2, 1\) \(stamps, names\), got \(2, 2\)'),
    (lambda: WrenchSamples(np.arange(2), '', np.zeros((2, 3)), np.zeros((3, 3))),
     r'WrenchSamples.torque must have the shape \(2, 3\) .* got \(3, 3\)'),
    (lambda: TextSamples(np.arange(2), ('a',)), 'for each of 2 stamps, got 1'),
    (lambda: NumberSamples(np.arange(2), np.zeros(3)), r'for each of 2 stamps, .* shape \(3,\)'),
])
def test_arrays_that_do_not_fit_are_refused(make: object, error: str) -> None:
    """The field, the shape that is due and the shape that came are named."""
    with pytest.raises(SamplesError, match=error):
        make()
