"""Seven sweeps of a Kinova Gen3, one joint and one encoder each: lines over the motor's turn."""

from collections.abc import Iterator
from pathlib import Path

from hda_arm_sim.model.files import read_arm
from hda_msgs_json.bag import open_recording
from hda_torque_estimator.commands.motors_alone import motor_figures
from hda_torque_estimator.commands.whole_directory import save_figures
from hda_torque_estimator.diagnosis.motors_alone.motor_fit import Explained, gain_without, LOAD
from hda_torque_estimator.diagnosis.motors_alone.motor_record import sweeps_together
from hda_torque_estimator.diagnosis.motors_alone.motor_side import diagnose_motors
from hda_torque_estimator.diagnosis.motors_alone.ripple import (explained_power, spectrum,
                                                                STANDS_OUT)
from hda_torque_estimator.least_squares.rows import rms
from hda_torque_estimator.measurements.recording_checks import mended, Mending
import numpy as np
from real_commands import Floats, hda, line, Numbers
from scipy.ndimage import median_filter
from scipy.optimize import minimize_scalar

FOLDER = 'kinova_gen3_jointwise'
SHOWN = 4, 7                    # joints whose figures stand on the page
ARM = 'kinova_gen3.yaml'
WIDTHS = 3.0                    # of a line, within which what is left beside it counts
ABOUT = 201                     # places of a spectrum about a line
PLAIN = 3.0                     # order from which a plain spectrum is looked at


def numbers(data: Path, folder: Path, figures: Path | None = None) -> Numbers:
    """Return what is found in the sweeps; figures go into their folder, where there is one."""
    arm, joints = read_arm(ARM), []
    for number in range(1, 8):
        bag = folder / f'sweep{number}'
        hda('import', data / FOLDER / f'joint_{number}_trapez.csv.gz', '--map', ARM, '--out', bag)
        states = mended(open_recording(bag).joint_states(), arm, Mending(), bag.name)
        found = diagnose_motors(sweeps_together({bag.name: states}, arm), arm)
        part, = found.parts
        said, rest, = found.diagnosis, found.diagnosis.residuals[0]
        resists = said.ambiguous[0].candidates[0].parameters['level']
        whole = said.gain
        joints.append({
            'joint': number, 'verdict': said.verdict, 'travel': _travel(part),
            'lines': sorted(_lines(part, said.findings), key=lambda one: -one['amplitude']),
            'all': [whole.removed, whole.low, whole.high] if said.findings else None,
            'without': rest.before, 'with': rest.after, 'noise': rest.floor,
            'resists': [resists.value, resists.low, resists.high],
            'friction': [_left(part, [LOAD, LOAD + 1]), _left(part, [])],
            'unsure': _unsure(part), 'baseline': _baseline(part)})
        if figures is not None and number in SHOWN:
            drawn = motor_figures(found.parts)
            save_figures(drawn, folder, vectors=False)
            for name in drawn:
                (folder / f'{name}.png').replace(figures / f'kinova_joint{number}.png')
    return {'joints': joints, 'ratio': arm.joints[0].ratio}


def _travel(part: Explained) -> float:
    """Return by how much the joint moved [rad]."""
    return float(np.ptp(part.sweep.angle)) / part.sweep.joint.ratio


def _left(part: Explained, taken: list[int]) -> float:
    """Return the error on held-out stretches without some columns [N*m rms at the shaft]."""
    return rms(part.without(taken)[part.sweep.moving & part.sweep.held_out])


def _lines(part: Explained, findings: tuple) -> Iterator[Numbers]:
    """Yield the lines of a motor: order in its turn, amplitude at the output, and the gain."""
    sweep = part.sweep
    pace = float(np.median(np.abs(sweep.speed[sweep.moving]))) / (2.0 * np.pi)
    orders, left = [one.order for one in part.lines], _spectrum_left(part)
    for found in findings:
        size, order = (found.parameters[name].value for name in ('amplitude', 'order'))
        number = orders.index(order)
        gain = gain_without(part, part.wave(number)).gain()
        yield {'order': order, 'amplitude': sweep.joint.ratio * size, 'hertz': order * pace,
               'removed': gain.removed, 'low': gain.low, 'high': gain.high,
               'off': _own_order(part, number) - order,
               'beside': _beside(part, number, left) / size}


def _own_order(part: Explained, number: int) -> float:
    """Return the order with which a line explains most, whole or not."""
    sweep, order = part.sweep, part.lines[number].order
    angle, rest = (values[sweep.moving] for values in (
        sweep.angle, part.without(part.wave(number))))
    width = 2.0 * np.pi / float(np.ptp(angle))
    found = minimize_scalar(lambda one: -explained_power(angle, rest, float(one)),
                            method='bounded',
                            bounds=(order - 0.5 * width, order + 0.5 * width))
    return float(found.x)


def _spectrum_left(part: Explained) -> tuple[Floats, Floats]:
    """Return orders and the spectrum of what is left of the torque [N*m at the shaft]."""
    sweep = part.sweep
    return spectrum(sweep.angle[sweep.moving], part.without(())[sweep.moving])


def _width(part: Explained) -> float:
    """Return how far beside an order what is left counts to its line."""
    return WIDTHS * 2.0 * np.pi / float(np.ptp(part.sweep.angle))


def _beside(part: Explained, number: int, left: tuple[Floats, Floats]) -> float:
    """Return the largest amplitude of what is `left` about a line [N*m at the shaft]."""
    orders, size = left
    return float(size[np.abs(orders - part.lines[number].order) < _width(part)].max())


def _unsure(part: Explained) -> list[float]:
    """Return orders that stand out of what is left, and are not named."""
    orders, size = _spectrum_left(part)
    ratio = size ** 2 / np.maximum(median_filter(size ** 2, ABOUT), 1e-300)
    ratio[orders < 0.5] = 0.0
    width = _width(part)
    for one in part.lines:
        ratio[np.abs(orders - one.order) < width] = 0.0
    found: list[float] = []
    while (best := int(np.argmax(ratio))) and ratio[best] > STANDS_OUT:
        found.append(float(orders[best]))
        ratio[np.abs(orders - orders[best]) < width] = 0.0
    return sorted(found)


def _baseline(part: Explained) -> Numbers:
    """Return what ten lines of numpy reach: a weight and an offset, then a plain spectrum."""
    sweep = part.sweep
    use, held = sweep.moving & ~sweep.held_out, sweep.moving & sweep.held_out
    link = sweep.angle / sweep.joint.ratio
    weight = np.stack([np.cos(link), np.sin(link), np.ones_like(link)], axis=1)
    rest = sweep.torque - weight @ line(weight[use], sweep.torque[use])
    orders, size = _plain_spectrum(sweep.angle[sweep.moving], rest[sweep.moving])
    return {'constant': sweep.joint.ratio * rms(sweep.torque[held] - sweep.torque[use].mean()),
            'weight': sweep.joint.ratio * rms(rest[held]),
            'order': float(orders[size.argmax()])}


def _plain_spectrum(angle: Floats, rest: Floats) -> tuple[Floats, Floats]:
    """Return orders from PLAIN on and the spectrum of a rest that is read at even angles."""
    order = np.argsort(angle)
    even = np.linspace(angle.min(), angle.max(), len(angle))
    size = np.abs(np.fft.rfft(np.interp(even, angle[order], rest[order])))
    orders = 2.0 * np.pi * np.arange(len(size)) / float(np.ptp(angle))
    return orders[orders > PLAIN], size[orders > PLAIN]
