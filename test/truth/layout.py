"""Where every number of an arm stands: one record per joint, one for the arm as a whole."""

from collections.abc import Iterable, Sequence
import hashlib
from pathlib import Path
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from . import nominal
from .catalogue import CATALOGUE
from .effect import Effect, Hidden, JOINTS, TruthError
from .outside import OUTSIDE

Record: TypeAlias = Any          # of a joint or the arm, whose numbers stand under their names

EFFECTS = {effect.name: effect for effect in (*CATALOGUE, *OUTSIDE)}

JOINT_NUMBERS = {
    'ratio': nominal.RATIO, 'limit': nominal.TORQUE_LIMIT, 'size': 1.0, 'pace': nominal.PACE,
    'curvature': nominal.CURVATURE, 'psi': nominal.PSI, 'soft_torque': nominal.SOFT_TORQUE,
    'middle': 0.0, 'hand': 0.0, 'hand_damping': 0.0,
    'k_p': nominal.K_P, 'k_d': nominal.K_D, 'noise': nominal.TORQUE_NOISE,
    'inertia': nominal.INERTIA, 'dry': nominal.DRY, 'viscous': nominal.VISCOUS,
    'stiffness': nominal.STIFFNESS, 'damping': nominal.DAMPING, 'gain': 1.0,
    'reference_power': 1.0, 'motor_step': 0.0, 'motor_zero': 0.0, 'link_step': 0.0,
    'link_zero': 0.0}
ARM_NUMBERS = {
    'p1': nominal.LINK_INERTIA[0], 'p2': nominal.LINK_INERTIA[1], 'p3': nominal.LINK_INERTIA[2],
    'moment_1': nominal.MASS_MOMENTS[0], 'moment_2': nominal.MASS_MOMENTS[1],
    'length_1': nominal.LENGTH, 'length_2': nominal.LENGTH, 'apart': 0.0, 'pull': 0.0,
    'downhill': 0.0, 'across': nominal.GRAVITY, 'powered': 1.0}
LAW = ('form', 'first', 'second')       # of an effect: which law it follows, and its numbers


def neutral(effects: Iterable[Effect]) -> dict[str, float]:
    """Return the field of every parameter of the effects and the value that does nothing."""
    return {name: value for effect in effects for name, value in (
        *((f'{effect.name}_{parameter.name}', parameter.neutral)
          for parameter in effect.parameters),
        *((f'{effect.name}_{name}', 0.0) for name in LAW))}


def sources() -> str:
    """Return a digest of this package, so that no change of it meets code compiled before."""
    digest = hashlib.sha256()
    for path in sorted(Path(__file__).parent.glob('*.py')):
        digest.update(path.read_bytes())
    return digest.hexdigest()[:12]


# The compiler's cache looks at the types of arguments and at one file: the digest in the type
# makes it look at all.
JOINT_DEFAULTS = JOINT_NUMBERS | neutral(e for e in EFFECTS.values() if e.joints)
ARM_DEFAULTS = ARM_NUMBERS | neutral(e for e in EFFECTS.values() if not e.joints)
JOINT = np.dtype([(name, float) for name in (*JOINT_DEFAULTS, f'of_{sources()}')], align=True)
ARM = np.dtype([(name, float) for name in (*ARM_DEFAULTS, f'of_{sources()}')], align=True)


def nominal_joints() -> NDArray[np.void]:
    """Return the nominal joints, with every effect neutral (2,)."""
    joints = np.zeros(len(JOINTS), JOINT)
    for name, value in JOINT_DEFAULTS.items():
        joints[name] = value
    return joints


def nominal_arm() -> NDArray[np.void]:
    """Return what belongs to no single joint, with every effect neutral (1,)."""
    arm = np.zeros(1, ARM)
    for name, value in ARM_DEFAULTS.items():
        arm[name] = value
    return arm


def scatter(joints: NDArray[np.void], arm: NDArray[np.void], rng: np.random.Generator) -> None:
    """Move every toleranced number within its tolerance, each joint by itself."""
    for name, sigma in nominal.TOLERANCES.items():
        joints[name] *= 1.0 + sigma * truncated(rng, len(JOINTS))
    for name in ('p1', 'p2', 'p3'):
        arm[name] *= 1.0 + nominal.LINK_TOLERANCE * truncated(rng, 1)
    joints['link_zero'] = nominal.LINK_ZERO * truncated(rng, len(JOINTS))


def truncated(rng: np.random.Generator, size: int | tuple[int, ...]) -> NDArray[np.float64]:
    """Return normal deviates, drawn again where they are beyond the truncation."""
    deviates = rng.standard_normal(size)
    while (beyond := np.abs(deviates) > nominal.TRUNCATION).any():
        deviates[beyond] = rng.standard_normal(beyond.sum())
    return deviates


def hide(hidden: Sequence[Hidden], joints: NDArray[np.void], arm: NDArray[np.void]) -> None:
    """
    Write the hidden effects into the numbers of an arm.

    Raises TruthError for an unknown effect, a wrong joint or parameter, or one effect twice.
    """
    taken = set()
    for one in hidden:
        effect = checked(one)
        if (one.effect, one.joint) in taken:
            raise TruthError(f'{one.effect} is hidden twice on {one.joint or "the arm"}')
        taken.add((one.effect, one.joint))
        place = joints[JOINTS.index(one.joint):][:1] if one.joint else arm
        for name, value in one.parameters.items():
            place[f'{effect.name}_{name}'] = value
        for name, value in zip(LAW, one.law):
            place[f'{effect.name}_{name}'] = value


def checked(hidden: Hidden) -> Effect:
    """Return the effect that is hidden; raise TruthError where it does not exist like this."""
    effect = EFFECTS.get(hidden.effect)
    if effect is None:
        raise unknown_effect(hidden.effect)
    if hidden.joint not in (effect.joints or (None,)):
        raise TruthError(f'{effect.name} belongs to {" or ".join(effect.joints) or "the arm"}, '
                         f'got {hidden.joint}')
    names = {parameter.name for parameter in effect.parameters}
    if hidden.parameters.keys() != names:
        raise TruthError(f'{effect.name} has the parameters {", ".join(sorted(names))}, '
                         f'got {", ".join(sorted(hidden.parameters)) or "none"}')
    return effect


def unknown_effect(name: str) -> TruthError:
    """Return the error about a name that no effect has."""
    return TruthError(f'no effect is named {name!r}; valid names: {", ".join(EFFECTS)}')


def draw(effect: str, rng: np.random.Generator) -> Hidden:
    """
    Draw joint, sizes, signs and phases of an effect.

    Raises TruthError for a name that is neither in the catalogue nor outside it.
    """
    if effect not in EFFECTS:
        raise unknown_effect(effect)
    found = EFFECTS[effect]
    joint = str(rng.choice(found.joints)) if found.joints else None
    drawn: dict[str, float] = {}
    for parameter in found.parameters:
        drawn[parameter.name] = parameter.draw(rng, drawn)
    return Hidden(effect, joint, drawn, found.site, found.coordinate)
