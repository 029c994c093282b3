"""Signals of two bags on even times, without what is too fast to align by."""

from collections.abc import Sequence
from typing import NamedTuple

from hda_arm_sim.foundation.arrays import Array
import numpy as np
from scipy.signal import butter, sosfiltfilt

from .signals import BagSignals, CompareError, Signal

FASTEST = 250.0                     # rate that is enough to align by [Hz]
_BAND = 0.1                         # of the rate: what is faster is left out
_SLOWER = 4.0                       # times the shortest period: slower signals show little
_MOVES = 5.0                        # times the fast rest that a signal must move
_MOST = 16                          # signals: more show no more
_FEWEST = 40                         # even samples


class Tracks(NamedTuple):
    """Hold signals at even times from the start of a bag."""

    rate: float                     # [Hz]
    values: Array                   # (n, s)


def tracks(first: BagSignals, second: BagSignals, names: Sequence[str]) -> tuple[Tracks, Tracks]:
    """Return the signals of both bags that move the most; raise CompareError if none does."""
    pairs = {name: (first.signals[name], second.signals[name]) for name in names}
    periods = {name: max(one.period, two.period) for name, (one, two) in pairs.items()}
    slowest = _SLOWER * min(periods.values())
    pairs = {name: pair for name, pair in pairs.items() if periods[name] <= slowest}
    rate = min(1.0 / max(periods[name] for name in pairs), FASTEST)
    smooth = {name: tuple(_smooth(bag, signal, rate) for bag, signal in
                          zip((first, second), pair)) for name, pair in pairs.items()}
    moving = {name: min(moves for _, moves in both) for name, both in smooth.items()}
    chosen = [name for name in sorted(moving, key=lambda name: -moving[name])[:_MOST]
              if moving[name] > _MOVES]
    if not chosen:
        raise CompareError(
            f'{first.source} and {second.source} cannot be aligned: none of the '
            f'{len(pairs)} common signals moves in both; use --align none to compare by stamps')
    one, two = (Tracks(rate, np.stack([smooth[name][side][0] for name in chosen], axis=1))
                for side in (0, 1))
    return one, two


def _smooth(bag: BagSignals, signal: Signal, rate: float) -> tuple[Array, float]:
    """Return a signal at even times, and how much it moves against its fast rest."""
    end = max(float(other.time[-1]) for other in bag.signals.values())
    dense = max(1, round(1.0 / (signal.period * rate)))
    if end * rate < _FEWEST:
        raise CompareError(f'{bag.source} cannot be aligned: it lasts {end:.3g} s, at least '
                           f'{_FEWEST / rate:.3g} s are needed; use --align none')
    time = np.arange(int(end * rate) * dense + 1) / (rate * dense)
    even = np.interp(time, signal.time, signal.values)
    slow = sosfiltfilt(butter(4, _BAND / dense * 2.0, output='sos'), even)
    scale = np.abs(even).max() * 1e-9
    return slow[::dense], float(slow.std() / max((even - slow).std(), scale, 1e-300))
