"""The page of the study of worlds: how often a diagnosis is right, wherever it was drawn."""

from collections import Counter, defaultdict
from collections.abc import Iterable, Iterator, Sequence
import json
from typing import Any

from diagnosis_tables import pairs_of, percent
import numpy as np
from world_judging import (accused, all_identified, follows, intervals, largest_identified,
                           probabilities, simple_is_right, simple_is_wrong, unknown_at_joint,
                           visible, wrong)

Outcome = dict[str, Any]
Row = tuple[str, str, str, str]
SINGLE = ('rich, 1 kHz', 'rich, 250 Hz', 'other motions, 1 kHz', 'any rate')
BINS = 10                       # of probabilities, in the reliability diagram
_HEAD = """# Worlds

Written by `benchmarks/worlds.py`. Arms, motions, rates, encoders and forms of law are drawn by
seeds {first} to {last}. {kind} {done} of {planned} planned records were run; {odd}
could not be, because such an arm or motion cannot have the effect.

The baseline names the effect whose first-order column follows the residual best. It names
nothing below half of the residual's power.

"""
_KINDS = {True: 'The study is a final one: forms and a motion never seen before are among them.',
          False: 'The study is one of development: held-out forms and motions are not in it.'}


def page(results: Sequence[Outcome], planned: int, *, first: int, last: int, final: bool) -> str:
    """Return the whole page."""
    odd = sum('impossible' in result for result in results)
    judged = [result for result in results if 'impossible' not in result]
    good = [result for result in judged if 'error' not in result]
    head = _HEAD.format(first=first, last=last, kind=_KINDS[final], done=len(judged),
                        planned=planned, odd=odd)
    return head + '\n'.join([
        *_table(('', 'asked', 'reached', 'baseline'), _rows(good)), '',
        '## By motion and rate', '',
        *_table(('single cause, above the smallest size', 'named', 'wrong', 'records'),
                _strata(good)), '',
        '## By effect and form', '', *_table(('hidden', 'named', 'otherwise'), _effects(good)), '',
        '## Reliability', '', *_reliability(good), '', *_failures(judged), ''])


def _table(names: Sequence[str], rows: Iterable[Sequence[str]]) -> list[str]:
    return [f'| {" | ".join(row)} |' for row in (names, ['---'] * len(names), *rows)]


def _rows(good: Sequence[Outcome]) -> Iterator[Row]:
    """Yield the rows of what is asked for."""
    by: dict[str, list[Outcome]] = defaultdict(list)
    for result in good:
        by[result['group']].append(result)
    for group, asked in zip(SINGLE, ('98 %', '95 %', '95 %', '-')):
        seen = list(filter(visible, by[group]))
        yield (f'one cause named, {group}, above the stated smallest', asked,
               percent(seen, all_identified), percent(seen, simple_is_right))
    hiding = [result for result in good if result['group'] not in ('healthy', 'left out')]
    yield ('a wrong cause named, anywhere', 'at most 1 %', percent(hiding, wrong),
           percent([r for group in SINGLE for r in by[group]], simple_is_wrong))
    yield ('healthy accused, any motion, rate, arm', 'at most 0.5 %', percent(
        by['healthy'], accused), percent(by['healthy'], simple_is_wrong))
    yield ('healthy: a cause named', '-', percent(by['healthy'], wrong), '-')
    for group, asked in (('two', '95 %'), ('three', '88 %')):
        yield (f'{group} named, 1 kHz', asked,
               percent(list(filter(visible, by[group])), all_identified), '-')
    yield from _fifteen(by['fifteen'])
    yield ('outside the catalogue: `unknown`, with site and joint', '97 %',
           percent(by['outside'], unknown_at_joint), '-')
    yield 'the same, with coordinate', '90 %', percent(by['outside'], follows), '-'
    yield ('true effect taken out: wrong name', 'at most 2 %', percent(by['left out'], wrong),
           percent(by['left out'], simple_is_wrong))
    yield 'same arm, other duration or bags: another cause', '0', *_durations(by['duration'])
    single = [r for group in SINGLE for r in by[group] if all_identified(r) and r['said']]
    removed = [r['removed'] for r in single if np.isfinite(r['removed'])]
    yield ('excess removed on held-out data, median', '98 %',
           f'{100.0 * np.median(removed):.2f} %' if removed else '-', '-')
    held = [one for result in single for one in intervals(result)]
    yield '90 % intervals hold', '87 to 93 %', percent(held, bool), '-'
    yield from _times(by)


def _fifteen(many: Sequence[Outcome]) -> Iterator[Row]:
    """Yield the rows of arms with fifteen small imperfections; some controllers cannot hold."""
    if many:
        yield ('fifteen at once: of the five largest, identified', '80 %', _share(many), '-')
        held = [result for result in many if not result['oscillating']]
        yield ('the same, arms whose controllers do not oscillate', '-', _share(held), '-')
        yield ('fifteen at once: wrong names per record', 'at most 0.1',
               f'{np.mean([len(wrong(r)) for r in many]):.2f}', '-')


def _share(many: Sequence[Outcome]) -> str:
    """Return which share of the five largest causes of arms is identified."""
    if not many:
        return '-'
    share = 100.0 * np.mean([largest_identified(result) for result in many])
    return f'{share:.0f} % ({len(many)} records)'


def _durations(results: Sequence[Outcome]) -> tuple[str, str]:
    """Return how often the same arm is given another cause than at 60 s in one recording."""
    arms: dict[int, list[Outcome]] = defaultdict(list)
    for result in results:
        arms[result['seed']].append(result)
    usual = {seed: set(pairs_of(one['said'])) for seed, ones in arms.items() for one in ones
             if case_of(one)['seconds'] == 60.0}
    changed = [bool(usual[seed] and set(pairs_of(one['said'])) - usual[seed])
               for seed, ones in arms.items() if seed in usual for one in ones
               if case_of(one)['seconds'] != 60.0]
    return percent(changed, bool), '-'


def case_of(result: Outcome) -> Outcome:
    """Return the case that an outcome is of."""
    case: Outcome = json.loads(result['case'])
    return case


def _times(by: dict[str, list[Outcome]]) -> Iterator[Row]:
    """Yield the processor times of the records at 1 kHz of two joints."""
    for what, asked, group in (
            ('healthy', '3 s', 'healthy'), ('one cause', '6 s', 'rich, 1 kHz'),
            ('three causes', '20 s', 'three'), ('fifteen causes', '90 s', 'fifteen')):
        taken = [result['seconds'] for result in by[group]
                 if result['rate'] == 1000.0 and result['joints'] == 2]
        yield (f'processor time, median: {what}', f'at most {asked}',
               f'{np.median(taken):.1f} s, largest {max(taken):.1f} s' if taken else '-', '-')


def _strata(good: Sequence[Outcome]) -> Iterator[Sequence[str]]:
    """Yield how single causes are named by motion, by rate and by number of joints."""
    single = [result for result in good if result['group'] in SINGLE and visible(result)]
    for what, key in (('', 'motion'), (' Hz', 'rate'), (' joint(s)', 'joints')):
        for value in sorted({result[key] for result in single}):
            chosen = [result for result in single if result[key] == value]
            shown = value if isinstance(value, str) else f'{value:g}'
            yield (f'{shown}{what}', percent(chosen, all_identified), percent(chosen, wrong),
                   str(len(chosen)))
    plain = [result for result in single if not result['hidden'][0][5]]
    for name, chosen in (("forms as in the truth's table", plain),
                         ('other forms', [one for one in single if one not in plain])):
        yield name, percent(chosen, all_identified), percent(chosen, wrong), str(len(chosen))


def _effects(good: Sequence[Outcome]) -> Iterator[Sequence[str]]:
    """Yield what was said of each effect in each form."""
    by: dict[str, list[Outcome]] = defaultdict(list)
    for result in good:
        if result['group'] in SINGLE:
            name, form = result['hidden'][0][0], result['hidden'][0][5]
            by[f'`{name}`' + (f', {form}' if form else '')].append(result)
    for what, results in sorted(by.items()):
        other = Counter(_said(result) for result in results if not all_identified(result))
        yield what, f'{sum(map(all_identified, results))} of {len(results)}', ', '.join(
            f'{said} {count}' for said, count in other.items())


def _said(result: Outcome) -> str:
    """Return in short what was said instead."""
    names = ' + '.join(name for name, *_ in result['said']) or f'({result["verdict"]})'
    return names + ('' if visible(result) else ', too small')


def _reliability(good: Sequence[Outcome]) -> list[str]:
    """Return the reliability of probabilities: stated as p, right in how many."""
    pairs = [pair for result in good for pair in probabilities(result)]
    if not pairs:
        return ['The reports of this study give no probabilities.']
    rows = [(f'{low:.1f} to {low + 1.0 / BINS:.1f}', f'{mean:.3f}', f'{right:.3f}', str(count))
            for low, mean, right, count in binned(pairs)]
    return [*_table(('stated', 'mean', 'right', 'causes'), rows), '',
            f'Expected calibration error: {calibration_error(pairs):.3f} (asked: at most 0.03).']


def binned(pairs: Sequence[tuple[float, bool]]) -> list[tuple[float, float, float, int]]:
    """Return the bins of the diagram: lower edge, mean probability, share right, size."""
    filled: dict[int, list[tuple[float, bool]]] = defaultdict(list)
    for probability, right in pairs:
        filled[min(int(BINS * probability), BINS - 1)].append((probability, right))
    return [(place / BINS, float(np.mean([p for p, _ in inside])),
             float(np.mean([right for _, right in inside])), len(inside))
            for place, inside in sorted(filled.items())]


def calibration_error(pairs: Sequence[tuple[float, bool]]) -> float:
    """Return the expected calibration error: by how much bins miss, weighed by their sizes."""
    return sum(count * abs(mean - right) for _, mean, right, count in binned(pairs)) / len(pairs)


def _failures(judged: Sequence[Outcome]) -> list[str]:
    failed = [result for result in judged if 'error' in result]
    return [] if not failed else ['## Records that could not be diagnosed', '', *(
        f'- {one["group"]}, seed {one["seed"]}, {one["motion"]} at {one["rate"]:g} Hz: '
        f'{one["error"]}' for one in failed)]
