"""A cause that raw readings show before any filter, and the limits that all of them must pass."""

from collections.abc import Mapping
from typing import NamedTuple

from hda_arm_sim.foundation.arrays import Array, Mask
from hda_arm_sim.model.arm import Arm
from hda_arm_sim.model.effects import Effect

from ..findings.report import FittedNumber
from ...significance import MOSTLY

BETWEEN = 1.0 + MOSTLY      # steps: what is more is nearer to two than to one

# Numerics.
# Where samples slip by it, the estimated torque of a moving arm is off by less than IMMATERIAL
# (measured: by 1.6 % more; by 0.05 of a sample 13 % more, by 0.1 of a sample 49 times as far)
TOLERABLE = 0.01        # rms by which samples slip, that nobody would call wrong [samples]

# Share of samples that may be wrong: it is the mean square of slips by one whole sample.
WRONG = TOLERABLE ** 2


class HitSamples(NamedTuple):
    """Which samples (k,) a cause hit, and what share of each it hits at its own rate."""

    hit: Mask
    share: Array


class RawCause(NamedTuple):
    """An effect at its place, its numbers with 90 % intervals, and how sure it is."""

    effect: Effect
    joint: str | None
    numbers: Mapping[str, FittedNumber]
    score: float
    channels: tuple[tuple[int, int], ...]       # columns and sides of the readings that show it
    recording: int = 0                          # the one of several that shows it best
    forms: tuple[Effect, ...] = ()              # what another form of its law does beside it
    counted: HitSamples | None = None           # of one that hits single samples

    def on(self, arm: Arm) -> Arm:
        """Return the arm with this cause."""
        return arm.with_effect(self.effect, self.joint)


def number(effect: Effect, name: str, reach: float) -> FittedNumber:
    """Return a number of an effect that is known to within `reach`."""
    value = getattr(effect, name)
    return FittedNumber(value, type(effect).declaration(name).unit, value - reach, value + reach)
