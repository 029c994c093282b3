"""The numbers of a world's effects in the library's terms, and how much each effect does."""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

from hda_torque_estimator.diagnosis.findings.report import Detectable
from hda_torque_estimator.diagnosis.findings.smallest import WEAKER
from hidden_truth import ADDED, built, EFFECTS, layout, SAME, SCALED, worlds
import numpy as np

Numbers = dict[str, tuple[float, float]]        # the whole number, and what of it is hidden


def library_numbers(world: Any, hidden: Any) -> Numbers:
    """
    Return what the library should report of a hidden effect: its number, and how much is hidden.

    Nothing where the law has another form: its numbers then mean something else. Angles of waves
    and forces are left out.
    """
    if hidden.form:
        return {}
    shares, numbers = scattered(world), {}
    place = 1 if hidden.joint == 'joint2' else 0
    for name, value in hidden.parameters.items():
        number, size = converted(world, hidden, name, value)
        if not size or 'phase' in number or 'direction' in number:
            continue
        whole = size
        if (hidden.effect, number) in ADDED:
            own, _ = ADDED[hidden.effect, number]
            whole += getattr(world.arm.axes[place], own) * shares[own][place]
        if (hidden.effect, number) in SCALED:
            whole = (1.0 + size) * shares[SCALED[hidden.effect, number]][place] - 1.0
        numbers[number] = whole, size
    return numbers


def converted(world: Any, hidden: Any, name: str, value: float) -> tuple[str, float]:
    """Return the library's name and value of a number of the truth."""
    axis = world.arm.axes[1 if hidden.joint == 'joint2' else 0]
    match hidden.effect, name:
        case 'inertial_coupling', 'share':
            return name, -value
        case 'stiffening_error', 'curvature':
            return 'error', value / axis.curvature - 1.0
        case 'wave_generator_compliance', 'psi':        # psi / 2 = compliance / (N c_w)
            return 'compliance', 0.5 * axis.ratio ** 2 / axis.soft_torque * (value - axis.psi)
    return SAME.get(name, name), value


def scattered(world: Any) -> Mapping[str, list[float]]:
    """Return the numbers of the two joints of a world's arm over the stated ones, by names."""
    given = built(world.arm, 1.0 / world.controller)
    joints, arm = given.joints.copy(), given.arm.copy()
    layout.scatter(joints, arm, np.random.default_rng([world.seed, 0]))
    shares = {name: (joints[name] / given.joints[name]).tolist()
              for name in ('dry', 'viscous', 'damping', 'stiffness', 'gain')}
    return {**shares, 'inertia': [
        float(arm[name][0] / given.arm[name][0]) for name in ('p1', 'p2')]}


def size_and_smallest(world: Any, hidden: Any, reported: Sequence[Detectable]) -> tuple[
        float, float | None, bool]:
    """Return how large an effect is, the stated smallest size, and whether it is above that."""
    row = next((row for row in reported
                if (row.effect, row.joint) == (hidden.effect, hidden.joint)), None)
    sizes = dict(converted(world, hidden, one.name, hidden.parameters[one.name])
                 for one in EFFECTS[hidden.effect].parameters if one.is_size)
    size = abs(sizes.get(row.parameter if row else '', next(iter(sizes.values()))))
    if row is None or row.smallest_detectable is None:
        return size, None, False
    shows = (size <= row.smallest_detectable if hidden.effect in WEAKER
             else size >= row.smallest_detectable)
    return size, row.smallest_detectable, bool(shows)       # a bool of numpy is none of JSON


def powers(world: Any) -> list[float]:
    """
    Return what each hidden effect changes in a recording of its arm, as a mean square.

    Torsions count as shares of the largest torque's, commands as shares of the motor's limit:
    the record is made again without each of them, with the same chance.
    """
    whole = world_seen(world)
    changes = []
    for place in range(len(world.hidden)):
        less = world_seen(replace(world, hidden=(*world.hidden[:place],
                                                 *world.hidden[place + 1:])))
        length = min(len(whole), len(less))
        changes.append(float(((whole[:length] - less[:length]) ** 2).mean()))
    return changes


def world_seen(world: Any) -> np.ndarray:
    """Return torsions and commands of a world's recording (k, 2 n), as shares."""
    log = worlds.record(world)
    ratios, limits, bends = (np.array(values) for values in zip(*(
        (axis.ratio, axis.limit, axis.torque / axis.stiffness) for axis in world.arm.axes)))
    torsion = (log.reading[:, :, 0] / ratios - log.reading[:, :, 1]) / bends
    return np.concatenate([torsion, log.command / limits], axis=1)
