"""A chain is calibrated from ordinary recordings: the weight of its links loads its gears."""

from dataclasses import replace

from chains import planar
from hda_arm_sim.model.arm import Arm
from hda_arm_sim.model.chain_links import ChainLinks, kept
from hda_arm_sim.model.effects import KinematicError
from hda_arm_sim.model.files import read_arm
from hda_arm_sim.model.parts import Joint, Links
from hda_arm_sim.motions import motion_of
from hda_msgs_json.bag import BagWriter
from hda_torque_estimator.calibrate.passages.loads import loads
from hda_torque_estimator.cli import main
from hda_torque_estimator.estimating.estimator import Estimator, EstimatorSettings
from hda_torque_estimator.measurements.measurement import Measurement
from hda_torque_estimator.measurements.motion import motion_of as motion_behind
from hda_torque_estimator.simulating.closed_loop import ClosedLoopRun, run
from hda_torque_estimator.simulating.recorded import write_run
import numpy as np
import pytest

COBOT = read_arm('cobot7.yaml')
LABEL, PLACE = 'joint4', 3
PAIR = Links(length1=0.3, length2=0.2, p1=2.0, p2=0.35, p3=0.3, first=4.0, second=1.0)
JOINTS = tuple(Joint(label=f'joint{j}', dry_friction=0.03) for j in (1, 2))


def moved(true: Arm, known: Arm, seed: int, seconds: float = 20.0) -> ClosedLoopRun:
    """Return a run of an arm that is moved by who knows another."""
    return run(true, known, motion_of(known, 'rich', seconds, 1e-3, seed), seed, estimator=None)


def behind(made: ClosedLoopRun, arm: Arm) -> Measurement:
    """Return a run as a recording."""
    return Measurement(arm.labels, 1e-3, np.ascontiguousarray(made.reading[:, :, :2]),
                       made.command)


def test_a_chain_in_a_plane_asks_of_its_gears_what_two_links_ask():
    flat = Arm(JOINTS, PAIR)
    leaning = replace(flat, base=replace(flat.base, tilt=0.3, direction=0.4))
    space = replace(leaning, links=ChainLinks(kept(planar(PAIR)), 'tip', flat.labels))
    motion = motion_behind(behind(moved(flat, flat, 1, 5.0), flat), flat)
    wrench = np.zeros((len(motion.state), 6))
    wrench[:, :2] = 10.0 * np.sin(np.outer(np.arange(len(wrench)), (0.01, 0.02)))
    np.testing.assert_allclose(loads(space, motion, wrench).torque,
                               loads(leaning, motion, wrench).torque, atol=1e-9)


def test_the_weight_of_the_links_calibrates_a_gear(tmp_path, capsys):
    joint = COBOT.joint(LABEL)
    softer = replace(joint.torsion, flexspline_stiffness=0.85 * joint.torsion.flexspline_stiffness)
    joints = [replace(one, torsion=softer) if one is joint else one for one in COBOT.joints]
    true = replace(COBOT, joints=tuple(joints)).with_effect(
        KinematicError(amplitude_2=8e-5, phase_2=0.6), LABEL)
    with BagWriter(tmp_path / 'run', {}) as bag:
        write_run(bag, COBOT, moved(true, COBOT, 1))
    out = tmp_path / 'calibrated.yaml'
    assert main(['calibrate', str(tmp_path / 'run'), '--arm', 'cobot7.yaml', '--joint', LABEL,
                 '--out', str(out)]) == 0
    assert 'the weight on the base' in capsys.readouterr().out
    found, other = read_arm(str(out)), moved(true, COBOT, 2, 10.0)
    assert found.links == COBOT.links
    assert found.joint(LABEL).torsion.flexspline_stiffness == pytest.approx(
        softer.flexspline_stiffness, rel=0.04)
    stamps = np.round(other.time * 1e9).astype(np.int64) + 1
    before, after = (np.abs(Estimator(arm, EstimatorSettings(fusion=0.0)).run(
        stamps, other.reading).torque - other.joint_torque)[1000:, PLACE].mean()
        for arm in (COBOT, found))
    assert after < 0.25 * before, (before, after)
