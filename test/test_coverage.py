"""A 90 % interval holds 85 to 95 % of the truth, at rest and moving, where tolerances hold."""

from functools import cache
from typing import NamedTuple

from hda_arm_sim.model.files import read_arm
from hda_torque_estimator.estimating.estimator import Estimator
from hda_torque_estimator.estimating.laws import layout
import numpy as np
from numpy.typing import NDArray
import pytest
from tolerated import DT, pushed, reading, tolerated

ARM = read_arm('hda_arm.yaml')
WITHIN = 1.645                  # deviations of a 90 % interval
ELLIPSE = 4.605                 # squared deviations of a 90 % ellipse in the plane
BEGUN = 500                     # samples until filters have settled
CASES = {'rest': [('standstill', seed, 2.0) for seed in range(200, 216)],
         'moving': [(path, seed, 12.0) for path, first in (('rich', 220), ('sine', 230),
                                                           ('turn', 240))
                    for seed in range(first, first + 5)]}


class Held(NamedTuple):
    """Shares of samples whose truth lies within the interval."""

    torque: float
    external: float
    force: float


@cache
def held(case: str) -> Held:
    """Return the mean shares over the recordings of a case."""
    return Held(*np.mean([_held(*each) for each in CASES[case]], axis=0))


def _held(path: str, seed: int, seconds: float) -> Held:
    force = pushed(round(seconds / DT) + 1, 15.0, np.random.default_rng([seed, 5]))
    seen = tolerated(ARM.tolerances, path, seed, seconds, force)
    found = Estimator(ARM).run(seen.stamps, reading(seen), seen.command)
    torque = np.abs(found.torque - seen.joint_torque) < WITHIN * found.torque_deviation
    external = (np.abs(found.external_torque - seen.external)
                < WITHIN * found.joints[:, :, layout.EXTERNAL_DEVIATION])
    return Held(float(torque[BEGUN:].mean()), float(external[BEGUN:].mean()),
                _inside((found.base_force - force)[BEGUN:], found.tip[BEGUN:]))


def _inside(error: NDArray[np.float64], tip: NDArray[np.float64]) -> float:
    """Return the share of force errors (k, 2) inside their ellipses."""
    known = tip[:, layout.SINGULAR] == 0.0
    covariance = tip[known, layout.BASE_COVARIANCE:layout.BASE_COVARIANCE + 4]
    inverse = np.linalg.inv(covariance.reshape(-1, 2, 2))
    return float((np.einsum('ki,kij,kj->k', error[known], inverse, error[known])
                  < ELLIPSE).mean())


@pytest.mark.parametrize('case', list(CASES))
def test_torque_intervals_hold(case):
    assert 0.85 <= held(case).torque <= 0.95


@pytest.mark.parametrize('case', list(CASES))
def test_external_torque_intervals_hold(case):
    assert 0.85 <= held(case).external <= 0.96


@pytest.mark.parametrize('case', list(CASES))
def test_tip_force_ellipses_hold(case):
    assert 0.85 <= held(case).force <= 0.97
