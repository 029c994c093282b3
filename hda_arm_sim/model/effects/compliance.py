"""What the stiffness of a gear is beside the stated one (docs/model.md#effects)."""

from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from .effect import Effect, Site
from .hypothesis import Hypothesis, KNEES, SCALE, TORQUE_LOOPS, Typical, Unmeasured
from .place import Place, Signal, Stated, STIFFENING, STIFFNESS, WIND_UP
from .words import Words
from ...foundation.compiled import compiled, Record
from ...foundation.parameter import parameter


@compiled
def stiffer(own: Record, at: Stated) -> Signal:
    """Return the flexspline's stiffness at zero torque, (eq:stiffness) [N*m/rad at the output]."""
    return at.nominal * (1.0 + own.error)


@compiled
def bent(own: Record, at: Stated) -> tuple[Signal, float, float, float, float]:
    """Return curvature, knees and stiffnesses of the flexspline in force, (eq:stiffening)."""
    return (at.nominal * (1.0 + own.error), own.knee_1, own.second_stiffness, own.knee_2,
            own.third_stiffness)


@compiled
def softer(own: Record, at: Stated) -> Signal:
    """Return the wave generator's compliance at zero torque, (eq:compliance) [rad/(N*m) motor]."""
    return np.maximum(at.nominal + own.compliance, 0.0)


@dataclass(frozen=True)
class StiffnessError(Effect):
    """Flexspline that is stiffer or softer than stated, at every torque alike, (eq:stiffness)."""

    name: ClassVar[str] = 'stiffness_error'
    cause: ClassVar[str] = 'the flexspline is stiffer or softer than stated'
    site: ClassVar[Site] = Site.TORSION
    place: ClassVar[Place] = STIFFNESS
    law = staticmethod(stiffer)
    # (measured: of a gear that is softer in all compliances alike it left up to 0.0015, of a
    # wind-up 0.02 at least)
    hypothesis: ClassVar[Hypothesis | None] = Hypothesis(
        varies=('joint_torque',), reach=0.003,
        free={'error': 0.05}, alike=('link_inertia_error', 'stiffening_error'), form_share=0.01,
        experiment=SCALE)
    typical: ClassVar[Typical | None] = Typical({'error': 0.1})
    unmeasured: ClassVar[Unmeasured | None] = Unmeasured({'error': 0.25})
    tolerance: ClassVar[tuple[str, str] | None] = ('error', 'stiffness')
    words: ClassVar[Words] = Words(
        'has a flexspline that is {size} stiffer than stated', 'flexspline',
        'Check the size of the gear that is built in, and the screws of the flexspline.',
        ('error',), less='has a flexspline that is {size} softer than stated')
    error: float = parameter(0.0, '', -0.9, 5.0, 'relative error of the flexspline stiffness')


@dataclass(frozen=True)
class StiffeningError(Effect):
    """Flexspline that stiffens otherwise: curvature, or three segments, (eq:stiffening)."""

    name: ClassVar[str] = 'stiffening_error'
    cause: ClassVar[str] = 'the flexspline stiffens with torque otherwise than stated'
    site: ClassVar[Site] = Site.TORSION
    place: ClassVar[Place] = STIFFENING
    law = staticmethod(bent)
    # (measured: fitted alone, it left a hundredth of the 3 % that were forgiven before. Of three
    # segments or a cubic law it left up to 0.04, of a stiffness 0.15 at least)
    hypothesis: ClassVar[Hypothesis | None] = Hypothesis(
        varies=('joint_torque',), reach=0.04,
        free={'error': 0.3}, grid={'error': (-0.8, 0.5), ('knee_1', 'knee_2'): KNEES},
        alike=('stiffness_error', 'wave_generator_compliance'), form_share=0.01,
        form_power=0.0003, form_error=0.01, experiment='slow torques up to 60 % of the peak',
        doubts={'error': (0.17, 'error')}, stands={'knee_1': 0.0},
        ends=('error',))                                    # no stiffening at all
    typical: ClassVar[Typical | None] = Typical({'error': 0.8})
    unmeasured: ClassVar[Unmeasured | None] = Unmeasured({
        'error': 0.5, 'knee_1': 0.3, 'second_stiffness': 0.3, 'knee_2': 0.3,
        'third_stiffness': 0.3})
    words: ClassVar[Words] = Words(
        'has a flexspline that stiffens {size} more with torque than stated', 'flexspline',
        'Load the joint in steps with its motor held, and read the torsion.', ('error',),
        less='has a flexspline that stiffens {size} less with torque than stated')
    error: float = parameter(0.0, '', -1.0, 10.0, 'relative error of c_f; -1 is a linear law')
    knee_1: float = parameter(
        0.0, 'N*m', 0.0, 1e4, 'torque T1 of the first knee of three segments; 0 for none')
    second_stiffness: float = parameter(
        0.0, 'N*m/rad', 0.0, 1e7, 'K2, beyond T1; 0 for segments that meet on the curve of c_f')
    knee_2: float = parameter(0.0, 'N*m', 0.0, 1e4, 'torque T2 of the second knee')
    third_stiffness: float = parameter(0.0, 'N*m/rad', 0.0, 1e7, 'K3, beyond T2')


def rigid(joint: Any) -> float:
    """Return the compliance of a rigid wave generator, (eq:compliance) [rad/(N*m) motor]."""
    return -1.0 / float(joint.torsion.wave_generator_stiffness)


@dataclass(frozen=True)
class WaveGeneratorCompliance(Effect):
    """Soft wind-up near zero torque that is larger or smaller than stated, (eq:compliance)."""

    name: ClassVar[str] = 'wave_generator_compliance'
    cause: ClassVar[str] = 'the soft wind-up of the wave generator near zero torque differs'
    site: ClassVar[Site] = Site.TORSION
    place: ClassVar[Place] = WIND_UP
    law = staticmethod(softer)
    # (measured: fitted rightly it left 0.0003 of its power; ten records were 9 to 20 % off. Of a
    # hyperbolic tangent it left up to 0.012, of a stiffness 0.03 at least)
    hypothesis: ClassVar[Hypothesis | None] = Hypothesis(
        varies=('joint_torque',), reach=0.012,
        free={'compliance': 0.1}, least={'compliance': rigid},
        alike=('backlash', 'stiffening_error', 'stiffness_error'), form_power=0.001,
        form_error=0.002, experiment=TORQUE_LOOPS,
        doubts={'compliance': (0.25, 'compliance')})
    typical: ClassVar[Typical | None] = Typical({'compliance': 0.5})
    unmeasured: ClassVar[Unmeasured | None] = Unmeasured({'compliance': 0.5})
    words: ClassVar[Words] = Words(
        'winds up {size} more at its wave generator near zero torque', 'wave_generator',
        'Check the wear of the wave generator bearing.', ('compliance',),
        less='winds up {size} less at its wave generator near zero torque')
    compliance: float = parameter(
        0.0, 'rad/(N*m)', -1e3, 1e3, 'added to 1 / K_w0, motor side; -1 / K_w0 leaves none')
