"""Arm files: what is written is read back, and every mistake is answered in one clear sentence."""

from copy import deepcopy
from dataclasses import replace

from hda_arm_sim.model.arm import Arm, ArmError, Placed
from hda_arm_sim.model.effects import EFFECTS, KinematicError, Payload, Scope
from hda_arm_sim.model.files import arm_from_text, read_arm, read_effects, shipped_arms
from hda_arm_sim.model.parts import Joint, Links
from hda_arm_sim.model.writing import arm_to_text, write_arm
from hypothesis import given, settings, strategies as st
import pytest
import yaml

NOMINAL = read_arm('hda_arm.yaml')
DOCUMENT = yaml.safe_load(arm_to_text(NOMINAL.with_effect(
    KinematicError(amplitude_2=1e-4), 'joint1')))
MISSING = object()


def numbers(rule):
    """Return values that a declaration allows."""
    return st.floats(rule.low, rule.high, allow_nan=False)


def filled(kind):
    """Return an effect with any parameters that are allowed."""
    return st.builds(kind, **{rule.name: numbers(rule) for rule in kind.declarations()})


def changed(path, value):
    """Return the text of the arm with one entry changed, added or removed."""
    document = deepcopy(DOCUMENT)
    owner = document
    for key in path[:-1]:
        owner = owner[key]
    if value is MISSING:
        del owner[path[-1]]
    else:
        owner[path[-1]] = value
    return yaml.safe_dump(document, sort_keys=False)


def places(document, path=()):
    """Yield the path of every entry of a document."""
    keys = document if isinstance(document, dict) else range(len(document))
    for key in keys:
        yield (*path, key)
        if isinstance(document[key], (dict, list)):
            yield from places(document[key], (*path, key))


@pytest.mark.parametrize('name', shipped_arms())
def test_shipped_arms_survive_a_round_trip(name):
    arm = read_arm(name)
    assert arm_from_text(arm_to_text(arm), name) == arm


@pytest.mark.parametrize('kind', EFFECTS, ids=lambda kind: kind.name)
@settings(max_examples=10)
@given(content=st.data())
def test_every_effect_survives_a_round_trip(kind, content):
    effect = content.draw(filled(kind))
    placed = Placed(effect, None if kind.scope is Scope.ARM else 'joint2')
    torsion_only = replace(NOMINAL, links=None, effects=(placed,))
    assert arm_from_text(arm_to_text(torsion_only), 'text') == torsion_only


@pytest.mark.parametrize('arm', [
    Arm((Joint(label='elbow'),), Links(p1=0.5, first=1.5)),
    replace(NOMINAL, links=None, provenance=(('joint1.torsion', 'a sentence: with a colon'),)),
    replace(NOMINAL, links=replace(NOMINAL.links, coupled=0.0)),
])
def test_arms_of_every_kind_survive_a_round_trip(arm, tmp_path):
    write_arm(arm, tmp_path / 'arm.yaml')
    assert read_arm(tmp_path / 'arm.yaml') == arm
    assert [path.name for path in tmp_path.iterdir()] == ['arm.yaml']


def test_a_joint_may_have_tolerances_of_its_own():
    text = changed(('joints', 1, 'tolerances'), {'torsion_zero': 3e-3})
    arm = arm_from_text(text, 'text')
    assert arm.tolerances_of('joint1') == arm.tolerances == NOMINAL.tolerances
    own = arm.tolerances_of('joint2')
    assert own == replace(NOMINAL.tolerances, torsion_zero=3e-3)
    assert arm.record().joints['tolerances']['torsion_zero'].tolist() == [
        NOMINAL.tolerances.torsion_zero, 3e-3]
    assert arm_from_text(arm_to_text(arm), 'text') == arm


def test_numbers_that_yaml_takes_for_text_are_numbers():
    text = changed(('joints', 0, 'link_encoder', 'counts'), '4e6')
    assert arm_from_text(text, 'text').joints[0].link_encoder.counts == 4e6


MISTAKES = [
    (('joint',), [], "the file has the unknown key 'joint'; valid keys: joints, links, base"),
    (('joints', 0, 'gear'), 100, "has the unknown key 'gear'; valid keys: name, torsion"),
    (('joints', 0, 'ratio'), 'hundred',
     "joint1.ratio must be a number in no unit (gear ratio N), got 'hundred'"),
    (('joints', 0, 'ratio'), -100.0, 'joint1.ratio must lie in [1, 10000] (gear ratio N)'),
    (('joints', 1, 'motor_inertia'), float('nan'), 'joint2.motor_inertia must lie in'),
    (('joints', 1, 'torque_limit'), 10 ** 400, 'joint2.torque_limit must lie in'),
    (('joints', 1, 'torsion', 'damping'), '8 N*m*s/rad',
     'joint2.torsion.damping must be a number in N*m*s/rad (D, damping of the torsion'),
    (('joints', 0, 'motor_encoder'), 4096,
     'joint1.motor_encoder must be a mapping with counts, zero, noise, sampling_time, got 4096'),
    (('joints', 0, 'name'), 'joint 1', "joints[0].name must be a name like joint1, got 'joint 1'"),
    (('joints', 1, 'name'), 'joint1', 'joint names must differ, got joint1 more than once'),
    (('joints',), [], 'an arm needs at least one joint, got none'),
    (('joints',), {'joint1': {}}, 'joints must be a list, got'),
    (('links',), MISSING, 'an arm needs "joints" and "links"'),
    (('links', 'lengths'), [0.15], 'links.lengths needs 2 numbers (length1, length2), got 1'),
    (('links', 'inertia'), [0.5, 0.25, 0.3],
     'the mass matrix must be positive definite: p2 (p1 - p2) > p3^2'),
    (('links', 'coupled'), 'yes', "links.coupled must be true or false, got 'yes'"),
    (('base', 'tilt'), 3.0, 'base.tilt must lie in [0, 1.5708] rad'),
    (('tolerances', 'stiffness'), [0.01], 'tolerances.stiffness must be a number'),
    (('joints', 0, 'tolerances'), {'stiffness': -1.0},
     'joint1.tolerances.stiffness must lie in [0, 1]'),
    (('joints', 0, 'tolerances'), {'zero': 1.0}, "joint1.tolerances has the unknown key 'zero'"),
    (('effects', 0, 'effect'), 'kinematic',
     "no effect is named 'kinematic'; did you mean kinematic_error? "),
    (('effects', 0, 'joint'), 'joint3', "has no joint 'joint3'; its joints are joint1, joint2"),
    (('effects', 0, 'joint'), MISSING, 'kinematic_error belongs to one joint: name one of joint1'),
    (('effects', 0, 'parameters', 'amplitude_3'), 1.0,
     "kinematic_error has the unknown key 'amplitude_3'; valid keys: amplitude_1"),
    (('effects', 0, 'parameters', 'amplitude_2'), 1.0,
     'kinematic_error.amplitude_2 must lie in [0, 0.05] rad (twice per motor turn'),
    (('provenance',), {'ratio': 100}, 'provenance must map the name of a number to a sentence'),
]


@pytest.mark.parametrize(('path', 'value', 'sentence'), MISTAKES,
                         ids=['.'.join(map(str, mistake[0])) for mistake in MISTAKES])
def test_a_mistake_is_answered_in_one_sentence(path, value, sentence):
    with pytest.raises(ArmError) as answer:
        arm_from_text(changed(path, value), 'arm.yaml')
    text = str(answer.value)
    assert text.startswith('arm.yaml: ')
    assert sentence in text
    assert '\n' not in text


def test_an_effect_listed_twice_is_a_mistake():
    twice = changed(('effects',), DOCUMENT['effects'] * 2)
    with pytest.raises(ArmError, match='kinematic_error of joint1 is listed twice'):
        arm_from_text(twice, 'arm.yaml')


@pytest.mark.parametrize('text', ['', '3', '- 1', 'joints: [', '\0',
                                  'joints: &a [*a]\nlinks: none'])
def test_what_is_no_arm_at_all_is_answered_in_one_sentence(text):
    with pytest.raises(ArmError) as answer:
        arm_from_text(text, 'arm.yaml')
    assert str(answer.value).startswith('arm.yaml')
    assert '\n' not in str(answer.value)


odd_values = st.one_of(
    st.none(), st.booleans(), st.text(max_size=5), st.integers(), st.floats(),
    st.just(10 ** 400), st.lists(st.integers(), max_size=3),
    st.dictionaries(st.text(max_size=3), st.none(), max_size=2), st.just(MISSING))


@given(st.sampled_from(list(places(DOCUMENT))), odd_values)
def test_whatever_stands_in_a_file_it_is_an_arm_or_a_sentence(path, value):
    try:
        arm = arm_from_text(changed(path, value), 'arm.yaml')
    except ArmError as error:
        assert str(error).startswith('arm.yaml: ')
        assert '\n' not in str(error)
    else:
        assert arm_from_text(arm_to_text(arm), 'again') == arm


def test_a_file_that_is_not_there_is_answered_with_the_shipped_ones(tmp_path):
    with pytest.raises(ArmError, match=r"no arm file '.*none.yaml'; the shipped ones are cobot7"):
        read_arm(tmp_path / 'none.yaml')


def test_a_file_that_is_not_text_is_said_so(tmp_path):
    (tmp_path / 'arm.yaml').write_bytes(b'\xff\xfe\x00')
    with pytest.raises(ArmError, match='cannot be read as text'):
        read_arm(tmp_path / 'arm.yaml')


def test_an_arm_that_cannot_be_written_leaves_no_file(tmp_path):
    with pytest.raises(ArmError, match='cannot be written'):
        write_arm(NOMINAL, tmp_path / 'none' / 'arm.yaml')
    assert list(tmp_path.iterdir()) == []


EFFECTS_TEXT = """
- {effect: kinematic_error, joint: joint1, parameters: {amplitude_2: 1.0e-4}}
- {effect: payload, parameters: {mass: 1.5}}
"""


@pytest.mark.parametrize('text', [EFFECTS_TEXT, 'effects:' + EFFECTS_TEXT.replace('\n', '\n  ')])
def test_effects_alone_are_read_too(text, tmp_path):
    (tmp_path / 'effects.yaml').write_text(text)
    assert read_effects(tmp_path / 'effects.yaml') == (
        Placed(KinematicError(amplitude_2=1e-4), 'joint1'), Placed(Payload(mass=1.5), None))


@pytest.mark.parametrize(('text', 'sentence'), [
    ('joints: []', 'it must be a list of effects, or have one under "effects"'),
    ('- {effect: rust}', "no effect is named 'rust'"),
    ('- {effect: payload, parameters: {mass: heavy}}', 'payload.mass must be a number in kg'),
])
def test_mistakes_in_effects_are_answered_in_one_sentence(text, sentence, tmp_path):
    (tmp_path / 'effects.yaml').write_text(text)
    with pytest.raises(ArmError) as answer:
        read_effects(tmp_path / 'effects.yaml')
    assert sentence in str(answer.value)
    assert '\n' not in str(answer.value)
