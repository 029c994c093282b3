"""The page of a diagnosis: one HTML file that needs no network, no script and no other file."""

from collections.abc import Iterable, Mapping
from html import escape
import math

from .report import Diagnosis, Finding, Gain, Number, OwnGain, Part, VERDICTS
from ..pages.document import captioned, code, document, figure, section, table, unit

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
    'example': 'One window simulated from the measured state. The extended arm should cover the '
               'measurement; the arm as given departs from it.',
}
_FINDING = ('What gives {} away: the line is the median of the residual, the band its middle '
            'half. Without the cause it follows the coordinate; with it, it should be flat at '
            'zero.')
_OTHER = 'Figure {}.'
_CERTAIN = 1e6                      # odds beyond which the number says nothing more


def page(diagnosis: Diagnosis, figures: Mapping[str, str]) -> str:
    """
    Return a diagnosis as one HTML document.

    `figures` are SVG elements by the names of `plots.figures`, in the order of the page. They go
    in as they are; all other text is escaped.
    """
    headline = VERDICTS[diagnosis.verdict]
    parts = [f'<h1>{escape(headline)}</h1>', _summary(diagnosis), _findings(diagnosis),
             _ambiguous(diagnosis), _unexplained(diagnosis), _gain(diagnosis),
             _prediction(diagnosis),
             _figures(diagnosis, figures), _residuals(diagnosis), _detectable(diagnosis),
             _recording(diagnosis)]
    return document(f'Diagnosis: {diagnosis.verdict.replace("_", " ")}', parts,
                    diagnosis.verdict)


def _summary(diagnosis: Diagnosis) -> str:
    told = [f'{code(found.effect)} at {escape(_place(found.joint))}'
            for found in diagnosis.findings]
    named = f'Named: {", ".join(told)}. ' if told else 'No cause is named. '
    removed = f'On data that no fit has seen {_removed(diagnosis.gain)} of the excess error is ' \
              'removed.' if told else ''
    return f'<p class="lead">{named}{removed}</p>'


def _findings(diagnosis: Diagnosis) -> str:
    if not diagnosis.findings:
        return ''
    rows = [[code(found.effect), escape(_place(found.joint)), escape(found.site),
             escape(found.cause), _numbers(found.parameters), _evidence(found),
             _removed(found.gain) + _placebo(found.gain)] for found in diagnosis.findings]
    return section('Causes', table(
        ('effect', 'where', 'site', 'cause', 'parameters, 90 % interval', 'evidence',
         'excess error removed, held out'), rows))


def _numbers(parameters: Mapping[str, Number]) -> str:
    return '<br>'.join(
        f'<span class="number">{escape(name)} = {figure(number.value)} '
        f'[{figure(number.low)}, {figure(number.high)}] {escape(unit(number.unit))}'.rstrip()
        + '</span>'
        for name, number in parameters.items())


def _evidence(found: Finding) -> str:
    evidence = found.evidence
    score = f'score {figure(evidence.score)}, threshold {figure(evidence.threshold)}'
    if evidence.runner_up is None:
        return f'{score}<br>no runner-up'
    odds = f'more than {_CERTAIN:,.0f}' if evidence.odds > _CERTAIN else figure(evidence.odds)
    return f'{score}<br>{odds} to 1 against {code(evidence.runner_up)}'


def _placebo(gain: Gain) -> str:
    if not isinstance(gain, OwnGain):
        return ''
    return f'<br>a placebo of equal freedom {100.0 * gain.placebo:.1f} %'


def _ambiguous(diagnosis: Diagnosis) -> str:
    rows = [[' or '.join(f'{code(effect)} at {escape(_place(joint))}'
                         for effect, joint in alike.effects), escape(alike.experiment)]
            for alike in diagnosis.ambiguous]
    return section('What this recording cannot tell apart', table(
        ('explain it equally well', 'the experiment that decides'), rows)) if rows else ''


def _unexplained(diagnosis: Diagnosis) -> str:
    rest = diagnosis.unexplained
    if rest is None:
        return ''
    return section('The unexplained rest', f'<p>{escape(_capital(rest.sentence()))}.</p>')


def _gain(diagnosis: Diagnosis) -> str:
    gain = diagnosis.gain
    rows = [[figure(gain.before), figure(gain.after), figure(gain.floor), _removed(gain)]]
    scale = unit(gain.unit)
    return section('Gain on held-out data', f'<p>{escape(_capital(gain.metric))}.</p>' + table(
        tuple(_with_unit(name, scale) for name in ('arm as given', 'extended arm',
                                                   'noise floor'))
        + ('excess removed, 90 % interval',), rows))


def _prediction(diagnosis: Diagnosis) -> str:
    rows = [[f'{figure(row.horizon)} s', figure(row.before), figure(row.after), figure(row.floor),
             escape(unit(row.unit))] for row in diagnosis.prediction]
    return section('Prediction of held-out data, by how far it looks ahead', table(
        ('horizon', 'arm as given', 'extended arm', 'noise floor', 'unit, rms'),
        rows)) if rows else ''


def _figures(diagnosis: Diagnosis, drawn: Mapping[str, str]) -> str:
    return section('Simulated against measured', ''.join(
        captioned(svg, _caption(diagnosis, name)) for name, svg in drawn.items())) if drawn else ''


def _caption(diagnosis: Diagnosis, name: str) -> str:
    kind, _, number = name.partition('_')
    if kind == 'finding' and number.isdigit() and 0 < int(number) <= len(diagnosis.findings):
        found = diagnosis.findings[int(number) - 1]
        return _FINDING.format(f'{found.effect} at {_place(found.joint)}')
    return CAPTIONS.get(name, CAPTIONS.get(kind, _OTHER.format(name.replace('_', ' '))))


def _residuals(diagnosis: Diagnosis) -> str:
    rows = [[escape(row.site), escape(_place(row.joint)), figure(row.before), figure(row.after),
             figure(row.floor), escape(unit(row.unit))] for row in diagnosis.residuals]
    return section('Residuals of the balances, rms on held-out data', table(
        ('balance', 'where', 'arm as given', 'extended arm', 'noise floor', 'unit'),
        rows)) if rows else ''


def _detectable(diagnosis: Diagnosis) -> str:
    rows = [[code(row.effect), escape(_place(row.joint)),
             'cannot be shown by this motion' if row.smallest_detectable is None
             else f'{figure(row.smallest_detectable)} {escape(unit(row.unit))}']
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
    return section('Recording', '<table class="facts"><tbody>' + ''.join(
        f'<tr><th scope="row">{name}</th><td>{value}</td></tr>\n' for name, value in rows)
        + '</tbody></table>')


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


def _place(joint: str | None) -> str:
    return joint or 'the arm'
