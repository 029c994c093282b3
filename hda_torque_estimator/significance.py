"""Numbers of statistics that several judges share, each in one place."""

import math

# Judgement; choices unless stated otherwise.
# Improvement of the score beyond what its freedom costs, from which a cause is named. The score is
# twice a log likelihood, so this asks for odds of e^30 to 1.
SCORE_BAR = 60.0
MATERIAL = 0.8          # rms beyond noise, over that of noise, that asks for a cause
NEARLY_ALL = 0.9        # share of a thing from which nothing of note lacks
# (source: more than all else together)
MOSTLY = 0.5            # share of a thing from which it is that more than anything else
IMMATERIAL = 0.02       # share of a power below which it is not worth a name
# Power over that about it, or elsewhere (null: passed by lines in 1 % of spectra, by none of the
# turns of 87 healthy joints of a cobot, which had up to 16; typical presliding had 34 to 548).
STANDS_OUT = 20.0
# (source: normal distribution, one of 16 000 is farther off)
DEVIATIONS = 4.0        # standard deviations from which a difference is not of noise
STILL = 0.02            # link travel below which nothing was moved [rad]
MANY = 5                # causes or contacts: one more is an imperfection, or a part of a rest

HARDLY = 1.0 - NEARLY_ALL           # share of a thing up to which it is nothing of note
UNLIKE = MOSTLY ** 2    # share of power by which two records of one thing may differ
# Rms over that of noise from which it is a rest, however noise is known: it is material still if
# what is known of the noise is MOSTLY of it, 2.56.
LOUD = math.sqrt(1.0 + MATERIAL ** 2) / MOSTLY
# Improvement of the score by which a curve, a bend or a whole rest explained is certain: more than
# many imperfections leave together of which none is worth a name. Right causes left some 100 to
# the best curve, others 700 to 5500. What stood in for a disc bent by 4 to 71, six true discs by
# 33 000 and more.
CERTAIN = MANY * SCORE_BAR

# Numerics.
NORMAL_90 = 1.645           # deviations each side of a 90 % interval (source: normal distribution)
NORMAL_MEDIAN = 0.6745      # median of absolute noise over deviation (source: normal distribution)
# Mean square of the fourth differences of white noise over its own: 1 + 16 + 36 + 16 + 1
# (source: squares of the binomial coefficients).
FOURTH_DIFFERENCES = 70.0


def surely_above(bar: float) -> float:
    """
    Return the improvement of the score that an effect must be worth to pass a bar 19 times of 20.

    By noise it varies by twice its root (source: noncentral chi-square distribution; eq:shown).
    """
    return (NORMAL_90 + math.sqrt(NORMAL_90 ** 2 + bar)) ** 2
