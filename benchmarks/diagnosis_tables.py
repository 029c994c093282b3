"""The tables of the accuracy study: from the outcomes of all records to `docs/accuracy.md`."""

from collections import Counter, defaultdict
from collections.abc import Callable, Iterable, Iterator, Sequence
from typing import Any, NamedTuple

from hidden_truth import ASKED, expected, ONE_EQUATION
import numpy as np

Outcome = dict[str, Any]
Row = tuple[str, str, str]
Place = tuple[str, str | None]           # an effect and its joint, None for the arm
_HEAD = """# Accuracy of the diagnosis

Written by `benchmarks/diagnosis.py`. Every record is 60 s at 1 kHz of the independent truth in
`test/truth/`: other formulas, integrator and step. It has its own scatter within the tolerances.
Its seeds were used nowhere else. {done} of {planned} planned records were run.

An asymmetric friction and an offset of the drive are one equation while a motor turns. No motion
separates them (`hda plan --between asymmetric_friction drive_offset` says so), and a diagnosis
names them together. They are 2 of 40 effects. So the rows that ask for one name can reach 95 % of
single effects, 90 % of pairs and 85 % of triples. The rows beneath count the two as named.
"""


class Sized(NamedTuple):
    """A number that was fitted: its error as a share of what is hidden, and its interval."""

    effect: str
    number: str
    error: float
    held: bool


def pairs_of(items: Iterable[Sequence[Any]]) -> list[Place]:
    """Return effects and joints, sorted."""
    return sorted(((item[0], item[1]) for item in items), key=str)


def exact(result: Outcome) -> bool:
    """Return whether what is hidden is named with its joint, and nothing else."""
    return pairs_of(result['hidden']) == pairs_of(result['said'])


def all_named(result: Outcome) -> bool:
    """Return whether everything hidden is named."""
    return set(pairs_of(result['hidden'])) <= set(pairs_of(result['said']))


def all_identified(result: Outcome) -> bool:
    """Return whether everything hidden is named, or named together with what is one equation."""
    together = {tuple(place) for pair in result['alike'] for place in pair
                if {name for name, _ in pair} == set(ONE_EQUATION)}
    return set(pairs_of(result['hidden'])) <= set(pairs_of(result['said'])) | together


def extras(result: Outcome) -> int:
    """Return how many causes are named that were not hidden."""
    return len(set(pairs_of(result['said'])) - set(pairs_of(result['hidden'])))


def named_together(result: Outcome) -> bool:
    """Return whether two causes that are one equation are named together, and nothing else."""
    joint = result['hidden'][0][1]
    return (result['verdict'] == 'ambiguous' and not result['said'] and all(
        sorted(map(tuple, pair)) == [(name, joint) for name in sorted(ONE_EQUATION)]
        for pair in result['alike']))


def located(result: Outcome) -> bool:
    """Return whether an effect outside the catalogue is unknown, its place and what it follows."""
    site, follows = result['hidden'][0][3:5]
    rest = result['rest']
    return (result['verdict'] == 'unknown' and not result['said'] and rest is not None
            and (rest[0], rest[2]) == (site, follows))


def percent(results: Sequence[Any], test: Callable[[Any], object]) -> str:
    """Return which share of results passes a test, and how many of how many."""
    if not results:
        return '-'
    passed = sum(bool(test(result)) for result in results)
    return f'{100.0 * passed / len(results):.1f} % ({passed} of {len(results)})'


def page(results: list[Outcome], planned: int) -> str:
    """Return the whole page."""
    good = [result for result in results if 'error' not in result]
    by_group: dict[str, list[Outcome]] = defaultdict(list)
    for result in good:
        by_group[result['group']].append(result)
    sized = [number for result in by_group['one'] if exact(result) for number in _sized(result)]
    return '\n'.join([_HEAD.format(done=len(results), planned=planned),
                      *_bars(by_group, sized), '',
                      '## What was called what', '', *_confusion(by_group['one']), '',
                      '## Numbers of the effects named right', '', *_numbers(sized),
                      '', *_failures(results), ''])


def _bars(by_group: dict[str, list[Outcome]], sized: list[Sized]) -> list[str]:
    one, two = by_group['one'], by_group['two']
    apart = [result for result in one if result['hidden'][0][0] not in ONE_EQUATION]
    seconds = [result['seconds'] for results in by_group.values() for result in results]
    extra = sum(extras(result) for result in two)
    rows = [
        ('one effect: named with its joint, nothing else', '97 %', percent(one, exact)),
        ('the same without asymmetric friction and drive offset', '-', percent(apart, exact)),
        ('those two, one equation while turning: named together', '-',
         percent([result for result in one if result not in apart], named_together)),
        ('one effect: another cause named', '-', percent(one, lambda r: extras(r) > 0)),
        ('healthy, doubled noise: `no_discrepancy`', '99.7 %',
         percent(by_group['healthy'], lambda r: r['verdict'] == 'no_discrepancy')),
        ('two effects: both named', '93 %', percent(two, all_named)),
        ('the same with the two that are one equation named together', '-',
         percent(two, all_identified)),
        ('two effects: extras per record', 'at most 0.05',
         f'{extra / len(two):.2f}' if two else '-'),
        ('three effects: all named', '80 %', percent(by_group['three'], all_named)),
        ('the same with the two that are one equation named together', '-',
         percent(by_group['three'], all_identified)),
        ('outside the catalogue: `unknown`, site and coordinate', '95 %',
         percent(by_group['outside'], located)),
        ('outside the catalogue: `unknown`', '-',
         percent(by_group['outside'], lambda r: r['verdict'] == 'unknown' and not r['said'])),
        ('true effect taken out: a wrong cause named', 'at most 3 %',
         percent(by_group['left out'], lambda r: extras(r) > 0)),
        ('one slow sine: no wrong name', '97 %',
         percent(by_group['poor'], lambda r: extras(r) == 0)),
        *_gained([result for result in one if exact(result)]), *_wide(sized),
        ('processor time, median and largest', '10 s',
         f'{np.median(seconds):.1f} s, {max(seconds):.1f} s')]
    return ['| | asked | reached |', '|---|---|---|',
            *(f'| {what} | {asked} | {reached} |' for what, asked, reached in rows)]


def _gained(named: list[Outcome]) -> Iterator[Row]:
    """Yield what extensions with the right cause removed."""
    loops = {'torsional_hysteresis'}
    for what, asked, chosen in (
            ('excess removed on held-out data, median', '98 %',
             [result for result in named if result['hidden'][0][0] not in loops]),
            ('the same of torsional hysteresis', '85 %',
             [result for result in named if result['hidden'][0][0] in loops])):
        removed = [result['removed'] for result in chosen if np.isfinite(result['removed'])]
        yield what, asked, f'{100.0 * np.median(removed):.2f} %' if removed else '-'


def _wide(sized: list[Sized]) -> Iterator[Row]:
    """Yield the errors of numbers by their kinds, and how often intervals hold."""
    for kind, (asked, names) in ASKED.items():
        errors = [one.error for one in sized if one.effect in names]
        yield (f'error of numbers, median: {kind}', f'at most {100.0 * asked:.0f} %',
               f'{100.0 * np.median(errors):.2f} %' if errors else '-')
    held = sum(one.held for one in sized)
    yield ('90 % intervals that hold the truth', '85 to 95 %',
           f'{100.0 * held / len(sized):.1f} % ({held} of {len(sized)})' if sized else '-')


def _confusion(one: list[Outcome]) -> list[str]:
    counts: dict[str, Counter[str]] = defaultdict(Counter)
    for result in one:
        said = ' + '.join(name for name, *_ in result['said']) or f'({result["verdict"]})'
        if pairs_of(result['said']) == pairs_of(result['hidden']):
            said = 'right'
        elif said == result['hidden'][0][0]:
            said += ', other joint'
        counts[result['hidden'][0][0]][said] += 1
    return ['| hidden | right | otherwise |', '|---|---|---|', *(
        f'| `{name}` | {count["right"]} of {count.total()} | '
        + ', '.join(f'{said} {times}' for said, times in count.items() if said != 'right') + ' |'
        for name, count in sorted(counts.items()))]


def _numbers(sized: list[Sized]) -> list[str]:
    errors: dict[tuple[str, str], list[Sized]] = defaultdict(list)
    for one in sized:
        errors[one.effect, one.number].append(one)
    return ['| effect | number | error, median | interval holds |', '|---|---|---|---|', *(
        f'| `{effect}` | {number} | {100.0 * np.median([one.error for one in same]):.2f} % | '
        f'{sum(one.held for one in same)} of {len(same)} |'
        for (effect, number), same in sorted(errors.items()))]


def _sized(result: Outcome) -> Iterator[Sized]:
    """Yield the numbers of a record that mean the same in the truth and in the library."""
    (effect, joint, true, *_), (_, _, found) = result['hidden'][0], result['said'][0]
    for number, (whole, hidden) in expected(effect, joint, true, result['scatter']).items():
        if number in found:
            estimate, low, high = found[number]
            yield Sized(effect, number, abs(estimate - whole) / abs(hidden), low <= whole <= high)


def _failures(results: list[Outcome]) -> list[str]:
    failed = [result for result in results if 'error' in result]
    return [] if not failed else ['## Records that could not be made or diagnosed', '', *(
        f'- {result["group"]}, seed {result["seed"]}: {result["error"]}' for result in failed)]
