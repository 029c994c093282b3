"""A push at the tip is felt soon, free motion is not, and a hard push is remembered."""

from functools import cache

from hda_arm_sim.model.files import read_arm
from hda_arm_sim.motions import motion
from hda_torque_estimator.estimating.estimates import Estimates
from hda_torque_estimator.estimating.estimator import Estimator, EstimatorSettings
from hda_torque_estimator.estimating.laws import contact, layout
from hda_torque_estimator.samples.readings import READINGS
import numpy as np
from numpy.typing import NDArray
import pytest
from truth import record, Reference, TruthRecord

ARM = read_arm('hda_arm.yaml')
DT = 1e-3
SOON = 50                       # samples in which a contact must be felt
LASTS = 400                     # samples of a push
REACHED = 0.5                   # |sin(theta2)| from which both components are asked for


def pushes(seconds: float, size: float, seed: int) -> tuple[NDArray[np.float64], list[int]]:
    """Return sudden pushes of `size` [N] every way (k, 2), and the samples at which they begin."""
    random = np.random.default_rng(seed)
    force, begins, now = np.zeros((round(seconds / DT) + 1, 2)), [], 4.0
    while now < seconds - 1.0:
        begin, way = round(now / DT), random.uniform(0.0, 2.0 * np.pi)
        force[begin:begin + LASTS] = size * np.cos(way), size * np.sin(way)
        begins.append(begin)
        now += random.uniform(1.2, 2.0)
    return force, begins


@cache
def moving(path: str, seed: int, size: float = 0.0, seconds: float = 20.0) -> TruthRecord:
    """Return a recording of the independent truth, pushed or free."""
    made = motion(path, 2, seconds, DT, seed)
    return record((), Reference(made.angle, made.rate, DT, pushes(seconds, size, seed)[0]),
                  seed=seed)


def reading(seen: TruthRecord) -> NDArray[np.float64]:
    """Return the readings of a recording, without velocities."""
    unknown = np.full_like(seen.motor_angle, np.nan)
    return np.stack([seen.motor_angle, seen.link_angle, unknown, unknown], axis=2)


def estimates(seen: TruthRecord, settings: EstimatorSettings = EstimatorSettings()) -> Estimates:
    """Return the estimates of a recording with its commands."""
    return Estimator(ARM, settings).run(seen.stamps, reading(seen), seen.command)


@pytest.mark.parametrize('path', ['rich', 'sine', 'turn'])
def test_small_contacts_are_felt_soon_and_end_by_themselves(path):
    seen = moving(path, 3, 5.0)
    level = estimates(seen).tip[:, layout.CONTACT_LEVEL]
    _, begins = pushes(20.0, 5.0, 3)
    reached = [k for k in begins if abs(np.sin(seen.states[k, 1, 2])) > REACHED]
    assert len(reached) > 3
    for begin in reached:
        assert level[begin - 1] == contact.FREE
        assert level[begin + SOON] == contact.CONTACT
        assert level[begin + LASTS + 300] == contact.FREE


@pytest.mark.parametrize('path', ['rich', 'sine', 'turn', 'standstill'])
def test_free_motion_is_no_contact(path):
    found = estimates(moving(path, 8))
    assert (found.tip[:, layout.CONTACT_LEVEL] == contact.FREE).all()
    assert found.tip[:, layout.CONTACT_DEVIATIONS].max() < 4.0


def test_tip_force_while_moving():
    for path, seed in (('rich', 4), ('sine', 5), ('turn', 6)):
        seen = moving(path, seed, 15.0)
        reached = np.abs(np.sin(seen.states[:, 1, 2])) > REACHED
        reached[:3000] = False
        error = (estimates(seen).base_force - pushes(20.0, 15.0, seed)[0])[reached]
        assert (np.sqrt((error ** 2).mean(axis=0)) < 1.5).all()


def test_collision_stays_until_the_reset():
    seen = moving('sine', 3, 30.0)
    made = Estimator(ARM)
    found = made.run(seen.stamps, reading(seen), seen.command)
    _, begins = pushes(20.0, 30.0, 3)
    level = found.tip[:, layout.CONTACT_LEVEL]
    assert (level[begins[0] + SOON:] == contact.COLLISION).all()
    assert made.memory[0, layout.CONTACT + contact.CONTACTS] >= len(begins)
    made.reset()
    made.update(int(seen.stamps[0]), reading(seen)[0], seen.command[0])
    assert made.tip[layout.CONTACT_LEVEL] == contact.FREE
    gentle = estimates(seen, EstimatorSettings(collision_torque=50.0))
    assert gentle.tip[:, layout.CONTACT_LEVEL].max() == contact.CONTACT


def test_without_links_nothing_is_felt():
    arm = read_arm('voraus_yucobot.yaml')
    made = Estimator(arm)
    made.update(5, np.zeros((6, READINGS)))
    assert contact.contact_name(made.tip[layout.CONTACT_LEVEL]) == 'free'
    assert np.isnan(made.tip[layout.CONTACT_DEVIATIONS])
