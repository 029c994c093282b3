"""
Worlds: arms, motions, logs and forms of law, drawn by a seed.

    from truth import worlds
    world = worlds.draw(7, effects=('stribeck_friction',), motion='trapezoid', rate=250)
    log = worlds.record(world)              # stamps, readings, motor torques, and the truth
    worlds.stated(world.arm)                # the arm's file, as a mapping
    world.hidden                            # effects with their numbers and `form`

Everything that is not given is drawn. Seeds of development are below SEEDS, those of the final
study above it: the two have no world in common, and what is held out is drawn in the final study
alone. `tolerated` are effects that may be named although they are not hidden: what the log itself
adds, and twins of a form.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from . import arms, forms, layout, logs, motions, sizes
from .arms import DrawnArm, stated
from .effect import Hidden, JOINTS, TruthError
from .recording import Device, record as recorded, Reference, TruthRecord

__all__ = ['draw', 'hide', 'record', 'SEEDS', 'stated', 'truth_of', 'World']

SEEDS = 1_000_000               # of development; those of the final study come after them
RATES = (100, 125, 200, 250, 500, 1000, 2000)       # of logs [Hz]
CONTROLLERS = (250, 500, 1000, 2000)    # which a log takes every sample of, or every n-th [Hz]
SLOWEST_STEP = 0.004            # longest period of a controller [s]
NOMINAL_CONTROLLER = 1000       # for which the jitter of stamps is drawn [Hz]
SECONDS = 60.0
SETTLING = 1.5                  # time at the first angle before a recording begins [s]
PLAIN = 0.25                    # share of effects that have the form of README.md
FINE_COUNTS = 2.0 ** 18         # of an encoder whose own faults are below what it resolves
NEEDS_COMMAND = {'torque_constant_error', 'current_loop_lag', 'command_delay',
                 'torque_saturation', 'torque_ripple'}
TWO_JOINTS = {'inertial_coupling', 'crossed_friction', 'bearing_crosstalk'}
NEVER_SMALL = {'presliding_friction', 'torque_saturation', 'inertial_coupling',
               'dropped_samples', 'clock_jitter', 'coarse_quantisation',
               'encoder_interpolation_error', 'external_contact', 'base_vibration'}


@dataclass(frozen=True)
class World:
    """One arm that makes one motion and is logged in one way, and what is hidden in it."""

    seed: int
    arm: DrawnArm
    motion: str
    seconds: float
    controller: int             # samples per second of the controller [Hz]
    logger: logs.Logger
    noise: float
    hidden: tuple[Hidden, ...] = ()
    tolerated: frozenset[str] = field(default_factory=frozenset)
    part: int = 0               # of several recordings of the arm, each with its own motion

    @property
    def rate(self) -> float:
        """Return the samples per second of the log [Hz]."""
        return self.controller / self.logger.every

    @property
    def final(self) -> bool:
        """Return whether the world belongs to the final study."""
        return is_final(self.seed)


def is_final(seed: int) -> bool:
    """Return whether a seed belongs to the final study; raises TruthError below zero."""
    if seed < 0:
        raise TruthError(f'a seed of a world is at least 0, got {seed}')
    return seed >= SEEDS


def draw(seed: int, effects: Sequence[str] = (), *, motion: str | None = None,
         rate: int | None = None, joints: int | None = None, seconds: float = SECONDS,
         form: str | None = None) -> World:
    """
    Draw the world of a seed, with these effects hidden in it.

    Motion, rate [Hz], number of joints and form are drawn unless given. Raises TruthError for
    what is held out, unless the seed is a final one, and for effects that such an arm or motion
    cannot have.
    """
    final = is_final(seed)
    rng = np.random.default_rng([seed, 10])
    count = joints or (2 if set(effects) & TWO_JOINTS or rng.random() < 0.7 else 1)
    arm = arms.draw_arm(np.random.default_rng([seed, 11]), count)
    world = World(seed, arm, _motion(motion, rng, effects, final), seconds,
                  *_logged(rate, rng), noise=float(rng.uniform(0.5, 2.0)))
    world = replace(world, arm=resolving(arm, effects), tolerated=_tolerated(world))
    for place, effect in enumerate(effects):
        world = hide(world, effect, np.random.default_rng([seed, 12, place]), form=form)
    return world


def _motion(name: str | None, rng: np.random.Generator, effects: Sequence[str],
            final: bool) -> str:
    """Return the motion of a world: the given one if it may be made, or one that is drawn."""
    known = [one for one in motions.MOTIONS if final or one not in motions.HELD_OUT]
    if name is not None and name not in known:
        raise TruthError(f'the motions of this study are {", ".join(known)}, got {name!r}')
    still = {'standstill', 'hand_guided'} if effects else set()
    drawn = str(rng.choice([one for one in known if one not in still]))
    return name or drawn


def _logged(rate: int | None, rng: np.random.Generator) -> tuple[int, logs.Logger]:
    """Return the rate of the controller [Hz] and how it is logged, at a rate if given."""
    wanted = int(rng.choice(RATES)) if rate is None else rate
    able = [one for one in CONTROLLERS if one >= wanted and one % wanted == 0]
    if not able:
        raise TruthError(f'a log has {", ".join(map(str, RATES))} Hz, got {wanted}')
    controller = int(rng.choice(able))
    jitter = rng.uniform(1e-4, 1e-3) if rng.random() < 0.2 else 0.0
    return controller, logs.Logger(controller // wanted, min(jitter, 0.15 / wanted),
                                   bool(rng.random() < 0.3))


def resolving(arm: DrawnArm, effects: Sequence[str]) -> DrawnArm:
    """Return the arm with encoders whose own faults can be seen, where such are hidden."""
    fine = {'encoder_interpolation_error', 'coarse_quantisation'} & set(effects)
    if not fine:
        return arm
    motor, link = arm.counts
    return arm._replace(counts=(max(motor, 2.0 ** 14), max(link, FINE_COUNTS)))


def _tolerated(world: World) -> frozenset[str]:
    """Return what may be named because of how the arm is moved and logged."""
    names = {'clock_jitter'} if world.logger.jitter > 0.0 else set()
    if world.motion in ('standstill', 'hand_guided'):
        names.add('external_contact')       # somebody pushes or leads the arm
    return frozenset(names)


def hide(world: World, effect: str, rng: np.random.Generator, *, shrink: float = 1.0,
         form: str | None = None, joint: str | None = None) -> World:
    """Return the world with one more effect in it; a form of '' is the one of README.md."""
    if effect in TWO_JOINTS and len(world.arm.axes) == 1:
        raise TruthError(f'{effect} needs two joints')
    if effect in NEEDS_COMMAND and world.motion == 'hand_guided':
        raise TruthError(f'{effect} does nothing while the motors are off')
    drawn = layout.draw(effect, rng)
    if drawn.joint is not None and (joint is not None or len(world.arm.axes) == 1):
        drawn = replace(drawn, joint=joint or JOINTS[0])
    drawn = sizes.scaled(drawn, world.arm, 1.0 if effect in NEVER_SMALL else shrink)
    if 'rest_angle' in drawn.parameters:        # within what the motion passes
        home = arms.HOME[JOINTS.index(drawn.joint or JOINTS[0])]
        drawn.parameters['rest_angle'] = home + 0.4 * (drawn.parameters['rest_angle'] - 0.5)
    if effect == 'clock_jitter':                # of the samples of its controller
        drawn.parameters['jitter'] *= NOMINAL_CONTROLLER / world.controller
    if 'onset' in drawn.parameters:
        drawn.parameters['onset'] *= min(world.seconds / SECONDS, 1.0)
    chosen = _form(effect, rng, world.final) if form is None else form
    if chosen:
        drawn = forms.formed(drawn, chosen, rng)
    twins = [name for one in forms.FORMS.get(effect, ()) if one.name == chosen
             for name in one.also]
    return replace(world, hidden=(*world.hidden, drawn),
                   tolerated=world.tolerated.union(twins))


def _form(effect: str, rng: np.random.Generator, final: bool) -> str:
    """Draw the name of a form, '' for the one of README.md."""
    known = forms.forms_of(effect, final=final)
    if not known or rng.random() < PLAIN:
        return ''
    return known[rng.integers(len(known))].name


def truth_of(world: World) -> TruthRecord:
    """Return the whole recording of the controller, before it is logged."""
    _refuse_held_out(world)
    period = 1.0 / world.controller
    built = arms.built(world.arm, period)
    time = period * np.arange(round(world.seconds * world.controller))
    limits = tuple(motions.Limits(0.5 * axis.fastest / axis.ratio, 0.3 * axis.torque / inertia)
                   for axis, inertia in zip(world.arm.axes, world.arm.heaviest()))
    rng = np.random.default_rng([world.seed, 13, world.part])
    motion = motions.made(world.motion, time, limits, rng)
    force = np.zeros_like(motion.angle)
    if motion.pushed:
        force = _pushes(time, sizes.scales(world.arm, None)['force'], rng)
    if not motion.powered:
        built.arm['powered'] = 0.0
        for joint, axis in zip(built.joints, world.arm.axes):
            joint['hand'], joint['hand_damping'] = 6.0 * axis.torque, 0.6 * axis.torque
    return recorded(world.hidden, Reference(motion.angle, motion.rate, period, force), world.seed,
                    noise=world.noise, device=Device(counts=world.arm.counts, built=built),
                    settling=SETTLING, part=world.part)


def _pushes(time: np.ndarray, scale: float, rng: np.random.Generator) -> np.ndarray:
    """Return pushes at the tip (k, 2), soft and from all sides [N]."""
    force, begin = np.zeros((len(time), 2)), 2.0
    while begin < time[-1]:
        way, most = rng.uniform(-np.pi, np.pi), rng.uniform(5.0, 30.0)
        lasts = rng.uniform(0.5, 2.0)
        share = np.clip((time - begin) / lasts, 0.0, 1.0)
        force += scale * most * np.outer(np.sin(np.pi * share) ** 2, (np.cos(way), np.sin(way)))
        begin += lasts + rng.uniform(2.0, 6.0)
    return force


def _refuse_held_out(world: World) -> None:
    """Raise TruthError for a world of development that holds what is held out."""
    if world.motion in motions.HELD_OUT and not world.final:
        raise TruthError(f'the motion {world.motion} is held out')
    allowed = {one.effect: forms.forms_of(one.effect, final=world.final) for one in world.hidden}
    for one in world.hidden:
        if one.form and one.form not in {form.name for form in allowed[one.effect]}:
            raise TruthError(f'the form {one.form} of {one.effect} is held out')


def record(world: World) -> logs.Log:
    """Return the log of a world."""
    seen = truth_of(world)
    return logs.kept(seen, world.logger, len(world.arm.axes),
                     np.random.default_rng([world.seed, 14, world.part]))
