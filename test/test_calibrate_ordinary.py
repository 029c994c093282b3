"""An arm is calibrated from ordinary recordings, by the command, and estimates better."""

from dataclasses import replace
import json
from pathlib import Path

from hda_arm_sim.model.arm import Arm
from hda_arm_sim.model.effects import (
    ClockSkew, KinematicError, LinkEncoderEccentricity, StribeckFriction, TorsionalHysteresis)
from hda_arm_sim.model.files import read_arm
from hda_arm_sim.motions import HOME, Motion, motion
from hda_msgs_json.bag import BagWriter
from hda_msgs_json.topics import BASE_FRAME, JOINT_STATES, REFERENCE_TIP_WRENCH
from hda_torque_estimator.cli import main
from hda_torque_estimator.estimating.estimator import Estimator, EstimatorSettings
from hda_torque_estimator.simulating.closed_loop import ClosedLoopRun, run
from hda_torque_estimator.simulating.recorded import joint_samples, on_tip
import numpy as np
import pytest

SECONDS, BEGUN = 20.0, 1000
TORSION_ALONE = EstimatorSettings(fusion=0.0)


@pytest.fixture(scope='module')
def nominal() -> Arm:
    """Return the arm that the file describes."""
    return read_arm('hda_arm.yaml')


@pytest.fixture(scope='module')
def true(nominal: Arm) -> Arm:
    """Return the arm as it is: both joints are off in all that a calibration looks for."""
    joints = []
    for joint, factor in zip(nominal.joints, (0.85, 1.12)):
        stiffness = factor * joint.torsion.flexspline_stiffness
        joints.append(replace(
            joint, torsion=replace(joint.torsion, flexspline_stiffness=stiffness),
            link_encoder=replace(joint.link_encoder, zero=2e-4)))
    arm = replace(nominal, joints=tuple(joints))
    for label, sign in (('joint1', 1.0), ('joint2', -1.0)):
        for effect in (
                KinematicError(amplitude_1=6e-5, phase_1=0.5, amplitude_2=1.2e-4, phase_2=-sign),
                LinkEncoderEccentricity(amplitude_1=2e-4, phase_1=0.7 * sign),
                ClockSkew(skew=2e-4 * sign), StribeckFriction(excess=0.02, speed=8.0),
                TorsionalHysteresis(level=0.5, width=1.5e-4)):
            arm = arm.with_effect(effect, label)
    return arm


def moved(true: Arm, nominal: Arm, seed: int, pull: float) -> ClosedLoopRun:
    """Return a run in which the tip is pulled slowly to and fro [N], or not."""
    asked = motion('rich', 2, SECONDS, 1e-3, seed)
    turning = 2.0 * np.pi * asked.time / SECONDS
    force = pull * np.stack([np.sin(3.0 * turning), np.sin(2.0 * turning + 1.0)], axis=1)
    return run(true, nominal, Motion(asked.time, asked.angle, asked.rate, force), seed)


def stamps_of(made: ClosedLoopRun) -> np.ndarray:
    """Return the stamps of a run [ns]."""
    return np.round(made.time * 1e9).astype(np.int64) + 1


def bag_of(path: Path, arm: Arm, made: ClosedLoopRun, *, sensor: bool) -> str:
    """Write a run as a driver records it, with a force sensor or without."""
    stamps = stamps_of(made)
    with BagWriter(path, {}) as bag:
        bag.write_joint_states(JOINT_STATES,
                               joint_samples(arm, stamps, made.reading, made.command))
        if sensor:
            bag.write_wrenches(REFERENCE_TIP_WRENCH, on_tip(stamps, BASE_FRAME, made.force))
    return str(path)


def off(arm: Arm, made: ClosedLoopRun) -> np.ndarray:
    """Return the mean absolute error of the torques by torsion alone (n,) [N*m]."""
    found = Estimator(arm, TORSION_ALONE).run(stamps_of(made), made.reading)
    return np.abs(found.torque - made.joint_torque)[BEGUN:].mean(axis=0)


def test_ordinary_recordings_calibrate_an_arm(true, nominal, tmp_path, capsys):
    bags = [bag_of(tmp_path / name, nominal, moved(true, nominal, seed, pull), sensor=pull > 0.0)
            for name, seed, pull in (('free', 1, 0.0), ('pulled', 2, 25.0))]
    out = tmp_path / 'calibrated.yaml'
    assert main(['calibrate', *bags, '--arm', 'hda_arm.yaml', '--out', str(out), '--json']) == 0
    report = json.loads(capsys.readouterr().out)
    arm, other = read_arm(str(out)), moved(true, nominal, 3, 15.0)
    before, after = off(nominal, other), off(arm, other)
    assert (after < before / 8.0).all(), (before, after)
    assert (after < 0.12).all(), after
    for joint, known in zip(arm.joints, true.joints):
        assert joint.torsion.flexspline_stiffness == pytest.approx(
            known.torsion.flexspline_stiffness, rel=0.05)
        skew = arm.effect('clock_skew', joint.label)
        assert skew.skew == pytest.approx(true.effect('clock_skew', joint.label).skew, rel=0.1)
    assert [joint['joint'] for joint in report['joints']] == list(nominal.labels)
    for joint, home in zip(report['joints'], HOME):     # the paper's polynomial, what it leaves
        angle = home + np.linspace(-0.3, 0.3, 50)
        assert 1e-6 < np.ptp(np.polyval(joint['coefficients'][::-1], angle)) < 3e-3
        assert joint['after'] < joint['polynomial'] / 4.0
        assert arm.joint(joint['joint']).torsion.deviation == joint['after']
        own = arm.tolerances_of(joint['joint'])
        for name in ('stiffness', 'torsion_zero', 'clock_skew', 'kinematic_error'):
            assert 0.0 < getattr(own, name) <= getattr(nominal.tolerances, name)
        assert own != nominal.tolerances
    assert arm.tolerances == nominal.tolerances
    for joint in nominal.joints:
        known = joint.dry_friction * arm.tolerances_of(joint.label).dry_friction
        found = arm.effect('coulomb_friction', joint.label).level
        assert abs(found - joint.dry_friction) < 3.0 * known
    assert arm.tolerances.link_inertia == nominal.tolerances.link_inertia
    estimated = Estimator(arm).run(stamps_of(other), other.reading, other.command)
    wrong = np.abs(estimated.torque - other.joint_torque)[BEGUN:]
    assert 0.8 < (wrong < 1.645 * estimated.torque_deviation[BEGUN:]).mean() <= 1.0
    assert any(name.startswith('joint1') for name, _ in arm.provenance)
