"""Compare two bags: every common signal on common times, and what is in one of them only."""

from dataclasses import dataclass

import numpy as np

from .align import align, Alignment
from .onset import noise_of, onset
from .overlay import Overlay, overlay
from .signals import BagSignals, CompareError, LEAST
from .spectrum import Spectrum, spectrum


@dataclass(frozen=True, eq=False)
class Difference:
    """Say how a signal of the second bag differs from that of the first."""

    name: str
    unit: str
    laid: Overlay
    rms: float
    largest: float                  # of its magnitude
    mean: float
    relative: float | None          # rms over the standard deviation of the first, if it moves
    noise: float                    # rms of what changes fast
    start: float | None             # first time beyond noise, from the start of the first [s]
    spectrum: Spectrum

    @property
    def is_significant(self) -> bool:
        """Return whether there is more than noise."""
        return self.start is not None or bool(self.spectrum.lines)


@dataclass(frozen=True, eq=False)
class Comparison:
    """Hold two bags laid over each other; the differences come largest first."""

    first: BagSignals
    second: BagSignals
    alignment: Alignment
    overlap: float                  # that both hold [s]
    differences: tuple[Difference, ...]
    only_first: tuple[str, ...]
    only_second: tuple[str, ...]
    apart: tuple[str, ...]          # signals that both have, but never at the same time


def compare(first: BagSignals, second: BagSignals, mode: str) -> Comparison:
    """
    Return two bags laid over each other, aligned by a mode of `align.MODES`.

    Raise CompareError if they have no signal in common, cannot be aligned or do not overlap.
    """
    common = [name for name in first.signals if name in second.signals]
    if not common:
        raise CompareError(
            f'{first.source} and {second.source} have no signal in common: the first has '
            f'{_some(first)}, the second {_some(second)}')
    alignment = align(first, second, common, mode)
    laid = {name: overlay(first.signals[name], second.signals[name], alignment)
            for name in common}
    found = [_difference(name, first.signals[name].unit, both) for name, both in laid.items()
             if len(both.time) >= LEAST]
    if not found:
        raise CompareError(
            f'{first.source} and {second.source} do not overlap in time: the second starts '
            f'{alignment.offset:.3f} s after the first; use --align offset or drift')
    return Comparison(
        first, second, alignment, _overlap(found),
        tuple(sorted(found, key=_rank)), _missing(first, second), _missing(second, first),
        tuple(name for name, both in laid.items() if len(both.time) < LEAST))


def _difference(name: str, unit: str, laid: Overlay) -> Difference:
    missed, moved, noise = laid.difference, float(laid.first.std()), noise_of(laid)
    rms = float(np.sqrt((missed ** 2).mean()))
    return Difference(name, unit, laid, rms, float(np.abs(missed).max()), float(missed.mean()),
                      rms / moved if moved > 0.0 else None, noise, onset(laid, noise),
                      spectrum(laid))


def _rank(found: Difference) -> tuple[bool, float, str]:
    """Return what sorts differences: those beyond noise first, by their relative size."""
    size = np.inf if found.relative is None and found.rms > 0.0 else found.relative or 0.0
    return not found.is_significant, -size, found.name


def _overlap(found: list[Difference]) -> float:
    times = [each.laid.time for each in found]
    return float(max(time[-1] for time in times) - min(time[0] for time in times))


def _missing(having: BagSignals, lacking: BagSignals) -> tuple[str, ...]:
    return tuple(name for name in having.signals if name not in lacking.signals)


def _some(bag: BagSignals) -> str:
    """Return a few names of signals."""
    names = list(bag.signals)
    return ', '.join(names[:3]) + (f' and {len(names) - 3} more' if len(names) > 3 else '')
