"""
What could be wrong: every effect as hypotheses from which a search can start.

A hypothesis gives the numbers to fit, starting values that a fit can reach any size from, what it
is confused with, and the motion that decides. The laws themselves stay in the model.
"""

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field, replace
from itertools import product
import math
from typing import Any

from hda_arm_sim.model.arm import Arm
from hda_arm_sim.model.effects import effect_named, Scope
from hda_arm_sim.model.parts import Joint

from .term import Term


Grid = Mapping[str | tuple[str, ...], tuple[float, ...] | tuple[tuple[float, ...], ...]]


@dataclass(frozen=True)
class Hypothesis:
    """
    How one effect is looked for.

    `free` and `waves` name the numbers to fit with a typical size; `grid` lists starting values
    of those numbers, or of several at once, that the residual does not depend on linearly, and
    `least` bounds by the joint below which the law does not change any more. `form_error` is the
    share of the effect's power that its law may leave, where the literature has laws of several
    forms. A curve without a name at its site may improve the score by `form` and by `form_share`
    of what the effect improves it, and may explain `form_power`, a share of the effect's power.
    `doubts` are half-widths that intervals have for the same reason, as shares of another number
    or absolute. `twin` is an effect that no motion tells from this one. What acts on the command
    acts on the noise of the encoders that it repeats: two such effects are compared `below` a
    frequency [Hz], and one of which the power over that of noise is less than `clear` is not told
    from the first of `alike`, and no other `form` than the usual one is asked of it.
    """

    free: dict[str, float] = field(default_factory=dict)
    waves: dict[tuple[str, str], float] = field(default_factory=dict)
    grid: Grid = field(default_factory=dict)
    least: dict[str, Callable[[Joint], float]] = field(default_factory=dict)
    alike: tuple[str, ...] = ()
    experiment: str = ''
    form_error: float = 0.003
    form: float = 300.0
    form_share: float = 0.02
    form_power: float = 0.0
    doubts: dict[str, tuple[float, str]] = field(default_factory=dict)
    twin: str = ''
    clear: float = 0.0
    below: float = math.inf


def _wave(order: int, size: float) -> dict[tuple[str, str], float]:
    return {(f'amplitude_{order}', f'phase_{order}'): size}


def _rigid(joint: Joint) -> float:
    """Return the compliance that leaves a rigid wave generator, (64) [rad/(N*m) motor side]."""
    return -1.0 / joint.torsion.wave_generator_stiffness


_LOOP = ('slow torque loops about zero at two amplitudes and two rates with the motor clamped; '
         'constant speed both ways for skew')
_SCALE = 'hang a known mass on the tip of a tilted arm, or push it with a force sensor'
_SLOW = 'constant slow speeds over two motor turns, and reversals of different length'

# Improvement by a curve beside a law of one form, where another one differs from it by little.
_NO_OTHER_FORM = 75.0

# Of no segments, and of the data sheets of sizes 14, 17, 20 and 25 [N*m].
_KNEES = ((0.0, 0.0), (2.0, 6.9), (3.9, 12.0), (7.0, 25.0), (14.0, 48.0))

HYPOTHESES: dict[str, Hypothesis] = {
    'coulomb_friction': Hypothesis({'level': 0.01}, alike=('stribeck_friction',),
                                   experiment=_SLOW),
    'viscous_friction': Hypothesis({'slope': 5e-5}, alike=('thermal_viscosity',
                                                           'nonlinear_viscous_friction'),
                                   experiment='at least three speeds, the same early and late'),
    'nonlinear_viscous_friction': Hypothesis(
        {'coefficient': 1e-3, 'exponent': 0.1}, grid={'exponent': (0.5, 1.7)},
        alike=('viscous_friction', 'stribeck_friction'), experiment='at least three speeds'),
    'stribeck_friction': Hypothesis(
        {'excess': 0.01, 'speed': 1.0}, grid={'speed': (3.0, 10.0, 25.0)},
        alike=('coulomb_friction', 'presliding_friction', 'motor_cogging'), form_error=0.02,
        experiment=_SLOW),
    'presliding_friction': Hypothesis(
        {'stiffness': 1.0}, grid={'stiffness': (3.0, 10.0)},
        alike=('stribeck_friction', 'current_loop_lag'), form_share=0.08, form_error=0.02,
        experiment=_SLOW),
    'asymmetric_friction': Hypothesis({'asymmetry': 0.1}, alike=('drive_offset',),
                                      twin='drive_offset',
                                      experiment='a dwell at zero command, and a return run'),
    'load_dependent_friction': Hypothesis(
        {'coefficient': 0.1}, alike=('torque_constant_error',),
        experiment='both directions under both signs of load'),
    'thermal_viscosity': Hypothesis(
        {'amplitude': 1e-4, 'time_constant': 10.0}, grid={'time_constant': (20.0, 100.0)},
        alike=('viscous_friction',), form_share=0.08, form_error=0.03,
        experiment='the same motion early, in the middle and late'),
    'position_dependent_friction': Hypothesis(
        waves={('amplitude', 'phase'): 0.1}, grid={'order': (1.0, 2.0, 3.0, 4.0, 6.0)},
        alike=('asymmetric_friction',), experiment='a slow full turn of the link both ways'),
    'torque_ripple': Hypothesis(waves={**_wave(2, 5e-3), **_wave(4, 5e-3)},
                                alike=('motor_cogging', 'kinematic_error'),
                                experiment='the same slow speed at two loads'),
    'motor_cogging': Hypothesis(
        waves={('amplitude', 'phase'): 5e-3},
        grid={'order': (1.0, 6.0, 7.0, 8.0, 12.0, 14.0, 21.0, 24.0, 28.0, 42.0)},
        alike=('torque_ripple',), experiment='one motor turn at 2 rad/s'),
    'torque_constant_error': Hypothesis({'error': 0.02}, alike=('link_inertia_error',
                                                                'stiffness_error'),
                                        experiment=_SCALE),
    'drive_offset': Hypothesis({'offset': 5e-3}, alike=('asymmetric_friction',),
                               twin='asymmetric_friction',
                               experiment='a dwell at zero command, and a return run'),
    'current_loop_lag': Hypothesis({'time_constant': 1e-3},
                                   grid={'time_constant': (1e-3, 4e-3)},
                                   alike=('command_delay',),
                                   form_error=0.02, form=_NO_OTHER_FORM, form_share=0.002,
                                   clear=4.0, below=30.0,
                                   experiment='a small multi-sine from 1 to 60 Hz'),
    'command_delay': Hypothesis({'delay': 1e-3}, grid={'delay': (1e-3, 4e-3)},
                                alike=('current_loop_lag',),
                                form_error=0.02, form=_NO_OTHER_FORM, form_share=0.002,
                                clear=4.0, below=30.0,
                                experiment='a small multi-sine from 1 to 60 Hz'),
    'torque_saturation': Hypothesis({'limit': 0.02}, grid={'limit': (0.05, 0.1, 0.15, 0.2)},
                                    alike=('torque_constant_error',),
                                    experiment='a motion that asks for the largest torque'),
    'motor_inertia_error': Hypothesis({'error': 0.05}, alike=('torque_constant_error',
                                                              'link_inertia_error'),
                                      experiment='fast small motions: the motor hardly moves the '
                                                 'link'),
    'stiffness_error': Hypothesis({'error': 0.05}, alike=('link_inertia_error',
                                                          'stiffening_error'),
                                  form_share=0.01, experiment=_SCALE),
    'stiffening_error': Hypothesis({'error': 0.3}, grid={
        'error': (-0.8, 0.5), ('knee_1', 'knee_2'): _KNEES},
                                   alike=('stiffness_error', 'wave_generator_compliance'),
                                   form_share=0.01, form_power=0.0003, form_error=0.01,
                                   experiment='slow torques up to 60 % of the peak',
                                   doubts={'error': (0.17, 'error')}),
    'wave_generator_compliance': Hypothesis({'compliance': 0.1}, least={'compliance': _rigid},
                                            alike=('backlash', 'stiffening_error',
                                                   'stiffness_error'),
                                            form_power=0.001, form_error=0.002, experiment=_LOOP,
                                            doubts={'compliance': (0.25, 'compliance')}),
    'torsional_hysteresis': Hypothesis({'level': 0.3, 'width': 2e-5},
                                       grid={'width': (3e-5, 1e-4, 3e-4)},
                                       alike=('backlash', 'clock_skew', 'structural_damping'),
                                       form_share=0.2, form_error=0.12, experiment=_LOOP),
    'structural_damping': Hypothesis({'coefficient': 2.0}, alike=('torsional_hysteresis',
                                                                  'clock_skew'),
                                     experiment='excite the resonance, 15 to 50 Hz'),
    'backlash': Hypothesis({'half_width': 2e-5}, grid={'half_width': (5e-5, 1.5e-4)},
                           alike=('wave_generator_compliance', 'torsional_hysteresis'),
                           form_share=0.08, experiment=_LOOP,
                           doubts={'half_width': (0.1, 'half_width')}),
    'kinematic_error': Hypothesis(waves={**_wave(1, 2e-5), **_wave(2, 2e-5), **_wave(4, 2e-5)},
                                  alike=('motor_encoder_eccentricity', 'torque_ripple'),
                                  experiment='constant speed off the resonance at two loads'),
    'link_encoder_eccentricity': Hypothesis(waves={**_wave(1, 5e-5), **_wave(2, 5e-5)},
                                            alike=('encoder_scale_error',),
                                            experiment='a slow full turn of the link both ways'),
    'motor_encoder_eccentricity': Hypothesis(waves={('amplitude', 'phase'): 2e-3},
                                             alike=('kinematic_error',),
                                             experiment='constant speed off the resonance at two '
                                                        'loads'),
    'encoder_scale_error': Hypothesis({'error': 5e-5}, alike=('link_encoder_eccentricity',),
                                      experiment='a slow full turn of the link both ways'),
    'clock_skew': Hypothesis({'skew': 5e-5}, alike=('torsional_hysteresis',),
                             experiment='two constant speeds both ways'),
    'link_bearing_friction': Hypothesis({'level': 0.3}, alike=('cable_spring',),
                                        form_share=0.08, form_error=0.006,
                                        experiment='reversals at two loads',
                                        doubts={'level': (0.17, 'level')}),
    'payload': Hypothesis({'mass': 0.5}, alike=('link_inertia_error',), form=2.0 * _NO_OTHER_FORM,
                          form_share=0.002, experiment=_SCALE),
    'link_inertia_error': Hypothesis({'error': 0.05}, alike=('payload', 'stiffness_error'),
                                     experiment='accelerate at several elbow angles'),
    'inertial_coupling': Hypothesis({'share': -0.2}, grid={'share': (-0.2, 0.2)},
                                    alike=('link_inertia_error',),
                                    experiment='move one joint and hold the other, then swap'),
    'base_tilt': Hypothesis(waves={('tilt', 'direction'): 5e-3}, alike=('cable_spring',),
                            experiment='hold postures all round the base'),
    'cable_spring': Hypothesis({'stiffness': 0.3, 'rest_angle': 0.3},
                               grid={'rest_angle': (-1.5, 1.5)}, alike=('base_tilt',),
                               experiment='a slow sweep of the whole range'),
    'external_contact': Hypothesis(
        {'force': 1.0, 'direction': 0.02, 'onset': 0.01, 'duration': 0.01},
        alike=('payload',), form_share=0.08, form_error=0.03,
        doubts={'direction': (0.03, ''), 'onset': (0.045, 'duration'),
                'duration': (0.09, 'duration')},            # edges may take up to a fifth of it
        experiment='the same motion again, with nothing near the arm'),
    'base_vibration': Hypothesis(
        {'amplitude': 2e-3, 'frequency': 0.05, 'damping': 5e-3, 'direction': 0.05},
        alike=('kinematic_error',), experiment='sudden stops at several postures'),
    'bearing_crosstalk': Hypothesis({'coefficient': 1e-6}, alike=('link_encoder_eccentricity',),
                                    experiment='the same posture with and without a payload'),
}


def terms_of(arm: Arm, name: str) -> Iterator[Term]:
    """Return every start of one hypothesis: each place on the arm, each point of the grid."""
    kind, sought = effect_named(name), HYPOTHESES[name]
    for joint in (None,) if kind.scope is Scope.ARM else arm.labels:
        present = arm.effect(name, joint)
        for point in product(*sought.grid.values()):
            start = replace(present, **_named(sought.grid, point))
            yield Term(start, joint, tuple(sought.free), tuple(sought.free.values()),
                       tuple(sought.waves), tuple(sought.waves.values()),
                       least=_least(arm, sought, joint),
                       grown=next(iter(sought.free), '') in sought.grid)


def _least(arm: Arm, sought: Hypothesis, joint: str | None) -> tuple[float, ...]:
    """Return the bounds of the free numbers at a joint, none where the law has none."""
    if joint is None or not sought.least:
        return ()
    bound = {name: least(arm.joint(joint)) for name, least in sought.least.items()}
    return tuple(bound.get(name, -math.inf) for name in sought.free)


def variant_of(term: Term) -> tuple[float, ...]:
    """Return the numbers of a term that its grid sets together: they make it another law."""
    return tuple(getattr(term.effect, name) for names in HYPOTHESES[term.name].grid
                 if not isinstance(names, str) for name in names)


def _named(grid: Grid, point: tuple[Any, ...]) -> dict[str, float]:
    """Return a point of a grid by the names of its numbers."""
    named: dict[str, float] = {}
    for names, values in zip(grid, point):
        named |= {names: values} if isinstance(names, str) else dict(zip(names, values))
    return named
