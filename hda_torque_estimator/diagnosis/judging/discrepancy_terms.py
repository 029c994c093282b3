"""
Causes without a name: what could be wrong at a site of a joint that no catalogue lists.

Each is a level, a trend, a power, a sense or a wave along a coordinate. Trends and waves may also
be carried by the sense of motion, by the torque or by its size. One more is the strongest line
over time. All are made at the recording's rate and filtered as balances are: a wave too quick for
these is none in them.
"""

from collections.abc import Collection, Iterator
from dataclasses import dataclass
from typing import NamedTuple

from hda_arm_sim.foundation.arrays import Array
from hda_arm_sim.model.kernel import LINK_ANGLE, MOTOR_ANGLE, MOTOR_VELOCITY
import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import gaussian_filter1d

from .discrepancy_curves import (
    numbers_of, sites, SLIDING, SLOW, solved, with_any_size)
from .selection_criteria import cost_of_number
from ..balances.balance import RATE, Shape
from ..balances.coordinates import SMOOTH, torques_of
from ..balances.strongest_wave import strongest_wave, TURN
from ..findings.rest import IN_WORDS
from ..fitting.fit import Fit, Fitter
from ..fitting.solve import Columns, condense, condense_more, Solution
from ...significance import HARDLY

# Numerics; choices unless stated otherwise.
_POWERS = (1, 2, 3)     # of a torque and of an angle
_HALF_A_WAVE = np.pi    # of travel, below which a wave is any curve [rad]
_SAME = 1e-6            # singular value over the largest, below which columns are the same
# The most waves per turn of each angle.
_ORDERS = {'motor_angle': 12, 'link_angle': 12, 'other_link_angle': 6}


class DiscrepancyTerm(NamedTuple):
    """What something without a name does at one site of a joint, of any size."""

    joint: str
    site: str
    coordinate: str
    form: str
    channels: tuple[int, ...]
    curves: Array               # (m, q) at the balances' times, each of any size in each channel
    improvement: float          # of a score, less what its freedom costs

    def sentence(self) -> str:
        """Return where it is, what it follows and in which form."""
        follows = IN_WORDS.get(self.coordinate, 'no coordinate')
        return (f'something without a name at the {self.site} of {self.joint} follows {follows}: '
                f'{self.form}')

    def shapes(self, valid: NDArray[np.bool_]) -> Iterator[Shape]:
        """Yield what it may do in each balance, where these are valid (m, c)."""
        for channel in self.channels:
            for values in self.curves.T:
                yield Shape(channel, values, valid[:, channel])


class _Form(NamedTuple):
    """A curve (m, 1), or both phases of a wave (m, 2), along a coordinate."""

    coordinate: str
    form: str
    curves: Array


@dataclass(frozen=True, eq=False)
class DiscrepancyTerms:
    """All causes without a name that a motion could show."""

    _forms: dict[str, list[_Form]]          # by joint

    @classmethod
    def along(cls, fitter: Fitter) -> 'DiscrepancyTerms':
        """Return those along the motion of a fitter's arm as it is known."""
        return cls({label: [one._replace(curves=fitter.balancer.filtered(one.curves))
                            for one in _forms_of(fitter, place)]
                    for place, label in enumerate(fitter.arm.labels)})

    def best(self, fitter: Fitter, fit: Fit, joints: Collection[str]) -> DiscrepancyTerm:
        """Return the one at these joints that improves the score of a fit most."""
        return max((cause for label in joints for cause in self._of_joint(fitter, fit, label)),
                   key=lambda cause: cause.improvement)

    def _of_joint(self, fitter: Fitter, fit: Fit, label: str) -> Iterator[DiscrepancyTerm]:
        """Yield what each does at each site of a joint beside a fit."""
        valid = fitter.valid(fit.balance)
        rests = {channel: _Rest.of(fitter, fit, channel) for channel in fitter.own_channels(label)
                 if valid[:, channel].any()}
        forms = [*self._forms[label], *(rest.line(fitter.balancer.time)
                                        for rest in rests.values())]
        price = cost_of_number(fitter)
        for one in forms:
            gains = {channel: rest.gain(fitter, one.curves) for channel, rest in rests.items()}
            for site, channels in sites(fitter, label).items():
                freedom = price * one.curves.shape[1] * len(channels)
                gain = sum(gains.get(channel, 0.0) for channel in channels)
                yield DiscrepancyTerm(label, site, one.coordinate, one.form, tuple(channels),
                                      one.curves, gain - freedom)


class _Rest(NamedTuple):
    """What a fit leaves in one channel, and what its numbers may move there within bounds."""

    channel: int
    residual: Array             # (m, 1), 0 where invalid
    columns: Array              # (m, 1, p) of the numbers that move anything here
    valid: NDArray[np.bool_]    # (m, 1)
    numbers: Array              # (4, p) from nominal, tolerances, and room down and up
    free: Array                 # (m, r) orthonormal: what those without a tolerance move
    known: Columns
    plain: Solution             # without any curve

    @classmethod
    def of(cls, fitter: Fitter, fit: Fit, channel: int) -> '_Rest':
        """Return what a fit leaves in a channel."""
        valid = fitter.valid(fit.balance)[:, [channel]]
        residual = np.where(valid, fit.balance.residual[:, [channel]], 0.0)
        columns = np.where(valid[:, :, None], fit.columns[:, [channel]], 0.0)
        here = columns.any(axis=(0, 1))
        columns = columns[:, :, here]
        numbers = numbers_of(fitter, fit)[:, here]
        known = condense(residual, columns, valid)
        return cls(channel, residual, columns, valid, numbers,
                   _span(columns[:, 0, np.isinf(numbers[1])]), known,
                   solved(fitter, known, numbers, [channel]))

    def line(self, time: Array) -> _Form:
        """Return the strongest line over time (m,) [s]."""
        left = (self.residual + self.columns @ self.plain.step)[:, 0]
        frequency = strongest_wave(time, left, self.valid[:, 0]).frequency
        return _Form('time', f'line of {frequency:.3f} Hz', _wave(TURN * frequency * time))

    def gain(self, fitter: Fitter, curves: Array) -> float:
        """Return by how much these curves (m, q) improve the score in this channel (eq:room)."""
        made = np.where(self.valid, fitter.balancer.in_balance(curves, self.channel), 0.0)
        own = made - self.free @ (self.free.T @ made)
        if ((own ** 2).sum(axis=0) <= HARDLY ** 2 * (made ** 2).sum(axis=0)).any():
            return 0.0                      # the fit could move as much
        wide = condense_more(self.known, self.residual, self.columns, made[:, None], self.valid)
        numbers = with_any_size(self.numbers, made.shape[1])
        return self.plain.score - solved(fitter, wide, numbers, [self.channel]).score


def _span(columns: Array) -> Array:
    """Return orthonormal columns (m, r) of which all of these (m, p) are made."""
    size = np.sqrt((columns ** 2).sum(axis=0))
    made, singular, _ = np.linalg.svd(columns / size, full_matrices=False)
    return np.asarray(made[:, singular > _SAME * singular.max(initial=0.0)])


def _forms_of(fitter: Fitter, place: int) -> Iterator[_Form]:
    """Yield all curves of a joint at the recording's rate (k, 1 or 2)."""
    balancer = fitter.balancer
    state, time = balancer.motion(fitter.arm).state, balancer.measurement.time
    motor, links, speed = (state[:, place, MOTOR_ANGLE], state[:, :, LINK_ANGLE],
                           state[:, place, MOTOR_VELOCITY])
    torque = gaussian_filter1d(torques_of(fitter.arm, state[:, :, MOTOR_ANGLE], links)[:, place],
                               SMOOTH / (RATE * balancer.measurement.dt))
    command = balancer.measurement.command[:, place]
    sense = np.sign(speed)                      # as laws have it
    yield _Form('nothing', 'level', np.ones((len(time), 1)))
    yield from _carried('time', 'trend', (time - time.mean())[:, None], sense, torque)
    yield from _frictions(speed, sense)
    for power in _POWERS:
        yield _Form('joint_torque', f'power {power}', torque[:, None] ** power)
        yield _Form('motor_torque', f'power {power}', command[:, None] ** power)
        yield _Form('link_angle', f'power {power}', links[:, [place]] ** power)
    yield _Form('joint_torque', 'torque by sense', (np.abs(torque) * sense)[:, None])
    angles = [('motor_angle', motor), ('link_angle', links[:, place]), *(
        ('other_link_angle', links[:, other]) for other in range(links.shape[1])
        if other != place)]
    for coordinate, angle in angles:
        for order in range(1, _ORDERS[coordinate] + 1):
            if order * np.ptp(angle) >= _HALF_A_WAVE:
                yield from _carried(coordinate, f'{order} per turn', _wave(order * angle), sense,
                                    torque)


def _carried(coordinate: str, form: str, curves: Array, sense: Array,
             torque: Array) -> Iterator[_Form]:
    """Yield curves (k, q) as they are, by friction, by a spring, and by one that stiffens."""
    yield _Form(coordinate, form, curves)
    yield _Form(coordinate, f'{form}, by sense', curves * sense[:, None])
    yield _Form(coordinate, f'{form}, by torque', curves * torque[:, None])
    yield _Form(coordinate, f'{form}, by load', curves * np.abs(torque)[:, None])


def _frictions(speed: Array, sense: Array) -> Iterator[_Form]:
    """Yield curves of the motor's speed (k,) and of its sense."""
    for form, values in (('sense', sense), (f'sense over {SLOW:g} rad/s', np.tanh(speed / SLOW)),
                         ('speed', speed), ('square', speed * np.abs(speed)), *(
            (f'sense below {slow:g} rad/s', sense / (1.0 + (speed / slow) ** 2))
            for slow in SLIDING)):
        yield _Form('motor_velocity', form, values[:, None])


def _wave(phase: Array) -> Array:
    """Return a wave at two phases (k, 2), so at any phase."""
    return np.stack([np.sin(phase), np.cos(phase)], axis=1)
