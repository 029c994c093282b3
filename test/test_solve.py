"""Steps of the diagnosis' least squares, where channels pull apart."""

from hda_torque_estimator.diagnosis.fitting.solve import Columns, condense, solve
from hypothesis import assume, given, strategies as st
import numpy as np

EFFECTIVE = 0.5
FREE = np.full(1, np.inf)


def pulled(apart, shares):
    """Return two channels of unit noise that want one number to be zero and `apart`."""
    count = 1000.0 * np.asarray(shares)
    wanted = np.array([0.0, apart])
    return Columns(count[:, None, None], -(count * wanted)[:, None], count * wanted ** 2, count)


def along(columns, steps):
    """Return the score of each of some steps of one number."""
    left = (columns.power + 2.0 * columns.against[:, 0] * steps[:, None]
            + columns.products[:, 0, 0] * steps[:, None] ** 2) / columns.samples
    return EFFECTIVE * np.where(left > 1.0, 1.0 + np.log(np.maximum(left, 1.0)),
                                left) @ columns.samples


@given(st.floats(0.0, 300.0), st.floats(0.02, 0.98), st.floats(-0.5, 1.5))
def test_of_two_best_steps_the_better_one_is_taken(apart, share, place):
    """But for one point: in the middle between two equal channels nothing says which way to go."""
    assume(abs(share - 0.5) + abs(place - 0.5) > 1e-3)
    columns, now = pulled(apart, (share, 1.0 - share)), place * apart
    moved = Columns(columns.products, columns.against + columns.products[:, :, 0] * now,
                    columns.power + 2.0 * columns.against[:, 0] * now
                    + columns.products[:, 0, 0] * now ** 2, columns.samples)
    found = solve(moved, np.ones(2), EFFECTIVE, np.array([now]), FREE)
    best = along(columns, np.linspace(-1.0, apart + 1.0, 5001)).min()
    assert found.score <= best + 0.02 * EFFECTIVE * 1000.0


@given(st.floats(0.01, 1.99), st.floats(0.02, 0.98))
def test_two_channels_that_are_less_than_two_deviations_apart_have_one_best_step(apart, share):
    course = np.diff(along(pulled(apart, (share, 1.0 - share)), np.linspace(0.0, apart, 501)))
    turns = np.diff(np.sign(course[np.abs(course) > 1e-6]))
    assert (turns >= 0.0).all()             # down to the best step, and up again


def test_a_small_error_of_a_derivative_does_not_hide_what_explains_nearly_all():
    """Hold what one channel shows at 300 times noise against an error of a derivative of 30."""
    random, time = np.random.default_rng(1), np.arange(20000) / 1000.0
    wave = np.sin(7.0 * time)
    residual = random.standard_normal((len(time), 2)) - np.stack([300.0 * wave, 0 * wave], 1)
    columns = np.stack([300.0 * wave, 30.0 * np.cos(7.0 * time)], axis=1)[:, :, None]
    valid = np.ones(residual.shape, bool)
    found = solve(condense(residual, columns, valid), np.ones(2), EFFECTIVE, np.zeros(1), FREE)
    assert abs(found.step[0] - 1.0) < 0.1
