"""Samples whose stamps jitter or are lost come onto the even grid of their clock."""

from hda_arm_sim.model.files import read_arm
from hda_msgs_json.samples import JointSamples
from hda_torque_estimator.measurements.sample_grid import measurement_from
import numpy as np
import pytest

ARM = read_arm('hda_arm.yaml')
NAMES = ('joint1', 'joint2', 'joint1_motor', 'joint2_motor')


def test_jittering_stamps_stay_on_the_grid():
    """A period that is off by a hundred millionth is off by a sample after an hour or two."""
    jitter = 4e3 * np.random.default_rng(1).standard_normal(60_000)
    stamps = (1_000_000 * np.arange(60_000) + jitter).astype(np.int64)
    keep = np.random.default_rng(2).random(60_000) > 0.01
    keep[[0, -1]] = True
    count = int(keep.sum())
    made = measurement_from(ARM.labels, JointSamples(
        stamps[keep], NAMES, np.zeros((count, 4)), np.zeros((count, 4)), np.zeros((count, 4))))
    assert len(made.command) == 60_000
    assert made.absent == tuple(np.flatnonzero(~keep).tolist())


@pytest.mark.parametrize('period', [1_000_000, 3_333_333, 8_000_000])
@pytest.mark.parametrize('late', [0.05, 0.15])
def test_stamps_of_a_host_that_come_late_stay_on_the_grid(period, late):
    """The first two samples say little: their lateness was taken for a part of the period."""
    for seed in range(40):
        more = late * np.abs(np.random.default_rng(seed).standard_normal(4000))
        stamps = (period * (np.arange(4000) + np.minimum(more, 0.45))).astype(np.int64)
        nothing = np.zeros((4000, 4))
        made = measurement_from(ARM.labels, JointSamples(stamps, NAMES, nothing, nothing, nothing))
        assert len(made.command) == 4000, seed
        assert made.absent == ()


@pytest.mark.parametrize('share', [0.15, 0.2])
def test_stamps_that_jitter_by_much_keep_their_period(share):
    """A line through few of them shows less than the mean of all their intervals."""
    random = np.random.default_rng(11)
    off = []
    for _ in range(60):
        late = 1.0 + share * random.standard_normal(4000)
        stamps = np.maximum.accumulate((4e6 * (np.arange(4000) + late)).astype(np.int64))
        stamps += np.arange(4000)
        swing = np.sin(1e-9 * stamps)
        made = measurement_from(('joint1',), JointSamples(
            stamps, ('joint1', 'joint1_motor'), np.column_stack([swing, 100.0 * swing]),
            np.full((4000, 2), np.nan), np.column_stack([swing, swing])))
        off.append(abs(len(made.command) - 4000))
    assert max(off) <= 1                                # of the first and the last stamp


@pytest.mark.parametrize('rate', [125.0, 300.0, 450.0])
def test_stamps_in_whole_milliseconds_have_the_period_of_their_samples(rate):
    stamps = np.floor(1e3 * np.arange(4000) / rate).astype(np.int64) * 1_000_000
    nothing = np.zeros((4000, 4))
    made = measurement_from(ARM.labels, JointSamples(stamps, NAMES, nothing, nothing, nothing))
    assert made.dt == pytest.approx(1.0 / rate, rel=1e-4)
