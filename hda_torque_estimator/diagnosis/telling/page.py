"""The page of a diagnosis: one HTML file that needs no network, no script and no other file."""

from collections.abc import Iterable, Mapping
from html import escape
import math

from hda_arm_sim.model.effects import EFFECTS

from ..findings.report import Alike, Candidate, Diagnosis, Finding, Gain, Number, OwnGain, Part
from ...pages.document import (captioned, card, code, document, facts_table, figure, number,
                               section, table, unit)

CAPTIONS = {
    'residuals': 'What each balance misses over time. The arm as given leaves the wide band; the '
                 'extended arm should stay mostly between the dashed lines, as noise and encoder '
                 'resolution alone do. Gaps are standstill, where friction is not known.',
    'unexplained': 'What no backed cause explains. Left: how much of its power each '
                   'coordinate tells beyond chance. Middle: along the one that tells most; a flat '
                   'line within its quartiles would be noise. Right: its spectrum.',
    'prediction': 'Error of the simulation from measured states, by how far it looks ahead. The '
                  'extended arm should lie on the noise; the gap between the two is what is '
                  'still missed.',
    'motor': 'A motor alone. Left: its torque over a held-out stretch, measured, and as load, '
             'friction and the lines found call for it. Right: what load and friction leave, over '
             'the turn of the motor; with the lines it should be flat.',
}
_FINDING = ('What gives {} away: the line is the median of the residual, the band its middle '
            'half. Without the cause it follows the coordinate; with it, it should be flat at '
            'zero.')
_OTHER = 'Figure {}.'
_OWN = 'finding_'       # begins the names of the causes' own figures
# Choices unless told otherwise.
_CERTAIN = 1e6                      # odds beyond which the number says nothing more


def page(diagnosis: Diagnosis, figures: Mapping[str, str]) -> str:
    """
    Return a diagnosis as one HTML document.

    `figures` are SVG elements by the names of `plots.figures`, in the order of the page. They go
    in as they are; all other text is escaped.
    """
    headline = diagnosis.headline
    parts = [f'<h1>{escape(headline)}</h1>', _summary(diagnosis), _findings(diagnosis, figures),
             _ambiguous(diagnosis), _unexplained(diagnosis), _gain(diagnosis),
             _prediction(diagnosis),
             _figures(diagnosis, figures), _residuals(diagnosis), _detectable(diagnosis),
             _recording(diagnosis)]
    return document(f'Diagnosis: {diagnosis.verdict.replace("_", " ")}', parts,
                    diagnosis.verdict)


def _summary(diagnosis: Diagnosis) -> str:
    told = [_named(found.effect, found.joint) for found in diagnosis.findings]
    named = f'Named: {", ".join(told)}. ' if told else 'No cause is named. '
    removed = f'On data that no fit has seen {_removed(diagnosis.gain)} of the excess error is ' \
              'removed.' if told else ''
    return f'<p class="lead">{named}{removed}</p>'


def _findings(diagnosis: Diagnosis, drawn: Mapping[str, str]) -> str:
    if not diagnosis.findings:
        return ''
    return section('Causes', ''.join(
        _finding(found, drawn.get(f'{_OWN}{place}', ''))
        for place, found in enumerate(diagnosis.findings, 1)))


def _finding(found: Finding, svg: str) -> str:
    """Return one cause: where and why, its numbers, what speaks for it, and its figure."""
    named = f'{found.effect} at {_place(found.joint)}'
    return card(_named(found.effect, found.joint), '\n'.join([
        f'<p>{escape(_capital(found.cause))}. Site: {escape(found.site)}.</p>',
        _numbers(found.effect, found.parameters),
        f'<p>Removes {_removed(found.gain)} of the excess error, held out{_placebo(found.gain)}. '
        f'{_evidence(found)}</p>', captioned(svg, _FINDING.format(named)) if svg else '']))


def _numbers(effect: str, parameters: Mapping[str, Number]) -> str:
    rows = [[f'{code(name)}{_meaning(effect, name)}', number(value.value), _within(value),
             escape(unit(value.unit))] for name, value in parameters.items()]
    return table(('parameter', 'value', '90 % interval', 'unit'), rows) if rows else ''


def _within(value: Number) -> str:
    if value.chosen:
        return 'chosen, not fitted'
    return f'{number(value.low)} to {number(value.high)}'


def _meaning(effect: str, name: str) -> str:
    """Return what a parameter means, in the words of its declaration."""
    known = next((kind for kind in EFFECTS if kind.name == effect), None)
    meanings = {} if known is None else {
        rule.name: rule.meaning for rule in known.declarations()}
    return f'<br><small>{escape(meanings[name])}</small>' if name in meanings else ''


def _evidence(found: Finding) -> str:
    evidence = found.evidence
    score = f'Score {figure(evidence.score)}, threshold {figure(evidence.threshold)}'
    if evidence.runner_up is None:
        return f'{score}; no runner-up.'
    odds = f'more than {_CERTAIN:,.0f}' if evidence.odds > _CERTAIN else figure(evidence.odds)
    return f'{score}; {odds} to 1 against {code(evidence.runner_up)}.'


def _placebo(gain: Gain) -> str:
    if not isinstance(gain, OwnGain):
        return ''
    return f'; a placebo of equal freedom {100.0 * gain.placebo:.1f} %'


def _ambiguous(diagnosis: Diagnosis) -> str:
    if not diagnosis.ambiguous:
        return ''
    return section('What this recording cannot tell apart',
                   ''.join(map(_alike, diagnosis.ambiguous)))


def _alike(alike: Alike) -> str:
    """Return causes that explain a recording equally well, each with its own numbers."""
    sizes = ''.join(f'<h4>{_named(one.effect, one.joint)}{_held(one)}</h4>\n'
                    + _numbers(one.effect, one.parameters) for one in alike.candidates)
    return card(' or '.join(_named(*place) for place in alike.effects),
                f'<p>Each explains the recording as well as the other. What decides: '
                f'{escape(alike.experiment)}.</p>\n{sizes}')


def _held(one: Candidate) -> str:
    return f', which {code("model.yaml")} holds' if one.in_model else ''


def _unexplained(diagnosis: Diagnosis) -> str:
    rest = diagnosis.unexplained
    if rest is None:
        return ''
    return section('The unexplained rest', f'<p>{escape(_capital(rest.sentence()))}.</p>')


def _gain(diagnosis: Diagnosis) -> str:
    gain = diagnosis.gain
    rows = [[number(gain.before), number(gain.after), number(gain.floor), _removed(gain)]]
    scale = unit(gain.unit)
    return section('Gain on held-out data', f'<p>{escape(_capital(gain.metric))}.</p>' + table(
        tuple(_with_unit(name, scale) for name in ('arm as given', 'extended arm',
                                                   'noise floor'))
        + ('excess removed, 90 % interval',), rows))


def _prediction(diagnosis: Diagnosis) -> str:
    rows = [[number(row.horizon, 's'), number(row.before), number(row.after), number(row.floor),
             escape(unit(row.unit))] for row in diagnosis.prediction]
    return section('Prediction of held-out data, by how far it looks ahead', table(
        ('horizon', 'arm as given', 'extended arm', 'noise floor', 'unit, rms'),
        rows)) if rows else ''


def _figures(diagnosis: Diagnosis, drawn: Mapping[str, str]) -> str:
    """Return the figures that belong to no cause alone."""
    shown = {f'{_OWN}{place}' for place in range(1, len(diagnosis.findings) + 1)}
    rest = ''.join(captioned(svg, _caption(name)) for name, svg in drawn.items()
                   if name not in shown)
    return section('Simulated against measured', rest) if rest else ''


def _caption(name: str) -> str:
    kind = name.partition('_')[0]
    return CAPTIONS.get(name, CAPTIONS.get(kind, _OTHER.format(name.replace('_', ' '))))


def _residuals(diagnosis: Diagnosis) -> str:
    rows = [[escape(row.site), escape(_place(row.joint)), number(row.before), number(row.after),
             number(row.floor), escape(unit(row.unit))] for row in diagnosis.residuals]
    return section('Residuals of the balances, rms on held-out data', table(
        ('balance', 'where', 'arm as given', 'extended arm', 'noise floor', 'unit'),
        rows)) if rows else ''


def _detectable(diagnosis: Diagnosis) -> str:
    rows = [[code(row.effect), escape(_place(row.joint)),
             'cannot be shown by this motion' if row.smallest_detectable is None
             else number(row.smallest_detectable, row.unit)]
            for row in diagnosis.excitation]
    said = ''.join(f'<p>{escape(_capital(remark))}.</p>' for remark in diagnosis.remarks)
    return section('Smallest size that this recording could have shown', said + table(
        ('effect', 'where', 'smallest detectable'), rows)) if rows else ''


def _recording(diagnosis: Diagnosis) -> str:
    facts = diagnosis.recording
    rows = [('duration', f'{figure(facts.duration)} s'), ('samples', f'{facts.samples:,}'),
            ('rate', f'{figure(facts.rate)} Hz'), *_bags(facts.bags),
            ('fitted to', _spans(facts.training)),
            ('held out', _spans(facts.held_out)), ('arm', code(diagnosis.arm)),
            ('version', escape(diagnosis.version)),
            ('time taken', f'{figure(diagnosis.seconds)} s')]
    return section('Recording', facts_table(rows))


def _bags(bags: Iterable[Part]) -> list[tuple[str, str]]:
    """Return the rows of several recordings."""
    return [(f'recording {place}', f'{code(part.bag)}, from {figure(part.begin)} s of the '
             f'running clock') for place, part in enumerate(bags, 1)]


def _spans(spans: Iterable[tuple[float, float]]) -> str:
    """Return stretches of time, those that touch as one."""
    joined: list[tuple[float, float]] = []
    for begin, end in spans:
        if joined and math.isclose(joined[-1][1], begin):
            begin = joined.pop()[0]
        joined.append((begin, end))
    total = sum(end - begin for begin, end in joined)
    listed = ', '.join(f'{figure(begin)} to {figure(end)}' for begin, end in joined)
    return f'{figure(total)} s: {listed} s' if joined else 'nothing'


def _removed(gain: Gain) -> str:
    """Return the share of the excess error that is gone, with its interval."""
    if not math.isfinite(gain.removed):
        return 'nothing to remove'
    return (f'{100.0 * gain.removed:.1f} % '
            f'[{100.0 * gain.low:.1f}, {100.0 * gain.high:.1f}]')


def _with_unit(name: str, scale: str) -> str:
    return f'{name} [{scale}]' if scale else name


def _capital(sentence: str) -> str:
    return sentence[:1].upper() + sentence[1:]


def _named(effect: str, joint: str | None) -> str:
    return f'{code(effect)} at {escape(_place(joint))}'


def _place(joint: str | None) -> str:
    return joint or 'the arm'
