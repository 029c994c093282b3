"""`hda simulate`: the arm under its controller, offline, to a bag with the truth beside it."""

import argparse
from collections.abc import Iterator
import json
from pathlib import Path

from hda_arm_sim.live import SimulationSettings
from hda_arm_sim.model.arm import Arm
from hda_arm_sim.model.effects import Effect
from hda_arm_sim.model.files import read_arm, read_effects
from hda_arm_sim.model.kernel import LINK_ANGLE
from hda_arm_sim.model.writing import arm_to_text
from hda_arm_sim.motion_file import read_motion
from hda_arm_sim.motions import Motion, motion_of, MotionError, MOTIONS, pushed_link
from hda_arm_sim.simulate import checked
from hda_msgs_json.bag import BagWriter
import numpy as np

from .out_option import add_out
from .outcome import Outcome
from .progress import progress
from .remarks import remark_on
from ..controlling.controller import bearable, ControllerSettings
from ..simulating.closed_loop import ClosedLoopRun, run
from ..simulating.recorded import write_run

_USUAL = 60.0           # duration of a motion by its name [s]
_AT_LIMIT, _OFF = 0.05, 0.1     # choice: share of samples; what one sees of a motion [rad]
EXAMPLES = (
    'hda simulate --arm hda_arm.yaml --motion rich --duration 30 --out bag',
    'hda simulate --arm hda_arm.yaml --effects hidden.yaml --motion rich --out bag',
    'hda simulate --arm hda_arm.yaml --motion push --torque-feedback -1 --out bag',
    'hda simulate --arm cobot7.yaml --motion push --push-at joint3 --out bag')


def configure(parser: argparse.ArgumentParser) -> None:
    """Declare the arguments."""
    motions = '; '.join(f'{name}: {recipe.meaning}' for name, recipe in MOTIONS.items())
    parser.add_argument('--arm', required=True, help='model file, or the name of a shipped one')
    parser.add_argument('--effects', metavar='FILE',
                        help='effects that the arm has and its controller does not know')
    parser.add_argument('--motion', required=True, metavar='NAME',
                        help=f'{motions}; or a file that hda plan has written')
    parser.add_argument('--duration', type=float, metavar='S',
                        help='seconds; 60 unless given, or all of the file')
    parser.add_argument('--rate', type=float, default=1000.0, metavar='HZ',
                        help='samples; the control loop runs at 1 kHz or above')
    parser.add_argument('--seed', type=int, default=0, metavar='N', help='of motion and noise')
    parser.add_argument('--push-at', metavar='JOINT',
                        help='the motion pushes the end of the link of this joint, not the tip')
    parser.add_argument('--torque-feedback', type=float, default=0.0, metavar='K_J',
                        help='-1 follows a push, between 0 and 1 rejects it')
    add_out(parser, 'BAG', 'bag to write')


def execute(options: argparse.Namespace) -> Outcome:
    """Simulate and write; raises the project's errors."""
    known = checked(read_arm(options.arm))
    true = _with_effects(known, options.effects)
    settings = bearable(known, ControllerSettings(torque_feedback=options.torque_feedback))
    sampled = SimulationSettings(rate=options.rate, seed=options.seed)
    asked = _pushing(options, known, _motion(options, known, 1.0 / sampled.rate))
    about = {'arm': arm_to_text(known), 'seed': str(options.seed),
             'parameters': json.dumps({'motion': options.motion, 'rate': options.rate,
                                       'push_at': options.push_at,
                                       'torque_feedback': options.torque_feedback}),
             'effects': json.dumps([[placed.effect.name, placed.joint,
                                     dict(zip(_names(placed.effect), placed.effect.values()))]
                                    for placed in true.effects])}
    with BagWriter(options.out, about, force=options.force) as bag, progress(
            f'simulating {asked.time[-1]:.0f} s of motion', quiet=options.json) as notify:
        made = run(true, known, asked, options.seed, controller=settings)
        for line in _weak(known, asked, made):
            remark_on(line)
        notify('writing')
        write_run(bag, known, made)
    return _outcome(options.out, asked, made)


def _motion(options: argparse.Namespace, arm: Arm, dt: float) -> Motion:
    """Return the motion of a name or a file; raises MotionError."""
    file = Path(options.motion)
    if options.motion not in MOTIONS and (file.suffix == '.csv' or file.is_file()):
        return read_motion(file, arm.labels, dt, options.duration)
    duration = _USUAL if options.duration is None else options.duration
    return motion_of(arm, options.motion, duration, dt, options.seed)


def _pushing(options: argparse.Namespace, arm: Arm, asked: Motion) -> Motion:
    """Return the motion with its push where it is asked for; raises MotionError."""
    if options.push_at is None:
        return asked
    if not asked.force.any():
        raise MotionError(f'--push-at needs a motion that pushes, as push does; '
                          f'{options.motion} does not within {asked.time[-1]:g} s')
    place = arm.labels.index(arm.joint(options.push_at).label) + 1
    made = asked._replace(pushed=place)
    pushed_link(arm, made)
    return made


def _with_effects(arm: Arm, path: str | None) -> Arm:
    for placed in read_effects(path, arm) if path else ():
        arm = arm.with_effect(placed.effect, placed.joint)
    return arm


def _names(effect: Effect) -> list[str]:
    return [rule.name for rule in effect.declarations()]


def _weak(arm: Arm, asked: Motion, made: ClosedLoopRun) -> Iterator[str]:
    """Yield a line for each joint that leaves its motion for want of torque."""
    off = np.abs(made.state[:, :, LINK_ANGLE] - asked.angle).max(axis=0)
    limit = np.array([joint.torque_limit for joint in arm.joints])
    held = (np.abs(made.command) >= limit).mean(axis=0)
    for label, most, share, far in zip(arm.labels, limit, held, off):
        if share > _AT_LIMIT and far > _OFF:
            yield (f'{label} is up to {far:.2g} rad off its motion: {share:.0%} of the time its '
                   f'motor gives all of its {most:g} N*m')


def _outcome(path: Path, asked: Motion, made: ClosedLoopRun) -> Outcome:
    report = {'bag': str(path), 'samples': len(made.time), 'duration': float(made.time[-1]),
              'largest_joint_torque': np.abs(made.joint_torque).max(axis=0).tolist(),
              'largest_motor_torque': np.abs(made.command).max(axis=0).tolist()}
    torques = ', '.join(f'{value:.2f}' for value in report['largest_joint_torque'])
    return Outcome(f'{path}: {report["samples"]} samples, {report["duration"]:g} s, joint torques '
                   f'up to {torques} N*m', report)
