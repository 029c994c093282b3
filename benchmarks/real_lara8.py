"""One sweep of joint 3 of a LARA8: its torque from both encoders and the current, and its gear."""

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
import re
from typing import NamedTuple

from hda_arm_sim.model.arm import Arm
from hda_arm_sim.model.files import read_arm
from hda_arm_sim.model.torsion import TorsionLaw
from hda_torque_estimator.calibrate.passages.joint_recording import Measured
from hda_torque_estimator.calibrate.referenced import calibrate
from hda_torque_estimator.estimating.estimator import Estimator, EstimatorSettings
from hda_torque_estimator.least_squares.rows import rms
from hda_torque_estimator.samples.readings import by_motor, LINK_READING, MOTOR_READING
from hda_torque_estimator.significance import NORMAL_90
import numpy as np
from real_commands import (
    Floats, hda, joint_of, line, log_of, missed_by_lines, Numbers, refused, write_table)

FILE = 'neura_lara8/sweep_joint3.csv.gz'
JOINT, RATIO, TURN = 'joint3', 101, 2 ** 24
FIFTHS = 5
# Denavit and Hartenberg: a [m], alpha [rad], d [m], offset of theta [rad] of each joint.
HALF = np.pi / 2.0
LINKS = ((0.0, -HALF, 0.26, 0.0), (0.48, 0.0, 0.0, -HALF), (0.0, HALF, 0.0, HALF),
         (0.0, -HALF, 0.7, 0.0), (0.0, HALF, 0.0, 0.0), (0.0, 0.0, 0.1735, 0.0))
# The author's friction of joint 3: dry [N*m], slope, and what it grows by and bends at [s/rad].
DRY, SLOPE, GROWS, BENDS, STANDS = 6.52696, 1.14945, 12.0, 54.5, 1e-3
MAP = """
time: {{column: Timestamp, unit: s}}
joints: [joint3]{more}
each:
  ratio: 101
  motor:
    position: {{column: encoder_motorinc_3, unit: count, counts_per_turn: 16777216, zero: {motor}}}
    effort: {{column: joint_torque_current_3, side: link}}
  link:
    position: {{column: encoder_loadinc_3, unit: count, counts_per_turn: 16777216, zero: {link}}}
"""
IN_FIFTHS = '\nsplit: fifth', '  reference: reference\n'


class Way(NamedTuple):
    """An arm whose estimator uses both witnesses, or one."""

    arm: Arm
    settings: EstimatorSettings = EstimatorSettings()


def numbers(data: Path, folder: Path) -> Numbers:
    """Return what is found in the sweep, with three files of which each knows more."""
    log, arms = log_of(data / FILE), {}
    for name, more in (('new', ()), ('dry', ('--starting-torque', round(DRY / RATIO, 4)))):
        arms[name] = folder / f'lara8_{name}.yaml'
        hda('new', '--gear', 'CSG-32-100', '--ratio', RATIO, '--joints', JOINT, '--motor-inertia',
            '4e-4', '--motor-torque', 2, '--motor-counts', TURN, '--link-counts', TURN, *more,
            '--out', arms[name])
    given = {name: read_arm(str(arm)) for name, arm in arms.items()}
    given['straight'] = _straight(given['dry'])
    parts = _fifths(log, folder)
    every = np.concatenate([part.reference for part in parts])
    return {'joint': JOINT, 'seconds': float(np.ptp(log['Timestamp'])),
            'rate': float(1.0 / np.median(np.diff(log['Timestamp']))),
            'varies': float(every.std()), 'bears': float(np.abs(every).max()),
            'guessed': given['new'].joints[0].torsion.flexspline_stiffness,
            'dry': DRY / RATIO, 'by_hand': _by_hand(parts), 'disc': _disc(parts),
            'files': {name: _left_out(arm, parts) for name, arm in given.items()},
            'diagnosis': _diagnosis(data / FILE, folder, arms['new']),
            'referenced': referenced(log, folder, arms['new'])}


def _straight(arm: Arm) -> Arm:
    """Return the arm with one guessed stiffness in the place of the catalogue's law."""
    law = TorsionLaw(flexspline_stiffness=arm.joints[0].torsion.flexspline_stiffness,
                     flexspline_curvature=0.0, wave_generator_stiffness=np.inf, damping=0.0,
                     valid_torque=arm.joints[0].torsion.valid_torque)
    return replace(arm, joints=(replace(arm.joints[0], torsion=law),))


def reference(log: dict[str, Floats]) -> Floats:
    """Return the torque of the gear: the controller's less friction and the force at the tip."""
    speed = log[f'target_joint_velocity_{JOINT[-1]}']
    size = DRY + SLOPE * (GROWS * np.abs(speed) + np.tanh(BENDS * np.abs(speed)))
    friction = np.where(np.abs(speed) < STANDS, 0.0, np.sign(speed) * size)
    return np.asarray(log['target_joint_torque_3'] - friction - _by_force(log))


def _by_force(log: dict[str, Floats]) -> Floats:
    """Return the torque of joint 3 by what the sensor at the flange reads."""
    frames = [np.tile(np.eye(4), (len(log['Timestamp']), 1, 1))]
    for number, (a, alpha, d, offset) in enumerate(LINKS, 1):
        theta = log[f'joint_angles_{number}'] + offset
        cos, sin, zero = np.cos(theta), np.sin(theta), np.zeros_like(theta)
        step = np.array([
            [cos, -sin * np.cos(alpha), sin * np.sin(alpha), a * cos],
            [sin, cos * np.cos(alpha), -cos * np.sin(alpha), a * sin],
            [zero, zero + np.sin(alpha), zero + np.cos(alpha), zero + d],
            [zero, zero, zero, zero + 1.0]])
        frames.append(frames[-1] @ step.transpose(2, 0, 1))
    tip, base = frames[6], frames[2]
    force, moment = (np.einsum('kij,kj->ki', tip[:, :3, :3], np.stack(
        [log[f'fts_reading_{number}'] for number in three], axis=1))
        for three in ((1, 2, 3), (4, 5, 6)))
    about = moment + np.cross(tip[:, :3, 3] - base[:, :3, 3], force)
    return np.asarray(np.einsum('ki,ki->k', base[:, :3, 2], about))


def _fifths(log: dict[str, Floats], folder: Path) -> list[Measured]:
    """Return the fifths of the sweep as recordings; all have the zeros of its first sample."""
    count = len(log['Timestamp'])
    wanted = 'Timestamp', 'encoder_motorinc_3', 'encoder_loadinc_3', 'joint_torque_current_3'
    table = write_table(folder / 'fifths.csv', {
        **{name: log[name] for name in wanted}, 'reference': reference(log),
        'fifth': np.arange(count) * FIFTHS // count})
    more, below = IN_FIFTHS
    zeros = {side: int(log[f'encoder_{side}inc_3'][0]) for side in ('motor', 'load')}
    (folder / 'fifths.yaml').write_text(MAP.format(
        more=more, motor=zeros['motor'], link=zeros['load']) + below, encoding='utf-8')
    bags = hda('import', table, '--map', folder / 'fifths.yaml', '--out', folder / 'fifth')['bags']
    return [joint_of(Path(bag), JOINT) for bag in bags]


def _left_out(arm: Arm, parts: Sequence[Measured]) -> Numbers:
    """Return how the estimator errs on each fifth, calibrated by the other four."""
    errors: dict[str, list[Floats]] = {'estimator': [], 'torsion': [], 'motor': []}
    held, stiffness, driven = [], [], 0
    for place, part in enumerate(parts):
        found = calibrate(arm, {JOINT: [*parts[:place], *parts[place + 1:]]})
        said = found.report()['joints'][0]
        stiffness += [one['value'] for one in said['numbers']
                      if one['name'] == 'torsion.flexspline_stiffness']
        driven += said['motor'] > 0.0
        ways = {'estimator': Way(found.arm), 'motor': Way(by_motor(found.arm, [JOINT])),
                'torsion': Way(found.arm, EstimatorSettings(fusion=0.0))}
        for name, way in ways.items():
            estimated = Estimator(*way).run(part.stamps, part.readings,
                                            part.command[:, np.newaxis])
            error = estimated.torque[:, 0] - part.reference
            known = np.isfinite(error)
            errors[name].append(error[known])
            if name == 'estimator':
                held.append(np.abs(error) <= NORMAL_90 * estimated.torque_deviation[:, 0])
    return {**{name: {'rms': rms(np.concatenate(each)), 'fifths': [rms(one) for one in each]}
               for name, each in errors.items()},
            'held': float(np.mean(np.concatenate(held))), 'stiffness': stiffness,
            'driven': driven}


def _by_hand(parts: Sequence[Measured]) -> dict[str, float]:
    """Return how lines by least squares err on fifths left out [N*m rms]."""
    aims = [part.reference for part in parts]
    return {name: rms(missed_by_lines([_columns(name, part) for part in parts], aims))
            for name in ('current', 'torsion', 'motion')}


def _columns(name: str, part: Measured) -> Floats:
    """Return what a line goes through: sense, offset, and a witness or the link angle's load."""
    motor, link = part.readings[:, 0, (MOTOR_READING, LINK_READING)].T
    witness = {'current': [RATIO * part.command], 'torsion': [motor / RATIO - link],
               'motion': [np.cos(link), np.sin(link)]}[name]
    return np.stack([*witness, np.sign(part.turning().rate), np.ones_like(motor)], axis=1)


def _disc(parts: Sequence[Measured]) -> Numbers:
    """Return the disc of the link encoder that a line through offset, current and it finds."""
    motor, link = np.concatenate([part.readings[:, 0] for part in parts])[
        :, (MOTOR_READING, LINK_READING)].T
    torsion, current = motor / RATIO - link, np.concatenate([part.command for part in parts])
    columns = np.stack([np.ones_like(link), current, np.cos(link), np.sin(link)], axis=1)
    factors, plain = line(columns, torsion), line(columns[:, :2], torsion)
    return {'amplitude': float(np.hypot(*factors[2:])), 'turns': float(np.ptp(link)),
            'left': rms(torsion - columns @ factors),
            'without': rms(torsion - columns[:, :2] @ plain)}


def _diagnosis(table: Path, folder: Path, arm: Path) -> Numbers:
    """Return what `hda diagnose` says of the gear, without the reference."""
    said = _said(table, folder / 'sweep', arm)
    return {**_verdict(said), 'off': said['gain']['before'], 'refused': refused(
        'calibrate', folder / 'sweep', '--arm', arm, '--out', folder / 'never.yaml')}


def referenced(log: dict[str, Floats], folder: Path, arm: Path) -> Numbers:
    """Return what `hda diagnose` says of the gear, held against the reference."""
    wanted = 'Timestamp', 'encoder_motorinc_3', 'encoder_loadinc_3', 'joint_torque_current_3'
    table = write_table(folder / 'referenced.csv', {
        **{name: log[name] for name in wanted}, 'reference': reference(log)})
    said = _said(table, folder / 'referenced', arm, IN_FIFTHS[1])
    remarks = ' '.join(said['remarks'])
    return {**_verdict(said), 'one_way': 'turns one way' in remarks,
            'one_load': 'bears one load' in remarks,
            'before': {one['site']: one['before'] for one in said['residuals']}}


def _said(table: Path, bag: Path, arm: Path, below: str = '') -> Numbers:
    """Return what `hda diagnose` says of a table."""
    shown = bag.with_suffix('.yaml')
    shown.write_text(MAP.format(more='', motor='first', link='first') + below, encoding='utf-8')
    hda('import', table, '--map', shown, '--out', bag)
    return hda('diagnose', bag, '--arm', arm, '--out', bag.with_name(f'{bag.name}_report'))


def _verdict(said: Numbers) -> Numbers:
    """Return verdict, names, and what could not have been seen, of what `hda diagnose` says."""
    unseen = re.search(r'(\d+) of (\d+) effects could not', ' '.join(said['remarks']))
    rest = said['unexplained'] or {}
    return {'verdict': said['verdict'], 'joint': rest.get('joint'), 'site': rest.get('site'),
            'named': [cause['effect'] for cause in said['findings']],
            'alike': [pair['effects'] for pair in said['ambiguous']], 'next': said['next'],
            'unseen': [int(count) for count in unseen.groups()] if unseen else None}
