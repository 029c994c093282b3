"""Steps of the diagnosis' least squares, where channels pull apart, and where numbers end."""

from hda_arm_sim.model.effects import InertialCoupling, Payload
from hda_torque_estimator.diagnosis.fitting.fit import room
from hda_torque_estimator.diagnosis.fitting.nuisance import Zero
from hda_torque_estimator.diagnosis.fitting.solve import Columns, condense, solve
from hda_torque_estimator.least_squares.charts import CarriedMoments, Identity
from hda_torque_estimator.least_squares.term import Term
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


@given(st.floats(-0.95, 0.95), st.floats(0.1, 5.0), st.floats(-5.0, 5.0))
def test_beside_what_ends_at_its_bound_others_step_as_if_it_were_known(alike, wanted, other):
    """Cut off afterwards, the second number would make room for what the first does not do."""
    gram = 1000.0 * np.array([[1.0, alike], [alike, 1.0]])
    best = np.array([-wanted, other])
    columns = Columns(gram[None], -(gram @ best)[None], np.array([best @ gram @ best]),
                      np.array([1000.0]))
    found = solve(columns, np.array([10.0]), EFFECTIVE, np.zeros(2), np.full(2, np.inf),
                  (np.array([0.0, np.inf]), np.full(2, np.inf)))
    np.testing.assert_allclose(found.step, [0.0, other - alike * wanted], atol=1e-6)


def test_the_room_of_a_step_is_what_is_declared():
    body = Term(Payload(mass=2.0, x=-0.1, radius=0.3), None,
                (CarriedMoments(('mass', 'x', 'radius'), 0.5),))
    coupled = Term(InertialCoupling(share=-0.75), None, (Identity(('share',), 0.2),))
    down, up = room([body, coupled, Zero('joint1')])
    np.testing.assert_allclose(down, [2.0, np.inf, 0.2, 0.25, np.inf])
    np.testing.assert_allclose(up, [np.inf, np.inf, np.inf, 1.75, np.inf])
