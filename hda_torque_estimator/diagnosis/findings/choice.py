"""Of causes that look alike, the one that the extended arm shall hold."""

from dataclasses import replace

from hda_arm_sim.model.arm import Arm
from hda_msgs_json.errors import HdaError

from .report import Alike, Candidate, Diagnosis


class ChoiceError(HdaError):
    """A candidate that a diagnosis does not have."""


def chosen(diagnosis: Diagnosis, extended: Arm, given: Arm,
           number: int) -> tuple[Diagnosis, Arm]:
    """
    Return a diagnosis and its extended arm with candidate `number`, from 1, of what looks alike.

    The first is the one that the arm holds already. `given` is the arm before the diagnosis.
    Raises ChoiceError where the causes that look alike are fewer; without any, nothing changes.
    """
    pairs = []
    for pair in diagnosis.ambiguous:
        if not 1 <= number <= max(len(pair.candidates), 1):
            raise ChoiceError(f'--candidate {number} is none of the {len(pair.candidates)} causes '
                              f'that look alike: {", ".join(name for name, _ in pair.effects)}')
        if number > 1:
            extended = _held(pair, extended, given, number)
            pair = replace(pair, candidates=tuple(
                replace(one, in_model=place == number)
                for place, one in enumerate(pair.candidates, 1)))
        pairs.append(pair)
    return replace(diagnosis, ambiguous=tuple(pairs)), extended


def _held(pair: Alike, extended: Arm, given: Arm, number: int) -> Arm:
    """Return the arm with one candidate of a pair, and what was given in place of the others."""
    for one in pair.candidates:
        extended = extended.with_effect(given.effect(one.effect, one.joint), one.joint)
    return _with(extended, pair.candidates[number - 1])


def _with(arm: Arm, one: Candidate) -> Arm:
    """Return an arm with a candidate, as large as it was reported."""
    sizes = {name: number.value for name, number in one.parameters.items()}
    return arm.with_effect(replace(arm.effect(one.effect, one.joint), **sizes), one.joint)
