"""How a shaft speeds up and how a torsion scatters: from samples alone, on whatever clock."""

from hda_torque_estimator.estimating.laws import fusion_memory as of
from hda_torque_estimator.estimating.laws.shaft_motion import begin_motion, follow_motion
from hda_torque_estimator.estimating.laws.torsion_scatter import follow_twist, forget_twist
import numpy as np
import pytest

DT, WINDOW = 0.01, 0.01         # [s]
SAMPLES = 3000
BEGUN = 500                     # samples after which a clock is chosen
EVEN = DT * np.arange(SAMPLES)
LATE = 1e-3 * np.abs(np.random.default_rng(1).standard_normal(SAMPLES))     # as of a host [s]
WAVE = 40.0, 3.0                # amplitude of a shaft [rad], and how fast it swings [rad/s]


def angle(time: np.ndarray) -> np.ndarray:
    """Return where the shaft is at times (k,) [rad]."""
    return WAVE[0] * np.sin(WAVE[1] * time)


def error(stamps: np.ndarray, taken: np.ndarray) -> float:
    """Return the rms error of accelerations of angles taken at times, over their rms."""
    memory = np.zeros(of.MEMORY)
    begin_motion(memory, angle(taken)[0])
    found = [follow_motion(memory, at, WINDOW, dt).now
             for at, dt in zip(angle(taken)[1:], np.diff(stamps))]
    true = -WAVE[1] ** 2 * angle(taken)[1:]
    return float(np.std((np.array(found) - true)[BEGUN:]) / np.std(true[BEGUN:]))


def test_a_steady_acceleration_is_estimated_without_lag():
    memory = np.zeros(of.MEMORY)
    begin_motion(memory, 0.0)
    for time in EVEN[1:200]:
        reported = follow_motion(memory, 0.5 * 30.0 * time ** 2, WINDOW, DT)
    assert reported.now == pytest.approx(30.0)
    assert reported.lag == pytest.approx(0.0, abs=1e-6)


def test_the_lag_behind_a_steady_change_is_estimated():
    memory = np.zeros(of.MEMORY)
    begin_motion(memory, 0.0)
    for time in EVEN[1:200]:
        reported = follow_motion(memory, 50.0 * time ** 3 / 6.0, WINDOW, DT)
    assert 50.0 * time - reported.now == pytest.approx(reported.lag, rel=0.5)
    assert reported.lag > 0.0


@pytest.mark.parametrize(('stamps', 'taken'), [
    (EVEN + LATE, EVEN), (EVEN + LATE, EVEN + LATE),
    (np.delete(EVEN + LATE, np.s_[900::37]), np.delete(EVEN, np.s_[900::37]))],
    ids=['a busy host', 'an uneven encoder', 'a busy host that loses samples'])
def test_the_clock_is_found_by_which_samples_were_taken(stamps, taken):
    assert error(stamps, taken) < 2.0 * error(EVEN, EVEN)


def test_a_clock_that_is_wrong_would_cost_much():
    """By stamps, late samples of a host cannot be distinguished from a shaft that shakes."""
    speed = np.diff(angle(EVEN)) / np.diff(EVEN + LATE)
    shaken = np.diff(speed) / DT
    assert np.std(shaken) > 2.0 * WAVE[0] * WAVE[1] ** 2


def scatter(torsion: np.ndarray) -> float:
    """Return the deviation that is learnt of a torsion (k,) [rad]."""
    memory = np.zeros(of.MEMORY)
    forget_twist(memory)
    for each in torsion:
        found = follow_twist(memory, each, True, 1e-3)
    return float(np.sqrt(found))


def test_samples_scatter_as_much_as_they_do():
    noise = 1e-5 * np.random.default_rng(2).standard_normal(SAMPLES)
    push = 1e-3 * np.minimum(np.arange(SAMPLES) / 500.0, 1.0)   # half a second to its full size
    assert scatter(noise) == pytest.approx(1e-5, rel=0.1)
    assert scatter(noise + push) == pytest.approx(1e-5, rel=0.1)
    assert scatter(push) < 1e-7


def test_nothing_is_learnt_of_a_scatter_across_a_gap_or_at_rest():
    memory = np.zeros(of.MEMORY)
    forget_twist(memory)
    for each in (0.0, 0.0, 0.0):
        follow_twist(memory, each, True, 1e-3)
    forget_twist(memory)
    assert [follow_twist(memory, each, True, 1e-3) for each in (1.0, 1.0)] == [0.0, 0.0]
    assert follow_twist(memory, 2.0, False, 1e-3) == 0.0
