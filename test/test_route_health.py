"""What goes wrong while running is said in words, and nothing is said of a healthy arm."""

from hda_arm_sim.model.files import read_arm
from hda_arm_sim.motions import motion
from hda_torque_estimator.estimating.estimator import Estimator
from hda_torque_estimator.estimating.laws import layout
from hda_torque_estimator.estimating.route_health import health_in_words
import numpy as np
import pytest
from tolerated import reading, tolerated
from truth import record, Reference, TruthRecord
from truth_cases import hide

ARM = read_arm('hda_arm.yaml')


def seen_with(effect: str, **parameters: float) -> TruthRecord:
    """Return a recording of the independent truth with an effect of joint1."""
    made = motion('rich', 2, 15.0, 1e-3, 4)
    return record((hide(effect, **parameters),), Reference(made.angle, made.rate, 1e-3), seed=4)


def words(seen: TruthRecord, readings: np.ndarray | None = None) -> list[str]:
    """Return what is said of both joints after a recording."""
    made = Estimator(ARM)
    made.run(seen.stamps, reading(seen) if readings is None else readings, seen.command)
    return [health_in_words(joint, ARM.tolerances_of(joint.label), memory[layout.FUSION:])
            for joint, memory in zip(ARM.joints, made.memory)]


@pytest.mark.parametrize(('effect', 'parameters', 'said'), [
    ('kinematic_error', {'amplitude_2': 1e-4, 'phase_2': 0.7}, 'the kinematic map is out of date'),
    ('link_encoder_eccentricity', {'amplitude_1': 2e-4, 'phase_1': 0.3},
     'the disc of the link encoder moved'),
    ('stiffness_error', {'relative_error': -0.15}, 'the stiffness changed by -1'),
    ('coulomb_friction', {'level': 0.02}, 'dry friction changed by +4'),
    ('torque_saturation', {'limit': 0.12}, 'torsion and motor torque differ')])
def test_what_changed_is_named_and_the_other_joint_is_well(effect, parameters, said):
    first, second = words(seen_with(effect, **parameters))
    assert said in first
    assert second == 'well'


def test_slipped_encoder_is_named():
    seen = tolerated(ARM.tolerances, 'rich', 306, 15.0)
    slipped = reading(seen)
    assert words(seen) == ['well', 'well']
    slipped[5000:, 1, 1] += 2e-4
    first, second = words(seen, slipped)
    assert first == 'well'
    assert 'an encoder slipped: the zero of the torsion moved by -' in second


@pytest.mark.parametrize('seed', range(300, 304))
def test_arms_within_their_tolerances_are_well(seed):
    assert words(tolerated(ARM.tolerances, 'rich', seed, 12.0)) == ['well', 'well']


def test_before_the_arm_has_moved_nothing_is_known():
    seen = tolerated(ARM.tolerances, 'standstill', 305, 2.0)
    assert words(seen) == ['nothing learnt yet'] * 2
