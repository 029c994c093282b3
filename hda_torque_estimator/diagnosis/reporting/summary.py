"""A diagnosis in sentences: what is wrong, how sure, what it costs, what to do next."""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
import math
from string import Formatter
from typing import Any

from hda_arm_sim.model.effects.words import Words

from .effect_words import ELEMENTS, WORDS
from ..findings.report import Diagnosis, Evidence, Finding, FittedNumber, Gain, OwnGain
from ...pages.wording import (
    capital, figure, handy, percent, ranged, short, spoken, unbroken)

# Numerics; choices unless stated otherwise.
_CERTAIN = 1e6          # odds beyond which the number says nothing more
_SURE = 0.999           # probability beyond which more digits say nothing
_NAMED = 2              # causes that one sentence can hold
_PLAIN = Words('differs from its model', 'link', 'None is known.')


@dataclass(frozen=True)
class Mark:
    """A part of the arm that a cause or a rest sits in; no joint is the whole arm."""

    joint: str | None
    element: str
    said: str


def headline(diagnosis: Diagnosis) -> str:
    """Return the verdict as a sentence that names cause, joint and size."""
    sentences = [cause_sentence(one.effect, one.joint,
                                one.parameters) for one in diagnosis.findings]
    if diagnosis.verdict == 'ambiguous' and diagnosis.ambiguous:
        sentences.append('; or '.join(cause_sentence(*place, parameters) for place, parameters in
                                      _candidates(diagnosis)) + ': this recording cannot decide')
    if diagnosis.verdict == 'unknown':
        sentences.append(_rest_sentence(diagnosis))
    if not sentences:
        return _NOTHING.get(diagnosis.verdict, diagnosis.headline)
    more = len(sentences) - _NAMED - (diagnosis.verdict != 'explained')
    if more > 0:
        kept = sentences[:_NAMED] + sentences[len(diagnosis.findings):]
        sentences = [*kept, f'{more} more cause{"s" * (more > 1)} below']
    return '. '.join(map(capital, sentences)) + '.'


_NOTHING = {
    'no_discrepancy': 'Nothing is wrong: the arm moves as its model says.',
    'insufficient_excitation': 'This recording cannot show whether anything is wrong.',
}


def cause_sentence(effect: str, joint: str | None, parameters: Mapping[str, FittedNumber]) -> str:
    """
    Return a cause in words, as `joint 1 has 0.2 mrad (0.69 arcmin) of play`.

    Where a number that its sentence needs is not known, the effect is named in its place.
    """
    words, largest = _largest(effect, parameters)
    said = words.said
    if largest is not None and largest.value < 0.0 and words.less:
        said = words.less
    size = '' if largest is None else _size(words, largest)
    known = {name: figure(number.value) for name, number in parameters.items()}
    if size:
        known['size'] = size
    if all(name in known for _, name, _, _ in Formatter().parse(said) if name):
        return ', '.join((f'{where(joint)} {said.format(**known)}', *_beside(words, parameters)))
    return f'{where(joint)} has {spoken(effect)}' + (f' of {size}' if size else '')


def _beside(words: Words, parameters: Mapping[str, FittedNumber]) -> list[str]:
    """Return further numbers of a cause in words, those that are not zero."""
    return [said.format(size=handy(parameters[name].value, parameters[name].unit))
            for name, said in words.beside if name in parameters and parameters[name].value]


def _largest(effect: str, parameters: Mapping[str, FittedNumber]) -> tuple[Words,
                                                                           FittedNumber | None]:
    """Return the words of an effect, and the largest of the numbers that they call its size."""
    words = WORDS.get(effect, _PLAIN)
    return words, max((parameters[name] for name in words.size if name in parameters),
                      key=lambda number: abs(number.value), default=None)


def _size(words: Words, number: FittedNumber) -> str:
    value = abs(number.value) if words.less else number.value
    return handy(words.scale * value, number.unit)


def where(joint: str | None) -> str:
    """Return a joint in words, or the arm."""
    return spoken(joint) if joint else 'the arm'


def _candidates(diagnosis: Diagnosis) -> list[tuple[tuple[str, str | None],
                                                    Mapping[str, FittedNumber]]]:
    alike = diagnosis.ambiguous[0]
    numbers = {(one.effect, one.joint): one.parameters for one in alike.candidates}
    return [(place, numbers.get(place, {})) for place in alike.effects]


def _rest_sentence(diagnosis: Diagnosis) -> str:
    rest = diagnosis.unexplained
    what = 'beside what is named so far, something else' if diagnosis.findings else 'something'
    place = '' if rest is None else f' {_SAID.get(rest.site, "at")} {where(rest.joint)}'
    likely = [f'{percent(one.probability)} probable: '
              + cause_sentence(one.effect, one.joint, one.parameters)
              for one in diagnosis.listed if one.kind == 'unsure']
    if likely:
        return f'{what} is wrong{place}, and no name for it is sure ({likely[0]})'
    return f'{what} is wrong{place} that no effect of the catalogue explains'


def marks(diagnosis: Diagnosis) -> list[Mark]:
    """Return the parts of the arm that a page points at, those of the first cause first."""
    places = [(one.effect, one.joint) for one in diagnosis.findings]
    places += [place for alike in diagnosis.ambiguous for place in alike.effects]
    found = [Mark(joint, WORDS.get(effect, _PLAIN).element, spoken(effect))
             for effect, joint in places]
    rest = diagnosis.unexplained
    if rest is not None and diagnosis.verdict == 'unknown':
        found.append(Mark(rest.joint, _SITES.get(rest.site, 'link'), 'unexplained rest'))
    return found


_SAID = {'motor': 'at the motor side of', 'torsion': 'in the torsion of',
         'link': 'at the link side of', 'timing': 'in the timing of',
         'sensing': 'in the sensors of', 'gear': 'at the motor or in the torsion of',
         'reference': 'in the reference torque of', 'sensor': 'in the reference torque of'}
_SITES = {'motor': 'motor', 'torsion': 'flexspline', 'link': 'link', 'timing': 'link_encoder',
          'sensing': 'link_encoder', 'gear': 'wave_generator', 'reference': 'link',
          'sensor': 'link'}
assert set(_SITES.values()) <= set(ELEMENTS)


def probability(judged: Any) -> str:
    """Return how probable something is, '' where that is not known."""
    value = getattr(judged, 'probability', None)
    if value is None or not math.isfinite(value):
        return ''
    return f'more than {100.0 * _SURE:.1f} %' if value > _SURE else percent(value)


def rival(found: Finding, named: Iterable[str]) -> list[str]:
    """
    Return the next best cause, how large it would be, its probability and the odds against it.

    Where the next best is among the causes that are `named` beside it, no other came nearer.
    """
    why, other = found.evidence, found.evidence.rival
    if why.runner_up is None or (other is None and why.runner_up not in named):
        return []
    if other is None:
        who = 'any other'
        size = f'{capital(spoken(why.runner_up))} came nearest, and is named too'
    else:
        who = f'{spoken(why.runner_up)} at {where(other.joint)}'
        size = capital(cause_sentence(why.runner_up, other.joint, other.parameters))
    share = 1.0 - found.probability if other is None else other.probability
    return [unbroken(cell) for cell in (who, size, _rare(share), f'{odds(why.odds)} to 1')]


def _rare(share: float) -> str:
    """Return a small probability, '' where it is not known."""
    if not math.isfinite(share):
        return ''
    small = share < 1.0 - _SURE
    return f'less than {100.0 * (1.0 - _SURE):.1f} %' if small else percent(share)


def certainty(diagnosis: Diagnosis) -> str:
    """Return how sure the verdict is: its probability or what speaks for it, and the size."""
    first = diagnosis.findings[0] if diagnosis.findings else None
    between = _sizes(diagnosis)
    known = probability(diagnosis)
    if known and first is not None and diagnosis.verdict == 'unknown':
        own = probability(first) or 'well backed'
        return (f'what is named: {own}{" probable" * own.endswith("%")}{between}. That something '
                f'else is wrong: {known} probable')
    if known:
        return f'{known} probable{between}'
    if first is not None:
        return f'{evidence(first.evidence)}{between}'
    return _UNSURE.get(diagnosis.verdict, diagnosis.headline)


_UNSURE = {
    'no_discrepancy': 'what the balances leave is noise; the smallest sizes that would have '
                      'shown are below',
    'ambiguous': 'the causes explain the recording equally well; nothing else does',
    'unknown': 'what is left is well above noise',
    'insufficient_excitation': 'silence of this recording says nothing'}


def _sizes(diagnosis: Diagnosis) -> str:
    """Return the intervals of the sizes that the headline names, '' where it has none."""
    spans = [(one, within(one.effect, one.parameters)) for one in diagnosis.findings[:_NAMED]]
    if len(diagnosis.findings) == 1:
        return ''.join(f'; with 90 % its size is between {span}' for _, span in spans if span)
    sizes = [f'the {spoken(one.effect)} of {where(one.joint)} is between {span}'
             for one, span in spans if span]
    return '; ' + 'each ' * (len(sizes) > 1) + 'with 90 % ' + ', '.join(sizes) if sizes else ''


def within(effect: str, parameters: Mapping[str, FittedNumber]) -> str:
    """Return the 90 % interval of the size that a sentence names, '' where it has none."""
    words, largest = _largest(effect, parameters)
    if largest is None or largest.chosen:
        return ''
    ends = (largest.low, largest.high)
    if words.less:
        ends = (abs(largest.low), abs(largest.high)) if largest.value > 0.0 else (
            abs(largest.high), abs(largest.low))
    return ranged(words.scale * ends[0], words.scale * ends[1], largest.unit)


def evidence(why: Evidence) -> str:
    """Return what speaks for a cause: the odds against the next best, or its score."""
    if why.runner_up is None:
        return f'its score is {short(why.score / why.threshold)} times the threshold, and no ' \
               'other cause comes near'
    return f'{odds(why.odds)} to 1 against the next best cause, {spoken(why.runner_up)}'


def odds(value: float) -> str:
    """Return odds as a number; what is more than a million says nothing more."""
    return f'more than {_CERTAIN:,.0f}' if value > _CERTAIN else figure(value)


def cost(diagnosis: Diagnosis) -> str:
    """Return what the arm as given gets wrong, '' where nothing was predicted."""
    far = diagnosis.prediction[-1:]
    if far:
        return (f'predicted {handy(far[0].horizon, "s")} ahead, the arm as given is off by '
                f'{handy(far[0].before, far[0].unit)} rms; noise alone makes '
                f'{handy(far[0].floor, far[0].unit)}')
    gain = diagnosis.gain
    if not math.isfinite(gain.before) or not gain.floor > 0.0:
        return ''
    return f'the squared error is {short(gain.before / gain.floor)} times that of noise'


def gained(diagnosis: Diagnosis) -> str:
    """Return what the extended arm improves, '' where nothing is extended."""
    if not diagnosis.extends:
        return ''
    far = diagnosis.prediction[-1:]
    to = f'with model.yaml it is off by {handy(far[0].after, far[0].unit)}: ' if far else ''
    return f'{to}{removed(diagnosis.gain)} of the excess error is gone, held out'


def removed(gain: Gain) -> str:
    """Return the share of the excess error that is gone, with its interval."""
    if not math.isfinite(gain.removed) or gain.before <= gain.floor:
        return 'nothing to remove'
    return f'{100.0 * gain.removed:.1f} % [{100.0 * gain.low:.1f}, {100.0 * gain.high:.1f}]'


def placebo(gain: Gain) -> str:
    """Return what a placebo removes, '' where none was tried."""
    return f'a placebo of equal freedom {percent(gain.placebo)}' if isinstance(
        gain, OwnGain) else ''


def steps(diagnosis: Diagnosis) -> list[str]:
    """Return what to do next: what the diagnosis itself asks for, then checks and files."""
    stated = [step if step.endswith('.') else f'{step}.' for step in diagnosis.steps]
    checks = _checks((one.effect, one.joint) for one in diagnosis.findings)
    checks += [f'What decides: {alike.experiment}.' for alike in diagnosis.ambiguous if not stated]
    checks += _checks(place for alike in diagnosis.ambiguous for place in alike.effects)
    after = _AFTER.get(diagnosis.verdict, ())
    if diagnosis.verdict == 'unknown' and diagnosis.unexplained is None:
        after = after[1:]               # no place, no coordinate: there is nothing to look at
    return [*stated, *(capital(one) for one in checks if one not in stated), *after,
            *_file(diagnosis)]


def _checks(places: Iterable[tuple[str, str | None]]) -> list[str]:
    return [f'{where(joint)}: {WORDS.get(effect, _PLAIN).check}' for effect, joint in places]


def _file(diagnosis: Diagnosis) -> list[str]:
    named = diagnosis.findings or any(alike.candidates for alike in diagnosis.ambiguous)
    return ['Until it is mended, load model.yaml as --arm: simulation, estimator and controller '
            'then know what is named here.'] if named else []


_AFTER = {
    'no_discrepancy': ('Nothing to mend. Keep this page to compare the next recording with.',),
    'insufficient_excitation': (
        'Record again for a minute: every joint both ways, slow sweeps over several motor turns, '
        'and quick bursts. The motion "rich" of hda simulate is an example.',
        'If you look for one effect, hda plan makes a motion that shows it.'),
    'unknown': (
        'Look below at what the rest follows: that names the part to look at.',
        'Record again. What follows time alone, and does not repeat, is a disturbance.'),
}
