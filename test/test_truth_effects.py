"""What the truth hides shows in its recordings, as its table says, and nothing else does."""

from dataclasses import replace
from functools import cache
from pathlib import Path
import re

from hda_arm_sim.foundation.arrays import Array
import numpy as np
import pytest
from truth import (
    CATALOGUE, Device, draw, EFFECTS, Hidden, layout, OUTSIDE, record, recording, Reference,
    TruthError, TruthRecord)
from truth.encoders import mount
from truth_cases import DT, EXACT, exact, hide, motion, recorded, SECONDS, times

TABLES = Path(__file__).parent / 'truth' / 'README.md'
LISTED = Path(__file__).parents[2] / 'shared' / 'design' / 'catalogue.md'
MOTOR_STEP, LINK_STEP = 2.0 * np.pi / 16384, 2.0 * np.pi / 4e6
ONLY_READ = {                   # what the link encoder shows and the arm does not do
    'bearing_crosstalk', 'clock_jitter', 'clock_skew', 'encoder_drift',
    'encoder_interpolation_error', 'encoder_scale_error', 'link_encoder_eccentricity'}
NAMES = pytest.mark.parametrize('name', EFFECTS)


@cache
def healthy() -> TruthRecord:
    """Return the recording in which nothing is hidden."""
    return recorded()


@cache
def hiding(name: str) -> TruthRecord:
    """Return the recording in which this effect is hidden."""
    return recorded([drawn(name)])


def drawn(name: str, seed: int = 0) -> Hidden:
    """Draw an effect; what happens at some time happens within these recordings."""
    hidden = draw(name, np.random.default_rng(seed))
    if 'onset' in hidden.parameters:
        hidden.parameters.update(onset=1.0)
    return hidden


def without_size(hidden: Hidden) -> Hidden:
    """Return the effect with all sizes neutral and its shape as it is."""
    sizes = {parameter.name: parameter.neutral
             for parameter in EFFECTS[hidden.effect].parameters if parameter.is_size}
    return replace(hidden, parameters=hidden.parameters | sizes)


def same(one: TruthRecord, other: TruthRecord) -> bool:
    """Return whether two recordings agree in every bit."""
    return all(np.array_equal(a, b) for a, b in zip(one, other))


def torsion(seen: TruthRecord) -> Array:
    """Return the torsion as a driver sees it (k, 2) [rad]."""
    return seen.motor_angle / 100.0 - seen.link_angle


@NAMES
def test_every_effect_changes_the_recording_and_none_does_without_its_size(name):
    assert not same(hiding(name), healthy())
    assert same(recorded([without_size(drawn(name))]), healthy())


@pytest.mark.parametrize('name', sorted(
    EFFECTS.keys() - {'coarse_quantisation', 'dropped_samples'}))
def test_what_is_only_read_moves_nothing_and_the_rest_moves_the_arm(name):
    assert np.array_equal(hiding(name).states, healthy().states) == (name in ONLY_READ)
    assert np.array_equal(hiding(name).motor_angle, healthy().motor_angle) == (name in ONLY_READ)


@NAMES
def test_the_arm_follows_its_motion_whatever_is_hidden(name):
    seen, (wanted, _) = hiding(name), motion(SECONDS)
    row = np.rint(times(seen) / DT).astype(int)
    assert np.abs(seen.states[:, :, 2] - wanted[row]).max() < 0.1


@NAMES
def test_draws_vary_and_stay_what_they_are(name):
    some = [draw(name, np.random.default_rng(seed)) for seed in range(40)]
    assert some[0] == draw(name, np.random.default_rng(0))
    for hidden in some:
        assert layout.checked(hidden) is EFFECTS[name]
    assert {hidden.joint for hidden in some} == set(EFFECTS[name].joints or [None])
    if name != 'inertial_coupling':
        for parameter in EFFECTS[name].parameters:
            assert len({hidden.parameters[parameter.name] for hidden in some}) > 1


def test_the_same_seed_gives_the_same_bits_and_another_does_not():
    two = [drawn('payload'), drawn('kinematic_error')]
    assert same(recorded(two, 1.0), recorded(two, 1.0))
    for pair in zip(recorded(two, 1.0)[:4], recorded(two, 1.0, seed=4)[:4]):
        assert not np.array_equal(*pair)


def test_effects_add_up():
    one, other = hide('encoder_drift', rate=1e-5), hide('clock_skew', skew=2e-4)
    alone = [exact(hidden).link_angle - exact().link_angle for hidden in (one, other)]
    assert exact(one, other).link_angle - exact().link_angle == pytest.approx(sum(alone),
                                                                              abs=1e-9)


def test_steps_and_zeros_are_those_of_encoders():
    seen = healthy()
    for reading, step in ((seen.motor_angle, MOTOR_STEP), (seen.link_angle, LINK_STEP)):
        counts = reading / step
        assert counts == pytest.approx(np.rint(counts), abs=1e-4)
    assert np.abs(seen.motor_angle - seen.states[:, :, 0]).max() < 4 * MOTOR_STEP
    assert np.abs(seen.link_angle - seen.states[:, :, 2]).max() < 3e-5


@pytest.mark.parametrize('every', [10_000, 11])
def test_command_answers_the_new_reading_before_it(monkeypatch, every):
    def mishaps(rng, samples, lead, arm):
        fate = np.zeros(samples, np.int64)
        fate[lead + every::every] = np.arange(len(fate[lead + every::every])) % 2 + 1
        return fate, np.zeros(samples)

    monkeypatch.setattr(recording, '_mishaps', mishaps)
    seen, wanted, speed, answer = exact(), motion(2.0), np.zeros(2), np.zeros(2)
    row = np.rint(times(seen) / DT).astype(int)
    last = 0
    for k in range(1, len(row)):
        if k > 60 and np.array_equal(seen.motor_angle[k], seen.motor_angle[k - 1]):
            assert np.array_equal(seen.link_angle[k], seen.link_angle[k - 1])
            assert np.array_equal(seen.command[k], seen.command[k - 1])
            continue
        if k > 150:             # the filter has forgotten what was before the recording
            assert seen.command[k] == pytest.approx(answer, abs=1e-6)
        elapsed = DT * (row[k] - row[last])
        moved = seen.motor_angle[k] - seen.motor_angle[last]
        speed += (moved - elapsed * speed) / (0.002 + elapsed)
        answer = np.clip(0.3 * (100.0 * wanted[0][row[k]] - seen.motor_angle[k])
                         + 0.012 * (100.0 * wanted[1][row[k]] - speed), -0.3, 0.3)
        last = k
    assert len(row) < 2000 or every > 2000


def test_every_encoder_has_its_own_zero_within_a_step():
    zeros = []
    for seed in range(200):
        joints = layout.nominal_joints()
        mount(joints, (1000, 2000), np.random.default_rng(seed))
        zeros.append([*joints['motor_zero'] * 1000, *joints['link_zero'] * 2000])
    turns = np.array(zeros) / (2.0 * np.pi)
    assert turns.min() >= 0.0 and turns.max() < 1.0
    assert turns.mean(axis=0) == pytest.approx(0.5, abs=0.08)
    assert np.abs(np.corrcoef(turns.T) - np.eye(4)).max() < 0.25


def test_healthy_numbers_lie_within_their_tolerances():
    ratios = []
    for seed in range(300):
        joints, arm = layout.nominal_joints(), layout.nominal_arm()
        layout.scatter(joints, arm, np.random.default_rng(seed))
        ratios.append([*(joints[name] / layout.JOINT_NUMBERS[name] for name in (
            'stiffness', 'gain', 'dry', 'viscous', 'damping')), np.repeat(arm['p1'] / 0.876, 2)])
    spread = np.array(ratios) - 1.0
    sigmas = np.array([0.01, 0.005, 0.03, 0.10, 0.10, 0.01])
    assert (np.abs(spread).max(axis=(0, 2)) <= 2.5 * sigmas).all()
    assert spread.std(axis=(0, 2)) == pytest.approx(sigmas, rel=0.15)


def test_link_readings_err_as_the_table_says():
    true = exact()
    q, t = true.states[:, :, 2], times(true)
    assert true.link_angle == pytest.approx(q, abs=1e-9)
    for hidden, error in (
            (hide('encoder_scale_error', relative_error=3e-4), 3e-4 * q[:, 0]),
            (hide('encoder_drift', rate=5e-6), 5e-6 * t),
            (hide('link_encoder_eccentricity', amplitude_1=2e-4, phase_1=0.5, amplitude_2=5e-5,
                  phase_2=-1.0),
             2e-4 * np.sin(q[:, 0] + 0.5) + 5e-5 * np.sin(2.0 * q[:, 0] - 1.0)),
            (hide('encoder_interpolation_error', amplitude=1e-5, lines=3600.0, phase=1.0),
             1e-5 * np.sin(3600.0 * q[:, 0] + 1.0)),
            (hide('bearing_crosstalk', coefficient=1e-5),
             -1e-5 * 9.81 * (2.925 + 1.2 * np.cos(q[:, 1]))),
            (hide('clock_skew', skew=2.3e-4), 2.3e-4 * true.states[:, 0, 3]),
            (hide('clock_skew', skew=-1.1e-4), -1.1e-4 * true.states[:, 0, 3])):
        seen = exact(hidden)
        assert seen.link_angle[:, 0] - q[:, 0] == pytest.approx(error, abs=4e-7), hidden
        assert np.array_equal(seen.link_angle[:, 1], true.link_angle[:, 1]), hidden


def test_motor_readings_err_as_the_table_says():
    seen = exact(hide('motor_encoder_eccentricity', amplitude=0.01, phase=0.3))
    theta = seen.states[:, 0, 0]
    assert seen.motor_angle[:, 0] - theta == pytest.approx(0.01 * np.sin(theta + 0.3), abs=1e-8)


@pytest.mark.parametrize(('side', 'step'), [(0.0, 4e-5), (1.0, 2.0 * np.pi / 2000)])
def test_coarse_steps_are_seen_on_their_side_only(side, step):
    seen = recorded([hide('coarse_quantisation', motor_side=side, step=step)])
    coarse, fine = ((seen.motor_angle, seen.link_angle) if side
                    else (seen.link_angle, seen.motor_angle))
    counts = coarse[:, 0] / step
    assert counts == pytest.approx(np.rint(counts), abs=1e-6)
    moves = np.abs(np.diff(fine[:, 0]))
    assert moves[moves > 1e-9].min() == pytest.approx(LINK_STEP if side else MOTOR_STEP, rel=1e-3)


def test_samples_are_lost_repeated_and_late():
    seen = recorded([hide('dropped_samples', None, rate=0.06)], 6.0)
    gaps = np.diff(seen.stamps) * 1e-6
    lost = np.rint(gaps).sum() + 1 - len(seen.stamps)
    repeated = ((np.diff(seen.motor_angle, axis=0) == 0.0)
                & (np.diff(seen.link_angle, axis=0) == 0.0)).all(axis=1)
    moving = np.abs(seen.states[1:, :, 3]).max(axis=1) > 0.1
    early = np.diff(seen.states[:, 0, 0]) * 1e3 / gaps / np.where(
        np.abs(seen.states[1:, 0, 1]) > 20.0, seen.states[1:, 0, 1], np.inf)
    assert 80 < lost < 160 and 60 < (repeated & moving).sum() < 160 and (early > 1.25).sum() > 40
    assert gaps.min() > 0.9 and not np.isnan(seen.link_angle).any()
    untouched = recorded(seconds=6.0)
    assert np.rint(np.diff(untouched.stamps) * 1e-6).max() == 1.0


def test_a_contact_is_a_force_for_a_time():
    hidden = hide('external_contact', None, force=20.0, direction=0.6, onset=0.8, duration=0.5)
    seen = exact(hidden)
    t, q = times(seen), seen.states[:, :, 2]
    assert (seen.external[(t < 0.8) | (t > 1.3)] == 0.0).all()
    a1, a2 = q[:, 0], q.sum(axis=1)
    fx, fy = 20.0 * np.cos(0.6), 20.0 * np.sin(0.6)
    second = 0.15 * (fy * np.cos(a2) - fx * np.sin(a2))
    first = second + 0.15 * (fy * np.cos(a1) - fx * np.sin(a1))
    middle = (t > 0.9) & (t < 1.2)
    assert seen.external[middle] == pytest.approx(np.stack([first, second], axis=1)[middle])


def test_a_tip_force_pushes_as_it_would_by_hand():
    angle, rate = motion(2.0)
    force = np.tile([5.0, -3.0], (len(angle), 1))
    seen = record([], Reference(angle, rate, DT, force), seed=1)
    second = 0.15 * (-3.0 * np.cos(seen.states[:, :, 2].sum(axis=1))
                     - 5.0 * np.sin(seen.states[:, :, 2].sum(axis=1)))
    assert seen.external[:, 1] == pytest.approx(second)


def test_decoupled_axes_do_not_feel_each_other():
    angle, rate = motion(2.0)
    angle[:, 0], rate[:, 0] = angle[0, 0], 0.0
    for hidden, coupled in (([], True), ([hide('inertial_coupling', None, share=1.0)], False)):
        seen = record(hidden, Reference(angle, rate, DT), seed=1,
                      device=Device(scatter=False, counts=EXACT), noise=0.0)
        assert (np.abs(seen.joint_torque[:, 0]).max() > 0.1) == coupled


@pytest.mark.parametrize(('hidden', 'says'), [
    (Hidden('stiction', 'joint1', {}, 'motor', 'time'), 'no effect is named'),
    (hide('payload', 'joint1', mass=1.0), 'belongs to the arm'),
    (hide('backlash', 'joint3'), 'belongs to joint1 or joint2'),
    (hide('bearing_crosstalk', 'joint2'), 'belongs to joint1'),
    (Hidden('backlash', 'joint1', {'width': 1.0}, 'torsion', 'torque'), 'half_width, got width')])
def test_what_cannot_be_hidden_is_refused(hidden, says):
    with pytest.raises(TruthError, match=says):
        recorded([hidden], 1.0)


def test_one_effect_is_hidden_once_per_joint():
    both = [hide('backlash', half_width=1e-4), hide('backlash', 'joint2', half_width=1e-4)]
    assert len(recorded(both, 1.0).stamps) == 1000
    with pytest.raises(TruthError, match='twice'):
        recorded([*both, both[0]], 1.0)


def test_a_motion_that_cannot_be_followed_is_refused():
    angle, rate = motion(1.0)
    with pytest.raises(TruthError, match=r'two arrays \(k, 2\)'):
        record([], Reference(angle[:, :1], rate[:, :1], DT), seed=0)
    with pytest.raises(TruthError, match='a tip force has the shape of the motion'):
        record([], Reference(angle, rate, DT, angle[:-1]), seed=0)
    with pytest.raises(TruthError, match='dt must lie'):
        record([], Reference(angle, rate, 1.0), seed=0)
    with pytest.raises(TruthError, match='valid names: coulomb_friction'):
        draw('stiction', np.random.default_rng(0))


@NAMES
def test_the_table_lists_every_effect_with_its_parameters(name):
    rows = TABLES.read_text().splitlines()
    first = next(i for i, row in enumerate(rows) if row.startswith(f'| `{name}` |'))
    last = next(i for i in range(first + 1, len(rows)) if not rows[i].startswith('| |'))
    listed = set(re.findall(r'`(\w+)`', ' '.join(rows[first:last]))) - {name}
    assert listed == {parameter.name for parameter in EFFECTS[name].parameters}


def test_names_scopes_and_sites_of_the_catalogue_stay():
    if not LISTED.exists():
        pytest.skip('catalogue.md is not at ../shared/design')
    rows = re.findall(r'^\| `(\w+)`.*?\| (joint|arm) \| (\w+) \|', LISTED.read_text(), re.M)
    assert {(effect.name, 'joint' if effect.joints else 'arm', effect.site)
            for effect in CATALOGUE} >= set(rows)


def test_four_and_more_effects_are_in_no_catalogue_at_any_site():
    assert len(OUTSIDE) >= 4 and len(EFFECTS) == len(CATALOGUE) + len(OUTSIDE)
    assert {effect.site for effect in OUTSIDE} == {'motor', 'torsion', 'link'}
