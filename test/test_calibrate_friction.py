"""Intervals of friction hold what the simulated arm has, over many recordings of it."""

from collections import defaultdict
from collections.abc import Mapping
from dataclasses import replace

from hda_arm_sim.model.arm import Arm
from hda_arm_sim.model.effects import (
    AsymmetricFriction, LoadDependentFriction, StribeckFriction, TorqueConstantError)
from hda_arm_sim.model.files import read_arm
from hda_arm_sim.motions import Motion, motion
from hda_msgs_json.topics import BASE_FRAME, EXTERNAL_WRENCH
from hda_torque_estimator.calibrate.calibration import one_joint
from hda_torque_estimator.calibrate.fitting.arm_numbers import ArmNumber
from hda_torque_estimator.calibrate.fitting.friction import friction
from hda_torque_estimator.calibrate.passages.calibration_recording import heard
from hda_torque_estimator.calibrate.passages.stated_conditions import StatedConditions
from hda_torque_estimator.simulating.closed_loop import run
from hda_torque_estimator.simulating.recorded import joint_samples, on_tip
import numpy as np
import pytest

SECONDS, PULL = 20.0, 25.0
RECORDINGS = 10             # of two joints each
EXPECTED = 0.9
BY_CHANCE = 3.0             # deviations of the share that holds, by the number of draws
PLAIN = {'coulomb_friction.level': 0.037, 'viscous_friction.slope': 5.96e-5}
ALL = {**PLAIN, 'stribeck_friction.excess': 0.02, 'stribeck_friction.speed': 8.0,
       'asymmetric_friction.asymmetry': 0.1, 'load_dependent_friction.coefficient': 0.1}
MORE = (StribeckFriction(excess=0.02, speed=8.0), AsymmetricFriction(asymmetry=0.1),
        LoadDependentFriction(coefficient=0.1))


@pytest.fixture(scope='module')
def nominal() -> Arm:
    """Return the arm that the file describes."""
    return read_arm('hda_arm.yaml')


def drawn(arm: Arm, seed: int) -> Arm:
    """Return an arm whose links and torque constants are off by what their tolerances admit."""
    random, known, links = np.random.default_rng(seed), arm.tolerances, arm.links
    assert links is not None
    p1, p2, p3 = 1.0 + known.link_inertia * random.standard_normal(3)
    arm = replace(arm, links=replace(links, p1=p1 * links.p1, p2=p2 * links.p2, p3=p3 * links.p3))
    for label in arm.labels:
        error = known.torque_constant * random.standard_normal()
        arm = arm.with_effect(TorqueConstantError(error=float(error)), label)
    return arm


def found(true: Arm, nominal: Arm, seed: int, period: float) -> list[ArmNumber]:
    """Return the friction of both joints, found on one recording in which the tip is pulled."""
    asked = motion('rich', 2, SECONDS, period, seed)
    turning = 2.0 * np.pi * asked.time / SECONDS
    force = PULL * np.stack([np.sin(3.0 * turning), np.sin(2.0 * turning + 1.0)], axis=1)
    made = run(true, nominal, Motion(asked.time, asked.angle, asked.rate, force), seed)
    stamps = 10 ** 9 + np.round(made.time * 1e9).astype(np.int64)
    states = joint_samples(nominal, stamps, made.reading, made.command)
    pulled = {EXTERNAL_WRENCH.name: on_tip(stamps, BASE_FRAME, made.force)}
    passages = heard(states, pulled, f'recording {seed}', nominal, StatedConditions()).passages
    return [number for label, passage in passages.items()
            for number in friction(one_joint(nominal, label), [passage])]


def shares(true: Arm, nominal: Arm, period: float, truth: Mapping[str, float]
           ) -> dict[str, tuple[float, float]]:
    """Return of each number how often its interval holds the truth, and its mean error in it."""
    held, error = defaultdict(list), defaultdict(list)
    for seed in range(RECORDINGS):
        for number in found(drawn(true, seed), nominal, seed, period):
            assert number.name in truth, (seed, str(number))
            half = 0.5 * (number.high - number.low)
            held[number.name].append(number.low <= truth[number.name] <= number.high)
            error[number.name].append((number.value - truth[number.name]) / half)
    return {name: (float(np.mean(held[name])), float(np.mean(error[name]))) for name in held}


@pytest.mark.parametrize('more, period, truth', [
    ((), 1e-3, PLAIN), (MORE, 1e-3, ALL)])
def test_intervals_of_friction_hold_the_truth(more, period, truth, nominal):
    true = nominal
    for label in nominal.labels:
        for effect in more:
            true = true.with_effect(effect, label)
    reported = shares(true, nominal, period, truth)
    assert set(reported) == set(truth)
    least = EXPECTED - BY_CHANCE * np.sqrt(EXPECTED * (1.0 - EXPECTED) / (2 * RECORDINGS))
    for name, (share, bias) in reported.items():
        assert share >= least, (name, share)
        assert abs(bias) < 0.5, (name, bias)


def test_intervals_are_no_wider_than_what_is_known(nominal):
    numbers = {number.name: number for number in found(nominal, nominal, 1, 1e-3)}
    level = numbers['coulomb_friction.level']
    assert 0.005 < (level.high - level.low) / level.value < 0.03        # torque constant: 0.5 %
