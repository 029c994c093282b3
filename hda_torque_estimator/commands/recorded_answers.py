"""What a recording shows of an arm for `hda new --from`: names, ratio, counts, torque at least."""

from collections.abc import Iterator
import math
from typing import Any, NamedTuple

from hda_arm_sim.model.gear_catalogue import gear, gear_names
from hda_msgs_json.bag import Recording
from hda_msgs_json.samples import JointSamples
from hda_msgs_json.topics import motor_name, MOTOR_SUFFIX
import numpy as np
from numpy.typing import NDArray

from .arm_answers import NewError
from ..samples.readings import column_of

TRAVEL = 0.05           # of the link, from which a ratio is observable (choice) [rad]
NEAR = 0.02             # relative, by which torsion and a disc may bend the ratio (choice)
ON_GRID = 0.05          # of a step, by which changes may miss whole steps (choice)
MOST_COUNTS = 1e9       # per turn; finer is no encoder
MOST_NAMED = 6          # gears that an error names
_HALF = 0.5             # of the one turn that a gear has more with its other output


class RecordedJoint(NamedTuple):
    """What a recording shows of one joint; None for what it does not."""

    label: str
    ratio: float | None
    motor_counts: float | None
    link_counts: float | None       # 0 where no angle of it was recorded
    motor_torque: float | None      # the largest seen [N*m]


def recorded_joints(recording: Recording) -> list[RecordedJoint]:
    """Return what a recording shows of each joint; raises NewError or BagError."""
    samples = recording.joint_states()
    labels = [name.removesuffix(MOTOR_SUFFIX) for name in samples.names
              if name.endswith(MOTOR_SUFFIX)]                   # a motor alone is a joint too
    if not labels:
        raise NewError(f'{recording.path} names no joint with both sides, as joint1 and '
                       f'joint1_motor; it names {", ".join(samples.names) or "nothing"}')
    labels.sort(key=lambda label: (*samples.names,).index(
        label if label in samples.names else motor_name(label)))
    return [_recorded_joint(samples, label) for label in labels]


def add_answers(options: Any, recorded: list[RecordedJoint], source: str) -> dict[str, str]:
    """
    Fill in what the user has not stated, and return where each answer comes from, by its name.

    Raises NewError where the gear that was stated has another ratio.
    """
    origins = {}
    ratios = _ratios(options, recorded)
    if not options.ratio and any(ratio is not None for ratio in ratios.values()):
        options.ratio = [*ratios.values()]
        origins['ratio'] = f'from {source}: one more than in the name of the gear'
    if not options.joints:
        options.joints = [one.label for one in recorded]
    elif len(options.joints) != len(recorded):
        raise NewError(f'{source} has {len(recorded)} joints, '
                       f'--joints names {len(options.joints)}')
    for name in ('motor_counts', 'link_counts', 'motor_torque'):
        values = [getattr(one, name) for one in recorded]
        stated = getattr(options, name) or (name == 'motor_torque' and options.motor_current)
        if not stated and all(value is not None for value in values):
            setattr(options, name, values)
            least = ', the largest seen: no less' if name == 'motor_torque' else (
                ': no such encoder was recorded' if not any(values) else '')
            origins[name] = f'from {source}{least}'
    return origins


def _ratios(options: Any, recorded: list[RecordedJoint]) -> dict[str, float | None]:
    """
    Return the ratio of each joint where it is one more than in the name of its gear, else None.

    It is where the output is at the circular spline. Raises NewError for any other.
    """
    ratios = [one.ratio for one in recorded if one.ratio is not None]
    if not options.gear:
        fit = [name for name in gear_names() if any(_is_near(gear(name).ratio, r) for r in ratios)]
        some = f' such as {", ".join(fit[:MOST_NAMED])}' if fit else ''
        shown = ', '.join(f'{ratio:.4g}' for ratio in ratios) or 'not known: nothing moves enough'
        raise NewError(f'an arm needs --gear{some}; the ratio of the recording is {shown}')
    names, stated = (values * len(recorded) if len(values) == 1 else values
                     for values in (options.gear, options.ratio or [None]))
    found: dict[str, float | None] = {}
    for name, ratio, one in zip(names, stated, recorded):
        known = ratio or gear(name).ratio
        if one.ratio is not None and not _is_near(known, one.ratio):
            raise NewError(f'{one.label}: {name} has the ratio {known:g}, but its '
                           f'motor turns {one.ratio:.4g} times per turn of the link')
        more = one.ratio is not None and one.ratio > known + _HALF and not ratio
        found[one.label] = known + 1.0 if more else None
    return found


def _is_near(ratio: float, seen: float) -> bool:
    return abs(seen / ratio - 1.0) <= NEAR


def _recorded_joint(samples: JointSamples, label: str) -> RecordedJoint:
    sides = label, motor_name(label)
    angles = np.column_stack([column_of(samples.position, samples, name) for name in sides])
    effort = np.abs(column_of(samples.effort, samples, sides[1]))
    largest = float(effort[np.isfinite(effort)].max(initial=0.0))
    link, motor = (_counts(column[np.isfinite(column)]) for column in angles.T)
    return RecordedJoint(label, _ratio(angles[np.isfinite(angles).all(axis=1)]), motor, link,
                         largest or None)


def _ratio(both: NDArray[np.float64]) -> float | None:
    """Return how far the motor turns for the link, from angles (k, 2) of link and motor."""
    if len(both) < 2 or np.ptp(both[:, 0]) < TRAVEL:
        return None
    return float(np.polyfit(both[:, 0], both[:, 1], 1)[0])


def _counts(angle: NDArray[np.float64]) -> float | None:
    """
    Return the counts per turn of angles (k,) that come in whole steps, None of others.

    Without any angle it is 0, as that of a perfect encoder.
    """
    if not len(angle):
        return 0.0
    changes = np.abs(np.diff(angle))
    changes = changes[changes > 2.0 * math.pi / MOST_COUNTS]
    if not len(changes):
        return None
    small = changes[changes < 1.5 * changes.min()]
    step = float(small.mean())
    few = changes[changes < step / ON_GRID]                 # of many steps the error adds up
    off = np.abs(few / step - np.rint(few / step))
    return float(round(2.0 * math.pi / step)) if np.median(off) < ON_GRID else None


def origin_words(origins: dict[str, str]) -> Iterator[str]:
    """Yield a line for each answer that was not stated."""
    for name, origin in origins.items():
        yield f'  --{name.replace("_", "-")} {origin}'
