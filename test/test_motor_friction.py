"""Friction of motors alone: each cause is found by its name, and none where the arm has it."""

from dataclasses import replace
import json
from pathlib import Path

from hda_arm_sim.model.effects import CoulombFriction, ViscousFriction
from hda_arm_sim.model.files import read_arm
from hda_msgs_json.bag import BagWriter
from hda_msgs_json.samples import JointSamples
from hda_msgs_json.topics import JOINT_STATES
from hda_torque_estimator.cli import main
from hda_torque_estimator.diagnosis.motors_alone.motor_record import sweeps_of, sweeps_together
from hda_torque_estimator.diagnosis.motors_alone.motor_side import diagnose_motors
from hda_torque_estimator.diagnosis.motors_alone.posterior import (Law, PossibleCause, posterior,
                                                                   Weigher)
from hda_torque_estimator.diagnosis.reporting.summary import cause_sentence
import numpy as np
import pytest

ARM = read_arm('kinova_gen3.yaml')
BAM = Path(__file__).parents[2] / 'shared' / 'data' / 'bam_xl330'
RATIO, LEVEL, SLOPE, RATE = 100.0, 0.05, 4e-4, 500.0


def swung(more, seed=1, noise=2e-3, seconds=40.0):
    """Return a motor that swings at many speeds under a weight, with `more` against it [N*m]."""
    time = np.arange(round(seconds * RATE)) / RATE
    angle = 150.0 * np.sin(0.5 * time) + 30.0 * np.sin(2.1 * time + 1.0) + 4.0 * np.sin(7.0 * time)
    speed = 75.0 * np.cos(0.5 * time) + 63.0 * np.cos(2.1 * time + 1.0) + 28.0 * np.cos(7.0 * time)
    rate = (-37.5 * np.sin(0.5 * time) - 132.3 * np.sin(2.1 * time + 1.0)
            - 196.0 * np.sin(7.0 * time))
    link = angle / RATIO
    weight = 0.4 * np.sin(link) + 0.1 * np.cos(link)
    load = weight + 1e-4 * rate
    torque = (load + 1.289e-4 * rate + LEVEL * np.sign(speed) + SLOPE * speed
              + more(time, speed, link, load))
    torque += noise * np.random.default_rng(seed).standard_normal(len(time))
    return recorded(time, angle, torque)


def recorded(time, angle, torque):
    """Return joint states of one motor."""
    return JointSamples(1 + np.rint(1e9 * time).astype(np.int64), ('joint1_motor',),
                        angle[:, None], np.full((len(time), 1), np.nan), torque[:, None])


MORE = {
    'stribeck_friction': lambda t, v, q, load: 0.03 * np.sign(v) * np.exp(-(v / 9.0) ** 2),
    'nonlinear_viscous_friction': lambda t, v, q, load: 3e-6 * v * np.abs(v),
    'load_dependent_friction': lambda t, v, q, load: 0.15 * np.abs(load) * np.sign(v),
    'position_dependent_friction': (
        lambda t, v, q, load: 0.4 * LEVEL * np.sin(2.0 * q + 0.5) * np.sign(v)),
    'thermal_viscosity': lambda t, v, q, load: 4e-4 * np.exp(-t / 15.0) * v,
}


def named(samples, arm=ARM):
    """Return what is said of a recording, and the names that are named."""
    found = diagnose_motors(sweeps_of(samples, arm, 'bag'), arm)
    return found, {cause.effect for cause in found.diagnosis.findings}


@pytest.mark.parametrize('effect', MORE)
def test_each_friction_is_named_beside_the_usual(effect):
    found, names = named(swung(MORE[effect]))
    usual = {'coulomb_friction', 'viscous_friction'}
    assert {'coulomb_friction', effect} <= names <= {*usual, effect}
    assert found.diagnosis.verdict in ('explained', 'ambiguous')
    one = next(cause for cause in found.diagnosis.findings if cause.effect == effect)
    assert one.probability >= 0.95 and one.gain.removed > one.gain.placebo
    assert found.extended.effect(effect, 'joint1') != ARM.effect(effect, 'joint1')


def test_sizes_hold_the_truth():
    found, _ = named(swung(MORE['load_dependent_friction']))
    findings = {cause.effect: cause.parameters for cause in found.diagnosis.findings}
    share = findings['load_dependent_friction']['coefficient']
    assert share.low <= 0.15 <= share.high and share.high - share.low < 0.03
    assert findings['coulomb_friction']['level'].value == pytest.approx(LEVEL, rel=0.05)


SHAPED = {
    'square': (lambda t, v, q, load: 0.6 * load ** 2 * np.sign(v), 'growth'),
    'exponential': (lambda t, v, q, load: 0.3 * np.abs(load) * np.exp(-np.abs(v) / 60.0)
                    * np.sign(v), 'fall'),
    'rational': (lambda t, v, q, load: 0.3 * np.abs(load) / (1.0 + 0.02 * np.abs(v))
                 * np.sign(v), 'fall'),
}


@pytest.mark.parametrize('truth', SHAPED)
def test_friction_by_load_has_the_law_that_it_follows(truth):
    more, number = SHAPED[truth]
    found, names = named(swung(more))
    assert names == {'coulomb_friction', 'viscous_friction', 'load_dependent_friction'}
    law = found.extended.effect('load_dependent_friction', 'joint1')
    assert {each for each in ('growth', 'fall') if getattr(law, each) > 0.0} == {number}
    one = next(each for each in found.diagnosis.findings if each.effect == law.name)
    said = cause_sentence(one.effect, one.joint, one.parameters)
    assert ('grows with torque by' in said, 'falls with speed by' in said) == (
        number == 'growth', number == 'fall')


def test_a_usual_law_keeps_its_odds_whatever_others_there_are():
    law = Law(np.ones((4, 1)), np.array([1.0]), np.zeros((4, 0)))
    alone = PossibleCause('cause', (law,), 0.1)
    beside = PossibleCause('cause', (law._replace(weight=2.0), law, law), 0.1)
    assert beside.odds(0) == alone.odds(0) and beside.usual() == [beside.laws[0]]
    assert sum(np.exp(beside.odds(place)) for place in (1, 2)) == pytest.approx(
        np.exp(alone.odds(0)))


def test_a_motor_of_any_size_has_its_friction_named():
    """The torque of a small servo is a thousandth of an arm's; so is what its load adds."""
    samples = swung(MORE['load_dependent_friction'])
    found, names = named(replace(samples, effort=1e-3 * samples.effort))
    assert {'coulomb_friction', 'load_dependent_friction'} <= names
    law = found.extended.effect('load_dependent_friction', 'joint1')
    assert law.coefficient == pytest.approx(0.15, abs=0.02) and law.growth == law.fall == 0.0


def test_a_wave_of_friction_has_its_size_and_phase():
    found, _ = named(swung(MORE['position_dependent_friction']))
    wave, = (cause.parameters for cause in found.diagnosis.findings
             if cause.effect == 'position_dependent_friction')
    assert wave['order'].value == 2.0 and wave['order'].chosen
    assert wave['amplitude'].value == pytest.approx(0.4, rel=0.1)
    assert wave['phase'].value == pytest.approx(0.5, abs=0.1)


@pytest.mark.parametrize('seed', [
    0, *(pytest.param(seed, marks=pytest.mark.study) for seed in (1, 2))])
def test_friction_that_the_file_states_is_no_discrepancy(seed):
    arm = ARM.with_effect(CoulombFriction(1.1 * LEVEL), 'joint1').with_effect(
        ViscousFriction(0.9 * SLOPE), 'joint1')
    found, names = named(swung(lambda *signals: 0.0, seed=seed), arm)
    assert not names and not found.diagnosis.ambiguous
    assert found.diagnosis.verdict == 'no_discrepancy'


def test_what_is_stated_and_what_is_more_add_up():
    arm = ARM.with_effect(CoulombFriction(0.5 * LEVEL), 'joint1').with_effect(
        ViscousFriction(SLOPE), 'joint1')
    found, names = named(swung(lambda *signals: 0.0), arm)
    assert names == {'coulomb_friction'}
    assert found.extended.effect('coulomb_friction', 'joint1').level == pytest.approx(
        LEVEL, rel=0.05)


def test_what_no_friction_explains_is_unknown_and_says_what_it_follows():
    found, names = named(swung(lambda t, v, q, load: 0.02 * np.sin(3.0 * q + 1.0)))
    assert found.diagnosis.verdict == 'unknown'
    assert found.diagnosis.unexplained.depends_on == 'link_angle'
    assert names <= {'coulomb_friction', 'viscous_friction'}


def test_twins_share_the_probability():
    random = np.random.default_rng(0)
    column, noise = random.standard_normal((2, 400))
    law = Law(column[:, None], np.array([1.0]), np.zeros((400, 0)))
    sets = posterior(Weigher(column + noise, np.ones((400, 1)), np.array([np.inf]), [
        PossibleCause('one', (law,), 0.1), PossibleCause('other', (law,), 0.1)], 1.0))
    assert sets.of('one') == pytest.approx(0.5, abs=0.1) == sets.of('other')
    assert sets.either('one', 'other') == pytest.approx(1.0, abs=1e-6)


def test_probabilities_of_causes_hold():
    """Of what is named with a probability p, a share p is there: drawn from the priors."""
    random, said = np.random.default_rng(3), []
    for _ in range(400):
        columns = random.standard_normal((60, 3))
        there = random.random(3) < 0.3
        residual = columns @ (there * 0.4 * random.standard_normal(3)) + random.standard_normal(60)
        causes = [PossibleCause(str(place), (Law(columns[:, [place]], np.array([0.4]),
                                                 np.zeros((60, 0))),), 0.3) for place in range(3)]
        found = posterior(Weigher(residual, np.zeros((60, 0)), np.zeros(0), causes, 1.0))
        said += [(found.of(str(place)), there[place]) for place in range(3)]
    chance, true = (np.array(column, dtype=float) for column in zip(*said))
    for low, high in ((0.0, 0.25), (0.25, 0.5), (0.5, 0.75), (0.75, 1.01)):
        inside = (chance >= low) & (chance < high)
        spread = np.sqrt(max(float(np.mean(chance[inside] * (1 - chance[inside]))), 1e-3)
                         / inside.sum())
        assert abs(float(np.mean(chance[inside] - true[inside]))) < 3.5 * spread


def bam(path):
    """Return a log of the bench as joint states, torque by its voltage [any unit at the shaft]."""
    log = np.genfromtxt(path, delimiter=',', names=True)
    duty = np.where(log['load'] > 32767, log['load'] - 65536.0, log['load']) / 885.0
    torque = np.where(log['torque_enable'] > 0, 0.1 * duty * log['input_volts'], 0.0)
    return recorded(log['time'] - log['time'][0], 288.35 * log['position'], torque / 288.35)


def test_a_bench_whose_friction_is_known_shows_that_it_grows_with_load():
    logs = sorted(BAM.glob('*.csv.gz'))
    if not logs:
        pytest.skip('the public recordings are not here')
    arm = replace(ARM, joints=(replace(ARM.joints[0], ratio=288.35, motor_inertia=1e-7),))
    together = sweeps_together({log.name: bam(log) for log in logs}, arm)
    names = {cause.effect for cause in diagnose_motors(together, arm).diagnosis.findings}
    assert 'load_dependent_friction' in names
    assert names <= {'load_dependent_friction', 'viscous_friction', 'coulomb_friction',
                     'stribeck_friction'}


@pytest.mark.parametrize('slower, said', [(1.015, False), (2.0, True)])
def test_motors_recorded_at_other_rates_are_said_to_be(slower, said, tmp_path, capsys):
    """Within 2 % recordings belong together; beyond it the page says how they were taken."""
    bags = []
    for name, seed, every in (('first', 1, 1.0), ('second', 2, slower)):
        samples = swung(lambda *signals: 0.0, seed=seed, seconds=20.0)
        rows = slice(None, None, 2) if every == 2.0 else slice(None)
        stamps = np.rint(samples.stamps * (1.0 if every == 2.0 else every)).astype(np.int64)
        with BagWriter(tmp_path / name, {}) as bag:
            bag.write_joint_states(JOINT_STATES, JointSamples(
                stamps[rows], samples.names, samples.position[rows], samples.velocity[rows],
                samples.effort[rows]))
        bags.append(str(tmp_path / name))
    words = ['diagnose', *bags, '--arm', 'kinova_gen3.yaml', '--out', str(tmp_path / 'found')]
    assert main([*words, '--json']) == 0
    remarks = ' '.join(json.loads(capsys.readouterr().out)['remarks'])
    assert ('have other rates: ' in remarks) == said
    assert ('500 Hz' in remarks and '250 Hz. All are taken as the slowest' in remarks) == said


def test_a_host_that_reads_faster_than_the_drive_answers_is_diagnosed():
    """Most rows repeat the one before: the median step of the angle is 0, and its pace is not."""
    samples = swung(lambda *signals: 0.0, seconds=20.0)
    rows = np.arange(len(samples.stamps)) // 3 * 3
    found, names = named(JointSamples(
        samples.stamps, samples.names, samples.position[rows], samples.velocity[rows],
        samples.effort[rows]))
    assert names <= {'coulomb_friction', 'viscous_friction'} and found.parts
