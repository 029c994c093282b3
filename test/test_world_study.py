"""The study of worlds judges a record as its page says, whatever the diagnosis said of it."""

import pytest
from truth import worlds
from world_cases import cases
import world_judging as judging
from world_tables import binned, calibration_error, page

HIDDEN = [['stribeck_friction', 'joint1', {}, 'motor', 'motor_rate', 'tustin']]


def outcome(**changes: object) -> dict[str, object]:
    """Return the outcome of a record with one cause that is named, but for what is changed."""
    return {'case': '{"seconds": 60.0}', 'group': 'rich, 1 kHz', 'seed': 7, 'motion': 'rich',
            'rate': 1000.0, 'joints': 2, 'tolerated': [], 'hidden': HIDDEN, 'numbers': [{}],
            'powers': None, 'seconds': 5.0, 'verdict': 'explained', 'removed': 0.99,
            'said': [['stribeck_friction', 'joint1', {}, None]], 'alike': [],
            'sizes': [[0.02, 0.001, True]], 'rest': None, 'baseline': None} | changes


def test_a_cause_at_its_joint_is_named():
    assert judging.all_identified(outcome())


@pytest.mark.parametrize('said', [
    [['stribeck_friction', 'joint2', {}, None]],                # at another joint
    [['viscous_friction', 'joint1', {}, None]],                 # another cause
    [['stribeck_friction', 'joint1', {}, None], ['payload', None, {}, None]]])  # and one more
def test_another_cause_or_joint_is_wrong(said):
    result = outcome(said=said)
    assert judging.wrong(result)
    assert not judging.all_identified(result)


def test_silence_is_neither_named_nor_wrong():
    result = outcome(said=[], verdict='unknown')
    assert not judging.all_identified(result)
    assert not judging.wrong(result)


def test_a_set_with_the_cause_names_it_and_one_without_it_is_wrong():
    twins = [[['stribeck_friction', 'joint1'], ['coulomb_friction', 'joint1']]]
    others = [[['payload', None], ['base_tilt', None]]]
    assert judging.all_identified(outcome(said=[], alike=twins))
    assert judging.wrong(outcome(said=[], alike=others))


def test_twins_by_nature_are_not_wrong():
    hidden = [['drive_offset', 'joint1', {}, 'motor', 'constant', '']]
    assert not judging.wrong(outcome(
        hidden=hidden, said=[['asymmetric_friction', 'joint1', {}, None]]))


def test_what_the_log_adds_accuses_nobody():
    healthy = {'hidden': [], 'sizes': [], 'said': [['clock_jitter', None, {}, None]]}
    assert judging.accused(outcome(**healthy))
    assert not judging.accused(outcome(**healthy, tolerated=['clock_jitter']))
    assert judging.accused(outcome(hidden=[], said=[], verdict='unknown'))


def test_of_fifteen_the_largest_count():
    names = [f'effect_{k}' for k in range(15)]
    many = {'hidden': [[name, 'joint1', {}, '', '', ''] for name in names],
            'powers': [float(k) for k in range(15)]}
    said = [[name, 'joint1', {}, None] for name in (*names[:10], names[14])]
    assert judging.largest_identified(outcome(**many, said=said)) == pytest.approx(0.2)


def test_arms_that_their_controllers_do_not_hold_have_a_row_beside_them():
    many = [outcome(group='fifteen', powers=[1.0], oscillating=loops, said=said)
            for loops, said in (([], outcome()['said']), (['joint1'], []))]
    rows = [line for line in page(many, 2, first=0, last=1, final=False).splitlines()
            if 'of the five largest' in line or 'do not oscillate' in line]
    assert ['50 % (2 records)' in rows[0], '100 % (1 records)' in rows[1]] == [True, True]


def test_the_calibration_error_is_the_share_by_which_bins_miss():
    honest = [(0.75, True)] * 75 + [(0.75, False)] * 25
    assert calibration_error(honest) == pytest.approx(0.0)
    assert calibration_error([(0.95, False)] * 10) == pytest.approx(0.95)
    assert [(low, size) for low, _, _, size in binned([(1.0, True), (0.05, False)])] == [
        (0.0, 1), (0.9, 1)]


@pytest.mark.parametrize('first', [0, worlds.SEEDS])
def test_a_study_keeps_to_its_own_seeds(first):
    seeds = {case.seed for case in cases(first, 1.0)}
    assert {worlds.is_final(seed) for seed in seeds} == {first >= worlds.SEEDS}
    assert max(seeds) - first < 0.01 * worlds.SEEDS     # and none comes near the other's


def test_the_final_study_is_as_large_as_asked():
    planned = list(cases(worlds.SEEDS, 1.0))
    assert len({case.key() for case in planned}) == len(planned) >= 2000
    assert sum(case.group == 'healthy' for case in planned) == 600


def test_a_page_states_failures_and_what_could_not_be():
    odd = {'case': 'x', 'group': 'two', 'seed': 8, 'impossible': 'needs two joints'}
    failed = {**outcome(seed=9), 'error': 'no such clock'}
    text = page([outcome(), odd, failed], 3, first=0, last=9, final=False)
    assert '100.0 % (1 of 1)' in text
    assert 'seed 9, rich at 1000 Hz: no such clock' in text
    assert '1\ncould not be' in text
