"""Robot descriptions of strangers: what is read of them, and one line for each mistake."""

from dataclasses import replace
import os

from chains import body, bounded, description, joint
from hda_arm_sim.foundation import chain as of
from hda_arm_sim.foundation.chain import CONSTANTS, INERTIA, MASS, MOMENT
from hda_arm_sim.model.arm import ArmError
from hda_arm_sim.model.chain_links import chain_to, ChainLinks, kept, tips
from hda_arm_sim.model.files import arm_from_text, read_arm
from hda_arm_sim.model.link_numbers import gyration, LinkTolerance
from hda_arm_sim.model.urdf import LARGEST, UrdfError
from hda_arm_sim.model.writing import arm_to_text
import numpy as np
import pytest

BASE, ONE, TWO = '<link name="base"/>', body('one'), body('two', at='0.1 0 0')
JOINTS = [joint('a', 'base', 'one'), joint('b', 'one', 'two', '0.3 0 0', axis='0 1 0')]
GOOD = description([BASE, ONE, TWO], JOINTS)
BOMB = ('<!DOCTYPE r [<!ENTITY a "aaaaaaaaaa"><!ENTITY b "&a;&a;&a;&a;&a;&a;&a;&a;&a;&a;">]>'
        '<robot name="&b;"/>')
STEALING = '<!DOCTYPE r [<!ENTITY x SYSTEM "file:///etc/passwd">]><robot name="&x;"/>'

BAD = {
    'no inertia': (description([BASE, '<link name="one"/>', TWO], JOINTS), 'one has no inertial'),
    'negative mass': (description([BASE, body('one', -1.0), TWO], JOINTS), 'must not be negative'),
    'no mass': (description([BASE, body('one', 0.0), TWO], JOINTS), 'inertia but no mass'),
    'flat': (description([BASE, body('one', inertia='0 1 1'), TWO], JOINTS), 'positive definite'),
    'no triangle': (description([BASE, body('one', inertia='0.1 0.1 0.5'), TWO], JOINTS),
                    'no body has this inertia'),
    'no number': (description([BASE, body('one', at='0 x 0'), TWO], JOINTS), 'three finite'),
    'nan': (description([BASE, body('one', inertia='nan 1 1'), TWO], JOINTS), 'finite number'),
    'millimetres': (GOOD.replace('0.3 0 0', '300 0 0'),
                    'b: its origin must lie within 100 m, got 300 m; lengths'),
    'bomb': (BOMB, 'never read'),
    'external entity': (STEALING, 'never read'),
    'no xml': ('<robot>', 'no XML'),
    'other xml': ('<sdf/>', 'no robot description'),
    'xacro': ('<robot><xacro:arm/></robot>', 'xacro FILE'),
    'deep': ('<robot>' + 100 * '<link name="x">', 'within each other'),
    'twice': (description([BASE, ONE, ONE, TWO], JOINTS), 'called one'),
    'unknown link': (description([BASE, ONE, TWO], [joint('a', 'base', 'three')]), "'three'"),
    'two parents': (description([BASE, ONE, TWO], [*JOINTS, joint('c', 'base', 'two')]), 'tree'),
    'circle': (description([ONE, TWO], [joint('a', 'two', 'one'), joint('b', 'one', 'two')]),
               'circle'),
    'sliding': (description([BASE, ONE, TWO], [JOINTS[0], joint(
        'b', 'one', 'two', kind='prismatic')]), 'b on the way to two is prismatic'),
    'no axis': (description([BASE, ONE, TWO], [JOINTS[0], joint('b', 'one', 'two',
                                                                axis='0 0 0')]), 'axis'),
    'limits reversed': (bounded(GOOD, 'b', 2.0, -1.0),
                        'joint b: its limits are reversed, lower is 2 rad and upper -1 rad'),
    'empty': ('<robot/>', 'no links'),
    'nameless': ('<robot><link/></robot>', 'has no name'),
    'long': (' ' * (LARGEST + 1), 'too long'),
}


def links(text: str = GOOD, tip: str = 'two', names: tuple[str, ...] = ('a', 'b')) -> ChainLinks:
    """Return the links of a description."""
    return ChainLinks(kept(text), tip, names)


@pytest.mark.parametrize('name', BAD)
def test_every_mistake_is_one_line(name):
    text, reported = BAD[name]
    with pytest.raises(UrdfError, match=reported) as caught:
        links(text)
    assert '\n' not in str(caught.value)
    assert str(caught.value).count('it is') <= 1        # one reason, not one within another


def test_an_unknown_tip_names_those_there_are():
    with pytest.raises(UrdfError, match="no link 'hand'.*base, one, two"):
        links(tip='hand')


@pytest.mark.parametrize('names', [('a',), ('b', 'a'), ('joint1', 'joint2')])
def test_names_of_joints_must_be_those_of_the_chain(names):
    with pytest.raises(UrdfError, match='lead to two are a, b, got'):
        links(names=names)


def test_meshes_are_never_opened(tmp_path):
    mesh = tmp_path / 'mesh.stl'
    os.mkfifo(mesh)                         # who opens it waits for ever
    seen = f'<visual><geometry><mesh filename="{mesh}"/></geometry></visual>'
    text = GOOD.replace('</inertial>', f'</inertial>{seen}')
    assert links(text) == links()
    assert 'mesh' not in kept(text)


def test_the_tip_and_the_chain_are_found():
    assert tips(GOOD) == ['two']
    assert chain_to(GOOD, 'two') == ('a', 'b')


def test_fixed_joints_make_one_body_of_their_links():
    """A link cut in two halves that are fixed to each other is the link."""
    halves = description(
        [BASE, ONE, body('near', 0.4, '0.1 0 0', '0.01 0.02 0.02'),
         body('far', 0.6, '-0.2 0.1 0', '0.01 0.01 0.02')],
        [JOINTS[0], joint('b', 'one', 'near', '0.3 0 0', axis='0 1 0'),
         joint('weld', 'near', 'far', '0.5 0 0', rpy='0 0 1.5707963267948966', kind='fixed')])
    row = links(halves, 'far').parts[2]
    turn = links(halves, 'far').parts[2, of.ROTATION:of.ROTATION + 9].reshape(3, 3)
    assert row[of.MASS] == 1.0
    moment = 0.4 * np.array([0.1, 0.0, 0.0]) + 0.6 * np.array([0.4, -0.2, 0.0])
    np.testing.assert_allclose(turn @ row[of.MOMENT:of.MOMENT + 3], moment, atol=1e-15)
    np.testing.assert_allclose(links(halves, 'far').parts[-1, of.MASS], 0.0)


@pytest.mark.parametrize('kind', ['prismatic', 'revolute', 'floating'])
def test_branches_are_left_aside_and_reported(kind):
    text = description([BASE, ONE, TWO, body('finger', 0.1)],
                       [*JOINTS, joint('slide', 'two', 'finger', kind=kind)])
    made = links(text)
    assert made.parts[2, of.MASS] == pytest.approx(1.1)
    remark, = made.built.remarks
    assert 'slide' in remark
    assert 'left aside' in remark
    assert '0.1 kg' in remark


def test_a_joint_that_mimics_is_reported_so():
    finger = joint('slide', 'two', 'finger').replace('</joint>', '<mimic joint="a"/></joint>')
    made = links(description([BASE, ONE, TWO, body('finger', 0.1)], [*JOINTS, finger]))
    assert 'slide (mimic)' in made.built.remarks[0]


@pytest.mark.parametrize('kind', ['prismatic', 'continuous'])
def test_what_hangs_beside_the_chain_on_its_base_is_left_aside_and_reported(kind):
    """Behind fixed joints as well; what is fixed to the base is no news."""
    text = description([BASE, ONE, TWO, body('post'), body('other')],
                       [*JOINTS, joint('stand', 'base', 'post', kind='fixed'),
                        joint('slide', 'post', 'other', kind=kind)])
    made = links(text)
    assert made.parts.tolist() == links().parts.tolist()
    remark, = made.built.remarks
    assert remark.startswith(f'slide ({kind})') and 'left aside' in remark


def test_a_gripper_is_no_tip():
    """No chain leads to a finger that slides: the hand is proposed, or a frame fixed to it."""
    fingers = [joint('left', 'two', 'near', kind='prismatic'),
               joint('right', 'two', 'far', kind='prismatic')]
    links_of = [BASE, ONE, TWO, body('near'), body('far')]
    assert tips(description(links_of, [*JOINTS, *fingers])) == ['two']
    assert tips(description([*links_of, '<link name="tcp"/>'], [
        *JOINTS, *fingers, joint('end', 'two', 'tcp', kind='fixed')])) == ['tcp']
    mimic = fingers[1].replace('prismatic', 'revolute').replace(
        '</joint>', '<mimic joint="left"/></joint>')
    assert tips(description(links_of, [*JOINTS, fingers[0], mimic])) == ['two']


def test_a_joint_that_slides_on_the_way_is_no_gripper():
    text = description([BASE, ONE, TWO], [joint('a', 'base', 'one', kind='prismatic'), JOINTS[1]])
    assert tips(text) == ['two']


def test_a_description_says_how_far_joints_turn():
    """Two zeros are what drawings state who know no limits; a continuous joint has none."""
    assert links(bounded(GOOD, 'b', -2.0, 0.5)).ranges.tolist() == [
        [-np.inf, np.inf], [-2.0, 0.5]]
    for text in (GOOD, bounded(GOOD, 'b', 0.0, 0.0)):
        assert np.isinf(links(text).ranges).all()


def test_inline_and_file_are_the_same_arm(tmp_path):
    shipped = read_arm('cobot7.yaml')
    assert arm_from_text(arm_to_text(shipped), 'a bag') == shipped
    (tmp_path / 'arm.urdf').write_text(shipped.links.description)
    text = arm_to_text(replace(shipped, links=None)).replace(
        'links: none', 'links: {urdf: arm.urdf, tip: tool_tip}')
    (tmp_path / 'arm.yaml').write_text(text)
    assert read_arm(tmp_path / 'arm.yaml').links.parts.tolist() == shipped.links.parts.tolist()


@pytest.mark.parametrize(('given', 'reported'), [
    ('{urdf: absent.urdf, tip: tool_tip}', 'no such file beside arm.yaml'),
    ('{urdf: ., tip: tool_tip}', 'it is a folder, not a file'),
    ('{urdf: "http://x/y.urdf", tip: tool_tip}', 'nothing is fetched'),
    ('{urdf: arm.urdf}', 'links.tip'),
    ('{urdf: arm.urdf, tip: tool_tip, lengths: [1, 1]}', 'unknown key'),
    ('{urdf: arm.urdf, tip: tool_tip, joints: [joint1]}', 'got joint1'),
    ('{urdf: arm.urdf, tip: link3}', 'joint1, joint2, joint3, got'),
    ('{urdf: arm.urdf, tip: tool_tip, home: [1]}', 'home needs 7'),
    ('{urdf: arm.urdf, tip: tool_tip, home: [a]}', 'links.home'),
    ('{urdf: arm.urdf, tip: tool_tip, rpy: [1, 2]}', 'links.rpy needs 3'),
    ('{urdf: arm.urdf, tip: tool_tip, tolerances: [1]}', 'links.tolerances must be a mapping'),
    ('{urdf: arm.urdf, tip: tool_tip, tolerances: {link3: {}}}', "unknown key 'link3'"),
    ('{urdf: arm.urdf, tip: tool_tip, tolerances: {joint3: {weight: 1}}}',
     'links.tolerances.joint3 has the unknown key'),
    ('{urdf: arm.urdf, tip: tool_tip, tolerances: {joint3: {mass: -1}}}',
     r'links.tolerances.joint3.mass must lie in \[0, 1\]')])
def test_links_of_a_file_have_one_line_for_each_mistake(tmp_path, given, reported):
    shipped = read_arm('cobot7.yaml')
    (tmp_path / 'arm.urdf').write_text(shipped.links.description)
    place = tmp_path / 'arm.yaml'
    place.write_text(arm_to_text(replace(shipped, links=None)).replace(
        'links: none', f'links: {given}'))
    with pytest.raises(ArmError, match=reported) as caught:
        read_arm(place)
    assert '\n' not in str(caught.value)
    assert str(place) in str(caught.value)


def test_a_file_states_how_well_each_link_is_known(tmp_path):
    shipped = read_arm('cobot7.yaml')
    (tmp_path / 'arm.urdf').write_text(shipped.links.description)
    (tmp_path / 'arm.yaml').write_text(arm_to_text(replace(shipped, links=None)).replace(
        'links: none', 'links: {urdf: arm.urdf, tip: tool_tip, '
        'tolerances: {joint3: {mass: 0.05, centre: 0.01}}}'))
    arm = read_arm(tmp_path / 'arm.yaml')
    known = arm.links.known(0.03)
    assert known[2] == LinkTolerance(mass=0.05, centre=0.01)
    assert {(one.mass, one.inertia) for one in (known[0], *known[3:])} == {(0.03, 0.03)}
    assert known[0].centre == pytest.approx(0.03 * gyration(arm.links.parts[1]))
    assert arm_from_text(arm_to_text(arm), 'a bag') == arm


def test_a_link_gyrates_about_its_centre_wherever_its_joint_is():
    """A ball of 2 kg with a radius of 0.1 m, its centre at (0.3, -0.2, 0.5) m."""
    own, centre, mass = 0.4 * 2.0 * 0.1 ** 2, np.array([0.3, -0.2, 0.5]), 2.0
    about = own * np.eye(3) + mass * (centre @ centre * np.eye(3) - np.outer(centre, centre))
    row = np.zeros(CONSTANTS)
    row[MASS], row[MOMENT:MOMENT + 3] = mass, mass * centre
    row[INERTIA:INERTIA + 6] = about[[0, 1, 2, 0, 0, 1], [0, 1, 2, 1, 2, 2]]
    assert gyration(row) == pytest.approx(np.sqrt(1.5 * own / mass))
    assert gyration(np.zeros(CONSTANTS)) == 0.0


def test_an_arm_that_hangs_feels_gravity_the_other_way():
    stands, hangs = (of.chain(replace(links(), rpy=(roll, 0.0, 0.0)).parts).table
                     for roll in (0.0, np.pi))
    for table, down in ((stands, 9.81), (hangs, -9.81)):
        table[0, of.DOWN + 2] = down
        of.place(table)
        of.weights(table)
    np.testing.assert_allclose(hangs[1:-1, of.TORQUE], stands[1:-1, of.TORQUE], atol=1e-12)
