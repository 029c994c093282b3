"""The noise of a difference, and the first time at which it leaves that noise and stays out."""

from hda_arm_sim.foundation.arrays import Array
import numpy as np
from scipy.ndimage import uniform_filter1d

from .overlay import Overlay

_WINDOW = 0.2                       # over which a level is taken [s]
_LEAST_WINDOW = 32                  # samples, so that the level of noise is sure to 40 %
_FAST = 5                           # windows of `_WINDOW` hold so many of what counts as fast
_BEYOND = 2.0                       # times the noise: a level of noise alone stays below
_DEVIATIONS = 3.0                   # of the alignment that are no difference
_HOLD = 5                           # windows in which a difference that stays is there ...
_SHARE = 0.5                        # ... for this share of the time
_EXACT = 1e-9                       # of a signal: differences below it are those of arithmetic


def noise_of(laid: Overlay) -> float:
    """
    Return the noise of a difference: the usual rms of what changes within 40 ms.

    It is at least the rounding of both signals, for most of a recording may stand still.
    """
    difference = laid.difference
    fast = difference - uniform_filter1d(difference, max(3, _window(laid) // _FAST))
    usual = float(np.sqrt(np.median(_mean(fast ** 2, _window(laid)))))
    rounding = np.hypot(_step(laid.first), _step(laid.second)) / np.sqrt(12.0)
    least = _EXACT * max(np.abs(laid.first).max(), np.abs(laid.second).max())
    return float(max(usual, rounding, least))


def onset(laid: Overlay, noise: float) -> float | None:
    """
    Return the first time at which a difference leaves its noise and stays beyond it [s].

    None if it never does. It stays if its level is twice the noise for half of the next second.
    """
    square, window = laid.difference ** 2, _window(laid)
    allowed = (_BEYOND * noise) ** 2 + _mean((_DEVIATIONS * laid.slack) ** 2, window)
    beyond = _mean(square, window) > allowed
    hold = min(_HOLD * window, len(beyond))
    total = np.concatenate([[0], np.cumsum(beyond), np.full(hold, beyond.sum())])
    stays = beyond & (total[hold:hold + len(beyond)] - total[:len(beyond)] >= _SHARE * hold)
    if not stays.any():
        return None
    first = int(stays.argmax())
    begin, least = max(0, first - window), 1e-6 * noise ** 2 + np.finfo(float).tiny
    if first <= window // 2:
        return float(laid.time[0])
    return float(laid.time[begin + _change(square[begin:first + window] + least)])


def _change(square: Array) -> int:
    """Return where the variance of noise changes, most likely, given its squares (k,)."""
    before = np.cumsum(square)[:-1]
    count = np.arange(1, len(square))
    after = np.maximum(square.sum() - before, square[-1])
    cost = count * np.log(before / count) + count[::-1] * np.log(after / count[::-1])
    return int(cost.argmin()) + 1


def _window(laid: Overlay) -> int:
    """Return the samples of a window."""
    return min(max(_LEAST_WINDOW, round(_WINDOW / laid.period)), len(laid.time))


def _mean(values: Array, window: int) -> Array:
    """Return the moving mean of what is never negative."""
    return np.maximum(uniform_filter1d(values, window), 0.0)


def _step(values: Array) -> float:
    """Return the smallest change of a signal, 0 if it never changes."""
    changes = np.abs(np.diff(values))
    changes = changes[changes > _EXACT * np.abs(values).max()]
    return float(changes.min()) if len(changes) else 0.0
