"""Least squares within bounds: the best step that keeps to them, against a general minimiser."""

from types import SimpleNamespace

from hda_arm_sim.model.effects import Backlash, Payload, ViscousFriction
from hda_arm_sim.model.files import read_arm
from hda_torque_estimator.diagnosis.fitting.nuisance import nuisances
from hda_torque_estimator.least_squares.charts import Identity
from hda_torque_estimator.least_squares.descent import improved
from hda_torque_estimator.least_squares.normal import within
from hda_torque_estimator.least_squares.term import Term, with_terms
from hypothesis import example, given, strategies as st
import numpy as np
from scipy.optimize import lsq_linear

RIDGE = 1e-10          # of scaled equations, as a fit has it


def drawn(seed, size):
    """Return columns of sizes that differ by ten thousands, and what they shall explain."""
    random = np.random.default_rng(seed)
    columns = random.normal(size=(4 * size, size)) * 10.0 ** random.uniform(-4.0, 4.0, size)
    return columns, columns @ (random.normal(size=size) / np.linalg.norm(columns, axis=0))


@given(st.integers(0, 2 ** 32 - 1), st.integers(1, 8))
def test_step_without_bounds_is_that_of_least_squares(seed, size):
    columns, reported = drawn(seed, size)
    free = np.full(size, np.inf)
    step = within(columns.T @ columns, columns.T @ reported, np.zeros(size), (-free, free))
    wanted = np.linalg.lstsq(columns, reported, rcond=None)[0]
    np.testing.assert_allclose(columns @ step, columns @ wanted, atol=1e-8)


@given(st.integers(0, 2 ** 32 - 1), st.floats(-2.0, 2.0), st.floats(0.0, 2.0))
@example(208821, 1.0, 1.0)              # ends at its bound, but for rounding
def test_one_number_beyond_its_bound_stays_there_and_the_others_are_the_best_beside_it(
        seed, place, width):
    columns, reported = drawn(seed, 4)
    free = np.linalg.lstsq(columns, reported, rcond=None)[0]
    low, high = np.full(4, -np.inf), np.full(4, np.inf)
    low[1], high[1] = sorted((place * free[1], (place + width) * free[1] + 1e-6))
    step = within(columns.T @ columns, columns.T @ reported, np.zeros(4), (low, high))
    scale = np.linalg.norm(columns, axis=0)
    wanted = lsq_linear(columns / scale, reported, (low * scale, high * scale), tol=1e-13)
    near = 1e-9 * max(1.0, 0.5 * (high[1] - low[1]))    # of half the way between two bounds
    assert (low - near <= step).all() and (step <= high + near).all()
    np.testing.assert_allclose(columns @ step, columns / scale @ wanted.x, atol=1e-5)


def test_with_a_ridge_a_column_of_zeros_does_not_move_and_does_no_harm():
    columns, _ = drawn(1, 3)
    columns[:, 1] = 0.0
    reported = columns @ (1.0, 1.0, 1.0)
    free = np.full(3, np.inf)
    step = within(columns.T @ columns, columns.T @ reported, np.zeros(3), (-free, free),
                  RIDGE)
    assert step[1] == 0.0
    np.testing.assert_allclose(columns @ step, reported, atol=1e-6 * np.abs(reported).max())


def test_what_stands_at_its_bound_goes_back_from_it():
    bounds = np.array([-1.0]), np.array([1.0])
    assert within(np.eye(1), np.array([-0.5]), np.array([1.0]), bounds)[0] < -0.49
    assert within(np.eye(1), np.array([0.5]), np.array([1.0]), bounds)[0] == 0.0


def test_a_descent_ends_where_a_step_gains_too_little_and_makes_slopes_anew_before_each():
    renewed = []

    def halved(state):
        return SimpleNamespace(score=0.5 * state.score)

    def anew(state, gained):
        renewed.append(gained)
        return state

    assert improved(SimpleNamespace(score=16.0), halved, anew, 10, 1.5).score == 1.0
    assert renewed == [8.0, 4.0, 2.0]
    assert improved(SimpleNamespace(score=16.0), halved, anew, 2, 1.5).score == 4.0


def test_terms_that_are_placed_at_once_make_the_arm_that_they_make_one_by_one():
    arm = read_arm('hda_arm.yaml').with_effect(Payload(mass=0.5)).with_effect(
        ViscousFriction(slope=1e-3), 'joint2')
    terms = [*nuisances(arm), Term(Backlash(half_width=1e-4), 'joint1'),
             Term(Payload(mass=0.2), None), Term(arm.joint('joint1').torsion, 'joint1',
                                                 (Identity(('damping',), 1.0),), 'torsion')]
    wanted = arm
    for term in terms:
        wanted = term.on(wanted)
    assert with_terms(arm, terms) == wanted
    assert with_terms(arm, ()) == arm


def held_in_turn(normal, right, now, low, high):
    """Return the step that holds what passes its bound by most, solving anew for each."""
    scale = 1.0 / np.sqrt(np.diag(normal))
    scaled, right = normal * np.outer(scale, scale) + RIDGE * np.eye(len(now)), right * scale
    fixed, half = {}, 0.5 * (high - low)
    while True:
        free = [number for number in range(len(now)) if number not in fixed]
        step = np.zeros(len(now))
        step[list(fixed)] = [value / scale[number] for number, value in fixed.items()]
        step[free] = np.linalg.solve(scaled[np.ix_(free, free)], (right - scaled @ step)[free])
        at = now + step * scale
        over = np.maximum(low - at, at - high) / half
        worst = max(free, key=lambda number: over[number], default=0)
        if not free or over[worst] <= 1e-9:
            return step * scale
        fixed[worst] = np.clip(at, low, high)[worst] - now[worst]


@given(st.integers(0, 2 ** 32 - 1), st.integers(2, 40), st.booleans())
def test_many_that_stop_are_found_as_if_each_were_solved_anew(seed, size, alike):
    random = np.random.default_rng(seed)
    columns = random.normal(size=(3 * size, size)) * 10.0 ** random.uniform(-4.0, 4.0, size)
    if alike:
        columns[:, 0] = 2.0 * columns[:, -1]
    normal = columns.T @ columns
    deviations = 10.0 ** random.uniform(-2.0, 1.0, size) / np.sqrt(np.diag(normal))
    now = deviations * random.uniform(-3.0, 3.0, size)
    normal += np.diag(1.0 / deviations ** 2)
    right = columns.T @ random.normal(0.0, 10.0, 3 * size) - now / deviations ** 2
    bounds = -3.5 * deviations, 3.5 * deviations
    step = within(normal, right, now, bounds, RIDGE)
    expected = held_in_turn(normal, right, now, *bounds)
    np.testing.assert_allclose(step / deviations, expected / deviations, atol=1e-6)
