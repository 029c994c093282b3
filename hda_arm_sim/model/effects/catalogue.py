"""The catalogue: every effect that the arm can have, each on one line."""

import numpy as np

from .effect import Effect, Scope
from .friction import CoulombFriction, StribeckFriction, ViscousFriction
from .load import Payload
from .sensing import ClockSkew, CoarseQuantisation
from .transmission import Backlash, KinematicError, StructuralDamping, TorsionalHysteresis
from ..parameter import ParameterError

EFFECTS: tuple[type[Effect], ...] = (
    CoulombFriction,
    ViscousFriction,
    StribeckFriction,
    KinematicError,
    Backlash,
    TorsionalHysteresis,
    StructuralDamping,
    ClockSkew,
    CoarseQuantisation,
    Payload,
)


def effect_named(name: str) -> type[Effect]:
    """Return the effect of this catalogue name; raises ParameterError with the valid names."""
    for effect in EFFECTS:
        if effect.name == name:
            return effect
    valid = ', '.join(effect.name for effect in EFFECTS)
    raise ParameterError(f'no effect is named {name!r}; valid names: {valid}')


def effects_of(scope: Scope) -> tuple[type[Effect], ...]:
    """Return the effects that belong to one joint, or those that belong to the whole arm."""
    return tuple(effect for effect in EFFECTS if effect.scope is scope)


def record_fields(scope: Scope) -> list[tuple[str, np.dtype]]:
    """Return one record field per effect of this scope, named after it."""
    return [(effect.name, effect.record_type()) for effect in effects_of(scope)]
