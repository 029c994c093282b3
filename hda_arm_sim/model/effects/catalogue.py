"""The catalogue: every effect that the arm can have, each on one line."""

from functools import cache

from hda_msgs_json.nearest import did_you_mean
import numpy as np

from .actuation import (CommandDelay, CurrentLoopLag, DriveOffset, MotorCogging, MotorInertiaError,
                        TorqueConstantError, TorqueRipple, TorqueSaturation)
from .compliance import StiffeningError, StiffnessError, WaveGeneratorCompliance
from .effect import Effect, Scope
from .environment import BaseTilt, BaseVibration, ExternalContact
from .friction import (AsymmetricFriction, CoulombFriction, LoadDependentFriction,
                       NonlinearViscousFriction, PositionDependentFriction, PreslidingFriction,
                       StribeckFriction, ThermalViscosity, ViscousFriction)
from .hypothesis import Unmeasured
from .load import CableSpring, InertialCoupling, LinkBearingFriction, LinkInertiaError, Payload
from .place import Place
from .sensing import (BearingCrosstalk, CoarseQuantisation, EncoderInterpolationError,
                      EncoderScaleError, LinkEncoderEccentricity, MotorEncoderEccentricity)
from .timing import ClockJitter, ClockSkew, DroppedSamples
from .transmission import (Backlash, KinematicError, LoadedKinematicError, StructuralDamping,
                           TorsionalHysteresis)
from ...foundation.parameter import ParameterError

EFFECTS: tuple[type[Effect], ...] = (
    CoulombFriction,
    ViscousFriction,
    NonlinearViscousFriction,
    StribeckFriction,
    PreslidingFriction,
    AsymmetricFriction,
    LoadDependentFriction,
    ThermalViscosity,
    PositionDependentFriction,
    TorqueRipple,
    MotorCogging,
    TorqueConstantError,
    DriveOffset,
    CurrentLoopLag,
    CommandDelay,
    TorqueSaturation,
    MotorInertiaError,
    StiffnessError,
    StiffeningError,
    WaveGeneratorCompliance,
    TorsionalHysteresis,
    StructuralDamping,
    Backlash,
    KinematicError,
    LoadedKinematicError,
    LinkEncoderEccentricity,
    MotorEncoderEccentricity,
    EncoderScaleError,
    EncoderInterpolationError,
    CoarseQuantisation,
    ClockSkew,
    DroppedSamples,
    ClockJitter,
    LinkBearingFriction,
    Payload,
    LinkInertiaError,
    InertialCoupling,
    BaseTilt,
    CableSpring,
    ExternalContact,
    BaseVibration,
    BearingCrosstalk,
)


_NAMED = {effect.name: effect for effect in EFFECTS}


def effect_named(name: str) -> type[Effect]:
    """Return the effect of this catalogue name; raises ParameterError with the valid names."""
    if isinstance(name, str) and name in _NAMED:        # a file may give a list as well
        return _NAMED[name]
    valid = ', '.join(effect.name for effect in EFFECTS)
    near = did_you_mean(name, (effect.name for effect in EFFECTS))
    raise ParameterError(f'no effect is named {name!r}{near or ";"} valid names: {valid}')


@cache
def effects_at(place: Place) -> tuple[type[Effect], ...]:
    """Return the effects that act at one place, in the order in which they do."""
    return tuple(effect for effect in EFFECTS if effect.place is place)


@cache
def sole_at(place: Place) -> type[Effect]:
    """
    Return the only effect of a place that has room for one, as where it keeps a state.

    Raises ParameterError where the catalogue has another number of effects there.
    """
    found = effects_at(place)
    if len(found) != 1:
        raise ParameterError(f'{place.name} is a place for one effect, got '
                             f'{", ".join(effect.name for effect in found) or "none"}')
    return found[0]


def unmeasured_at(place: Place) -> type[Effect]:
    """
    Return the effect of a place that a calibration looks for.

    Raises ParameterError where not just one states how it scatters from joint to joint.
    """
    found = [effect for effect in effects_at(place) if effect.unmeasured is not None]
    if len(found) != 1:
        raise ParameterError(f'a calibration looks for one effect at {place.name}, got '
                             f'{", ".join(effect.name for effect in found) or "none"}')
    return found[0]


def usual_at(place: Place) -> Unmeasured:
    """Return how what a calibration looks for at a place scatters from joint to joint."""
    usual = unmeasured_at(place).unmeasured
    assert usual is not None
    return usual


def orders_at(place: Place) -> type[Effect]:
    """Return the effect of a place that is one wave of an order still to be found."""
    found, = (effect for effect in effects_at(place)
              if effect.hypothesis is not None and 'order' in effect.hypothesis.grid)
    return found


@cache
def tried_orders(place: Place) -> tuple[float, ...]:
    """Return the orders that are tried for the one wave of a place, per turn."""
    declared = orders_at(place).hypothesis
    assert declared is not None
    return tuple(order for order in declared.grid['order'] if isinstance(order, float))


@cache
def known_as(tolerance: str) -> type[Effect]:
    """Return the effect whose numbers are known by this tolerance of the arm file."""
    for effect in EFFECTS:
        if effect.known_by is not None and effect.known_by.tolerance == tolerance:
            return effect
    raise ParameterError(f'no effect is known by the tolerance {tolerance!r}')


@cache
def effects_of(scope: Scope) -> tuple[type[Effect], ...]:
    """Return the effects that belong to one joint, or those that belong to the whole arm."""
    return tuple(effect for effect in EFFECTS if effect.scope is scope)


def record_fields(scope: Scope) -> list[tuple[str, np.dtype]]:
    """Return one record field per effect of this scope, named after it."""
    return [(effect.name, effect.record_type()) for effect in effects_of(scope)]
