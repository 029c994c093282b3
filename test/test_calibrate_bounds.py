"""No number that a calibration finds is one that the arm file refuses; at a bound it is said."""

from dataclasses import replace
import math

from hda_arm_sim.foundation.parameter import ParameterError
from hda_arm_sim.model.arm import Arm
from hda_arm_sim.model.effects import ClockSkew, TorsionalHysteresis
from hda_arm_sim.model.files import arm_from_text, read_arm
from hda_arm_sim.model.parts import Base
from hda_arm_sim.model.writing import arm_to_text
from hda_torque_estimator.calibrate.calibration import one_joint
from hda_torque_estimator.calibrate.fitting import laws, referenced_terms
from hda_torque_estimator.calibrate.fitting.arm_numbers import number, with_numbers
from hda_torque_estimator.least_squares.term import Term
import numpy as np
import pytest

LARGEST = 400.0             # torque of a large joint [N*m]
FAR = 100.0                 # where a search without a bound ends, in its unknowns


@pytest.fixture(scope='module')
def joint() -> Arm:
    """Return one joint whose numbers are close to their bounds already."""
    arm = one_joint(read_arm('hda_arm.yaml'), 'joint1')
    axis, = arm.joints
    torsion = replace(axis.torsion, flexspline_stiffness=9e6, flexspline_curvature=9.0,
                      damping=9e3)
    arm = replace(arm, joints=(replace(axis, torsion=torsion),))
    arm = arm.with_effect(TorsionalHysteresis(level=30.0, width=9e-3), 'joint1')
    return arm.with_effect(ClockSkew(skew=0.0999), 'joint1')


def every_term(arm: Arm) -> list[Term]:
    """Return all that any calibration looks for."""
    makers = (*referenced_terms.TORSION, *referenced_terms.TORSION_MORE,
              *referenced_terms.motor_always(300.0, slides=True), *referenced_terms.motor_more(),
              referenced_terms.cogging(14.0))
    return [*(make(arm, LARGEST) for make in makers),
            laws.stiffness(arm), laws.curvature(arm), laws.segments(arm, LARGEST),
            laws.soft_wind_up(arm), laws.damping(arm), laws.loop(arm), laws.skew(arm),
            *laws.waves(arm, (1.0, 2.0, 3.0, 0.01, 2.02))]


@pytest.mark.parametrize('end', ['low', 'high'])
def test_a_search_at_its_end_is_an_arm(end, joint):
    for term in every_term(joint):
        values = np.clip(term.bounds()[end == 'high'], -FAR, FAR)
        found = term.at(values).on(joint)
        numbers = [number(name, value, 1.0) for name, value in term.at(values).numbers().items()]
        written = with_numbers(joint, 'joint1', numbers, 'a test')
        assert arm_from_text(arm_to_text(written), 'it') == written
        assert found.record() is not None


def test_a_loop_of_a_large_joint_is_a_number(joint):
    """A joint of 100 N*m may have a loop of 79 N*m; this is more than 50, and not a bound."""
    assert not number('torsional_hysteresis.level', 79.2, 1.0).at_bound


def test_a_number_at_its_bound_says_so():
    found = number('clock_skew.skew', 0.2, 1e-3)
    assert (found.value, found.high, found.at_bound) == (0.1, 0.1, True)
    assert 'at its bound' in str(found)
    arm = with_numbers(read_arm('hda_arm.yaml'), 'joint1', [found], 'a test')
    assert 'at its bound' in dict(arm.provenance)['joint1.clock_skew.skew']
    assert 'bound' not in str(number('clock_skew.skew', 0.01, 1e-3))


def test_asymmetric_friction_is_no_larger_than_the_arm_file_takes():
    assert number('asymmetric_friction.asymmetry', 1.3, 0.1).value == 0.95


def test_a_bound_that_is_rounded_is_the_bound():
    """No sentence says that 1.5708 must lie in [0, 1.5708]."""
    assert Base(tilt=1.5708).tilt == math.pi / 2
    with pytest.raises(ParameterError, match=r'must lie in \[0, 1\.5708\] rad .* got 1\.571'):
        Base(tilt=1.571)
