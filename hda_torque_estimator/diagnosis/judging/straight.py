"""
Whether a wave over the link's angle was seen to bend: a straight part of it is no wave.

Over one radian a disc off its centre can stand in for any error that grows with the angle. What
tells a disc is how it bends beside the best straight line, which must show in the balances.
"""

from hda_arm_sim.model.effects import LinkEncoderEccentricity
from hda_arm_sim.model.kernel import LINK_ANGLE
import numpy as np
from numpy.typing import NDArray

from ..fitting.fit import Fit, Fitter
from ..fitting.nuisance import Zero
from ...least_squares.term import Term

Array = NDArray[np.float64]
# (measured: what stood in for a disc had 4 to 71, six true discs 33 000 and more)
_BEND = 1000.0          # score of the bend alone, from which a disc is one


def straight(fitter: Fitter, fit: Fit) -> tuple[Term, ...]:
    """Return the accepted discs of link encoders that were not seen to bend."""
    return tuple(term for term in fit.accepted if isinstance(term.effect, LinkEncoderEccentricity)
                 and _bend(fitter, fit, term, term.effect) < _BEND)


def _bend(fitter: Fitter, fit: Fit, term: Term, disc: LinkEncoderEccentricity) -> float:
    """Return the score of what a disc reads beside a straight line over the link's angle."""
    place, torsion = fitter.own_channels(term.joint)
    valid = fitter.valid(fit.balance)
    motion = fitter.balancer.motion(fitter.on(fit.terms))
    angle = motion.state[::fitter.balancer.every, place, LINK_ANGLE]
    error = disc(angle=angle)
    seen = valid[:, torsion]
    line = np.polynomial.Polynomial.fit(angle[seen], error[seen], 1)
    zero, = (other for other in fit.nuisance
             if isinstance(other, Zero) and other.joint == term.joint)
    shown = fit.columns[:, :, fit.own(zero)][:, :, 0] * (error - line(angle))[:, None]
    return float(fitter.effective * np.where(valid, shown ** 2 / fit.variance, 0.0).sum())
