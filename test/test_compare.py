"""Two bags laid over each other: clocks are found again, and so is what was hidden in one."""

from hda_msgs_json.samples import JointSamples
from hda_torque_estimator.comparison.align import align, Alignment
from hda_torque_estimator.comparison.signals import Bag, bag_of, CompareError
import numpy as np
from numpy.typing import NDArray
import pytest

Array = NDArray[np.float64]
EPOCH = 1_700_000_000_000_000_000
NOISE = 2e-4
RATE = 500.0
SEEDS = range(20)


def motion(seed: int, time: Array) -> Array:
    """Return two angles [rad] that move in their own ways, (k, 2)."""
    random = np.random.default_rng(seed)
    angle = np.zeros((len(time), 2))
    for column in (0, 1):
        for frequency in random.uniform(0.1, 1.5, 6):
            angle[:, column] += random.uniform(0.05, 0.2) * np.sin(
                2.0 * np.pi * (frequency * time + random.random()))
    return angle


def bag(seed: int, *, noise_seed: int = 0, offset: float = 0.0, drift: float = 0.0,
        duration: float = 20.0, rate: float = RATE, noise: float = NOISE,
        added: Array | None = None) -> Bag:
    """Return a recording of a motion that began `offset` before it, by a clock that drifts."""
    random = np.random.default_rng((seed, noise_seed))
    time = np.arange(round(duration * rate)) / rate
    position = motion(seed, offset + (1.0 + drift) * time)
    position += noise * random.normal(size=position.shape)
    if added is not None:
        position[:, 0] += added
    velocity = np.gradient(position, axis=0) * rate
    stamps = EPOCH + np.round(1e9 * time).astype(np.int64)
    return bag_of(f'bag{noise_seed}', {'/joint_states': JointSamples(
        stamps, ('joint1', 'joint2'), position, velocity, np.full_like(position, np.nan))})


def aligned(first: Bag, second: Bag, mode: str = 'drift') -> Alignment:
    """Return the alignment by all common signals."""
    return align(first, second, sorted(first.signals.keys() & second.signals.keys()), mode)


def clocks(seed: int) -> tuple[float, float]:
    """Return an offset [s] and a drift that no two seeds share."""
    random = np.random.default_rng((seed, 99))
    return float(random.uniform(-4.0, 4.0)), float(random.uniform(-3e-4, 3e-4))


def test_offset_and_drift_lie_within_their_intervals_as_often_as_said():
    inside = np.zeros(2)
    for seed in SEEDS:
        offset, drift = clocks(seed)
        start = max(0.0, -offset)
        found = aligned(bag(seed, noise_seed=1, offset=start),
                        bag(seed, noise_seed=2, offset=start + offset, drift=drift))
        truth = np.array([offset + drift * found.middle, drift])
        half = found.quantile * np.sqrt(np.diag(found.covariance))
        missed = np.abs(np.array([found.shift, found.drift]) - truth)
        inside += missed <= half
        assert (missed < 3.0 * half).all()
        assert half[0] < 0.005 / RATE
        assert half[1] < 2e-6
    assert (inside >= 0.75 * len(SEEDS)).all()


@pytest.mark.parametrize('rate', [125.0, 1000.0])
def test_an_offset_is_found_between_recordings_of_two_rates(rate):
    found = aligned(bag(3, noise_seed=1), bag(3, noise_seed=2, offset=2.34567, rate=rate),
                    'offset')
    assert found.drift == 0.0
    assert found.offset == pytest.approx(2.34567, abs=2e-4)


def test_a_copy_lies_exactly_over_the_recording():
    found = aligned(bag(5), bag(5))
    assert abs(found.offset) < 1e-9
    assert abs(found.drift) < 1e-9


def test_times_go_to_the_other_bag_and_back():
    found = Alignment('drift', 1.5, 2e-3, 7.0, np.zeros((2, 2)), 0.0)
    time = np.linspace(0.0, 20.0, 5)
    np.testing.assert_allclose(found.to_second(found.to_first(time)), time, atol=1e-12)
    assert found.to_first(np.zeros(1))[0] == pytest.approx(found.offset)


def test_stamps_are_believed_when_told_so():
    found = aligned(bag(1), bag(2), 'none')
    assert (found.offset, found.drift) == (0.0, 0.0)


def test_other_motions_are_not_aligned():
    with pytest.raises(CompareError, match='cannot be aligned.*--align none'):
        aligned(bag(1), bag(2))


def test_bags_that_stand_still_are_not_aligned():
    still = [bag_of('still', {'js': JointSamples(
        EPOCH + np.arange(2000) * 2_000_000, ('joint1',), *(
            np.random.default_rng(seed).normal(size=(3, 2000, 1))))}) for seed in (1, 2)]
    with pytest.raises(CompareError, match='none of the 3 common signals moves'):
        aligned(*still)
