"""A mass at the tip is found with its deviation while the arm moves; none, where there is none."""

from dataclasses import replace

from hda_arm_sim.model.arm import Arm, Base
from hda_arm_sim.model.effects import Payload
from hda_arm_sim.model.files import read_arm
from hda_arm_sim.motions import motion
from hda_torque_estimator.estimating.estimator import Estimator
from hda_torque_estimator.estimating.laws import layout
from hda_torque_estimator.estimating.laws.payload import HEAVIEST
from hda_torque_estimator.simulating.closed_loop import run
import numpy as np
import pytest
from tolerated import reading
from truth import record, Reference
from truth_cases import hide

ARM = read_arm('hda_arm.yaml')


def found(mass: float, path: str = 'rich', seed: int = 1, seconds: float = 15.0):
    """Return the mass found in a recording of the independent truth, and its deviation [kg]."""
    made = motion(path, 2, seconds, 1e-3, seed)
    hidden = (hide('payload', None, mass=mass),) if mass else ()
    seen = record(hidden, Reference(made.angle, made.rate, 1e-3), seed=seed)
    estimated = Estimator(ARM).run(seen.stamps, reading(seen), seen.command)
    return estimated.tip[-1, [layout.MASS, layout.MASS_DEVIATION]]


@pytest.mark.parametrize(('mass', 'seed'), [(0.0, 1), (0.0, 2), (0.7, 3), (1.5, 4), (3.0, 5)])
def test_mass_is_found_within_its_deviation(mass, seed):
    value, deviation = found(mass, seed=seed)
    assert abs(value - mass) < 3.0 * deviation
    assert deviation < 0.25
    assert (value > 3.0 * deviation) == (mass > 0.0)


def test_without_motion_nothing_is_known_of_a_mass():
    value, deviation = found(1.0, 'standstill', seconds=3.0)
    assert deviation > 0.9 * HEAVIEST
    assert abs(value) < HEAVIEST


def test_weight_on_a_tilted_base_determines_the_mass_at_rest():
    tilted = replace(ARM, base=Base(tilt=0.3, direction=0.4))
    carrying = tilted.with_effect(Payload(mass=1.0))
    made = run(carrying, tilted, motion('standstill', 2, 6.0, 1e-3, 1), 1)
    stamps = np.round(made.time * 1e9).astype(np.int64)
    value, deviation = Estimator(tilted).run(stamps, made.reading, made.command).tip[
        -1, [layout.MASS, layout.MASS_DEVIATION]]
    assert value == pytest.approx(1.0, abs=0.15)
    assert deviation < 0.3


def test_known_mass_is_no_mass_beyond_the_model():
    known = ARM.with_effect(Payload(mass=2.0))
    made = run(known, known, motion('sine', 2, 8.0, 1e-3, 2), 2)
    stamps = np.round(made.time * 1e9).astype(np.int64)
    tip = Estimator(known).run(stamps, made.reading, made.command).tip[-1]
    assert abs(tip[layout.MASS]) < 2.0 * tip[layout.MASS_DEVIATION]


def test_single_joint_carries_a_mass():
    single = Arm(ARM.joints[:1], replace(ARM.links, length2=0.0, p2=0.0, p3=0.0, second=0.0))
    carrying = single.with_effect(Payload(mass=3.0))
    made = run(carrying, single, motion('sine', 1, 10.0, 1e-3, 3), 3)
    stamps = np.round(made.time * 1e9).astype(np.int64)
    tip = Estimator(single).run(stamps, made.reading, made.command).tip[-1]
    assert abs(tip[layout.MASS] - 3.0) < 3.0 * tip[layout.MASS_DEVIATION]
