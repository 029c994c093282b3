"""
What is assumed of a recording before a cause is known, and asked again when some are.

Motors show where friction builds up after a shaft turned round, and what commands did between two
samples. But what is wrong with an arm may hide that, or look like it.
"""

from dataclasses import dataclass, replace

from hda_arm_sim.foundation.arrays import Array
from hda_arm_sim.model.arm import Arm
import numpy as np

from .balances.balance import Balancer, NearRest
from .balances.bearings import borne_by
from .balances.commands import on_its_way
from .balances.healthy_twin import (
    healthy_twin, noise_of, torque_noise_of, torque_response, TorqueNoise)
from .balances.reversals import bristled, turning_round
from .balances.unresolved import unresolved
from .fitting.fit import Fitter
from .readings.raw_readings import RawReadings
from ..measurements.measurement import Measurement
from ..measurements.running_clock import inside, Spans

# Numerics; choices unless stated otherwise.
# (measured: noise of healthy joints at 100 to 1000 Hz has an autocorrelation r with
# 1 / (1 + 2 sum r^2) of 0.4 to 0.63)
EFFECTIVE = 0.5         # share of the balances' samples that are independent
_FIRST_NOISE = 0        # seed of a twin that shows what noise leaves,
_OTHER_NOISE = 2        # of another one, that shows what chance buys,
_NOISE_OF_TORQUES = 5   # and of noise that motors give


@dataclass(frozen=True, eq=False)
class AsRecorded:
    """The balances of a recording with nothing assumed, and what noise leaves of them."""

    arm: Arm                            # as given
    balancer: Balancer
    quiet: Measurement                  # of a healthy twin
    noise: Array                        # (c,) [N*m]
    plain: Array                        # (c,) of readings alone [N*m]
    training: Spans

    @classmethod
    def of(cls, raw: RawReadings, training: Spans) -> 'AsRecorded':
        """
        Return it of readings, to be fitted on the training stretches.

        Where the arm moved faster than samples resolve, balances hold nothing.
        """
        whole = cls._of_all(raw.arm, raw.measurement, training)
        more = unresolved(whole.balancer, whole.arm, whole.noise)
        if not more:
            return whole
        blind = tuple(sorted({*raw.measurement.blind, *more}))
        return cls._of_all(raw.arm, replace(raw.measurement, blind=blind), training)

    @classmethod
    def _of_all(cls, arm: Arm, measurement: Measurement, training: Spans) -> 'AsRecorded':
        """Return it of all readings but the blind ones."""
        balancer = Balancer(measurement).apart(arm)
        quiet = healthy_twin(balancer, arm, _FIRST_NOISE)
        return cls(arm, balancer, quiet, *noise_of(balancer, arm, quiet), training)

    def turning(self, found: Arm) -> tuple[int, ...]:
        """
        Return the places of the joints whose friction builds up, beside what was `found`.

        Weight and friction of a chain are off within their tolerances, and a cause may be loud
        where shafts turn round. So nothing is asked of an arm as it was given. Bristles that were
        found must explain what motors show there, for it is there that they do most.
        """
        loud = turning_round(self.balancer, found, self.noise)
        return tuple(sorted({*loud, *bristled(found)}))

    def assuming(self, turns: tuple[int, ...], found: Arm) -> Balancer:
        """Return balances with joints that turn, and commands as motors of `found` show them."""
        near_rest, balancer = NearRest(turns, borne_by(found)), self.balancer
        if near_rest != NearRest():
            balancer = balancer.but(near_rest=near_rest)
        return on_its_way(balancer, found, self.noise)

    def bears_out(self, fitter: Fitter, found: Arm) -> bool:
        """
        Return whether the arm that was `found` shows what the balances of a fitter assume.

        What a cause does where a shaft turns round is explained when it is found. So only joints
        that were not assumed to turn are asked again.
        """
        assumed = fitter.balancer
        turning, borne = assumed.near_rest
        if not (set(self.turning(found)) <= set(turning) and set(borne_by(found)) <= set(borne)):
            return False
        shown = self.assuming(turning, found)
        if assumed.unknown is None and shown.unknown is None:
            return bool(np.array_equal(shown.measurement.command, assumed.measurement.command))
        return assumed.unknown is not None and shown.unknown is not None

    def fitter(self, turns: tuple[int, ...], found: Arm) -> Fitter:
        """Return what fits the training stretches under these assumptions (`assuming`)."""
        balancer, noise, plain = self.assuming(turns, found), self.noise, self.plain
        if balancer is not self.balancer:
            noise, plain = noise_of(balancer, self.arm, self.quiet)
        white = balancer.whitened(self.arm, np.sqrt(noise ** 2 - plain ** 2))
        if white is not balancer:
            balancer, (noise, plain) = white, noise_of(white, self.arm, self.quiet)
        more = torque_noise_of(noise, plain, balancer, self.arm)
        balancer = balancer.knowing(torque_response(
            balancer, self.arm, _NOISE_OF_TORQUES, more))
        noise_of(balancer, self.arm, self.quiet)        # balances keep it, and this twin is made
        twin = twin_of(balancer, self.arm, _OTHER_NOISE, more)
        return Fitter(balancer, self.arm, noise, EFFECTIVE,
                      inside(balancer.time, self.training), twin)

    def without_turns(self, fitter: Fitter, found: Arm) -> Fitter:
        """Return a fitter of the same rows, but for those where shafts turn round."""
        return replace(self.fitter((), found), rows=fitter.rows)


def twin_of(balancer: Balancer, arm: Arm, seed: int, more: TorqueNoise) -> Balancer:
    """Return the balances of a healthy arm that was recorded with as much noise."""
    return balancer.like(healthy_twin(balancer, arm, seed, more))
