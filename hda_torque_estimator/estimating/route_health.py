"""
Say in words what the comparison of torsion and motor torque found wrong, joint by joint.

An error that the comparison taught is remarkable where it lies far beyond its tolerance and is
known well enough to say so. A difference that no error explains is one too (docs/estimation.md).
"""

from collections.abc import Iterator
from typing import NamedTuple

from hda_arm_sim.foundation.arrays import Array
from hda_arm_sim.model.effects import EFFECTS
from hda_arm_sim.model.parts import Joint, Tolerances
import numpy as np

from .laws import fusion_memory as fusion
from .laws.route_errors import (DRY, ERRORS, GAIN, LINK_1, LINK_2, OFFSET, RIPPLE_2, RIPPLE_4,
                                SHAFT_1, SHAFT_2, SHAFT_4, SKEW, STIFFNESS, VISCOUS, ZERO)

# Choices unless stated otherwise.
# A healthy arm's errors are drawn from a normal distribution of one tolerance. The two parts of a
# wave make a Rayleigh distribution. Each of 7 numbers and 7 waves passes its bar once in 280 000
# joints: together one joint in 20 000. Waves at the bar of a number pass it five times as often
# (source: normal and Rayleigh distributions).
REMARKABLE, REMARKABLE_WAVE = 4.63, 5.01        # tolerances, and deviations of what was learnt
WELL, UNTAUGHT = 'well', 'nothing learnt yet'
# (null: misfits of healthy arms wander up to 6 over one second, and these are over five)
MISFITTING = 8.0        # squared differences over those that tolerances allow

# Errors by the tolerances of the arm file in which they are stated.
_WAVES = ((SHAFT_1, 'kinematic_error', 'order 1 of the motor'),
          (SHAFT_2, 'kinematic_error', 'order 2 of the motor'),
          (SHAFT_4, 'kinematic_error', 'order 4 of the motor'),
          (RIPPLE_2, 'torque_ripple', 'order 2 of the motor'),
          (RIPPLE_4, 'torque_ripple', 'order 4 of the motor'),
          (LINK_1, 'eccentricity', 'order 1 of the link'),
          (LINK_2, 'eccentricity', 'order 2 of the link'))
_NUMBERS = ((ZERO, 'torsion_zero'), (SKEW, 'clock_skew'), (STIFFNESS, 'stiffness'),
            (DRY, 'dry_friction'), (VISCOUS, 'viscous_friction'), (GAIN, 'torque_constant'),
            (OFFSET, 'drive_offset'))
# What is said of them: an effect brings its words, parts of a joint have none.
_WORDS = {effect.known_by.tolerance: effect.known_by.beyond for effect in EFFECTS
          if effect.known_by} | {
    'torsion_zero': 'an encoder slipped: the zero of the torsion moved by {size:.1e} rad',
    'stiffness': 'the stiffness changed by {percent:+.0f} %'}


class Remark(NamedTuple):
    """What is wrong, in words, and by how many tolerances."""

    words: str
    tolerances: float


def remarks(known: Tolerances, memory: Array) -> list[Remark]:
    """Return what is wrong with a joint by its fusion's memory (MEMORY,), the worst first."""
    found = sorted((*_waves(known, memory), *_numbers(known, memory)),
                   key=lambda remark: -remark.tolerances)
    return [*found, *_unexplained(memory)]


def health_in_words(joint: Joint, known: Tolerances, memory: Array) -> str:
    """Return the health of a joint in one line."""
    if joint.dry_friction <= 0.0 and joint.motor_deviation <= 0.0:
        return 'unknown: the model has no friction of the motor'
    found = remarks(known, memory)
    if not found:
        return WELL if memory[fusion.LEARNT:fusion.LEARNT + ERRORS].any() else UNTAUGHT
    return '; '.join(f'{remark.words} ({remark.tolerances:.0f} tolerances)' if remark.tolerances
                     else remark.words for remark in found)


def _deviations(memory: Array) -> Array:
    gained = fusion.gained(memory)
    return np.sqrt(np.maximum(1.0 + np.diagonal(gained), 0.0))


def _beyond(size: float, deviation: float, bar: float = REMARKABLE) -> bool:
    return size > bar * max(1.0, deviation)


def _waves(known: Tolerances, memory: Array) -> Iterator[Remark]:
    learnt, deviations = memory[fusion.LEARNT:fusion.LEARNT + ERRORS], _deviations(memory)
    for place, name, order in _WAVES:
        size = float(np.hypot(*learnt[place:place + 2]))
        if _beyond(size, float(deviations[place:place + 2].max()), REMARKABLE_WAVE):
            yield Remark(_WORDS[name].format(size=size * getattr(known, name), order=order),
                         size)


def _numbers(known: Tolerances, memory: Array) -> Iterator[Remark]:
    learnt, deviations = memory[fusion.LEARNT:fusion.LEARNT + ERRORS], _deviations(memory)
    for place, name in _NUMBERS:
        if _beyond(abs(learnt[place]), float(deviations[place])):
            size = float(learnt[place]) * getattr(known, name)
            words = _WORDS[name].format(size=size, percent=100.0 * size)
            yield Remark(words, abs(float(learnt[place])))


def _unexplained(memory: Array) -> Iterator[Remark]:
    if (misfit := fusion.usual_misfit(memory)) > MISFITTING:
        yield Remark(f'torsion and motor torque differ {np.sqrt(misfit):.1f} times '
                     'more than tolerances allow', 0.0)
