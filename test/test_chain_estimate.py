"""External torques and the wrench on the tip of a chain, against Pinocchio and against truth."""

from dataclasses import replace

from hda_arm_sim.foundation import chain
from hda_arm_sim.foundation.chain import Chain
from hda_arm_sim.foundation.chain_doubts import own_doubts
from hda_arm_sim.model.arm import Arm
from hda_arm_sim.model.effects import Payload
from hda_arm_sim.model.files import read_arm
from hda_arm_sim.model.link_side import loaded_inertia
from hda_arm_sim.motions import motion_of
from hda_msgs_json.messages import EstimatorState, from_json
from hda_torque_estimator.estimating.estimate_messages import estimate_samples, EstimateEncoder
from hda_torque_estimator.estimating.estimates import Estimates
from hda_torque_estimator.estimating.estimator import Estimator, EstimatorSettings
from hda_torque_estimator.estimating.laws import layout
from hda_torque_estimator.estimating.laws.contact import contact_level
from hda_torque_estimator.estimating.laws.tip_wrench import tip_wrench
from hda_torque_estimator.estimating.state_messages import state_samples
from hda_torque_estimator.simulating.closed_loop import ClosedLoopRun, run
from hypothesis import example, given, settings, strategies as st
import numpy as np
import pytest
from scipy.stats import chi2

COBOT = read_arm('cobot7.yaml')
DT, SETTLED = 1e-3, 1000        # [s], samples until the observer has followed the start
PUSH = np.array([10.0, -6.0, 8.0, 0.5, -0.3, 0.4])      # on the tip, base frame [N, N*m]
ANGLES = st.lists(st.floats(-2.0, 2.0), min_size=7, max_size=7)
LIKELY = np.array([1000.0, 1000.0, 1000.0, 300.0, 300.0, 300.0])    # wrenches [N, N*m]


def moved(push: np.ndarray, seconds: float = 4.0) -> ClosedLoopRun:
    """Return a run in which a wrench acts on the tip in its second half."""
    path = motion_of(COBOT, 'sine', seconds, DT, 3)
    force = np.zeros((len(path.time), 6))
    force[len(force) // 2:] = push
    return run(COBOT, COBOT, path._replace(force=force), 3, estimator=None)


def estimated(made: ClosedLoopRun, arm: Arm = COBOT) -> Estimates:
    """Return the estimates of a run."""
    stamps = np.round(made.time * 1e9).astype(np.int64) + 1
    return Estimator(arm).run(stamps, made.reading, made.command)


@pytest.fixture(scope='module')
def pushed() -> ClosedLoopRun:
    """Return a run with a push and a twist."""
    return moved(PUSH)


@pytest.fixture(scope='module')
def found(pushed: ClosedLoopRun) -> Estimates:
    """Return what is estimated of it."""
    return estimated(pushed)


def test_the_wrench_on_the_tip_is_found(pushed, found):
    felt = slice(len(found.stamps) // 2 + 300, None)
    error = (found.base_wrench - PUSH)[felt]
    assert np.sqrt((error[:, :3] ** 2).mean()) < 1.0
    assert np.sqrt((error[:, 3:] ** 2).mean()) < 0.2
    deviation = np.sqrt(found.tip[felt, layout.WRENCH_COVARIANCE::7])
    assert (np.abs(error) < 3.0 * deviation).mean() > 0.95


def test_free_motion_needs_no_environment(found):
    free = slice(SETTLED, len(found.stamps) // 2)
    torque = found.joints[free, :, layout.EXTERNAL_TORQUE]
    deviation = found.joints[free, :, layout.EXTERNAL_DEVIATION]
    assert (np.abs(torque) < 3.0 * deviation).mean() > 0.95
    assert found.tip[free, layout.CONTACT_DEVIATIONS].max() < contact_level(4.0, 7)


def test_a_tool_sees_the_same_wrench_turned(found):
    last = len(found.stamps) - 1
    base, tool = found.base_wrench[last], found.tool_wrench[last]
    for part in (slice(0, 3), slice(3, 6)):
        assert np.linalg.norm(base[part]) == pytest.approx(np.linalg.norm(tool[part]), rel=1e-9)
    assert not np.allclose(base, tool)


def test_node_and_command_write_the_same_wrenches(found):
    row = len(found.stamps) - 1
    topics = estimate_samples(COBOT, found)
    weighed = {topic.name: samples for topic, samples in topics.items()}['tip/wrench']
    np.testing.assert_array_equal(
        np.column_stack([weighed.force, weighed.torque])[row], found.base_wrench[row])
    assert len(EstimateEncoder(COBOT)(1, found.joints[row], found.tip[row])) == len(topics)


def test_the_state_names_the_joint_beyond_which_the_push_is(found):
    state = from_json(EstimatorState, state_samples(COBOT, found).texts[-1])
    assert state.contact != 'free' and state.contact_beyond in COBOT.labels
    assert len(state.tip_force) == 3 and len(state.tip_force_covariance) == 9
    np.testing.assert_allclose(state.tip_force, found.base_wrench[-1, :3], atol=0.5)


def placed(angles: np.ndarray) -> Chain:
    """Return the chain of the arm at angles (n,)."""
    links = loaded_inertia(COBOT.record().body)
    assert isinstance(links, Chain)
    links.table[1:-1, chain.ANGLE] = angles
    chain.place(links.table)
    return links


@settings(deadline=None, max_examples=30)
@example([2.0, 0.0, 0.0, 0.0, 0.125, 0.0, 0.0], [0.0, 0.0, 0.0, 21.0, -25.0, 0.0])
@given(ANGLES, st.lists(st.floats(-30.0, 30.0), min_size=6, max_size=6))
def test_torques_of_a_wrench_determine_the_wrench(angles, wrench):
    """
    Virtual work: tau = J^T F; what the pose hides is reported as unknown, never wrongly.

    With P what is likely, an estimate of covariance S is off by S P^-1 F. As S < P, that is less
    than its own deviation times the root of F^T P^-1 F.
    """
    links, jacobian = placed(np.array(angles)), np.empty((6, 7))
    chain.tip_jacobian(links.table, jacobian)
    tip = np.empty(layout.CHAIN_TIP_RESULTS)
    tip_wrench(links.table, jacobian.T @ wrench, np.eye(7) / 0.05 ** 2, tip)
    weighed = tip[layout.BASE_WRENCH:layout.BASE_WRENCH + 6]
    known = np.isfinite(weighed)
    assert known.all() == (tip[layout.SINGULAR] == 0.0)
    deviation = np.sqrt(tip[layout.WRENCH_COVARIANCE::7])
    share = np.linalg.norm(wrench / LIKELY)
    assert (np.abs(weighed - wrench)[known] < share * deviation[known] + 1e-6).all()


def test_a_stretched_arm_hides_a_part_of_the_wrench():
    tip = np.empty(layout.CHAIN_TIP_RESULTS)
    tip_wrench(placed(np.zeros(7)).table, np.zeros(7), np.eye(7) / 0.1 ** 2, tip)
    assert tip[layout.SINGULAR] == 1.0 and 0.0 < tip[layout.CONDITIONING] < 1.0
    assert np.isnan(tip[layout.BASE_WRENCH:layout.BASE_WRENCH + 6]).any()


@pytest.mark.parametrize('joints', [1, 2, 6, 7, 12])
def test_free_motion_exceeds_the_level_as_rarely_with_any_number_of_joints(joints):
    level = contact_level(4.0, joints)
    if joints <= 2:
        assert level == 4.0
    else:
        assert chi2.sf(level ** 2, joints) == pytest.approx(chi2.sf(16.0, 2))


def test_what_links_need_alone_is_all_that_they_need():
    """One link that carries all makes the sum of products the product of the sums."""
    links = placed(np.linspace(-0.5, 0.7, 7))
    c, found = links.table, np.empty((7, 7))
    c[1:-1, chain.SPEED], c[1:-1, chain.SPEEDING] = 0.3, -0.8
    for row in range(1, 8):
        if row != 7:
            c[row, chain.MASS:chain.INERTIA + 6] = 0.0
    chain.place(c)
    own_doubts(c, np.outer(np.ones(7), (1.0, 0.0, 0.0)), found)
    chain.inverse_dynamics(c)
    needs = c[1:-1, chain.TORQUE]
    np.testing.assert_allclose(found, np.outer(needs, needs), rtol=1e-9, atol=1e-12)


def test_a_base_turned_about_gravity_changes_no_torque(pushed):
    """Frame invariance: about its own vertical an arm feels the same."""
    tilted = replace(COBOT, base=replace(COBOT.base, direction=1.1))
    part = replace(pushed, **{name: value[:1500] for name, value in vars(pushed).items()
                              if isinstance(value, np.ndarray)})
    np.testing.assert_allclose(estimated(part, tilted).external_torque,
                               estimated(part).external_torque, atol=1e-9)


@pytest.mark.parametrize('mass', [0.0, 0.8])
@pytest.mark.parametrize('motion', ['standstill', 'sine'])
def test_a_mass_at_the_tip_is_weighed(mass, motion):
    """Held still as in motion, and as surely as it is stated."""
    true = COBOT.with_effect(Payload(mass=mass))
    made = run(true, COBOT, motion_of(COBOT, motion, 6.0, DT, 3), 3, estimator=None)
    weighed, deviation = estimated(made).tip[4000:, [layout.MASS, layout.MASS_DEVIATION]].T
    assert (np.abs(weighed - mass) < 3.0 * deviation).all()
    assert (deviation > 0.01).all() and (deviation < 0.4).all()


def test_a_body_at_the_tip_is_a_point_where_its_centre_is():
    """Its mass, moment and inertia are those of a body about its centre, seen from the link."""
    off = np.array([0.05, -0.02, 0.1])
    body = COBOT.with_effect(Payload(mass=2.0, x=off[0], y=off[1], z=off[2], radius=0.04))
    point = COBOT.with_effect(Payload(mass=2.0))
    tables = [loaded_inertia(arm.record().body).table for arm in (body, point, COBOT)]
    added, plain = (table[7, chain.MASS:chain.CONSTANTS] - tables[2][7, chain.MASS:chain.CONSTANTS]
                    for table in tables[:2])
    turn = tables[2][8, chain.ROTATION:chain.ROTATION + 9].reshape(3, 3)
    centre = tables[2][8, chain.OFFSET:chain.OFFSET + 3] + turn @ off
    assert added[0] == plain[0] == pytest.approx(2.0)
    np.testing.assert_allclose(added[1:4], 2.0 * centre, atol=1e-12)
    whole = 2.0 * ((centre @ centre + 0.04 ** 2) * np.eye(3) - np.outer(centre, centre))
    np.testing.assert_allclose(added[4:], whole[[0, 1, 2, 0, 0, 1], [0, 1, 2, 1, 2, 2]],
                               atol=1e-12)


def test_settings_of_two_joints_hold_for_seven():
    assert Estimator(COBOT, EstimatorSettings(contact_deviations=5.0)).settings == (
        EstimatorSettings(contact_deviations=5.0))
