"""Find what no fixed grid can start from: effects at a bound, at a time, at a frequency."""

from dataclasses import replace

from hda_arm_sim.model.files import read_arm
from hda_arm_sim.motions import motion
from hda_torque_estimator.diagnosis.diagnose import diagnose
from hda_torque_estimator.diagnosis.measurement import Measurement
import numpy as np
import pytest
from truth import draw, record

ARM = read_arm('hda_arm.yaml')
DECOUPLED = replace(ARM, links=replace(ARM.links, coupled=0.0))


def measured(hidden, seed, duration=30.0):
    """Return the measurement of an arm with hidden effects in the motion that shows most."""
    asked = motion('rich', 2, duration, 1e-3, seed)
    made = record(hidden, motion_angle=asked.angle, motion_rate=asked.rate, dt=1e-3, seed=seed)
    return Measurement(ARM.labels, 1e-3, np.stack([made.motor_angle, made.link_angle], axis=2),
                       made.command)


def named(diagnosis):
    """Return what a diagnosis names: effects and joints."""
    return [(found.effect, found.joint) for found in diagnosis.findings]


@pytest.mark.parametrize(('hides', 'arm', 'share'), [(True, ARM, -1.0), (False, DECOUPLED, 1.0)])
def test_coupling_is_found_both_ways(hides, arm, share):
    """An arm that is given coupled and is not, and one that is not and should be."""
    hidden = [draw('inertial_coupling', np.random.default_rng(1))] if hides else []
    found = diagnose(measured(hidden, 110), arm).diagnosis
    assert named(found) == [('inertial_coupling', None)]
    assert found.findings[0].parameters['share'].value == pytest.approx(share, abs=0.03)
    assert found.gain.removed > 0.98
