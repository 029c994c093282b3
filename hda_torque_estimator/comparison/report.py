"""What a comparison says: as a JSON document, and as lines for people."""

from collections.abc import Sequence
from dataclasses import asdict
from typing import Any

import numpy as np

from .align import Alignment
from .compare import Comparison, Difference
from .signals import BagSignals

SCHEMA = 'hda.compare/1'
_USUAL_DRIFT = 3e-4                 # crystals stay below
_SMALL = 1e-3           # offset of clocks that is stated in microseconds (choice) [s]
_DRAWN, _DRAWN_ALIKE = 6, 2         # signals worth a figure, and those if none differs
_HEADS = ('signal', 'unit', 'rms', 'max', 'mean', 'of motion', 'noise', 'starts', 'lines')
_WORDS = ('signal', 'unit', 'lines')
_DISPENSABLE = ('lines', 'mean', 'noise', 'max')       # columns, what a narrow screen loses first


def document(found: Comparison, version: str) -> dict[str, Any]:
    """Return all of a comparison as plain JSON values; times count from the start of the first."""
    return {
        'schema': SCHEMA, 'version': version,
        'first': _bag(found.first), 'second': _bag(found.second),
        'alignment': _alignment(found.alignment), 'overlap': found.overlap,
        'signals': [_signal(each) for each in found.differences],
        'only_in_first': list(found.only_first), 'only_in_second': list(found.only_second),
        'never_at_the_same_time': list(found.apart)}


def sentences(found: Comparison, width: int | None = None) -> list[str]:
    """Return the lines for people, a table as wide as a terminal is where that is known."""
    return [headline(found), '', clock_sentence(found), *doubts(found.alignment), '',
            *table([_HEADS, *map(_row, found.differences)], width), *_lists(found), '',
            *_samplings(found)]


def headline(found: Comparison) -> str:
    """Return the result in one sentence."""
    apart = [each for each in found.differences if each.is_significant]
    count = len(found.differences)
    if not apart:
        return f'None of {count} common signals differs beyond noise.'
    starts = [each.start for each in apart if each.start is not None]
    since = f', first at {min(starts):.3f} s' if starts else ''
    return f'{len(apart)} of {count} common signals {"differ" if len(apart) > 1 else "differs"} ' \
           f'beyond noise{since}.'


def drawn(found: Comparison) -> tuple[Difference, ...]:
    """Return the differences that are worth a figure."""
    apart = sum(each.is_significant for each in found.differences)
    return found.differences[:min(apart, _DRAWN) or _DRAWN_ALIKE]


def clock_sentence(found: Comparison) -> str:
    """Return how the clocks of both bags go, with 90 % intervals."""
    clock = found.alignment
    common = f'both hold {found.overlap:.3f} s'
    if clock.mode == 'none':
        return f'By its stamps the second starts {clock.offset:.7f} s after the first; {common}.'
    drift = '' if clock.mode == 'offset' else \
        f', drift {1e6 * clock.drift:.3f} +- {1e6 * drift_half(clock):.3f} ppm'
    return f'The second starts {_offset(clock)} after the ' \
           f'first{drift}; {common}; the motions correlate by {clock.correlation:.4f}.'


def _offset(clock: Alignment) -> str:
    """Return the offset with half its 90 % interval, a small one in microseconds."""
    half = offset_half(clock)
    if max(abs(clock.offset), half) < _SMALL:
        return f'{1e6 * clock.offset:.1f} +- {1e6 * half:.1f} us'
    return f'{clock.offset:.7f} +- {half:.1e} s'


def doubts(clock: Alignment) -> list[str]:
    """Return what speaks against an alignment, a sentence each."""
    found = []
    if abs(clock.drift) - drift_half(clock) > _USUAL_DRIFT:
        found.append('Clocks seldom drift that much: one run may be slower than the other, which '
                     '--align offset shows as a difference.')
    if clock.rivals:
        found.append(
            'The motion repeats itself: offsets of '
            + ', '.join(f'{rival:.3f}' for rival in clock.rivals[:5])
            + ' s fit as well; the one of most overlap is taken.')
    return found


def offset_half(clock: Alignment) -> float:
    """Return half the 90 % interval of the offset [s]."""
    return float(clock.quantile * clock.deviation(np.zeros(1))[0])


def drift_half(clock: Alignment) -> float:
    """Return half the 90 % interval of the drift."""
    return float(clock.quantile * np.sqrt(clock.covariance[1, 1]))


def lines_text(found: Difference) -> str:
    """Return the strongest lines of a difference, frequency and amplitude."""
    return ', '.join(f'{line.frequency:.2f} Hz ({line.amplitude:.2g})'
                     for line in found.spectrum.lines)


def share_text(found: Difference) -> str:
    """Return a difference as a share of the motion."""
    return '' if found.relative is None else f'{100.0 * found.relative:.3g} %'


def start_text(found: Difference) -> str:
    """Return when a difference starts."""
    return '' if found.start is None else f'{found.start:.3f} s'


def _bag(bag: BagSignals) -> dict[str, Any]:
    return {'bag': bag.source, 'first_stamp': bag.start,
            'topics': {name: asdict(sampling) for name, sampling in bag.sampling.items()}}


def _alignment(clock: Alignment) -> dict[str, Any]:
    return {'mode': clock.mode, 'offset': _interval(clock.offset, offset_half(clock)),
            'drift': _interval(clock.drift, drift_half(clock)),
            'correlation': clock.correlation, 'other_offsets': list(clock.rivals),
            'doubts': doubts(clock)}


def _interval(value: float, half: float) -> dict[str, float]:
    return {'value': value, 'low': value - half, 'high': value + half}


def _signal(found: Difference) -> dict[str, Any]:
    return {'name': found.name, 'unit': found.unit, 'samples': len(found.laid.time),
            'rms': found.rms, 'max': found.largest, 'mean': found.mean,
            'relative': found.relative, 'noise': found.noise, 'start': found.start,
            'lines': [line._asdict() for line in found.spectrum.lines]}


def _row(found: Difference) -> tuple[str, ...]:
    return (found.name, found.unit, f'{found.rms:.3g}', f'{found.largest:.3g}',
            f'{found.mean:.3g}', share_text(found), f'{found.noise:.3g}', start_text(found),
            lines_text(found))


def table(rows: Sequence[Sequence[str]], width: int | None = None) -> list[str]:
    """
    Return rows as lines of at most a width, words to the left and numbers to the right.

    Columns go until the others fit, those first that the page beside it is read for.
    """
    kept = {head: column for head, *column in zip(*rows)}
    wide = {head: max(map(len, (head, *column))) for head, column in kept.items()}
    for head in _DISPENSABLE:
        if width is None or sum(wide[one] + 2 for one in kept) <= width:
            break
        del kept[head]
    columns = [[cell.ljust(wide[head]) if head in _WORDS else cell.rjust(wide[head])
                for cell in (head, *column)] for head, column in kept.items()]
    lines = [f'  {"  ".join(row)}'.rstrip() for row in zip(*columns)]
    missing = len(_HEADS) - len(kept)
    return [*lines, f'  compare.html has {missing} more columns'] if missing else lines


def _lists(found: Comparison) -> list[str]:
    """Return the signals that could not be compared."""
    named = (('only in the first', found.only_first), ('only in the second', found.only_second),
             ('in both, but never at the same time', found.apart))
    lines = [f'  {where}: {", ".join(names)}' for where, names in named if names]
    return ['', *lines] if lines else []


def _samplings(found: Comparison) -> list[str]:
    return [f'  {bag.source}: {topic} at {sampling.rate:.1f} Hz, {sampling.samples} samples, '
            f'{sampling.lost} lost, longest gap {1e3 * sampling.longest_gap:.2f} ms'
            for bag in (found.first, found.second) for topic, sampling in bag.sampling.items()]
