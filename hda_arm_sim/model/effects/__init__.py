"""The effects of a real arm, each defined once: name, cause, site, parameters, law."""

from .actuation import (CommandDelay, CurrentLoopLag, DriveOffset, MotorCogging, MotorInertiaError,
                        TorqueConstantError, TorqueRipple, TorqueSaturation)
from .catalogue import effect_named, EFFECTS, effects_of
from .compliance import StiffeningError, StiffnessError, WaveGeneratorCompliance
from .effect import Effect, Scope, Site
from .environment import BaseTilt, BaseVibration, ExternalContact
from .friction import (AsymmetricFriction, CoulombFriction, LoadDependentFriction,
                       NonlinearViscousFriction, PositionDependentFriction, PreslidingFriction,
                       StribeckFriction, ThermalViscosity, ViscousFriction)
from .load import CableSpring, InertialCoupling, LinkBearingFriction, LinkInertiaError, Payload
from .sensing import (BearingCrosstalk, CoarseQuantisation, EncoderInterpolationError,
                      EncoderScaleError, LinkEncoderEccentricity, MotorEncoderEccentricity)
from .timing import ClockJitter, ClockSkew, DroppedSamples
from .transmission import (Backlash, KinematicError, StructuralDamping,
                           TorsionalHysteresis)

__all__ = [
    'AsymmetricFriction', 'Backlash', 'BaseTilt', 'BaseVibration', 'BearingCrosstalk',
    'CableSpring', 'ClockJitter', 'ClockSkew', 'CoarseQuantisation', 'CommandDelay',
    'CoulombFriction', 'CurrentLoopLag', 'DriveOffset', 'DroppedSamples', 'Effect',
    'effect_named', 'EFFECTS', 'effects_of', 'EncoderInterpolationError', 'EncoderScaleError',
    'ExternalContact', 'InertialCoupling', 'KinematicError', 'LinkBearingFriction',
    'LinkEncoderEccentricity', 'LinkInertiaError', 'LoadDependentFriction', 'MotorCogging',
    'MotorEncoderEccentricity', 'MotorInertiaError', 'NonlinearViscousFriction', 'Payload',
    'PositionDependentFriction', 'PreslidingFriction', 'Scope', 'Site', 'StiffeningError',
    'StiffnessError', 'StribeckFriction', 'StructuralDamping', 'ThermalViscosity',
    'TorqueConstantError', 'TorqueRipple', 'TorqueSaturation', 'TorsionalHysteresis',
    'ViscousFriction', 'WaveGeneratorCompliance',
]
