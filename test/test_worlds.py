"""Worlds come from their seeds alone, differ as they say, and keep the studies apart."""

from dataclasses import replace
from itertools import combinations
from pathlib import Path

from hda_arm_sim.model.torsion import torsion_of_torque
import numpy as np
import pytest
from truth import CATALOGUE, forms, layout, motions, TruthError, worlds
from truth.arms import built, draw_arm, HOME
from truth.links import body
from truth.logs import Log
from truth.torsion import torsion
from world_samples import arm_of, logged

LATE = {'torque_saturation', 'external_contact', 'cable_spring'}    # seen in longer motions
FINAL = worlds.SEEDS                    # the first seed of the final study


def short(effect: str = '', form: str = '', seed: int = FINAL, **given: object) -> worlds.World:
    """Return a short world of two joints in a rich motion, with at most one effect."""
    known: dict[str, object] = {'motion': 'rich', 'rate': 500, 'joints': 2, 'seconds': 2.0}
    return worlds.draw(seed, (effect,) if effect else (), form=form, **(known | given))


def test_every_effect_has_two_forms_that_are_not_the_library_s():
    assert forms.FORMS.keys() == {effect.name for effect in CATALOGUE}
    assert min(map(len, forms.FORMS.values())) >= 2


def test_a_third_of_the_forms_and_a_motion_are_held_out():
    known = [form for group in forms.FORMS.values() for form in group]
    assert 3 * sum(form.held_out for form in known) >= len(known)
    assert motions.HELD_OUT
    assert motions.MOTIONS.keys() > motions.HELD_OUT


def test_the_codes_of_an_effect_s_forms_differ():
    for effect, known in forms.FORMS.items():
        codes = [form.code for form in known]
        assert sorted(codes) == list(range(1, len(codes) + 1)), effect


def test_development_never_draws_what_is_held_out():
    seen, motion = set(), set()
    for effect in forms.FORMS:
        for seed in range(20):
            try:
                world = worlds.draw(seed, (effect,))
            except TruthError:          # this motion or arm cannot have it
                continue
            motion.add(world.motion)
            seen.add((effect, world.hidden[0].form))
    drawn = {(effect, form.name) for effect, known in forms.FORMS.items()
             for form in known if form.held_out}
    assert not seen & drawn
    assert not motion & motions.HELD_OUT
    assert len(seen) > len(forms.FORMS)         # and draws others


@pytest.mark.parametrize('name', sorted(motions.HELD_OUT))
def test_a_held_out_motion_cannot_be_asked_for_in_development(name):
    with pytest.raises(TruthError, match='motions of this study'):
        worlds.draw(3, motion=name)
    assert worlds.draw(FINAL, motion=name).motion == name
    with pytest.raises(TruthError, match='held out'):
        worlds.record(replace(worlds.draw(3), motion=name))


@pytest.mark.parametrize(('effect', 'form'), [
    (effect, form.name) for effect, known in forms.FORMS.items() for form in known
    if form.held_out])
def test_a_held_out_form_cannot_be_recorded_in_development(effect, form):
    world = worlds.draw(3, (effect,), motion='rich', joints=2, form=form, seconds=3.0)
    with pytest.raises(TruthError, match='held out'):
        worlds.record(world)


def test_the_final_study_draws_what_is_held_out():
    drawn = {worlds.draw(FINAL + k, ('stribeck_friction',), motion='rich').hidden[0].form
             for k in range(60)}
    assert {form.name for form in forms.FORMS['stribeck_friction']} | {''} == drawn


def test_studies_have_no_seed_in_common():
    assert not any(worlds.is_final(seed) for seed in (0, 1, worlds.SEEDS - 1))
    assert all(worlds.is_final(seed) for seed in (worlds.SEEDS, 10 * worlds.SEEDS))
    with pytest.raises(TruthError, match='at least 0'):
        worlds.draw(-1)


def test_the_same_seed_is_the_same_world():
    one, other = (worlds.record(short('backlash', seed=5)) for _ in range(2))
    assert all(np.array_equal(a, b, equal_nan=True) for a, b in zip(one, other))
    assert worlds.draw(5).arm != worlds.draw(6).arm


def shows(one: Log, other: Log) -> bool:
    """Return whether two logs differ."""
    return not (np.array_equal(one.stamps, other.stamps)
                and np.array_equal(one.reading, other.reading, equal_nan=True))


@pytest.mark.parametrize('effect', forms.FORMS)
def test_every_form_acts_and_is_no_other(effect):
    """A form changes what the log shows, against the arm without it and against all others."""
    given = {'motion': 'trapezoid', 'seconds': 20.0} if effect in LATE else {}
    worlds_ = [short(effect, form, **given)
               for form in ('', *(one.name for one in forms.FORMS[effect]))]
    logs = [worlds.record(one) for one in (replace(worlds_[0], hidden=()), *worlds_)]
    for log in logs:
        assert np.isfinite(log.command).all()
        if len(log.stamps) == len(logs[0].stamps):      # and the arm still follows its motion
            assert np.abs(log.reading - logs[0].reading)[:, :, 1].max() < 0.3
    assert all(shows(one, other) for one, other in combinations(logs, 2))


@pytest.mark.parametrize('name', motions.MOTIONS)
@pytest.mark.parametrize('joints', [1, 2])
def test_arms_follow_every_motion_within_their_torques(name, joints):
    for seed in range(FINAL, FINAL + 2):
        world = worlds.draw(seed, motion=name, joints=joints, rate=500, seconds=4.0)
        log, axes = worlds.record(world), world.arm.axes
        assert log.command.shape[1] == joints
        limits = np.array([axis.limit for axis in axes])
        assert (np.abs(log.command).max(axis=0) < limits).all()
        assert (np.abs(log.joint_torque).max(axis=0) < [axis.torque for axis in axes]).all()
        assert (np.ptp(log.reading[:, :, 1], axis=0) > 0.05).any() == (name != 'standstill')
        assert (log.command == 0.0).all() == (name == 'hand_guided')
        assert log.external.any() == (name in ('standstill', 'hand_guided'))


def test_a_drawn_arm_can_be_built():
    """Masses are positive, numbers lie in the ranges that are asked for, and the file is valid."""
    for seed in range(60):
        arm = draw_arm(np.random.default_rng(seed), 1 + seed % 2)
        p1, p2, p3 = arm.links
        assert p1 > 0.0 and (len(arm.axes) == 1 or p1 * p2 > (p2 + p3) ** 2)
        for axis in arm.axes:
            assert 50.0 <= axis.ratio <= 160.0 and 2e3 <= axis.stiffness <= 1e5
            assert 1e-5 <= axis.inertia <= 1e-3 and 0.5 <= axis.torque <= 300.0
        assert 2 ** 10 <= arm.counts[0] <= 2 ** 24 and 2 ** 12 <= arm.counts[1] <= 2 ** 24
        assert len(arm_of(replace(worlds.draw(1), arm=arm)).joints) == len(arm.axes)


def test_the_file_states_the_arm_that_moves():
    """The torsion law of the stated arm is the one that acts, and so are inertias and weight."""
    world = worlds.draw(1, joints=2)
    arm, truth = arm_of(world), built(world.arm, 1e-3)
    for joint, stated, axis in zip(truth.joints, arm.record().joints, world.arm.axes):
        torque = np.linspace(-0.9, 0.9, 50) * axis.torque
        assert torsion_of_torque(stated['torsion'], axis.ratio, torque) == pytest.approx(
            torsion(joint, torque), rel=1e-9)
    still = np.zeros(2, layout.JOINT)
    assert body(truth.arm[0:1], still)[:2] == pytest.approx(
        [arm.links.p1 - arm.links.p2, arm.links.p2])
    assert truth.arm['pull'][0] == pytest.approx(arm.base.gravity * np.sin(arm.base.tilt))


@pytest.mark.parametrize('rate', worlds.RATES)
def test_a_log_has_the_rate_that_is_asked_for(rate):
    world = worlds.draw(2, rate=rate, motion='rich', seconds=4.0)
    stamps = logged(world, arm_of(world)).stamps
    assert np.median(np.diff(stamps)) == pytest.approx(1e9 / rate, rel=0.01)
    assert (np.diff(stamps) > 0).all()


def test_stamps_of_a_host_jitter_and_velocities_may_be_missing():
    worlds_ = [worlds.draw(seed) for seed in range(80)]
    assert {bool(world.logger.jitter) for world in worlds_} == {True, False}
    assert {world.logger.velocities for world in worlds_} == {True, False}
    for world in worlds_:
        assert ('clock_jitter' in world.tolerated) == (world.logger.jitter > 0.0)


def test_motions_begin_at_rest_about_home():
    time = 1e-3 * np.arange(8000)
    for name in motions.MOTIONS:
        made = motions.made(name, time, (motions.Limits(2.0, 5.0),), np.random.default_rng(1))
        assert made.angle[0] == pytest.approx(HOME)
        assert np.abs(made.rate[0]).max() < 0.02
        assert np.abs(made.rate).max() <= 2.0 * 1.15
        assert (made.angle[:, 1] == HOME[1]).all()


def test_the_table_of_forms_is_that_of_the_source():
    table = (Path(__file__).parent / 'truth' / 'README.md').read_text().partition('## Worlds')[2]
    for effect, known in forms.FORMS.items():
        listed = ', '.join(f'*{one.name}*' if one.held_out else one.name for one in known)
        assert f'| `{effect}` | {listed} |' in table
    listed = ', '.join(f'*{name}*' if name in motions.HELD_OUT else name
                       for name in motions.MOTIONS)
    assert f'Motions: {listed}.' in table
