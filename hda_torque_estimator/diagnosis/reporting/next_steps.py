"""What to measure or to do next: where a recording leaves a question, what would answer it."""

from collections.abc import Iterator

from hda_arm_sim.model.typical_sizes import SIZED

from ..detectability.slow_rate import FAST, SLOWER
from ..findings.report import Diagnosis
from ..findings.rest import NOTHING, Unexplained
from ..fitting.hypotheses import HYPOTHESES

# Numerics; choices unless stated otherwise.
_LISTED = 3             # effects that a sentence names
# What shows whether a rest follows the coordinate that it seems to follow.
_SHOWN_BY = {
    'time': 'record the same motion again, later: what is the same then is no matter of time',
    'motor_velocity': 'record constant speeds, slow to fast and both ways',
    'link_velocity': 'record constant speeds, slow to fast and both ways',
    'motor_angle': 'record a slow constant speed over several motor turns, both ways',
    'link_angle': 'record a slow sweep over the whole link angle, both ways',
    'other_link_angle': 'record the joint at several fixed angles of the other one',
    'joint_torque': 'record slow loops of torque, with a known mass and without',
    'motor_torque': 'record slow loops of torque, with a known mass and without',
    NOTHING: 'record the same motion twice: what does not repeat is no law of the arm',
}


def next_steps(diagnosis: Diagnosis) -> tuple[str, ...]:
    """Return sentences on what to do, none where a diagnosis leaves no question."""
    return tuple(dict.fromkeys(_steps(diagnosis)))


def _steps(diagnosis: Diagnosis) -> Iterator[str]:
    yield from (loop.step() for loop in diagnosis.recording.oscillating)
    if diagnosis.verdict == 'unknown' and diagnosis.unexplained is not None:
        yield _shown(diagnosis.unexplained)
    yield from (f'to decide between {" and ".join(name for name, _ in pair.effects)}: '
                f'{pair.experiment}' for pair in diagnosis.ambiguous)
    slow = diagnosis.recording.rate < SLOWER * FAST
    if diagnosis.verdict == 'unknown' and slow or diagnosis.limited_by == 'rate':
        yield f'record at {FAST / 1000.0:g} kHz'
    if diagnosis.limited_by == 'motion':
        yield from _planned(diagnosis)


def _shown(rest: Unexplained) -> str:
    """Return what shows whether a rest follows what it seems to follow."""
    return _SHOWN_BY.get(rest.depends_on, _SHOWN_BY[NOTHING])


def _planned(diagnosis: Diagnosis) -> Iterator[str]:
    """Yield the command that plans a motion for effects that no size of would have shown."""
    shown = {row.effect for row in diagnosis.excitation if row.smallest_detectable is not None}
    hidden = dict.fromkeys(row.effect for row in diagnosis.excitation
                           if row.effect not in shown and row.effect in SIZED
                           and row.effect in HYPOTHESES)
    if hidden:
        listed = ' '.join(list(hidden)[:_LISTED])
        yield ('plan a motion that shows what this one cannot: '
               f'hda plan --arm {diagnosis.arm or "ARM"} --show {listed} --out motion.csv')
    else:
        yield 'record a motion of larger and faster strokes: hda plan --show EFFECT plans one'
