"""Recordings that cannot calibrate an arm are refused in one line, and so are wrong statements."""

from collections.abc import Callable
import math
from pathlib import Path

from hda_arm_sim.model.arm import Arm
from hda_arm_sim.model.files import read_arm
from hda_torque_estimator.calibrate.calibration import one_joint
from hda_torque_estimator.calibrate.fitting.laws import stiffness, waves
from hda_torque_estimator.calibrate.fitting.orders import candidates
from hda_torque_estimator.calibrate.fitting.torsion_fits import TorsionFits
from hda_torque_estimator.calibrate.ordinary import calibrate_ordinary
from hda_torque_estimator.calibrate.passages.calibration_recording import CalibrationRecording
from hda_torque_estimator.calibrate.passages.joint_recording import CalibrationError
from hda_torque_estimator.calibrate.passages.passage import Passage
from hda_torque_estimator.calibrate.passages.stated_conditions import stated, StatedConditions
from hda_torque_estimator.calibrate.passages.suitability import (check, check_alike,
                                                                 check_of_one_piece)
from hda_torque_estimator.calibrate.run import scale_of
import numpy as np
import pytest

RATIO, STIFFNESS, DT = 100.0, 8000.0, 0.004


@pytest.fixture(scope='module')
def arm() -> Arm:
    """Return the arm that the recordings are said to be of."""
    return read_arm('hda_arm.yaml')


def good(load: float = 5.0) -> Passage:
    """Return a passage of 12 s that can calibrate: both ways, under a torque that varies."""
    time = DT * np.arange(3000)
    link, rate = 0.8 * np.sin(time), 0.8 * np.cos(time)
    torque = load * np.sin(0.7 * time) + 0.5
    readings = np.full((len(time), 1, 4), np.nan)
    readings[:, 0, 0] = RATIO * (link + torque / STIFFNESS)
    readings[:, 0, 1] = link + 4e-4 * np.sin(link + 1.0)
    motor_rate = RATIO * rate
    command = torque / RATIO + 0.04 * np.sign(motor_rate)
    return Passage('good', DT, readings, torque, np.zeros((len(time), 3)),
                   np.ones(len(time), bool), command, link, rate, motor_rate,
                   np.zeros(len(time)))


def counted_otherwise(part: Passage, factor: float) -> Passage:
    """Return a passage whose motor encoder counts otherwise."""
    readings = part.readings.copy()
    readings[:, 0, 0] *= factor
    return part._replace(readings=readings)


def test_what_can_calibrate_is_not_refused(arm):
    check(arm, 'joint1', [good()])


def test_recordings_of_other_rates_belong_together(arm):
    """Two that should be of one rate differ by 0.13 %, and two by 2 %: all are one calibration."""
    joint, passages = one_joint(arm, 'joint1'), [
        good()._replace(dt=factor * DT) for factor in (1.0, 1.0013, 1.02)]
    check(arm, 'joint1', passages)
    found = TorsionFits(joint, passages).fit([stiffness(joint)])
    assert len(np.unique(found.rows.stretch)) == 13 and np.isfinite(found.scaled).all()


def test_a_disc_off_its_axis_is_no_wrong_sign(arm):
    part = good(0.0)
    against = -0.9 * part.link_angle
    readings = part.readings.copy()
    readings[:, 0, 0] = RATIO * (part.link_angle + against / STIFFNESS)
    check(arm, 'joint1', [part._replace(reference=against, readings=readings)])


@pytest.mark.parametrize('spoil, message', [
    (lambda part: part._replace(motor_rate=np.abs(part.motor_rate)),
     'joint1 turns one way only, forwards: '),
    (lambda part: part._replace(usable=part.usable & (np.arange(3000) < 1000)),
     r'joint1: the recordings are too short: 4\.0 s can be used, at least 10 s are needed'),
    (lambda part: part._replace(motor_rate=0.0 * part.motor_rate),
     'joint1 stands still: its motor travels 0 turns'),
    (lambda part: part._replace(reference=0.0 * part.reference),
     r'joint1 bears one load only: its torque stays between 0 and 0 N\*m; add a recording'),
    (lambda part: counted_otherwise(part, 1.01),
     'its motor turns 10[01].* times per turn of the link where the arm file says 100: the ratio'),
    (lambda part: counted_otherwise(part, -1.0), 'the sign of one encoder is wrong'),
    (lambda part: part._replace(command=-part.command),
     'joint1: its gear twists against its motor .* the motor torques have the wrong sign'),
    (lambda part: part._replace(reference=-part.reference),
     r'joint1: the torque falls where the torsion grows \(correlation -')])
def test_what_cannot_calibrate_is_refused_in_one_line(
        spoil: Callable[[Passage], Passage], message: str, arm: Arm):
    with pytest.raises(CalibrationError, match=message) as caught:
        check(arm, 'joint1', [spoil(good())])
    assert '\n' not in str(caught.value)


def test_joints_that_can_be_calibrated_without_one_are_named(arm):
    hanging = good()._replace(reference=0.0 * good().reference)
    with pytest.raises(CalibrationError, match='joint1 bears one load only') as caught:
        calibrate_ordinary(arm, {'joint1': [hanging], 'joint2': [good()]}, {})
    assert str(caught.value).endswith('; or calibrate the others: --joint joint2')
    with pytest.raises(CalibrationError) as caught:
        calibrate_ordinary(arm, {'joint1': [hanging], 'joint2': [hanging]}, {})
    assert '--joint' not in str(caught.value)


def test_recordings_that_contradict_each_other_are_refused():
    torque = np.linspace(-5.0, 5.0, 200)
    first = ('first', 0.01 * np.sin(torque), torque)
    check_of_one_piece('joint1', [first, ('second', 0.02 * torque, torque)])
    check_of_one_piece('joint1', [first, ('light', 0.3 * torque / 10.0, torque / 10.0)])
    with pytest.raises(CalibrationError, match='second asks for 30 % less torque than first'):
        check_of_one_piece('joint1', [first, ('second', 0.3 * torque, torque)])


def test_a_sensor_that_contradicts_known_loads_is_refused():
    known = 3.0 * np.sin(np.linspace(0.0, 20.0, 500))
    check_alike('joint1', 'bag', 1.05 * known + 2.0, known)
    check_alike('joint1', 'bag', 0.1 * known, 0.05 * known)
    with pytest.raises(CalibrationError, match='joint1 in bag: the references contradict each '
                       r'other: its sensor shows 1\.30 times the torque of the known loads'):
        check_alike('joint1', 'bag', np.where(known > 2.9, np.nan, 1.3 * known), known)


def test_the_scale_of_the_torque_is_named():
    alone = CalibrationRecording('bag', {}, StatedConditions(), frozenset(), False, False)
    assert scale_of([alone], 'joint1').startswith('no independent torque: the inertia of the ')
    assert scale_of([alone, alone._replace(pushed=True)], 'joint1') == (
        'the known force on the tip in bag')
    assert scale_of([alone._replace(sensed=frozenset({'joint1'}))], 'joint1') == (
        'the reference sensor of joint1')
    heavy = alone._replace(stated=StatedConditions((0.5, 0.0), 2.0))
    assert scale_of([heavy], 'joint2') == 'a tilt of 28.6479 degrees and a payload of 2 kg of bag'


def test_statements_go_to_the_bag_that_they_name(arm):
    bags = [Path('a/one'), Path('a/two')]
    found = stated(bags, [('two', '30', '90')], [('a/one', '2.5')])
    assert found[0] == StatedConditions(payload=2.5)
    assert found[1].tilt == pytest.approx((math.radians(30.0), math.radians(90.0)))
    assert found[1].on(arm).base.tilt == pytest.approx(math.radians(30.0))


@pytest.mark.parametrize('tilts, payloads, message', [
    ([('nowhere', '20', '0')], [], "--tilt names 'nowhere', which must be one of the bags: bag"),
    ([('bag', 'steep', '0')], [], r"--tilt must be a number in \[0, 90\], got 'steep'"),
    ([('bag', '100', '0')], [], r"--tilt must be a number in \[0, 90\], got '100'"),
    ([], [('bag', '-1')], r"--payload must be a number in \[0, 100\], got '-1'"),
    ([], [('bag', 'nan')], r"--payload must be a number in \[0, 100\], got 'nan'")])
def test_what_cannot_be_meant_is_refused(tilts, payloads, message):
    with pytest.raises(CalibrationError, match=message):
        stated([Path('bag')], tilts, payloads)


@pytest.mark.parametrize('order', [0.01, 0.02, 0.03, 1.0, 2.0, 3.0, 4.0, 2.02])
def test_a_wave_of_any_order_reaches_the_arm_file(order, arm):
    joint = one_joint(arm, 'joint1')
    term, = waves(joint, (order,))
    found = term.at(np.array([3e-5, 4e-5]))
    numbers = found.numbers()
    amplitude, = (value for name, value in numbers.items() if 'amplitude' in name)
    phase, = (value for name, value in numbers.items() if 'phase' in name)
    assert amplitude == pytest.approx(5e-5) and phase == pytest.approx(math.atan2(4.0, 3.0))
    of_disc = {name.partition('.')[0] for name in numbers} == {'link_encoder_eccentricity'}
    assert of_disc == (order < 0.025)
    assert any(order == pytest.approx(known) for known in candidates(RATIO))
    assert found.on(joint) != joint
