"""
How sure a judgement is, as a probability (eq:certainty).

Every bar of the judgement is where odds are 19 to 1, for or against. How far something is from its
bar, in bars, is its margin. A cause is as sure as the weakest of what it rests on.
"""

from collections.abc import Iterable
import math

from .report import at_place, Evidence, Finding
from ...significance import IMMATERIAL

# Judgement; choices unless stated otherwise.
NAMED = 0.95             # probability at one bar, and of a cause that is named
ODDS = NAMED / (1.0 - NAMED)        # to 1 at a margin of one bar

# Numerics; choices unless stated otherwise.
_MOST = 40.0                    # bars beyond which a number of this size holds nothing more


def probability(margin: float) -> float:
    """Return the probability of what is so many bars beyond even odds."""
    return 1.0 / (1.0 + ODDS ** -min(max(margin, -_MOST), _MOST))


def margin_of_rest(share: float) -> float:
    """
    Return the margin by which a rest is none, if it has a `share` of what would be one.

    Odds are even where the rest is called one, and 19 to 1 at half of it and at half as much more.
    """
    return 2.0 * (1.0 - max(share, 0.0))


def margin_of_share(left: float) -> float:
    """
    Return the margin by which a cause is no stand-in, if it leaves a share of what it explains.

    Odds are even where that is immaterial, and 19 to 1 at a tenth of it.
    """
    return math.log10(IMMATERIAL / max(left, 1e-300))


def margin_of(evidence: Evidence) -> float:
    """Return the margin by which a cause is there, whatever else could be meant."""
    return evidence.score / max(evidence.threshold, 1e-300)


def unsure(finding: Finding) -> str | None:
    """Return why a finding is not named, None where it is."""
    if not finding.probability < NAMED:
        return None
    needed = round(100.0 * NAMED)
    sure = min(round(100.0 * finding.probability), needed - 1)      # never both alike
    return (f'{at_place(finding.effect, finding.joint)} is not named: it is {sure} % sure, and '
            f'{needed} % are needed')


def verdict_probability(verdict: str, findings: Iterable[Finding], pairs: Iterable[float],
                        nothing_left: float) -> float:
    """
    Return the probability of a verdict, from those of its findings and of its pairs.

    `nothing_left` is the probability that all else is noise.
    """
    if verdict == 'unknown':
        return 1.0 - nothing_left
    return math.prod((*(found.probability for found in findings), *pairs), start=nothing_left)
