"""The simulator, against other integrators and against what motion may and may not do."""

from dataclasses import replace

from hda_arm_sim.drive import act
from hda_arm_sim.model.arm import Arm, ArmError
from hda_arm_sim.model.effects import (AsymmetricFriction, Backlash, BaseVibration, CableSpring,
                                       CommandDelay, CoulombFriction, CurrentLoopLag,
                                       ExternalContact, KinematicError, LinkBearingFriction,
                                       LoadDependentFriction, PreslidingFriction,
                                       TorqueSaturation, TorsionalHysteresis)
from hda_arm_sim.model.effects.transmission import LoadedKinematicError
from hda_arm_sim.model.energy import energy
from hda_arm_sim.model.kernel import (BASE_OFFSET, CURRENT, LINK_ANGLE, LINK_VELOCITY,
                                      MOTOR_ANGLE, MOTOR_VELOCITY, registers, STATE)
from hda_arm_sim.model.link_side import loaded_inertia
from hda_arm_sim.model.parts import Base, Joint, Links
from hda_arm_sim.model.torsion import TorsionLaw
from hda_arm_sim.plant import Plant
from hda_arm_sim.simulate import InputHistory, rest, rollout
from hypothesis import example, given, settings, strategies as st
import numpy as np
import pytest
from reference_values import reference

LINKS = Links(length2=0.15, p2=0.25, p3=0.18, first=2.925, second=1.2)
DT = 1e-3
DRY = 0.037                     # dry friction at the shaft [N*m]


def arm_with(dry: float = 0.0, damping: float = 8.0, drag: float = 5.96e-5) -> Arm:
    """Return the arm of the reference trajectories, or one with friction."""
    torsion = TorsionLaw(damping=damping)
    return Arm(tuple(Joint(label=f'joint{j}', torsion=torsion, viscous_friction=drag,
                           dry_friction=dry) for j in (1, 2)), LINKS)


def inputs(samples: int, size: float = 0.06) -> tuple[np.ndarray, np.ndarray]:
    """Return smooth motor torques (k, 2) and tip forces (k, 2)."""
    time = DT * np.arange(samples)
    torque = size * np.stack([np.sin(7.0 * time), np.sin(11.0 * time + 0.4)], axis=1)
    return torque, np.stack([8.0 * np.sin(6.0 * time), -5.0 * np.cos(8.0 * time)], axis=1)


def idle(samples: int) -> tuple[np.ndarray, np.ndarray]:
    """Return no inputs."""
    return np.zeros((samples, 2)), np.zeros((samples, 2))


@pytest.mark.parametrize('name', ['free', 'forced', 'kinematic'])
def test_equals_another_integrator(name):
    seen = np.load(reference(f'{name}.npz'))
    arm = arm_with()
    if name == 'kinematic':
        for joint, size, phase in (('joint1', 1.0e-4, 0.5), ('joint2', 0.6e-4, -1.1)):
            arm = arm.with_effect(KinematicError(amplitude_2=size, phase_2=phase), joint)
    start = rest(arm, seen['link_angle'][0])
    start[:, MOTOR_ANGLE] = seen['motor_angle'][0]
    start[:, MOTOR_VELOCITY] = seen['motor_velocity'][0]
    start[:, LINK_VELOCITY] = seen['link_velocity'][0]
    made = rollout(arm, start, InputHistory(seen['motor_torque'], seen['tip_force']), DT,
                   held=False)
    np.testing.assert_allclose(made.link_angle, seen['link_angle'], rtol=0.0, atol=1e-8)
    np.testing.assert_allclose(made.motor_angle, seen['motor_angle'], rtol=0.0, atol=1e-6)
    np.testing.assert_allclose(made.joint_torque, seen['joint_torque'], rtol=0.0, atol=1e-4)


def order(arm: Arm) -> float:
    """Return the order of convergence between steps of 1/2 and 1/8 ms."""
    torque, force = inputs(1001, 0.09)
    start = rest(arm, (0.3, 0.8))

    def angles(count):
        made = rollout(arm, start, InputHistory(torque, force), DT, step=DT / count, held=False)
        return made.state[:, :, [MOTOR_ANGLE, LINK_ANGLE]]
    fine = angles(40)
    coarse, middle = (np.abs(angles(count) - fine).max() for count in (2, 8))
    return np.log(coarse / middle) / np.log(4.0)


def test_smooth_motion_converges_with_order_four():
    assert order(arm_with()) > 3.8


STICKING = {
    'motors': arm_with(DRY),
    'uneven motors': arm_with(DRY).with_effect(AsymmetricFriction(asymmetry=0.3), 'joint1'),
    'one link': arm_with().with_effect(LinkBearingFriction(level=1.0), 'joint1'),
    'motors and both links': arm_with(DRY).with_effect(
        LinkBearingFriction(level=1.0), 'joint1').with_effect(
        LinkBearingFriction(level=0.6), 'joint2'),
}


@pytest.mark.parametrize('name', STICKING)
def test_sticking_keeps_the_order(name):
    torque, force = inputs(1001, 0.09)
    made = rollout(STICKING[name], rest(arm_with(), (0.3, 0.8)), InputHistory(torque, force), DT)
    column = LINK_VELOCITY if name == 'one link' else MOTOR_VELOCITY
    assert 0.005 < (made.state[:, 0, column] == 0.0).mean() < 0.9
    assert order(STICKING[name]) > 2.5


@pytest.mark.parametrize('share', [0.2, 0.999])
def test_a_motor_below_its_dry_friction_stands_exactly_still(share):
    arm = arm_with(DRY)
    torque, force = idle(2000)
    torque[:] = share * DRY * np.sin(np.arange(2000) * 0.01)[:, None]
    made = rollout(arm, rest(arm, (0.3, -0.8)), InputHistory(torque, force), DT)
    assert (made.motor_velocity == 0.0).all()
    assert (made.motor_angle == made.motor_angle[0]).all()


def test_a_motor_above_its_dry_friction_breaks_away():
    arm = arm_with(DRY)
    torque, force = idle(200)
    torque[:, 0] = 1.01 * DRY
    made = rollout(arm, rest(arm, (0.3, -0.8)), InputHistory(torque, force), DT)
    assert made.motor_velocity[-1, 0] > 0.0
    assert (made.motor_velocity[:, 1] == 0.0).all()


@pytest.mark.parametrize('pushed', [0, 1])
def test_links_below_their_bearing_friction_stand_exactly_still(pushed):
    arm = arm_with(DRY)
    for joint in arm.labels:
        arm = arm.with_effect(LinkBearingFriction(level=1.5), joint)
    torque, force = idle(1500)
    force[:, pushed] = 4.0 * np.sin(np.arange(1500) * 0.01)        # at most 1.2 N*m on a joint
    made = rollout(arm, rest(arm, (0.3, 0.8)), InputHistory(torque, force), DT)
    assert (made.link_velocity == 0.0).all()
    assert (made.joint_torque == 0.0).all()


def test_a_link_that_moves_pulls_the_other_one_loose():
    """A blow on link 2 is reaction on joint 1: no torque acts there but through M12."""
    arm = arm_with(drag=0.0)
    start = rest(arm, (0.3, 0.8))
    start[1, MOTOR_VELOCITY], start[1, LINK_VELOCITY] = 300.0, 3.0
    loose = arm.with_effect(LinkBearingFriction(level=0.5), 'joint1')
    tight = arm.with_effect(LinkBearingFriction(level=50.0), 'joint1')
    made = {name: rollout(one, start, InputHistory(*idle(300)), DT).link_velocity[:, 0]
            for name, one in (('loose', loose), ('tight', tight))}
    assert (made['tight'] == 0.0).all()
    assert np.abs(made['loose']).max() > 1e-3


def test_friction_stops_a_swinging_link_for_good():
    arm = replace(arm_with(DRY), base=Base(tilt=0.0))
    arm = arm.with_effect(LinkBearingFriction(level=2.0), 'joint1')
    arm = arm.with_effect(LinkBearingFriction(level=2.0), 'joint2')
    start = rest(arm, (0.3, 0.8))
    start[:, LINK_VELOCITY] = (1.0, -1.5)
    made = rollout(arm, start, InputHistory(*idle(3000)), DT)
    assert (made.state[-500:, :, [MOTOR_VELOCITY, LINK_VELOCITY]] == 0.0).all()


dissipative = st.builds(
    lambda arm, play, loop, bearing, bristles, uneven: (
        arm.with_effect(Backlash(half_width=play), 'joint1')
        .with_effect(TorsionalHysteresis(level=loop, width=2e-4), 'joint1')
        .with_effect(LinkBearingFriction(level=bearing), 'joint2')
        .with_effect(PreslidingFriction(stiffness=bristles), 'joint2')
        .with_effect(AsymmetricFriction(asymmetry=uneven), 'joint1')
        .with_effect(LoadDependentFriction(coefficient=abs(uneven)), 'joint1')
        .with_effect(CableSpring(stiffness=1.0, rest_angle=0.2), 'joint1')),
    st.builds(arm_with, st.sampled_from([0.0, 0.01, 0.04]), st.floats(0.0, 20.0),
              st.floats(0.0, 1e-4)),
    st.sampled_from([0.0, 1e-4]), st.sampled_from([0.0, 1.0]), st.sampled_from([0.0, 0.7]),
    st.sampled_from([0.0, 5.0]), st.sampled_from([0.0, 0.3]))


def gained(arm, start, step):
    """Return the most energy that an arm left alone gains at once, and its range [J]."""
    states = rollout(arm, start, InputHistory(*idle(120)), DT, step=step).state
    energies = np.array([energy(arm, state) for state in states[::4]])
    return np.diff(energies).max(), np.ptp(energies)


@settings(max_examples=25)
@given(dissipative, st.floats(-3.0, 3.0), st.floats(-3.0, 3.0), st.floats(-50.0, 50.0),
       st.floats(-2.0, 2.0), st.floats(0.0, 0.5))
@example(arm_with(0.0, 0.0, 0.0), 0.0, 0.0, 0.0, 1.0, 0.0)      # which keeps its energy
@example(arm_with(0.0, 0.0, 0.0).with_effect(Backlash(half_width=1e-4), 'joint1'),
         0.0, 0.0, 0.0, 0.25, 0.0)
def test_energy_never_grows_without_inputs(arm, q1, q2, motor_speed, link_speed, tilt):
    """
    What an arm without losses seems to gain is the integrator's, and goes with its step.

    Where play closes within a step, it matters when. So a single halving of the step shows little.
    """
    arm = replace(arm, base=Base(tilt=tilt, direction=0.7))
    start = rest(arm, (q1, q2))
    start[:, MOTOR_VELOCITY], start[:, LINK_VELOCITY] = motor_speed, (link_speed, -link_speed)
    gain, change = gained(arm, start, DT / 8)
    assert gain < 1e-5 * (change + 1e-3) or gained(arm, start, DT / 64)[0] < gain / 16.0


def test_energy_stays_without_friction():
    arm = replace(arm_with(0.0, 0.0, 0.0), base=Base(tilt=0.4, direction=0.7))
    arm = arm.with_effect(KinematicError(amplitude_2=1e-4), 'joint1')
    arm = arm.with_effect(BaseVibration(amplitude=0.02, frequency=12.0, damping=0.0))
    start = rest(arm, (0.3, 0.8))
    start[:, MOTOR_ANGLE] += (0.05, -0.03)
    start[:, LINK_VELOCITY] = (0.5, -0.8)
    states = rollout(arm, start, InputHistory(*idle(300)), DT, step=DT / 32).state
    energies = np.array([energy(arm, state) for state in states[::10]])
    kinetic = 0.5 * 1.289e-4 * (states[:, :, MOTOR_VELOCITY] ** 2).sum(axis=1)
    assert np.ptp(energies) < 1e-5 * np.ptp(kinetic)    # what went to and fro meanwhile


def test_energy_stays_where_an_error_grows_with_torque():
    arm = arm_with(0.0, 0.0, 0.0).with_effect(
        LoadedKinematicError(amplitude=8e-6, phase=0.4), 'joint1')
    start = rest(arm, (0.3, 0.8))
    start[:, MOTOR_ANGLE] += (0.1, -0.03)
    start[:, MOTOR_VELOCITY], start[:, LINK_VELOCITY] = (60.0, -20.0), (0.5, -0.8)
    states = rollout(arm, start, InputHistory(*idle(300)), DT, step=DT / 32).state[::10]
    unaware = arm.without('loaded_kinematic_error', 'joint1')
    energies, others = ([energy(known, state) for state in states] for known in (arm, unaware))
    assert np.ptp(energies) < 1e-5 * np.ptp(others)


def test_a_base_mode_rings_at_its_frequency_with_the_joints_locked():
    arm = arm_with(5.0)
    for joint in arm.labels:
        arm = arm.with_effect(LinkBearingFriction(level=50.0), joint)
    arm = arm.with_effect(BaseVibration(amplitude=0.02, frequency=12.0, damping=0.05))
    start = rest(arm, (0.3, 0.8))
    start[0, BASE_OFFSET] = 1e-3
    time = DT * np.arange(400)
    offset = rollout(arm, start, InputHistory(*idle(400)), DT).state[:, 0, BASE_OFFSET]
    pace = 2.0 * np.pi * 12.0
    swing = pace * np.sqrt(1.0 - 0.05 ** 2)
    expected = 1e-3 * np.exp(-0.05 * pace * time) * (
        np.cos(swing * time) + 0.05 * pace / swing * np.sin(swing * time))
    np.testing.assert_allclose(offset, expected, atol=1e-8)


def delivered(arm: Arm, commands: np.ndarray, count: int = 3) -> np.ndarray:
    """Return the current loop's torque of joint 1 at every sample, for commands (k,)."""
    w, record = registers(rest(arm, (0.3, 0.8))), arm.record()
    inertia, force, seen = loaded_inertia(record.body), np.zeros(2), []
    for command in commands:
        act(record, inertia, w, np.array([command, 0.0]), force, DT, count)
        seen.append(w[0, STATE + CURRENT])
    return np.array(seen)


def test_a_lag_is_exact_however_fast_it_is():
    for time_constant in (1e-5, 1e-4, 3e-3):
        arm = arm_with(1.0).with_effect(CurrentLoopLag(time_constant=time_constant), 'joint1')
        expected = 0.05 * -np.expm1(-DT * np.arange(1, 6) / time_constant)
        np.testing.assert_allclose(delivered(arm, np.full(5, 0.05)), expected, rtol=1e-9)


def test_a_delay_of_whole_samples_shifts_commands():
    torque, force = inputs(400)
    plain, late = arm_with(DRY), arm_with(DRY).with_effect(CommandDelay(delay=3 * DT), 'joint1')
    late = late.with_effect(CommandDelay(delay=3 * DT), 'joint2')
    shifted = np.concatenate([np.zeros((3, 2)), torque[:-3]])
    start = rest(plain, (0.3, 0.8))
    np.testing.assert_allclose(rollout(late, start, InputHistory(torque, force), DT).state,
                               rollout(plain, start, InputHistory(shifted, force), DT).state,
                               atol=1e-13)


def test_a_delay_of_part_of_a_sample_switches_within_it():
    """Momentum after a step of torque shows when it came: nothing else acts on the shaft."""
    arm = arm_with(0.0, 0.0, 0.0)
    arm = replace(arm, joints=tuple(replace(joint, torsion=TorsionLaw(
        1.0, 0.0, np.inf, 0.0, damping=0.0)) for joint in arm.joints))
    torque, force = idle(11)
    torque[:, 0] = 0.05
    for delay in (0.0, 0.37e-3, 1e-3, 2.618e-3):
        late = arm.with_effect(CommandDelay(delay=delay), 'joint1')
        made = rollout(late, rest(late, (0.3, 0.8)), InputHistory(torque, force), DT)
        speed = made.motor_velocity[-1, 0]
        assert speed == pytest.approx(0.05 * (10 * DT - delay) / 1.289e-4, rel=1e-4)


def test_smooth_inputs_come_late_too():
    torque, force = inputs(600)
    plain = arm_with()
    late = plain.with_effect(CommandDelay(delay=2.5e-3), 'joint1')
    start = rest(plain, (0.3, 0.8))
    smooth, held = (rollout(late, start, InputHistory(torque, force), DT, held=way).link_angle
                    - rollout(plain, start, InputHistory(torque, force), DT, held=way).link_angle
                    for way in (False, True))
    np.testing.assert_allclose(smooth, held, atol=0.02 * np.abs(held).max())
    assert np.abs(held).max() > 1e-4


def test_torque_is_clipped_in_the_drive():
    arm = arm_with(1.0).with_effect(TorqueSaturation(limit=0.02), 'joint1')
    np.testing.assert_allclose(delivered(arm, np.array([0.01, 0.05, -0.05])), [0.01, 0.02, -0.02],
                               rtol=1e-12)


@pytest.mark.parametrize('softness', [0.5, 1.0])
def test_a_limit_that_levels_off_gives_less_at_every_torque_and_never_more(softness):
    arm = arm_with(1.0).with_effect(TorqueSaturation(limit=0.02, softness=softness), 'joint1')
    asked = np.linspace(-0.1, 0.1, 21)
    given = delivered(arm, asked)
    np.testing.assert_allclose(given, -given[::-1], atol=1e-12)
    most = np.minimum(np.abs(asked), 0.02)
    assert (np.abs(given) <= most + 1e-12).all() and (np.abs(given) >= 0.7 * most).all()
    assert given[-1] == pytest.approx(0.02, rel=1e-3)


def test_time_is_that_of_the_recording():
    arm = arm_with().with_effect(ExternalContact(force=20.0, onset=0.1, duration=0.2))
    torque, force = idle(400)
    start = rest(arm, (0.3, 0.8))
    whole = rollout(arm, start, InputHistory(torque, force), DT)
    rest_of_it = rollout(arm, whole.state[150], InputHistory(torque[150:], force[150:]), DT,
                         start=150 * DT)
    np.testing.assert_allclose(rest_of_it.state, whole.state[150:], atol=1e-9)
    np.testing.assert_allclose(rest_of_it.time, whole.time[150:])


@pytest.mark.parametrize('angle', [0.0, 1.0])
def test_one_joint_swings_at_the_frequency_of_its_spring(angle):
    law = TorsionLaw(1e4, 0.0, np.inf, 0.0, damping=0.0)
    arm = Arm((Joint(label='joint1', torsion=law),), Links(p1=0.876))
    start = rest(arm, (angle,))
    start[0, MOTOR_ANGLE] += 1e-2
    made = rollout(arm, start, InputHistory(np.zeros((2001, 1)), np.zeros((2001, 2))), DT)
    pace = np.sqrt(1e4 / 0.876 + 1e4 / (1.289e-4 * 1e4))
    share = 0.876 / (0.876 + 1.289)
    expected = 1e-4 * (1.0 - share * (1.0 - np.cos(pace * made.time)))
    torsion = made.motor_angle[:, 0] / 100.0 - made.link_angle[:, 0]
    np.testing.assert_allclose(torsion, 1e-4 * np.cos(pace * made.time), atol=1e-8)
    assert (made.motor_angle[:, 0] / 100.0 - angle).max() <= expected.max() + 1e-8


def test_one_joint_takes_every_effect_of_the_links():
    arm = Arm((Joint(label='joint1', dry_friction=DRY),), Links(p1=0.876, first=2.0))
    arm = arm.with_effect(LinkBearingFriction(level=0.5), 'joint1')
    arm = arm.with_effect(BaseVibration(amplitude=0.02))
    arm = arm.with_effect(ExternalContact(force=20.0, direction=1.6))
    made = rollout(arm, rest(arm, (0.0,)),
                   InputHistory(np.full((500, 1), 0.05), np.zeros((500, 2))), DT)
    assert np.isfinite(made.state).all()
    assert made.link_angle[-1, 0] > 0.0


def test_a_plant_repeats_itself_to_the_bit_and_obeys_its_seed():
    arm = arm_with(DRY)
    arm = replace(arm, joints=tuple(replace(joint, link_encoder=replace(
        joint.link_encoder, noise=1e-5)) for joint in arm.joints))

    def readings(seed):
        plant = Plant(arm, rest(arm, (0.3, 0.8)), DT, seed)
        seen = []
        for k in range(100):
            seen.append(plant.sample().copy())
            plant.advance(np.array([0.05, -0.05]) * np.sin(0.1 * k), np.zeros(2))
        return np.array(seen)
    np.testing.assert_array_equal(readings(1), readings(1))
    assert (readings(1)[:, :, 1] != readings(2)[:, :, 1]).any()
    np.testing.assert_array_equal(readings(1)[:, :, 0], readings(2)[:, :, 0])


def test_plant_and_rollout_are_the_same_arm():
    arm = arm_with(DRY).with_effect(CommandDelay(delay=1.3e-3), 'joint2')
    torque, force = inputs(300)
    start = rest(arm, (0.3, 0.8))
    plant, states = Plant(arm, start, DT, 0), []
    for k in range(300):
        plant.sample()
        states.append(plant.state)
        plant.advance(torque[k], force[k])
    np.testing.assert_array_equal(states,
                                  rollout(arm, start, InputHistory(torque, force), DT).state)


@pytest.mark.parametrize(('arm', 'torque', 'sentence'), [
    (replace(arm_with(), links=None), np.zeros((5, 2)), 'an arm without links'),
    (arm_with(), np.zeros((5, 3)), r'inputs must have shapes \(k, 2\)'),
    (arm_with().with_effect(CommandDelay(delay=0.02), 'joint1'), np.zeros((5, 2)),
     'command_delay of joint1 must be at most 64 samples'),
])
def test_what_cannot_be_simulated_is_said_in_a_sentence(arm, torque, sentence):
    dt = 1e-4 if 'command' in sentence else DT
    with pytest.raises(ArmError, match=sentence):
        rollout(arm, rest(arm_with(), (0.3, 0.8)), InputHistory(torque, np.zeros((5, 2))), dt)


def test_coulomb_effect_is_the_joints_dry_friction():
    torque, force = inputs(300)
    start = rest(arm_with(), (0.3, 0.8))
    listed = arm_with().with_effect(CoulombFriction(level=DRY), 'joint1')
    listed = listed.with_effect(CoulombFriction(level=DRY), 'joint2')
    np.testing.assert_array_equal(rollout(listed, start, InputHistory(torque, force), DT).state,
                                  rollout(arm_with(DRY), start, InputHistory(torque, force),
                                          DT).state)
