"""Whether friction builds up after a shaft has turned round, beside what tolerances explain."""

from hda_arm_sim.model.chain_links import ChainLinks

from .fit import Fitter
from ..balances.reversals import turning_round


def turning(fitter: Fitter) -> tuple[int, ...]:
    """
    Return the places of the joints whose friction builds up after they turn round.

    Weight and friction of a chain, off within their tolerances, are loud where it turns as well.
    So they are fitted before that is believed.
    """
    found = turning_round(fitter.balancer, fitter.arm, fitter.noise)
    if not found or not isinstance(fitter.arm.links, ChainLinks):
        return found
    fitted = turning_round(fitter.balancer, fitter.on(fitter.first.terms), fitter.noise)
    return tuple(joint for joint in found if joint in fitted)
