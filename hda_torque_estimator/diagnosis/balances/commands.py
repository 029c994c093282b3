"""
The command between the samples of a log: held there, or on its way to the next one.

A controller that was faster than its log changed the command between two samples. Of every n-th
of its samples, the mean command is (n - 1) / 2n of the way to the next one. The motor shows how
far: where the command changes by more than noise, its acceleration shows which torque acted.

Whether commands were held, readings show for certain if stamps know when they were taken. The
stamps of a host do not. Then the motor shows that as well.
"""

from collections.abc import Sequence
from dataclasses import replace

from hda_arm_sim.foundation.arrays import Array
from hda_arm_sim.model.arm import Arm
import numpy as np
from scipy.ndimage import gaussian_filter1d

from .balance import Balancer, RATE
from ...measurements.measurement import Measurement
from ...significance import DEVIATIONS, MOSTLY, UNLIKE

# Numerics; choices unless stated otherwise.
_FAST = 4.0             # samples of the balances over which what is slower is another's effect
# (source: eq:command-way, of every second sample)
_LEAST_WAY = 0.5        # to the next command, of a log of a faster loop
_CHANGES = 5            # stretches of a second with changes of the command, at least


def way_between(balancer: Balancer, arm: Arm, noise: Array) -> float | None:
    """
    Return how far, of the way to the next command, commands went between two samples.

    0 if they were held, 1 if they went all the way at an even rate; None where no change of the
    command shows. `noise` (c,) is that of the balances [N*m]. Its way must explain much of what
    motors do there that it would not, had commands been held, or gone all the way. It must be
    known well enough to tell the least way that there may be from none.
    """
    held, even = (balancer.like(_on_way(balancer.measurement, share))(arm)
                  for share in (0.0, 1.0))
    joints = len(arm.joints)
    valid = held.valid[:, :joints]
    shift = _quick(even.residual[:, :joints] - held.residual[:, :joints])
    rest = _quick(held.residual[:, :joints])
    resolved = valid & (np.abs(shift) > noise[:joints])
    weight = np.where(resolved, 1.0, 0.0) / noise[:joints] ** 2
    against, own = _by_second(-rest * shift * weight), _by_second(shift ** 2 * weight)
    if (own > 0.0).sum() < _CHANGES:
        return None
    share = float(against.sum() / own.sum())
    unsure = float(np.sqrt(np.sum((against - share * own) ** 2)) / own.sum())
    way = min(max(share, 0.0), 1.0)
    as_held, as_even, after = (float(((rest + part * shift) ** 2 * weight).sum())
                               for part in (0.0, 1.0, way))
    if min(way, _LEAST_WAY) > DEVIATIONS * unsure and after < (1.0 - UNLIKE) * as_held:
        return way
    surely_held = (share + DEVIATIONS * unsure < MOSTLY * _LEAST_WAY
                   and as_held < (1.0 - UNLIKE) * as_even)
    return 0.0 if surely_held else None


def on_its_way(balancer: Balancer, arm: Arm, noise: Array) -> Balancer:
    """
    Return balances with commands that went as far between samples as the motors show.

    Where a command changed so much that what is not known of its way is more than noise, the
    motor balances hold nothing. Those of commands that were held are returned as they are.
    A delay looks as if commands had been held. So that is not asked of motors where readings show
    it.
    """
    way = way_between(balancer, arm, noise)
    if way is None or way == 0.0 and len(balancer.measurement.past):
        return balancer
    if way == 0.0:
        held = replace(_on_way(balancer.measurement, way), held=True)
        return balancer.like(held)
    one, other = (balancer.like(_on_way(balancer.measurement, share))(arm) for share in (0.0, 1.0))
    joints = len(arm.joints)
    unknown = np.abs(other.residual - one.residual)[:, :joints] / np.sqrt(12.0) > noise[:joints]
    return balancer.but(measurement=_on_way(balancer.measurement, way), parts=None,
                        unknown=unknown)


def _on_way(measurement: Measurement, share: float) -> Measurement:
    """Return the measurement with commands so far on the way from each sample to the next."""
    parts = measurement.parts
    known = measurement.command[::parts]
    ahead = np.concatenate([known[1:], known[-1:]])
    for begin in measurement.begins[1:]:                    # no way from one recording to another
        ahead[begin // parts - 1] = known[begin // parts - 1]
    passed = ((np.arange(parts) + 0.5) / parts)[None, :, None]
    moved = known[:, None] + share * passed * (ahead - known)[:, None]
    command = moved.reshape(-1, known.shape[1])[:len(measurement.command)]
    return replace(measurement, command=np.ascontiguousarray(command))


def _quick(values: Array) -> Array:
    """Return columns (m, n) without what is slower than a change of a command."""
    return np.asarray(values - gaussian_filter1d(values, _FAST, axis=0))


def _by_second(values: Array) -> Array:
    """Return the sums of columns (m, n) over all joints and each second."""
    starts: Sequence[int] = np.arange(0, len(values), round(RATE)).tolist()
    return np.asarray(np.add.reduceat(values.sum(axis=1), starts))
