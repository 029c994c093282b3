"""Whether friction builds up after a shaft has turned round, beside what tolerances explain."""

from hda_arm_sim.model.chain_links import ChainLinks

from .fit import Fitter
from ..balances.reversals import turning_round


def turning(fitter: Fitter) -> tuple[int, ...]:
    """
    Return the places of the joints whose friction builds up after they turn round.

    Weight and friction of a chain are off within their tolerances. That is loud where it turns,
    and it hides what builds up there where it is loud elsewhere. So they are fitted first.
    """
    arm, chain = fitter.arm, isinstance(fitter.arm.links, ChainLinks)
    return turning_round(fitter.balancer, fitter.on(fitter.first.terms) if chain else arm,
                         fitter.noise)
