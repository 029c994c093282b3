"""Findings as the report states them: JSON for machines, sentences for people."""

from collections.abc import Iterable, Mapping
from dataclasses import asdict, dataclass
from itertools import starmap
import math
from typing import Any

from .origin import RecordingFacts
from .rest import Unexplained
from ...pages.wording import percent

SCHEMA = 'hda.diagnosis/2'
VERDICTS = {
    'explained': 'Explained: the simulation misses what is named here, the rest is noise.',
    'no_discrepancy': 'Nothing is wrong: the arm is as its model says, within the tolerances.',
    'ambiguous': 'Ambiguous: more than one cause explains this recording equally well.',
    'insufficient_excitation': 'Insufficient excitation: this motion cannot show what is wrong.',
    'unknown': 'Unknown: something is wrong, and no effect of the catalogue is sure to be it.',
}
RATE_TOO_LOW = ('Insufficient rate: this motion would show what is wrong, sampled more often; at '
                'this rate it cannot.')


@dataclass(frozen=True)
class FittedNumber:
    """A fitted number with its 90 % interval; one that was chosen from a list has no width."""

    value: float
    unit: str
    low: float
    high: float

    @property
    def chosen(self) -> bool:
        """Return whether the number was chosen from a list, as the order of a wave is."""
        return self.low == self.high


@dataclass(frozen=True)
class RunnerUp:
    """The next best cause in the place of one that is named, as large as it would be there."""

    joint: str | None
    parameters: Mapping[str, FittedNumber]    # without intervals; none where nothing of it is left
    probability: float                  # that it is this one in the place of the other


@dataclass(frozen=True)
class Evidence:
    """Why a cause is named: its score, the threshold, and the odds to the runner-up."""

    score: float
    threshold: float
    runner_up: str | None
    odds: float
    rival: RunnerUp | None = None          # the runner-up with its size, where it was fitted


@dataclass(frozen=True)
class Gain:
    """Error of the simulation on data that no fit has seen; `removed` is a share of the excess."""

    before: float
    after: float
    floor: float
    removed: float
    low: float
    high: float

    def beside(self, placebo: float, metric: str = '') -> 'OwnGain':
        """Return the gain of a cause, in words of what, beside that of its placebo."""
        return OwnGain(self.before, self.after, self.floor, self.removed, self.low, self.high,
                       placebo, metric)


@dataclass(frozen=True)
class OwnGain(Gain):
    """
    The gain of one cause, and what a placebo of equal freedom removes, a share as well.

    The `metric` says in words of what the errors are.
    """

    placebo: float
    metric: str = ''


@dataclass(frozen=True)
class Finding:
    """One cause."""

    effect: str
    joint: str | None
    site: str
    cause: str
    parameters: Mapping[str, FittedNumber]
    evidence: Evidence
    gain: Gain
    probability: float = math.nan       # that it is this cause (eq:certainty)


def with_gain(findings: Iterable[Finding]) -> tuple[Finding, ...]:
    """
    Return the findings that may be named: each gains on data that no fit has seen.

    All routes ask this, whatever else they ask: what removes nothing there explains nothing.
    """
    return tuple(found for found in findings if found.gain.removed > 0.0)


@dataclass(frozen=True)
class Candidate:
    """One of several causes that explain a recording equally well, as large as it would be."""

    effect: str
    joint: str | None
    parameters: Mapping[str, FittedNumber]
    in_model: bool              # whether the extended arm holds it
    probability: float = math.nan       # that it is this one

    def sentence(self) -> str:
        """Return the cause with its numbers."""
        return f'{at_place(self.effect, self.joint)}: {_numbers(self.parameters)}'


@dataclass(frozen=True)
class Alike:
    """Causes that explain the recording equally well, and the experiment that separates them."""

    effects: tuple[tuple[str, str | None], ...]
    experiment: str
    candidates: tuple[Candidate, ...] = ()
    probability: float = math.nan       # that it is one of them
    lead: float = 0.5                   # ... and then the first

    def share(self, place: tuple[str, str | None]) -> float:
        """Return the probability of one of the effects."""
        first = place == self.effects[0]
        return self.probability * (self.lead if first else
                                   (1.0 - self.lead) / max(len(self.effects) - 1, 1))

    def document(self) -> dict[str, Any]:
        """Return the JSON document, with the size of each candidate by its place."""
        sizes = [{'effect': one.effect, 'joint': one.joint, 'probability': one.probability,
                  'parameters': {name: asdict(number) for name, number in one.parameters.items()}}
                 for one in self.candidates]
        return {**asdict(self), 'sizes': sizes}


@dataclass(frozen=True)
class Listed:
    """A cause that is not told: not sure enough, at a bound of its law, or too small."""

    effect: str
    joint: str | None
    parameters: Mapping[str, FittedNumber]
    probability: float                  # that it is this cause
    kind: str                           # 'unsure', 'at_bound' or 'small'
    why: str                            # it is not told, a sentence

    def sentences(self) -> list[str]:
        """Return why it is not told, and how large it would be."""
        return [f'  {self.why}', f'    it would be {_numbers(self.parameters)}']


@dataclass(frozen=True)
class Detectable:
    """
    The smallest size of an effect that this recording could have shown 19 times of 20.

    It is that of one of its numbers, the `parameter` that shows at the smallest size.
    """

    effect: str
    joint: str | None
    smallest_detectable: float | None
    unit: str
    parameter: str = ''


@dataclass(frozen=True)
class Residual:
    """What one balance misses on data that no fit has seen, rms."""

    site: str
    joint: str | None
    before: float
    after: float
    floor: float
    unit: str


@dataclass(frozen=True)
class Prediction:
    """Error of the simulation from measured states, rms over a horizon [s], held out."""

    horizon: float
    before: float
    after: float
    floor: float
    unit: str


@dataclass(frozen=True)
class TotalGain(Gain):
    """The gain of all causes together."""

    metric: str
    unit: str


@dataclass(frozen=True)
class Diagnosis:
    """The outcome, as `report.json` holds it."""

    verdict: str
    findings: tuple[Finding, ...]
    ambiguous: tuple[Alike, ...]
    unexplained: Unexplained | None
    excitation: tuple[Detectable, ...]
    gain: TotalGain
    residuals: tuple[Residual, ...]
    recording: RecordingFacts
    arm: str
    version: str
    seconds: float
    remarks: tuple[str, ...] = ()   # on what the recording could not have shown
    prediction: tuple[Prediction, ...] = ()
    limited_by: str | None = None   # of insufficient excitation: 'motion' or 'rate'
    probability: float = math.nan   # of the verdict (eq:certainty)
    steps: tuple[str, ...] = ()     # what to measure or to do next
    listed: tuple[Listed, ...] = ()  # causes that are not told, and why not

    @property
    def extends(self) -> bool:
        """Tell whether the arm that comes with the diagnosis holds a cause."""
        return bool(self.findings) or any(one.in_model for alike in self.ambiguous
                                          for one in alike.candidates)

    @property
    def headline(self) -> str:
        """Return the verdict as a sentence."""
        return RATE_TOO_LOW if self.limited_by == 'rate' else VERDICTS[self.verdict]

    def notes(self) -> list[str]:
        """Return what must be known of the extended arm beside its numbers."""
        lines = []
        for alike in self.ambiguous:
            held = [one for one in alike.candidates if one.in_model]
            others = [one for one in alike.candidates if not one.in_model]
            if others:
                lines.append(f'holds {held[0].sentence() if held else "none of these"}')
                lines += [f'{"as well explained by" if held else "either"} {one.sentence()}'
                          for one in others]
        return lines

    def document(self) -> dict[str, Any]:
        """Return the JSON document; numbers that do not exist are null."""
        plain = {'schema': SCHEMA, **_plain({
            **asdict(self), 'ambiguous': [alike.document() for alike in self.ambiguous]})}
        plain['next'] = plain.pop('steps')
        for rare in ('bags', 'oscillating'):
            if not plain['recording'][rare]:
                del plain['recording'][rare]
        return plain

    def sentences(self) -> list[str]:
        """Return the diagnosis for people, best first."""
        return [self.headline, *(_finding_sentence(found) for found in self.findings),
                *(line for alike in self.ambiguous for line in _alike_sentences(alike)),
                *_unexplained_sentences(self.unexplained),
                *(line for one in self.listed for line in one.sentences()),
                *(f'  {remark}' for remark in self.remarks),
                *(f'  next: {step}' for step in self.steps)]


def _plain(value: Any) -> Any:
    if isinstance(value, Mapping):
        return {key: _plain(item) for key, item in value.items()}
    if isinstance(value, (tuple, list)):
        return [_plain(item) for item in value]
    if isinstance(value, float) and not math.isfinite(value):
        return None
    return value


def _finding_sentence(found: Finding) -> str:
    return (f'  {found.joint or "arm":<7} {found.effect:<28} {found.cause}: '
            f'{_numbers(found.parameters)}; removes '
            f'{100.0 * found.gain.removed:.1f} % of the excess error{_placebo(found.gain)}')


def _numbers(parameters: Mapping[str, FittedNumber]) -> str:
    return ', '.join(_written(name, number) for name, number in parameters.items())


def _written(name: str, number: FittedNumber) -> str:
    within = '' if number.chosen else f' [{number.low:.4g}, {number.high:.4g}]'
    return f'{name} = {number.value:.4g}{within} {number.unit}'.rstrip()


def _alike_sentences(alike: Alike) -> list[str]:
    """Return which causes look alike, what decides, and how large each would be."""
    return [f'  these look alike here: {_places(alike.effects)}; what decides: '
            f'{alike.experiment}',
            *(f'    {one.sentence()}' + (' (in model.yaml)' if one.in_model else '')
              for one in alike.candidates)]


def at_place(effect: str, joint: str | None) -> str:
    """Return an effect with its place in words."""
    return f'{effect} at {joint or "the arm"}'


def _placebo(gain: Gain) -> str:
    if not isinstance(gain, OwnGain):
        return ''
    return f', a placebo of equal freedom {percent(gain.placebo)}'


def _places(effects: tuple[tuple[str, str | None], ...]) -> str:
    return ' and '.join(starmap(at_place, effects))


def _unexplained_sentences(rest: Unexplained | None) -> list[str]:
    return [] if rest is None else [f'  unexplained: {rest.sentence()}']
