"""
The torsion law of a joint with the effects that change its numbers, as compiled code reads it.

Arms that differ elsewhere share it: a fit makes thousands of them.
"""

from dataclasses import replace
from functools import lru_cache
import math

from .effects import Effect
from .effects.place import STIFFENING, STIFFNESS, WIND_UP
from .torsion import chords, TorsionLaw

OF_TORSION = (STIFFENING, WIND_UP, STIFFNESS)       # places in the order of `torsion_record`
_STIFFNESSES = ('flexspline_stiffness', 'second_stiffness', 'third_stiffness')
_SEGMENTS = ('knee_1', 'second_stiffness', 'knee_2', 'third_stiffness')
# Choices unless stated otherwise.
_KEPT = 64              # records


@lru_cache(_KEPT)
def torsion_record(ratio: float, law: TorsionLaw, stiffening: Effect, softer: Effect,
                   stiffer: Effect) -> tuple[float, ...]:
    """Return a torsion law with the effects of these places, for a gear of this ratio."""
    law = _bent(law, stiffening)
    if not softer.is_neutral():
        rest = softer(nominal=1.0 / law.wave_generator_stiffness)
        law = replace(law, wave_generator_stiffness=1.0 / rest if rest > 0.0 else math.inf)
    law = replace(law, **{name: stiffer(nominal=getattr(law, name)) for name in _STIFFNESSES})
    return tuple(law.record(ratio))


def _bent(law: TorsionLaw, stiffening: Effect) -> TorsionLaw:
    """Return a torsion law that stiffens as its effect says."""
    curvature, *segments = stiffening(nominal=law.flexspline_curvature)
    law = replace(law, flexspline_curvature=curvature)
    named = dict(zip(_SEGMENTS, segments))
    if named['knee_1'] <= 0.0:
        return law
    if named['second_stiffness'] > 0.0:
        return replace(law, **named)
    stiffnesses = chords(law.flexspline_stiffness, curvature, named['knee_1'], named['knee_2'])
    return replace(law, **{**named, **dict(zip(_STIFFNESSES, stiffnesses))})
