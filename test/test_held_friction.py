"""A joint that always comes to rest alike tells its zero before it moves; others do not."""

from dataclasses import replace

from hda_arm_sim.model.arm import Arm
from hda_arm_sim.model.files import arm_from_text, read_arm
from hda_arm_sim.model.parts import Encoder
from hda_arm_sim.model.writing import arm_to_text
from hda_torque_estimator.calibrate.fitting.held_friction import HELD_SHARE
from hda_torque_estimator.calibrate.fitting.witness_fit import motor_of
from hda_torque_estimator.calibrate.passages.joint_recording import Measured
from hda_torque_estimator.calibrate.referenced import calibrate
from hda_torque_estimator.estimating.estimator import Estimator
from hda_torque_estimator.estimating.laws.fusion_memory import carried, carry, LASTS, MEMORY
from hda_torque_estimator.samples.readings import READINGS
import numpy as np
import pytest

DT, SECONDS, RESTS = 0.01, 3.0, 2.0
RATIO, STIFFNESS, INERTIA, DRY, LOAD = 100.0, 2e4, 1e-4, 0.04, 20.0
ZERO = 3e-4                     # by which the zero moves from recording to recording [rad]
ALIKE, ANYHOW = 0.9, None       # share of its friction that holds a shaft at rest, None for any
Array = np.ndarray


def joint(**known: float) -> Arm:
    """Return a joint with one stiffness."""
    whole = read_arm('hda_arm.yaml')
    law = replace(whole.joints[0].torsion, flexspline_stiffness=STIFFNESS,
                  flexspline_curvature=0.0, wave_generator_stiffness=np.inf,
                  wave_generator_curvature=0.0, damping=0.0)
    one = replace(whole.joints[0], torsion=law, ratio=RATIO, motor_inertia=INERTIA,
                  viscous_friction=0.0, effort_lag=0.0, motor_encoder=Encoder(),
                  link_encoder=Encoder(), **known)
    return replace(whole, joints=(one,), links=None, effects=(),
                   tolerances=replace(whole.tolerances, torsion_zero=ZERO, stiffness=0.3))


def resting(seed: int, held: float | None) -> Measured:
    """Return a joint that bears a load at rest and then turns; friction holds a share at rest."""
    random = np.random.default_rng(seed)
    time = DT * np.arange(round(SECONDS / DT))
    rate = 20.0 * np.clip(time - RESTS, 0.0, None) * np.where(time < SECONDS - 0.4, 1.0, 0.8)
    angle = np.cumsum(rate) * DT
    load = LOAD + 4.0 * np.sin(0.4 * angle) + 0.2 * random.standard_normal()
    share = random.uniform(-1.0, 1.0) if held is None else held
    given = (load / RATIO + DRY * np.where(rate > 0.1, 1.0, share)
             + INERTIA * np.gradient(rate, time) + 5e-4 * random.standard_normal(len(time)))
    readings = np.full((len(time), 1, READINGS), np.nan)
    zero = ZERO * random.choice((-1.0, 1.0))
    readings[:, 0, 0] = angle
    readings[:, 0, 1] = (angle / RATIO - load / STIFFNESS + zero
                         + 4e-6 * random.standard_normal(len(time)))
    stamps = 1 + np.round(1e9 * time).astype(np.int64)
    return Measured(f'run{seed}', stamps, readings, given, load, 0.0)


def at_rest(arm: Arm, one: Measured) -> float:
    """Return what the estimator errs by after the first tenth of a second, at rest [N*m rms]."""
    found = Estimator(arm).run(one.stamps, one.readings, one.command[:, np.newaxis])
    rests = (one.time > 0.1) & (one.time < RESTS - 0.1)
    return float(np.sqrt(np.mean((found.torque[:, 0] - one.reference)[rests] ** 2)))


def share_of(recordings: list[Measured]) -> tuple[float, float]:
    """Return the share that is found, 1 for none, and how unsure a motor at rest is [N*m]."""
    fit = motor_of(joint(), recordings, resting=True)
    assert fit is not None
    share = {number.name: number.value for number in fit.numbers}.get(HELD_SHARE, 1.0)
    held = share * RATIO * DRY / np.sqrt(3.0)       # and an offset may be another each time
    return share, float(np.linalg.norm([fit.deviation, held, RATIO * fit.spread]))


def test_rests_that_are_alike_leave_little_of_the_friction_open():
    share, unsure = share_of([resting(seed, ALIKE) for seed in range(6)])
    assert share < 0.2
    assert unsure < 0.2 * RATIO * DRY


def test_rests_that_differ_leave_it_open():
    """Share, deviation or an offset that moves say it: what friction holds is hardly known."""
    assert share_of([resting(seed, ANYHOW) for seed in range(6)])[1] > 0.4 * RATIO * DRY


def test_one_recording_does_not_show_how_others_rest():
    assert share_of([resting(1, ALIKE)])[0] == 1.0


@pytest.mark.parametrize('seed', [20, 21])
def test_a_zero_is_known_at_rest_only_where_friction_is(seed):
    """Else it is hidden by all that friction may hold."""
    known = joint(dry_friction=DRY, motor_deviation=0.3, held_share=0.0)
    one = resting(seed, 0.0)
    assert at_rest(known, one) < 0.5
    assert at_rest(known, one) < 0.5 * at_rest(
        replace(known, joints=(replace(known.joints[0], held_share=1.0),)), one)


def test_an_arm_file_keeps_it():
    arm = joint(held_share=0.25)
    assert arm_from_text(arm_to_text(arm), 'it').joints[0].held_share == 0.25


def test_a_calibration_of_such_rests_knows_the_zero_of_another():
    found = calibrate(joint(), {'joint1': [resting(seed, ALIKE) for seed in range(4)]})
    assert at_rest(found.arm, resting(9, ALIKE)) < 0.25 * ZERO * STIFFNESS


def test_a_zero_that_is_said_to_move_is_the_motor_s_to_give():
    """The zeros of the recordings agree by chance; that of another one is far off."""
    alike = [replace(one, readings=one.readings - np.array([0.0, zero_of(one), 0.0, 0.0]))
             for one in (resting(seed, ALIKE) for seed in range(4))]
    other = resting(9, ALIKE)
    other = replace(other, readings=other.readings + np.array([0.0, 10.0 * ZERO, 0.0, 0.0]))
    usual, moving = (calibrate(joint(), {'joint1': alike}, zero_moves=moves).arm
                     for moves in (False, True))
    assert at_rest(moving, other) < 0.25 * ZERO * STIFFNESS
    known, unknown = (arm.tolerances_of('joint1').torsion_zero for arm in (usual, moving))
    assert unknown > 10.0 * known


def zero_of(one: Measured) -> float:
    """Return the zero of a recording (`resting`) [rad]."""
    motor, link = one.readings[:, 0, 0], one.readings[:, 0, 1]
    return float(np.mean(link - motor / RATIO + one.reference / STIFFNESS))


def test_what_a_zero_makes_up_for_lasts_until_the_shaft_has_turned():
    memory = np.zeros(MEMORY)
    for _ in range(3):
        carry(memory, 0.5)
    assert carried(memory, False, 5.0) == pytest.approx(0.875)
    assert carried(memory, True, LASTS) == pytest.approx(0.875 * np.exp(-1.0))


def test_an_error_that_a_zero_makes_up_for_is_not_doubted_twice():
    """A torsion off by 1 N*m has its zero from a motor: both are as good, and neither leads."""
    known = joint(dry_friction=DRY, motor_deviation=0.3, held_share=0.0)
    known = replace(known, joints=(replace(known.joints[0], torsion=replace(
        known.joints[0].torsion, deviation=1.0)),),
        tolerances=replace(known.tolerances, stiffness=1e-3))
    one = resting(20, 0.0)
    astray = np.where(one.time > 1.0, 1.0 / RATIO, 0.0)         # 1 N*m at the link
    torque = [Estimator(known).run(one.stamps, one.readings, (one.command + more)[
        :, np.newaxis]).torque[:, 0] for more in (0.0, astray)]
    rests = (one.time > 1.3) & (one.time < RESTS - 0.1)
    assert 0.3 < np.mean((torque[1] - torque[0])[rests]) < 0.7
