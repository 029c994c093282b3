"""The effects of a real arm, each defined once: name, cause, site, parameters, law."""

from .catalogue import effect_named, EFFECTS, effects_of
from .effect import Effect, Scope, Signals, Site
from .friction import CoulombFriction, StribeckFriction, ViscousFriction
from .load import Payload
from .sensing import ClockSkew, CoarseQuantisation
from .transmission import Backlash, KinematicError, StructuralDamping, TorsionalHysteresis

__all__ = [
    'Backlash', 'ClockSkew', 'CoarseQuantisation', 'CoulombFriction', 'EFFECTS', 'Effect',
    'KinematicError', 'Payload', 'Scope', 'Signals', 'Site', 'StribeckFriction',
    'StructuralDamping', 'TorsionalHysteresis', 'ViscousFriction', 'effect_named', 'effects_of',
]
