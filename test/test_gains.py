"""Gains on held-out data are shares of what is above noise, wherever the floor is."""

from hda_torque_estimator.diagnosis.findings.gains import Gains
import numpy as np
import pytest

WINDOWS = 200


def gains(before: float, after: float, floor: float, spread: float = 0.0) -> Gains:
    """Return gains of windows with these means (w,)."""
    random = np.random.default_rng(920200)
    return Gains(*(mean + spread * random.standard_normal(WINDOWS)
                   for mean in (before, after, floor)))


@pytest.mark.parametrize(('before', 'after', 'floor', 'share'), [
    (5.0, 1.0, 1.0, 1.0), (5.0, 3.0, 1.0, 0.5), (5.0, 0.8, 1.0, 1.0), (5.0, 7.0, 1.0, -0.5),
    (5.0, 5.0, 1.0, 0.0)])
def test_a_gain_is_the_share_of_the_excess_that_is_gone(before, after, floor, share):
    assert gains(before, after, floor).removed() == pytest.approx(share)


def test_a_floor_above_what_is_left_hides_no_gain():
    """Noise of a twin may be overestimated; what is left in truth is the better floor."""
    assert gains(0.20, 0.13, 1.0).removed() == pytest.approx(1.0)
    low, high = gains(0.20, 0.13, 1.0, 0.05).interval()
    assert 0.0 < low <= high == pytest.approx(1.0)


def test_what_gets_worse_below_a_floor_is_no_gain():
    assert gains(0.13, 0.20, 1.0).removed() == -1.0
    assert gains(0.20, 0.20, 1.0, 0.05).interval()[0] < 0.0
    assert np.isnan(gains(0.20, 0.20, 1.0).removed())
