"""Four seconds of a Yu-Cobot: a calibration by joint torque sensors, and what is simpler."""

from collections.abc import Mapping, Sequence
from pathlib import Path
import re
from unittest.mock import patch

from hda_arm_sim.model.arm import Arm
from hda_arm_sim.model.files import read_arm
from hda_torque_estimator.calibrate.fitting import witness_fit
from hda_torque_estimator.calibrate.fitting.referenced_terms import disc, TORSION_MORE
from hda_torque_estimator.calibrate.passages.joint_recording import CalibrationError, Measured
from hda_torque_estimator.calibrate.referenced import calibrate
from hda_torque_estimator.least_squares.rows import rms
from hda_torque_estimator.samples.readings import LINK_READING, MOTOR_READING
import numpy as np
from real_commands import Floats, hda, joint_of, line, missed_by_lines, Numbers, refused

FILE, ARM = 'voraus_yucobot/test.parquet', 'voraus_yucobot.yaml'
RUNS = 12, 755, 1702, 1703
RATIO = 100.0
MOVES = 'joint2'    # whose zero moves
SIGNS = 0.01, 0.03, 0.1, 0.3      # speeds over which a sign is smooth [rad/s]
SHIFTED = 20        # samples by which recordings are shifted against each other, most
SCANNED = np.arange(80.0, 122.0, 2.0)       # gear ratios that are tried


def numbers(data: Path, folder: Path) -> Numbers:
    """Return what the recordings show."""
    hda('import', data / FILE, '--map', ARM, '--out', folder / 'yu')
    bags = [folder / f'yu_{run}' for run in RUNS]
    silent = refused('diagnose', '--each', *bags, '--arm', ARM, '--out', folder / 'never')
    said = hda('calibrate', *bags, '--arm', ARM, '--out', folder / 'yu.yaml')
    moving = hda('calibrate', *bags, '--arm', ARM, '--joint', MOVES, '--zero-moves',
                 '--out', folder / 'moving.yaml')['joints'][0]
    arm, joints = read_arm(ARM), []
    parts = {label: [joint_of(bag, label) for bag in bags] for label in arm.labels}
    for joint in said['joints']:
        seen = parts[joint['joint']]
        joints.append({
            **{key: joint[key] for key in ('reference', 'before', 'after', 'together', 'given',
                                           'about', 'by_hand', 'leader', 'doubtful', 'zero_moves',
                                           'zero_torque')},
            'numbers': {one['name']: [one['value'], one['low'], one['high']]
                        for one in joint['numbers']},
            'baseline': _baselines(seen)})
    discs = [place for place, joint in enumerate(joints)
             if any(name.startswith('link_encoder_ecc') for name in joint['numbers'])]
    for place in discs:
        joints[place]['without_disc'] = _without_disc(arm, arm.labels[place], parts)
    short = re.search(r'([\d.]+) s are too short; record at least ([\d.]+) s', silent)
    return {'joints': joints, 'moving': {key: moving[key] for key in ('together', 'about')},
            'unseen': _unseen(bags, folder), 'discs': [place + 1 for place in discs],
            'refused': [float(word) for word in short.groups()] if short else None,
            'ratio': _best_ratio(list(parts.values()))}


def _unseen(bags: Sequence[Path], folder: Path) -> dict[str, list[float]]:
    """Return what each recording is missed by, offset included, with files of the others."""
    found: dict[str, list[float]] = {}
    for name, more in (('usual', ()), ('moving', ('--zero-moves',))):
        found[name] = []
        for place, left_out in enumerate(bags):
            arm = folder / f'{name}_{place}.yaml'
            hda('calibrate', *(bag for bag in bags if bag != left_out), '--arm', ARM,
                '--joint', MOVES, *more, '--out', arm)
            said = hda('estimate', left_out, '--arm', arm, '--out', folder / f'{name}_{place}')
            found[name].append(float(said['errors'][f'reference/{MOVES}/torque']['rms']))
    return found


def _without_disc(arm: Arm, label: str, parts: Mapping[str, Sequence[Measured]]) -> float:
    """Return the error that a joint is left with where no disc may sit off its axis [N*m rms]."""
    others = tuple(make for make in TORSION_MORE if make is not disc)
    with patch.object(witness_fit, 'TORSION_MORE', others):
        try:
            return float(calibrate(arm, {label: parts[label]}).report()['joints'][0]['after'])
        except CalibrationError as kept:        # it stays as it was, and the line says why
            found = re.search(r'calibrated, it would be ([\d.]+) N', str(kept))
            assert found is not None, kept
            return float(found[1])


def _baselines(parts: Sequence[Measured]) -> dict[str, float]:
    """Return errors on recordings left out, without their means, of what is simple [N*m rms]."""
    aims = [part.reference - part.reference.mean() for part in parts]
    found = {'mean': rms(np.concatenate([_about(aims[place] - np.mean([
        _as_timed(other, part) for other in parts if other is not part], axis=0))
        for place, part in enumerate(parts)]))}
    for name, tables in (('motor', [part.command[:, None] for part in parts]),
                         ('motion', [_motion(part) for part in parts])):
        found[name] = rms(missed_by_lines([table - table.mean(axis=0) for table in tables], aims))
    return found


def _motion(part: Measured) -> Floats:
    """Return the speed and its sign, smooth to several degrees, at the output (k, p)."""
    speed = np.gradient(part.readings[:, 0, MOTOR_READING], part.time) / RATIO
    return np.stack([speed, *(np.tanh(speed / scale) for scale in SIGNS)], axis=1)


def _as_timed(other: Measured, part: Measured) -> Floats:
    """Return the torque of another recording, shifted so that its motor angle fits best (k,)."""
    angles = [_about(one.readings[:, 0, MOTOR_READING]) for one in (other, part)]
    shifts = part.dt * np.arange(-SHIFTED, SHIFTED + 1)
    best = min(shifts, key=lambda shift: rms(_about(
        np.interp(part.time + shift, other.time, angles[0]) - angles[1])))
    return np.interp(part.time + best, other.time, _about(other.reference))


def _about(values: Floats) -> Floats:
    """Return values without their mean."""
    return values - values.mean()


def _best_ratio(joints: Sequence[Sequence[Measured]]) -> dict[str, float]:
    """Return the gear ratio whose waves leave least of the torsion, and how much."""
    left = [np.mean([_left(part, ratio) for parts in joints for part in parts])
            for ratio in SCANNED]
    best = int(np.argmin(left))
    return {'best': float(SCANNED[best]), 'left': float(left[best]),
            'usual': float(np.median(left))}


def _left(part: Measured, ratio: float) -> float:
    """Return the share of a torsion that torque, offset and waves of a ratio leave."""
    motor, link = part.readings[:, 0, (MOTOR_READING, LINK_READING)].T
    torsion = motor / RATIO - link
    usual = np.stack([part.reference, np.ones_like(link), link, part.turning().rate], axis=1)
    waves = np.stack([wave(order * ratio * link) for order in (1.0, 2.0)
                      for wave in (np.sin, np.cos)], axis=1)
    both: Floats = np.concatenate([usual, waves], axis=1)
    return rms(torsion - both @ line(both, torsion)) / rms(torsion - usual @ line(usual, torsion))
