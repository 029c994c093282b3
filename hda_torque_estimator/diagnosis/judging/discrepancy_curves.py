"""
Laws without a name: simple curves along each coordinate, at each site of each joint.

They belong to no cause. But a cause that is named rightly leaves none of them, whatever the size
of its rest. One with several numbers explains more than any single curve does. A cause that
stands in for another passes neither.
"""

from collections.abc import Collection, Iterator, Mapping, MutableMapping, Sequence
from typing import NamedTuple
from weakref import WeakKeyDictionary

from hda_arm_sim.model.effects import Site
import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import gaussian_filter1d

from ..balances.balance import RATE
from ..balances.coordinates import coordinates_of, of_motion, SMOOTH
from ..balances.loop_noise import noisier_commands
from ..findings.rest import GEAR, NOTHING, SENSOR
from ..fitting.fit import Fit, Fitter, room
from ..fitting.hypotheses import HYPOTHESES
from ..fitting.solve import Columns, condense, condense_more, Solution, solve
from ...significance import IMMATERIAL

Array = NDArray[np.float64]
# Numerics; choices unless stated otherwise.
SLOW = 1.0              # shaft speed over which a sense of motion sets in [rad/s]
SLIDING = (5.0, 20.0)   # shaft speeds over which friction may fall [rad/s]
_LINK_ORDERS = (1, 2, 3, 4, 6)  # waves per link turn of curves without a name
_MOTOR_ORDERS = (1, 2, 4, 6, 8, 12)  # waves per motor turn of curves without a name
_ANY_SIZE = np.array([[0.0], [np.inf], [np.inf], [np.inf]])     # of a curve: nothing holds it
_AT_REST = 1e-30        # mean square of a shape, below which nothing moved that makes it
_RATED = ('joint_torque', 'motor_torque', 'motor_velocity')
_OF_COMMANDS = 'motor_torque'           # of which a slow log keeps a part
# Beside these two, what follows the torque lets a motor balance shrink with all of its noise.
_SCALED = {name for name, sought in HYPOTHESES.items() if sought.scales}
_SCALE = 'joint_torque^1'


Usual = Mapping[tuple[str, str, str], float]    # improvements by joint, site and form
_KNOWN: 'MutableMapping[Fitter, Usual]' = WeakKeyDictionary()


class Curve(NamedTuple):
    """
    One curve at one site of a joint, with the score of a fit that has it as well.

    It may help what is left at another joint, through masses that are not quite known. That says
    nothing of its own, so the `improvement` is not more than in the channels of its joint.
    """

    joint: str
    site: str
    form: str
    score: float
    improvement: float


def best_curves(fitter: Fitter, fit: Fit, joints: Collection[str],
                usual: Usual | None = None) -> dict[str, Curve]:
    """
    Return the curve that explains most of each of these joints beside the terms of a fit.

    What the same curve explains of a healthy arm, recorded with as much noise, does not count. Nor
    does what is `usual` beside these terms.
    """
    chance = _chance(fitter)
    curves: dict[str, Curve] = {}
    for curve in _curves(fitter, fit, joints):
        more = max(chance.get(curve[:3], 0.0), (usual or {}).get(curve[:3], 0.0), 0.0)
        curve = curve._replace(score=curve.score + more, improvement=curve.improvement - more)
        if curve.joint not in curves or curve.improvement > curves[curve.joint].improvement:
            curves[curve.joint] = curve
    return curves


def usual_curves(fitter: Fitter, fit: Fit) -> Usual:
    """Return what each curve improves of a fit, quick ones as well, by joint, site and form."""
    return {curve[:3]: curve.improvement
            for curve in _curves(fitter, fit, fitter.arm.labels, quick=True)}


def improvement_of(fitter: Fitter, fit: Fit, curve: Curve) -> float:
    """Return what a curve improves beside the terms of a fit, nothing where noise makes it."""
    return next((each.improvement for each in _curves(fitter, fit, (curve.joint,))
                 if each[:3] == curve[:3]), 0.0)


def _chance(fitter: Fitter) -> Usual:
    """Return what each curve improves of a healthy arm, by joint, site and form."""
    healthy = fitter.healthy
    if healthy is None:
        return {}
    if healthy not in _KNOWN:
        _KNOWN[healthy] = usual_curves(healthy, healthy.first)
    return _KNOWN[healthy]


def is_worth_a_look(fitter: Fitter, fit: Fit, joints: Collection[str], bar: float) -> bool:
    """
    Return whether a curve at these joints improves the score by more than a bar.

    What is quick may be of noise, and is among the curves: whether it is, a law must show.
    """
    return any(curve.improvement > bar for curve in _curves(fitter, fit, joints, quick=True))


class CurvesAtSite(NamedTuple):
    """All curves at one site of a joint, with what they do in the balances."""

    joint: str
    site: str
    forms: tuple[str, ...]      # (q,)
    columns: Array              # (m, c, q) of the residuals, of mean square 1 before any whitening


def curves_at_sites(fitter: Fitter, fit: Fit, joints: Collection[str],
                    quick: bool = False) -> Iterator[CurvesAtSite]:
    """
    Yield every curve at these joints; quick ones may be of noise, and are there if asked.

    What commands did between the samples of a log goes with their rates: nobody recorded it.
    """
    time, arm = fitter.balancer.time, fitter.on(fit.terms)
    rated = [name for name in _RATED if name != _OF_COMMANDS or fitter.balancer.is_commanded]
    coordinates = coordinates_of(fitter.balancer, arm)
    torques = _quiet_torques(fitter, fit, coordinates['joint_torque'])
    noisy = {} if quick else coordinates_of(fitter.balancer.noisier, arm)
    if noisy and _OF_COMMANDS in rated:
        noisy[_OF_COMMANDS] = noisier_commands(fitter.balancer)[::fitter.balancer.every]
    for place, label in enumerate(fitter.arm.labels):
        if label not in joints:
            continue
        along, noisier = ({name: values[:, place] for name, values in each.items()}
                          for each in (coordinates, noisy))
        forms = dict(_forms(time, along | {'joint_torque': torques[:, place]}))
        for rates_of in (_rates, _quick_rates):
            with_noise = {} if quick else dict(rates_of(time, noisier, rated))
            forms |= {name: rate for name, rate in rates_of(time, along, rated) if quick or (
                np.var(with_noise[name] - rate) <= IMMATERIAL * np.var(rate))}
        columns = np.stack(list(forms.values()), 1)
        shapes = columns / np.sqrt(np.maximum(np.mean(columns ** 2, axis=0), _AT_REST))
        for site, channels in sites(fitter, label).items():
            more = np.zeros((len(shapes), len(fitter.noise), shapes.shape[1]))
            for channel, share in channels.items():
                more[:, channel] = share * fitter.balancer.in_balance(shapes, channel)
            yield CurvesAtSite(label, site, tuple(forms), more)


def _quiet_torques(fitter: Fitter, fit: Fit, torque: Array) -> Array:
    """
    Return joint torques (m, n) without noise of the torsions, (eq:quiet-torque) [N*m].

    Beside what the links need, a curve along a noisy torque is that noise, and explains what noise
    leaves in the balances.
    """
    count = torque.shape[1]
    balance, torsions = fitter.balancer.unwhitened(fitter.on(fit.terms)), slice(count, 2 * count)
    share = (fitter.noise ** 2 / fit.variance)[torsions] * ~fitter.balancer.measurement.unloaded
    return torque + share * np.where(balance.valid, balance.residual, 0.0)[:, torsions]


def _curves(fitter: Fitter, fit: Fit, joints: Collection[str],
            quick: bool = False) -> Iterator[Curve]:
    """Yield every curve at these joints beside the terms of a fit."""
    valid = fitter.valid(fit.balance)
    known = condense(fit.balance.residual, fit.columns, valid)
    numbers = numbers_of(fitter, fit)
    plain = solved(fitter, known, numbers)
    wider = with_any_size(numbers)
    for label, site, forms, more in curves_at_sites(fitter, fit, joints, quick):
        own = fitter.own_channels(label)
        scaled = {term.name for term in fit.accepted if term.joint == label} >= _SCALED
        wide = condense_more(known, fit.balance.residual, fit.columns, more, valid)
        for number, form in enumerate(forms):
            if form == _SCALE and site in ('motor', GEAR) and scaled:
                continue
            if form == NOTHING and site == 'torsion':
                continue                        # that is the zero of an encoder
            solution = solved(fitter, _one_of(wide, number, len(forms)), wider)
            yield Curve(label, site, form, solution.score,
                        min(plain.score - solution.score,
                            float((plain.scores - solution.scores)[own].sum())))


def numbers_of(fitter: Fitter, fit: Fit) -> Array:
    """Return how far the numbers of a fit are off, tolerances, and room down and up (4, p)."""
    return np.stack([fitter.away(fit.terms), fit.deviations, *room(fit.terms)])


def with_any_size(numbers: Array, count: int = 1) -> Array:
    """Return numbers (4, p) with sizes of `count` curves before them, which nothing holds."""
    return np.concatenate([np.repeat(_ANY_SIZE, count, axis=1), numbers], axis=1)


def solved(fitter: Fitter, columns: Columns, numbers: Array,
           channels: slice | list[int] = slice(None)) -> Solution:
    """Return the best step of numbers (4, p) in channels of which columns are condensed."""
    away, deviations, down, up = numbers
    return solve(columns, fitter.noise[channels], fitter.effective, away, deviations, (down, up))


def sites(fitter: Fitter, label: str) -> dict[str, dict[int, float]]:
    """Return the channels in which a curve at each site of a joint shows, and how much of it."""
    motor, torsion, *third = fitter.own_channels(label)
    if fitter.is_unloaded(label):
        return {GEAR: {motor: 1.0}}
    found = {'motor': {motor: 1.0}, 'torsion': {torsion: 1.0},
             fitter.beyond_gear(label): {motor: 1.0, torsion: 1.0}}
    for channel in third:                       # eq:balance-third
        of_link = float(fitter.balancer.of_link_torque[channel])
        found['torsion'][channel] = 1.0 + of_link
        if of_link:
            found[Site.LINK.value][channel] = of_link
        found[SENSOR] = {channel: 1.0}
    return found


def _one_of(wide: Columns, number: int, count: int) -> Columns:
    """Return the columns with one of the `count` curves that stand before those of a fit."""
    products, against = wide.products[:, count - 1:, count - 1:].copy(), wide.against[
        :, count - 1:].copy()
    products[:, 0, 1:] = products[:, 1:, 0] = wide.products[:, number, count:]
    products[:, 0, 0], against[:, 0] = wide.products[:, number, number], wide.against[:, number]
    return wide._replace(products=products, against=against)


def _rates(time: Array, along: Mapping[str, Array],
           rated: Sequence[str]) -> Iterator[tuple[str, Array]]:
    """Yield rates (m,) of a motion, by what they are of."""
    for name in rated:
        for order, which in enumerate(('rate', 'second rate'), 1):
            yield f'{which} of {name}', gaussian_filter1d(
                along[name], SMOOTH, order=order) * RATE ** order


def _quick_rates(time: Array, along: Mapping[str, Array],
                 rated: Sequence[str]) -> Iterator[tuple[str, Array]]:
    """Yield rates (m,) with all that they have at high frequency, noise as well."""
    for name in rated:
        rate = np.gradient(along[name], time)
        yield f'quick rate of {name}', rate
        yield f'quick second rate of {name}', np.gradient(rate, time)


def _forms(time: Array, along: Mapping[str, Array]) -> Iterator[tuple[str, Array]]:
    """Yield curves (m,) by what they follow."""
    speed, torque = along['motor_velocity'], of_motion(along['joint_torque'])
    link, motor = along['link_angle'], along['motor_angle']
    sense, middle = np.tanh(speed / SLOW), time - time.mean()
    yield NOTHING, np.ones_like(time)
    yield 'time', middle
    for carrier, values in (('sense', sense), ('motor_velocity', speed)):
        yield carrier, values
        yield f'{carrier} over time', values * middle
    yield 'motor_velocity, squared', speed * np.abs(speed)
    yield 'motor_velocity, cubed', speed ** 3
    for slow in SLIDING:
        yield f'sense below {slow:g} rad/s', sense / (1.0 + (speed / slow) ** 2)
    for power in (1, 2, 3, 5):
        yield f'joint_torque^{power}', torque ** power
    yield 'sense of joint_torque', np.tanh(torque)
    yield 'joint_torque by sense', np.abs(torque) * sense
    for power in (1, 2, 3):
        yield f'link_angle^{power}', link ** power
    for order in _LINK_ORDERS:
        for name, wave in (('sin', np.sin(order * link)), ('cos', np.cos(order * link))):
            yield f'{name} {order} link_angle', wave
            yield f'{name} {order} link_angle by sense', wave * sense
    for order in _MOTOR_ORDERS:
        yield f'sin {order} motor_angle', np.sin(order * motor)
        yield f'cos {order} motor_angle', np.cos(order * motor)
