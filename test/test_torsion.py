"""The torsion law, against 50-digit decimals and against a table that another program wrote."""

import csv
from dataclasses import replace
from decimal import Decimal, getcontext

from hda_arm_sim.foundation.parameter import ParameterError
from hda_arm_sim.model.torsion import (flexed, flexspline_torsion, stiffer_torque,
                                       stiffer_torsion, stiffness_at, torque_of_torsion,
                                       torsion_of_torque, TorsionLaw, wave_generator_torsion)
from hda_arm_sim.model.torsion_table import tabled_torque, torque_table
from hypothesis import assume, given, strategies as st
import numpy as np
import pytest
from reference_values import reference

getcontext().prec = 50
RATIO = 100.0
LAW = TorsionLaw()
SEGMENTS = TorsionLaw(flexspline_stiffness=1e4, knee_1=3.9, second_stiffness=1.4e4, knee_2=12.0,
                      third_stiffness=1.6e4, wave_generator_stiffness=np.inf)
TORQUES = [sign * size for size in (1e-9, 1e-6, 1e-3, 0.1, 1.0, 3.7, 12.0, 31.0, 36.9)
           for sign in (1.0, -1.0)]

laws = st.builds(
    TorsionLaw, flexspline_stiffness=st.floats(1e3, 1e5), flexspline_curvature=st.floats(0.0, 0.5),
    wave_generator_stiffness=st.one_of(st.floats(0.1, 100.0), st.just(np.inf)),
    wave_generator_curvature=st.floats(0.0, 100.0), valid_torque=st.floats(0.5, 80.0))


def arctangent(x: Decimal) -> Decimal:
    """Return atan(x) to nearly 50 digits: halve the angle ten times, then Taylor's series."""
    for _ in range(10):
        x = x / (1 + (1 + x * x).sqrt())
    return 1024 * sum((-1) ** k * x ** (2 * k + 1) / (2 * k + 1) for k in range(12))


def exact_torsion(law: TorsionLaw, torque: float) -> Decimal:
    """Return the total torsion of the tangent law in decimals [rad]."""
    size = abs(Decimal(torque))
    c, k = Decimal(law.flexspline_curvature), Decimal(law.flexspline_stiffness)
    cw, kw = Decimal(law.wave_generator_curvature), Decimal(law.wave_generator_stiffness)
    ratio = Decimal(RATIO)
    total = arctangent(c * size) / (c * k) + (1 - (-cw * size / ratio).exp()) / (ratio * cw * kw)
    return total if torque > 0.0 else -total


def error(value: float, exact: Decimal) -> float:
    """Return the relative error of a float."""
    return abs(float((Decimal(value) - exact) / exact))


def test_the_oracle_knows_pi():
    pi = Decimal('3.1415926535897932384626433832795028841971693993751')
    assert abs(4 * arctangent(Decimal(1)) - pi) < Decimal('1e-45')


@pytest.mark.parametrize('torque', TORQUES)
def test_law_equals_decimals(torque):
    found = torsion_of_torque(LAW.record(RATIO), RATIO, torque)
    assert error(float(found), exact_torsion(LAW, torque)) < 1e-14


@pytest.mark.parametrize('torque', TORQUES)
def test_inverse_equals_decimals(torque):
    torsion = exact_torsion(LAW, torque)
    assert error(torque_of_torsion(LAW.record(RATIO), RATIO, float(torsion)),
                 Decimal(torque)) < 1e-12


def test_law_equals_the_table_where_the_table_is_right():
    with reference('torsion_law.csv').open() as source:
        rows = [[float(value) for value in row.values()] for row in csv.DictReader(source)]
    law, seen = LAW.record(RATIO), []
    for torque, flexspline, total in rows:
        if torque == 0.0:
            continue
        exact = exact_torsion(LAW, torque)
        found = float(torsion_of_torque(law, RATIO, torque))
        assert error(found, exact) < 1e-12
        assert flexspline_torsion(torque, LAW.flexspline_stiffness,
                                  LAW.flexspline_curvature) == pytest.approx(flexspline, rel=1e-12)
        seen.append((abs(torque), error(total, exact)))
        if abs(torque) > 0.01:
            assert found == pytest.approx(total, rel=1e-12)
    # 1 - exp(-x) has cancelled in the table at its smallest torques: 9 to 7 digits are left
    assert max(miss for torque, miss in seen if torque <= 1e-9) > 1e-9
    assert max(miss for torque, miss in seen if torque > 0.01) < 1e-12


@given(laws, st.floats(-1.0, 1.0))
def test_inverse_of_any_law(law, share):
    torque = share * law.valid_torque
    assume(abs(torque) > 1e-9)
    record = law.record(RATIO)
    torsion = float(torsion_of_torque(record, RATIO, torque))
    assert torque_of_torsion(record, RATIO, torsion) == pytest.approx(torque, rel=1e-9)


@given(laws)
def test_any_law_is_odd_rising_and_stiffens(law):
    record = law.record(RATIO)
    torque = np.linspace(0.0, law.valid_torque, 50)
    torsion = torsion_of_torque(record, RATIO, torque)
    np.testing.assert_array_equal(torsion_of_torque(record, RATIO, -torque), -torsion)
    steps = np.diff(torsion)
    assert (steps > 0.0).all()
    assert (np.diff(steps) <= 1e-9 * steps[0]).all()


def test_scalars_equal_arrays():
    torque = np.array([-20.0, -0.3, 0.0, 1e-6, 5.0])
    for law in (LAW, SEGMENTS):
        record = law.record(RATIO)
        one_by_one = [float(torsion_of_torque(record, RATIO, value)) for value in torque]
        np.testing.assert_array_equal(torsion_of_torque(record, RATIO, torque), one_by_one)


@pytest.mark.parametrize('law', [LAW, SEGMENTS, replace(LAW, flexspline_curvature=0.0)])
def test_torque_goes_on_along_the_last_slope(law):
    record = law.record(RATIO)
    end = float(torsion_of_torque(record, RATIO, law.valid_torque))
    slope = stiffness_at(record, RATIO, law.valid_torque)
    for sign in (1.0, -1.0):
        beyond = torque_of_torsion(record, RATIO, sign * (end + 1e-3))
        assert beyond == pytest.approx(sign * (law.valid_torque + 1e-3 * slope), rel=1e-12)


@pytest.mark.parametrize('growing', [6e-6, -6e-6])
@pytest.mark.parametrize('law', [LAW, SEGMENTS], ids=['tangent', 'segments'])
def test_inverse_where_torque_adds_to_the_torsion(law, growing):
    record = law.record(RATIO)
    for torque in TORQUES:
        torsion = float(torsion_of_torque(record, RATIO, torque)) - growing * abs(torque)
        assert torque_of_torsion(record, RATIO, torsion, growing) == pytest.approx(
            torque, rel=1e-11)


@pytest.mark.parametrize('factor', [0.5, 0.85, 1.0, 1.01, 2.0])
@pytest.mark.parametrize('law', [LAW, SEGMENTS], ids=['tangent', 'segments'])
def test_a_stiffer_flexspline_is_one_of_a_stiffer_law(law, factor):
    """What a factor makes of a torque, the inverse of the stiffer law makes of its torsion."""
    record = law.record(RATIO)
    stiffer = replace(law, flexspline_stiffness=factor * law.flexspline_stiffness,
                      second_stiffness=factor * law.second_stiffness,
                      third_stiffness=factor * law.third_stiffness).record(RATIO)
    for torque in (share * law.valid_torque for share in (-0.3, -1e-3, 1e-6, 0.1, 0.4)):
        for growing in (0.0, 3e-6, -3e-6):
            torsion = float(torsion_of_torque(record, RATIO, torque)) - growing * abs(torque)
            there, slope = stiffer_torsion(record, RATIO, torque, factor, growing)
            assert there == pytest.approx(
                torsion_of_torque(stiffer, RATIO, torque) - growing * abs(torque), rel=1e-9)
            assert 1.0 / slope == pytest.approx(
                1.0 / (1.0 / stiffness_at(stiffer, RATIO, torque)
                       - np.sign(torque) * growing), rel=1e-9)
            assert stiffer_torque(record, RATIO, torque, factor, growing) == pytest.approx(
                torque_of_torsion(stiffer, RATIO, torsion, growing), rel=1e-6)
    assert flexed(record, 2.0) == pytest.approx(
        stiffer_torsion(record, RATIO, 2.0, 0.5, 0.0)[0] - torsion_of_torque(record, RATIO, 2.0))


@pytest.mark.parametrize('growing', [6e-6, -6e-6])
def test_torque_that_adds_to_the_torsion_goes_on_along_the_last_slope(growing):
    record = LAW.record(RATIO)
    slope = 1.0 / stiffness_at(record, RATIO, LAW.valid_torque) - growing
    end = float(torsion_of_torque(record, RATIO, LAW.valid_torque)) - growing * LAW.valid_torque
    beyond = torque_of_torsion(record, RATIO, end + 1e-4, growing)
    assert beyond == pytest.approx(LAW.valid_torque + 1e-4 / slope, rel=1e-12)


def test_wave_generator_and_flexspline_are_springs_in_series():
    initial = 1.0 / (1.0 / LAW.flexspline_stiffness + 1.0 / (RATIO ** 2 * 2.5517))
    assert stiffness_at(LAW.record(RATIO), RATIO, 0.0) == pytest.approx(initial, rel=1e-12)
    assert initial == pytest.approx(7051.0, abs=1.0)


def test_wave_generator_saturates_at_half_of_psi():
    psi = 2.0 * 0.037 / (RATIO * 2.5517)
    assert wave_generator_torsion(1e4, RATIO, 2.5517, 1.0 / 0.037) == pytest.approx(0.5 * psi)


def test_infinite_stiffness_leaves_a_part_out():
    rigid = replace(LAW, wave_generator_stiffness=np.inf).record(RATIO)
    assert torsion_of_torque(rigid, RATIO, 5.0) == flexspline_torsion(
        5.0, LAW.flexspline_stiffness, LAW.flexspline_curvature)


def test_no_curvature_is_a_linear_spring():
    law = TorsionLaw(flexspline_curvature=0.0, wave_generator_stiffness=np.inf).record(RATIO)
    assert torque_of_torsion(law, RATIO, 1e-3) == pytest.approx(9.743939, rel=1e-12)


@given(laws, st.floats(1e-3, 1.5), st.lists(st.floats(-1.0, 1.0), min_size=5, max_size=20))
def test_a_table_gives_the_torques_of_the_iteration(law, share, places):
    record = law.record(RATIO)
    most = share * record['valid_torsion']
    table = torque_table(record, RATIO, min(most, record['valid_torsion']))
    for torsion in most * np.array(places):
        torque = torque_of_torsion(record, RATIO, torsion)
        found = tabled_torque(record, RATIO, table, torsion)
        assert abs(found - torque) <= 4e-11 * torque_of_torsion(record, RATIO, most)


def test_a_table_iterates_at_knees_alone():
    record = SEGMENTS.record(RATIO)
    table = torque_table(record, RATIO, record['valid_torsion'])
    assert 1 <= np.count_nonzero(~table.good) <= 4
    for torsion in np.linspace(0.0, record['valid_torsion'], 3001):
        assert tabled_torque(record, RATIO, table, torsion) == pytest.approx(
            torque_of_torsion(record, RATIO, torsion), rel=1e-9)


def test_segments_pass_through_their_knees():
    record = SEGMENTS.record(RATIO)
    knees = 3.9e-4, 3.9e-4 + 8.1 / 1.4e4, 3.9e-4 + 8.1 / 1.4e4 + 8.0 / 1.6e4
    for torsion, torque in zip(knees, (3.9, 12.0, 20.0)):
        assert torsion_of_torque(record, RATIO, torque) == pytest.approx(torsion, rel=1e-12)
        assert torque_of_torsion(record, RATIO, -torsion) == pytest.approx(-torque, rel=1e-12)


def test_segments_and_wave_generator_are_in_series_too():
    record = replace(SEGMENTS, wave_generator_stiffness=2.5517).record(RATIO)
    for torque in (0.5, 3.9, 7.0, 12.0, 25.0):
        torsion = float(torsion_of_torque(record, RATIO, torque))
        assert torque_of_torsion(record, RATIO, torsion) == pytest.approx(torque, rel=1e-12)


@pytest.mark.parametrize(('wrong', 'sentence'), [
    ({'knee_1': 3.0}, 'torsion.knee_1 needs torsion.second_stiffness > 0'),
    ({'knee_1': 3.0, 'second_stiffness': 1e4, 'knee_2': 2.0, 'third_stiffness': 1e4},
     'torsion.knee_2 must lie beyond torsion.knee_1'),
    ({'flexspline_stiffness': -1.0}, 'torsion.flexspline_stiffness must lie in'),
])
def test_a_law_that_cannot_be_is_refused(wrong, sentence):
    with pytest.raises(ParameterError, match=sentence):
        TorsionLaw(**wrong)
