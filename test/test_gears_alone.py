"""Gears are judged alone where links are led, or have no model: motor against torsion."""

from dataclasses import replace
import json
from pathlib import Path

from hda_arm_sim.model.chain_links import ChainLinks
from hda_arm_sim.model.files import read_arm
from hda_arm_sim.model.typical_sizes import typical
from hda_arm_sim.motions import motion
from hda_torque_estimator.cli import main
from hda_torque_estimator.diagnosis.balances.balance import Balancer
from hda_torque_estimator.diagnosis.balances.coordinates import torques_of
from hda_torque_estimator.diagnosis.balances.led import is_led
from hda_torque_estimator.diagnosis.balances.stand_in import with_stand_in
from hda_torque_estimator.diagnosis.diagnose import diagnose
from hda_torque_estimator.measurements.measurement import Measurement
from hda_torque_estimator.simulating.closed_loop import run
import numpy as np
import pytest
from truth import worlds
from world_fits import diagnosed
from world_samples import as_read

LAB = read_arm('hda_arm.yaml')
BARE = replace(LAB, links=None)
MAP = """
time: {column: Timestamp, unit: s}
joints: [joint3]
each:
  ratio: 101
  motor:
    position: {column: encoder_motorinc_3, unit: count, counts_per_turn: 16777216, zero: first}
    effort: {column: joint_torque_current_3, side: link}
  link:
    position: {column: encoder_loadinc_3, unit: count, counts_per_turn: 16777216, zero: first}
"""
LARA8 = Path(__file__).parents[2] / 'shared' / 'data' / 'neura_lara8' / 'sweep_joint3.csv.gz'


def recorded(true, seconds=30.0, seed=11):
    """Return a recording of the laboratory's arm, as it is in truth."""
    made = run(true, LAB, motion('rich', 2, seconds, 1e-3, seed), seed, estimator=None)
    return Measurement(LAB.labels, 1e-3, np.ascontiguousarray(made.reading[:, :, :2]),
                       made.command)


def test_balances_of_gears_do_not_depend_on_links():
    measurement = replace(recorded(LAB, 5.0), led=True)
    stand_in = with_stand_in(BARE)
    own, other = Balancer(measurement)(LAB), Balancer(measurement)(stand_in)
    assert isinstance(stand_in.links, ChainLinks) and with_stand_in(LAB) is LAB
    both = own.valid[:, :2] & other.valid[:, :2]
    assert both.any() and not own.valid[:, 2:].any() and not other.valid[:, 2:].any()
    np.testing.assert_allclose(own.residual[:, :2][both], other.residual[:, :2][both], atol=1e-9)


def test_a_hand_turns_shafts_even_where_coarse_encoders_show_no_torque():
    world = worlds.draw(740258, ())
    arm, measurement = as_read(world)
    assert world.motion == 'hand_guided' and is_led(measurement, arm)
    friction = arm.record().joints['coulomb_friction']['level']
    assert not is_led(replace(measurement, command=measurement.command + 0.2 * friction), arm)


def test_noise_of_a_coarse_encoder_on_a_stiff_gear_leads_nothing():
    """It makes 36 N*m of a torsion that carries 2: torque that motors do not give."""
    world = worlds.draw(997301, (), motion='rich', rate=1000, seconds=10.0, joints=2)
    arm, measurement = as_read(world)
    reading = measurement.reading
    through = torques_of(arm, reading[:, :, 0], reading[:, :, 1])[:, 0]
    given = arm.joints[0].ratio * measurement.command[:, 0]
    assert np.std(given) < 0.05 * np.std(through)
    assert not is_led(measurement, arm)


@pytest.mark.parametrize('effect, joint', [
    (None, None), ('payload', None), ('kinematic_error', 'joint1'),
    pytest.param('coulomb_friction', 'joint2', marks=pytest.mark.study),
    pytest.param('stiffness_error', 'joint1', marks=pytest.mark.study)])
def test_gears_without_a_model_of_links_are_diagnosed(effect, joint):
    true = LAB if effect is None else LAB.with_effect(typical(LAB, effect, joint), joint)
    said = diagnose(recorded(true), BARE)
    named = [(cause.effect, cause.joint) for cause in said.diagnosis.findings]
    seen = effect if joint else None                # a payload is no matter of a gear
    assert named == ([(seen, joint)] if seen else [])
    assert said.diagnosis.verdict == ('explained' if seen else 'no_discrepancy')
    assert said.extended.links is None
    assert any('nothing is said of the links' in remark for remark in said.diagnosis.remarks)


def test_a_motor_that_works_leads_its_link():
    measurement = recorded(LAB, 5.0)
    assert not is_led(measurement, LAB)
    assert is_led(replace(measurement, command=np.zeros_like(measurement.command)), LAB)


@pytest.mark.parametrize('seed, rate', [
    (7000, 500), pytest.param(7001, 2000, marks=pytest.mark.study)])
def test_a_healthy_arm_that_a_hand_leads_is_not_accused(seed, rate):
    """The hand's force is no fault of the arm; it was named play, tilt or inertia."""
    world = worlds.draw(seed, (), motion='hand_guided', rate=rate, joints=2, seconds=30.0)
    said = diagnosed(world)
    late = ['clock_jitter'] if world.logger.jitter > 0.0 else []
    assert [one.effect for one in said.findings] == late and not said.ambiguous
    assert said.verdict == ('explained' if late else 'no_discrepancy')
    assert any('led by a hand' in remark for remark in said.remarks)


@pytest.mark.skipif(not LARA8.exists(), reason='the recordings of the LARA8 are kept apart')
def test_a_joint_of_a_real_arm_is_judged_without_its_links(tmp_path, monkeypatch, capsys):
    """Under one load a disc is like any torsion, and late stamps are late, not lost samples."""
    monkeypatch.chdir(tmp_path)
    Path('map.yaml').write_text(MAP)
    assert main(['import', str(LARA8), '--map', 'map.yaml', '--out', 'sweep']) == 0
    assert main(['new', '--gear', 'CSG-32-100', '--ratio', '101', '--joints', 'joint3',
                 '--motor-inertia', '4e-4', '--motor-torque', '2', '--motor-counts', '16777216',
                 '--link-counts', '16777216', '--out', 'arm.yaml']) == 0
    capsys.readouterr()
    assert main(['diagnose', 'sweep', '--arm', 'arm.yaml', '--out', 'report', '--json']) == 0
    said = json.loads(capsys.readouterr().out)
    assert [one['effect'] for one in said['findings']] == ['clock_jitter']
    assert said['ambiguous'] == []
    assert said['verdict'] == 'unknown' and said['unexplained']['joint'] == 'joint3'
