"""A pendulum on a servo, one encoder: which friction its twelve logs show, together and alone."""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from unittest.mock import patch

from hda_arm_sim.model.arm import Arm
from hda_arm_sim.model.files import read_arm
from hda_msgs_json.bag import open_recording
from hda_msgs_json.samples import JointSamples
from hda_torque_estimator.diagnosis.motors_alone import friction_causes
from hda_torque_estimator.diagnosis.motors_alone.motor_record import sweeps_together
from hda_torque_estimator.diagnosis.motors_alone.motor_side import diagnose_motors
from hda_torque_estimator.least_squares.rows import rms
import numpy as np
from pendulum import held_out, LEFT_OUT
from real_commands import Floats, hda, line, log_of, Numbers, write_table

FOLDER = 'bam_xl330'
GAINS = (100, 200, 800)
RATIO = 288.35                  # of the servo's spur gears
FULL = 885                      # duty that is the whole voltage
_MAP = """
time: {column: time, unit: s}
joints: [joint1]
each:
  ratio: 288.35
  motor:
    position: {column: position, unit: rad, side: link}
    effort: {formula: '0.1 * duty / 885 * input_volts * torque_enable', side: link}
"""


def numbers(data: Path, folder: Path) -> Numbers:
    """Return what is found in the logs."""
    tables = {path.name.removesuffix('.csv.gz'): log_of(path)
              for path in sorted((data / FOLDER).glob('*.csv.gz'))}
    logs = {name: _signed(log) for name, log in tables.items()}
    kinova = read_arm('kinova_gen3.yaml')
    arm = replace(kinova, joints=(replace(
        kinova.joints[0], ratio=RATIO, motor_inertia=1e-7),))
    states = {name: _imported(name, log, folder) for name, log in logs.items()}
    by_gain = {gain: [name for name in states if name.endswith(f'kp{gain}')] for gain in GAINS}
    seen = [name for name in states if name not in by_gain[LEFT_OUT]]
    with patch.object(friction_causes, 'factors_along', lambda *known, **counts: ()):
        plain = _said(states, list(states), arm)
    return {'logs': len(states), 'gains': list(GAINS), 'ratio': RATIO,
            'rate': float(np.median([1.0 / np.median(np.diff(log['time']))
                                     for log in logs.values()])),
            'together': _said(states, list(states), arm), 'plain': plain,
            'by_gain': {str(gain): _said(states, names, arm) for gain, names in by_gain.items()},
            'seen': _said(states, seen, arm),
            'single': {name: _said(states, [name], arm) for name in states},
            'regression': _regression(logs), 'simulation': held_out(logs)}


def _signed(log: Mapping[str, Floats]) -> dict[str, Floats]:
    """Return a log whose duty has its sign: it is written as 16 bits without one."""
    return {**log, 'duty': np.where(log['load'] > 32767, log['load'] - 65536.0, log['load'])}


def _imported(name: str, log: Mapping[str, Floats], folder: Path) -> JointSamples:
    """Return a log as `hda import` brings it in; its torque has an unknown scale."""
    columns = folder / 'bench.yaml'
    columns.write_text(_MAP, encoding='utf-8')
    table = write_table(folder / f'{name}.csv', log)
    hda('import', table, '--map', columns, '--out', folder / name)
    return open_recording(folder / name).joint_states()


def _said(states: Mapping[str, JointSamples], names: Sequence[str], arm: Arm) -> Numbers:
    """Return what a diagnosis of some logs as one motor says of its friction."""
    found = diagnose_motors(sweeps_together({name: states[name] for name in names}, arm), arm)
    said = found.diagnosis
    frictions = {}
    for part in found.parts:
        if part.friction is not None:
            known = part.friction.posterior
            frictions = {cause.name: known.of(cause.name) for cause in known.causes if cause.named}
    return {'verdict': said.verdict, 'named': {
        cause.effect: {'probability': cause.probability,
                       **{name: number.value for name, number in cause.parameters.items()}}
        for cause in said.findings}, 'probabilities': frictions,
        'unexplained': None if said.unexplained is None else said.unexplained.depends_on}


def _regression(logs: Mapping[str, Mapping[str, Floats]]) -> dict[str, float]:
    """Return how lines err on gain 200 [share of its torque], with and without load friction."""
    tables = {name: _columns(log) for name, log in logs.items()}
    seen = [table for name, table in tables.items() if not name.endswith(f'kp{LEFT_OUT}')]
    left = np.concatenate([tables[name] for name in tables if name.endswith(f'kp{LEFT_OUT}')])
    every = np.concatenate(seen)
    found = {}
    for name, count in (('coulomb_viscous', 5), ('load', 6)):
        factors = line(every[:, :count], every[:, -1])
        found[name] = rms(left[:, -1] - left[:, :count] @ factors) / rms(left[:, -1])
    return found


def _columns(log: Mapping[str, Floats]) -> Floats:
    """Return inertia, weight, offset, frictions and the torque by the voltage where it turns."""
    time, angle = log['time'], log['position']
    grid = np.arange(time[0], time[-1], 5e-3)
    place = np.interp(grid, time, angle)
    smooth = np.convolve(np.pad(place, 5, 'edge'), np.full(11, 1.0 / 11.0), 'valid')
    speed = np.gradient(smooth, grid)
    rate = np.gradient(speed, grid)
    torque = np.interp(grid, time, log['duty'] * log['input_volts'] / FULL * log['torque_enable'])
    way = np.sign(speed)
    moving = (np.abs(speed) > 0.1) & (np.interp(grid, time, log['torque_enable']) == 1.0)
    return np.stack([rate, np.sin(smooth), np.ones_like(grid), way, speed,
                     np.abs(np.sin(smooth)) * way, torque], axis=1)[moving]
