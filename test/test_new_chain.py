"""`hda new --urdf` makes the arm file of a chain from its description and a table of gears."""

from pathlib import Path

from hda_arm_sim.foundation import chain
from hda_arm_sim.model.chain_links import ChainLinks
from hda_arm_sim.model.files import read_arm
from hda_arm_sim.model.link_side import loaded_inertia
from hda_torque_estimator.cli import main
import numpy as np
import pytest

URDF = Path(__file__).resolve().parents[1] / 'config' / 'cobot7.urdf'
HEAD = 'joint,gear,ratio,motor_inertia,motor_torque,motor_counts,link_counts'
ROWS = [f'joint{j},CSG-{size},100,{inertia:g},1.0,65536,8e6' for j, (size, inertia) in enumerate(
    [(32, 2e-4), (32, 2e-4), (25, 1e-4), (25, 1e-4), (17, 5e-5), (17, 5e-5), (17, 5e-5)], 1)]


def new(folder, head=HEAD, rows=ROWS, *more):
    """Return the exit code of `hda new` with a description and this table."""
    table = folder / 'gears.csv'
    table.write_text('\n'.join([head, *rows]) + '\n')
    return main(['new', '--urdf', str(URDF), '--gears', str(table), '--out',
                 str(folder / 'arm.yaml'), *more])


def test_a_description_and_a_table_of_gears_make_an_arm(tmp_path):
    assert new(tmp_path) == 0
    arm = read_arm(str(tmp_path / 'arm.yaml'))
    assert isinstance(arm.links, ChainLinks)
    assert arm.labels == tuple(f'joint{j}' for j in range(1, 8))
    assert [joint.ratio for joint in arm.joints] == [100.0] * 7
    assert arm.links.parts.tolist() == read_arm('cobot7.yaml').links.parts.tolist()


def test_a_ratio_beside_a_whole_name_is_that_of_the_output_at_the_circular_spline(tmp_path):
    """As with `--gear CSG-17-100 --ratio 101`; nothing else changes."""
    assert new(tmp_path, HEAD, [*ROWS[:-1], ROWS[-1].replace('CSG-17,100', 'CSG-17-100,101')]) == 0
    arm = read_arm(str(tmp_path / 'arm.yaml'))
    assert [joint.ratio for joint in arm.joints] == [100.0] * 6 + [101.0]
    assert arm.joints[6].torsion.valid_torque == arm.joints[5].torsion.valid_torque


def test_a_table_states_which_currents_were_measured(tmp_path):
    rows = [f'{row},{"0" if place else ""}' for place, row in enumerate(ROWS)]
    assert new(tmp_path, f'{HEAD},effort_lag', rows) == 0
    arm = read_arm(str(tmp_path / 'arm.yaml'))
    assert [joint.effort_lag for joint in arm.joints] == [0.5] + [0.0] * 6


def test_a_folder_is_no_description(tmp_path, capsys):
    assert main(['new', '--urdf', str(tmp_path), '--gears', 'gears.csv', '--out',
                 str(tmp_path / 'arm.yaml')]) == 2
    assert capsys.readouterr().err.strip() == f'hda new: {tmp_path}: it is a folder, not a file'


def test_the_description_of_a_real_arm_weighs_what_its_controller_says(tmp_path):
    """LARA8 in the first sample of its log: 52 and 55 N*m, and 36 more by the load."""
    given = URDF.parents[1] / 'examples'
    assert main(['new', '--urdf', str(given / 'robots' / 'lara8.urdf'), '--gears',
                 str(given / 'gears' / 'lara8.csv'), '--out', str(tmp_path / 'six.yaml')]) == 0
    arm = read_arm(str(tmp_path / 'six.yaml'))
    assert [joint.ratio for joint in arm.joints] == [121.0, 121.0, 101.0, 101.0, 101.0, 101.0]
    table = loaded_inertia(arm.record().body).table
    table[1:-1, chain.ANGLE] = 1.1637, 0.0026, 1.5710, 0.0, 1.5709, 0.0
    chain.place(table)
    chain.weights(table)
    np.testing.assert_allclose(table[1:5, chain.TORQUE], [0.0, 88.3, 91.5, 0.0], atol=1.0)


@pytest.mark.parametrize(('head', 'rows', 'said'), [
    (HEAD.replace('ratio', 'ration'), ROWS, 'ration'), (HEAD, ROWS[:-1], 'joint7'),
    (HEAD, [*ROWS, ROWS[0]], 'joint1'), (HEAD, [*ROWS[:-1], 'wrist' + ROWS[-1][6:]], 'wrist'),
    (HEAD, [*ROWS[:-1], ROWS[-1].replace('65536', 'many')], 'motor_counts'),
    (HEAD, [*ROWS[:-1], ROWS[-1].replace('65536', '')], 'motor_counts'),
    (HEAD, [*ROWS[:-1], 'joint7,CSG-17'], 'fields'),
    (HEAD, [*ROWS[:-1], ROWS[-1].replace('CSG-17', 'XYZ-17')], 'XYZ')])
def test_a_wrong_table_is_one_line(tmp_path, capsys, head, rows, said):
    assert new(tmp_path, head, rows) != 0
    output = capsys.readouterr().err.strip()
    assert said in output and '\n' not in output
    assert not (tmp_path / 'arm.yaml').exists()


def test_an_unknown_tip_is_one_line(tmp_path, capsys):
    assert new(tmp_path, HEAD, ROWS, '--tip', 'nose') != 0
    assert 'nose' in capsys.readouterr().err


@pytest.mark.parametrize(('before', 'after', 'said'), [
    ('<joint name="joint3" type="revolute">', '<joint name="joint3" type="prismatic">',
     'joint3 on the way to tool_tip is prismatic'),
    ('<mass value="', '<mass value="-', 'must not be negative')])
def test_what_a_chain_cannot_be_is_said_at_once(tmp_path, capsys, before, after, said):
    robot = tmp_path / 'robot.urdf'
    assert before in URDF.read_text()
    robot.write_text(URDF.read_text().replace(before, after))
    table = tmp_path / 'gears.csv'
    table.write_text('\n'.join([HEAD, *ROWS]) + '\n')
    assert main(['new', '--urdf', str(robot), '--gears', str(table), '--out',
                 str(tmp_path / 'arm.yaml')]) == 2
    output = capsys.readouterr().err.strip()
    assert said in output and '\n' not in output
    assert not (tmp_path / 'arm.yaml').exists()


def test_what_hangs_beside_the_chain_is_told(tmp_path, capsys):
    text = URDF.read_text().replace('</robot>', """
<link name="finger"><inertial><mass value="0.1"/>
<inertia ixx="1e-4" iyy="1e-4" izz="1e-4" ixy="0" ixz="0" iyz="0"/></inertial></link>
<joint name="slide" type="prismatic"><parent link="link2"/><child link="finger"/>
<axis xyz="1 0 0"/></joint></robot>""")
    branched, table = tmp_path / 'branched.urdf', tmp_path / 'gears.csv'
    branched.write_text(text)
    table.write_text('\n'.join([HEAD, *ROWS]) + '\n')
    assert main(['new', '--urdf', str(branched), '--gears', str(table), '--tip', 'tool_tip',
                 '--out', str(tmp_path / 'arm.yaml')]) == 0
    assert 'slide (prismatic) is not in the chain and left aside' in capsys.readouterr().err


@pytest.mark.parametrize(('before', 'after'), [
    ('</robot>', """
<joint name="back" type="fixed"><parent link="tool_tip"/><child link="base"/></joint></robot>"""),
    ('<parent link="base"/>', '<parent link="tool_tip"/>')])        # the base is left alone
def test_a_description_whose_links_go_round_in_a_circle_is_refused_in_one_line(
        tmp_path, capsys, before, after):
    circle, table = tmp_path / 'circle.urdf', tmp_path / 'gears.csv'
    assert before in URDF.read_text()
    circle.write_text(URDF.read_text().replace(before, after))
    table.write_text('\n'.join([HEAD, *ROWS]) + '\n')
    assert main(['new', '--urdf', str(circle), '--gears', str(table), '--out',
                 str(tmp_path / 'arm.yaml')]) == 2
    said = capsys.readouterr().err
    assert said.count('\n') == 1
    assert 'hang on each other in a circle' in said
