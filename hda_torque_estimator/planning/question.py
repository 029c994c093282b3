"""What is asked of a motion: to separate two effects, or to show some, each at its place."""

from collections.abc import Sequence
from typing import NamedTuple

from hda_arm_sim.model.arm import Arm
from hda_arm_sim.model.effects import Effect, effect_named, Scope
from hda_arm_sim.model.typical_sizes import SIZED, typical
from hda_msgs_json.errors import HdaError

from ..diagnosis.fitting.hypotheses import HYPOTHESES, left_aside


class PlanError(HdaError):
    """Effects for which no motion can be planned."""


class Suspect(NamedTuple):
    """An effect at a typical size and its place: a joint's label, or None for the arm."""

    effect: Effect
    joint: str | None

    @property
    def label(self) -> str:
        """Return the effect as it is written on a command line."""
        return self.effect.name + (f'@{self.joint}' if self.joint else '')

    def on(self, arm: Arm) -> Arm:
        """Return the arm with this effect; raises ArmError where it cannot have it."""
        return arm.with_effect(self.effect, self.joint)


class Question(NamedTuple):
    """An arm as it is believed to be, and suspects of which it may have one."""

    arm: Arm
    suspects: tuple[Suspect, ...]
    between: bool = True        # two are to be distinguished; else each is to be seen


def shown(arm: Arm, words: Sequence[str]) -> Question:
    """
    Return the question which motion shows effects, each written EFFECT or EFFECT@JOINT.

    An effect of a joint without a joint belongs to the first. Raises as `question`.
    """
    suspects = dict.fromkeys(_suspect(arm, name, joint, arm.labels[0])
                             for name, joint in (_split(text, '--show') for text in words))
    for suspect in suspects:
        suspect.on(arm).record()
    return Question(arm, tuple(suspects), between=False)


def question(arm: Arm, first: str, second: str) -> Question:
    """
    Return the question which of two effects an arm has, each written EFFECT or EFFECT@JOINT.

    An effect of a joint without a joint belongs to that of the other effect, else to the first.
    Raises PlanError, ParameterError or ArmError for effects that cannot be distinguished, that do
    not exist, or that the arm cannot have.
    """
    words = [_split(text, '--between') for text in (first, second)]
    named = [joint for _, joint in words if joint] + [arm.labels[0]]
    suspects = [_suspect(arm, name, joint, named[0]) for name, joint in words]
    if suspects[0].label == suspects[1].label:
        raise PlanError(f'--between needs two different effects, got {suspects[0].label} twice')
    for suspect in suspects:
        suspect.on(arm).record()                # an arm that cannot be says so here
    return Question(arm, (suspects[0], suspects[1]))


def _split(text: str, option: str) -> tuple[str, str | None]:
    name, at, joint = text.partition('@')
    if at and not joint:
        raise PlanError(f'{option} got {text!r}: name a joint after the @')
    return name, joint or None


def _suspect(arm: Arm, name: str, joint: str | None, usual: str) -> Suspect:
    """Return an effect at its place; raises for one that motions do not decide about."""
    kind = effect_named(name)
    place = usual if joint is None and kind.scope is Scope.JOINT else joint
    arm.effect(name, place)
    if name not in HYPOTHESES or name not in SIZED:
        raise PlanError(f'no motion is planned for {name}: it shows in raw readings or in time '
                        'whatever the motion; any recording of 60 s will do')
    if left_aside(arm, [name]):
        raise PlanError(f'no motion is planned for {name}: a diagnosis does not look for it on a '
                        'chain')
    if kind.planar and len(arm.joints) < 2:
        raise PlanError(f'{name} acts between two joints; the arm has {len(arm.joints)}, '
                        f'{", ".join(arm.labels)}')
    return Suspect(typical(arm, name, place), place)
