"""Imports run one way: from what is inferred, over what the arm is, to what travels."""

import ast
from fnmatch import fnmatch
from graphlib import TopologicalSorter
import re
import sys

from project_files import PACKAGES, ROOT
from project_imports import IMPORTS, PATHS
import pytest

# Shells deal with ROS, files, figures or the terminal. Every other module is pure.
SHELLS = (
    'hda_arm_sim.main',
    'hda_arm_sim.model.chain_files',
    'hda_arm_sim.model.files',
    'hda_arm_sim.model.writing',
    'hda_arm_sim.motion_file',
    'hda_arm_sim.node',
    'hda_arm_sim.ros*',
    'hda_msgs_json.bag*',
    'hda_msgs_json.mcap_*',
    'hda_msgs_json.outputs',
    'hda_msgs_json.schemas',
    'hda_msgs_json.yaml_text',
    'hda_torque_estimator.*.page',
    'hda_torque_estimator.*.run',
    'hda_torque_estimator.live.recorder',
    'hda_torque_estimator.live.server',
    'hda_torque_estimator.*_node',
    'hda_torque_estimator.cli',
    'hda_torque_estimator.commands*',
    'hda_torque_estimator.comparison.plots',
    'hda_torque_estimator.diagnosis.reporting.plots',
    'hda_torque_estimator.fleet.fleet_page',
    'hda_torque_estimator.importing.map_document',
    'hda_torque_estimator.importing.mat73',
    'hda_torque_estimator.importing.side_by_side',
    'hda_torque_estimator.importing.tables',
    'hda_torque_estimator.measurements.recorded_readings',
    'hda_torque_estimator.measurements.renamed_recording',
    'hda_torque_estimator.pages.drawing',
    'hda_torque_estimator.pages.render',
    'hda_torque_estimator.reproduction.diagram_plots',
    'hda_torque_estimator.reproduction.plots',
    'hda_torque_estimator.simulating.recorded',
    'hda_torque_estimator.warm_up',
)
# The rooms, lowest first: a folder, or a module that is a room of its own.
ROOMS = (
    'hda_msgs_json',
    'hda_arm_sim.foundation',
    'hda_arm_sim.model.effects',
    'hda_arm_sim.model',
    'hda_arm_sim.health',
    'hda_arm_sim.ros',
    'hda_arm_sim',
    'hda_torque_estimator.version',
    'hda_torque_estimator.error_sentences',
    'hda_torque_estimator.significance',
    'hda_torque_estimator.pages',
    'hda_torque_estimator.samples',
    'hda_torque_estimator.measurements',
    'hda_torque_estimator.estimating.laws',
    'hda_torque_estimator.estimating',
    'hda_torque_estimator.controlling',
    'hda_torque_estimator.simulating',
    'hda_torque_estimator.recording',
    'hda_torque_estimator.playing',
    'hda_torque_estimator.live',
    'hda_torque_estimator.importing',
    'hda_torque_estimator.comparison',
    'hda_torque_estimator.least_squares',
    'hda_torque_estimator.calibrate.passages',
    'hda_torque_estimator.calibrate.fitting',
    'hda_torque_estimator.calibrate',
    'hda_torque_estimator.diagnosis.balances',
    'hda_torque_estimator.diagnosis.fitting',
    'hda_torque_estimator.diagnosis.findings',
    'hda_torque_estimator.diagnosis.readings',
    'hda_torque_estimator.diagnosis.judging',
    'hda_torque_estimator.diagnosis.detectability',
    'hda_torque_estimator.diagnosis.reporting',
    'hda_torque_estimator.diagnosis.motors_alone',
    'hda_torque_estimator.diagnosis',
    'hda_torque_estimator.planning',
    'hda_torque_estimator.reproduction.rig',
    'hda_torque_estimator.reproduction.figures',
    'hda_torque_estimator.reproduction',
    'hda_torque_estimator.fleet',
    'hda_torque_estimator.commands',
    'hda_torque_estimator',
)
PURE_LIBRARIES = {'numba', 'numpy', 'scipy'}
IMPURE_STANDARD = {'argparse', 'logging', 'subprocess', 'tempfile'}


def is_shell(name: str) -> bool:
    """Return whether a module is one of the shells."""
    return any(fnmatch(name, pattern) for pattern in SHELLS)


def room(name: str) -> str:
    """Return the room of a module: itself if it is listed, else its folder."""
    is_room = name in ROOMS or PATHS[name].stem == '__init__'
    return name if is_room else name.rpartition('.')[0]


def is_pure_import(name: str) -> bool:
    """Return whether a pure module may import this."""
    if name in PATHS:
        return not is_shell(name)
    top = name.partition('.')[0]
    return top in PURE_LIBRARIES or top in sys.stdlib_module_names - IMPURE_STANDARD


@pytest.mark.parametrize('package', PACKAGES)
def test_packages_import_only_what_is_below_them(package):
    above = PACKAGES[PACKAGES.index(package) + 1:]
    assert {(name, used) for name, uses in IMPORTS.items() for used in uses
            if name.startswith(package) and used.startswith(above)} == set()


def test_every_room_has_its_place():
    assert {room(name) for name in PATHS} == set(ROOMS)


def test_modules_import_only_from_their_room_and_those_below_it():
    assert {(name, used) for name, uses in IMPORTS.items() for used in uses & PATHS.keys()
            if ROOMS.index(room(used)) > ROOMS.index(room(name))} == set()


def test_the_map_of_rooms_shows_all_of_them_in_order():
    text = (ROOT / 'docs' / 'architecture.md').read_text()
    listed = text.partition('\n## Rooms\n')[2].partition('\n## ')[0]
    shown = re.findall(r'^\| `([\w/]+)(?:\.py)?` \|', listed, re.MULTILINE)
    assert [name.replace('/', '.') for name in shown] == list(ROOMS)


def test_pure_modules_import_only_pure_things():
    assert {(name, used) for name, uses in IMPORTS.items() for used in uses
            if not is_shell(name) and not is_pure_import(used)} == set()


def test_no_module_imports_itself_in_a_circle():
    TopologicalSorter({name: uses & PATHS.keys() for name, uses in IMPORTS.items()}).prepare()


def changed(target: ast.expr) -> bool:
    """Return whether an assignment to this changes a field of another object."""
    match target:
        case ast.Tuple(elts=parts):
            return any(changed(part) for part in parts)
        case ast.Subscript(value=owner):
            return changed(owner)
        case ast.Attribute(value=ast.Name(id='self')):
            return False
    return isinstance(target, ast.Attribute)


# The others hand messages of ROS, arguments or arrays to what fills them.
@pytest.mark.parametrize('folder', [
    'calibrate', 'comparison', 'diagnosis', 'fleet', 'importing', 'least_squares', 'measurements',
    'planning', 'samples'])
def test_nobody_changes_the_fields_of_another_object(folder):
    within = PACKAGES[-1] + '.' + folder
    assert [(name, node.lineno) for name, path in PATHS.items() if name.startswith(within)
            for node in ast.walk(ast.parse(path.read_text()))
            for target in getattr(node, 'targets', [getattr(node, 'target', None)])
            if isinstance(node, (ast.Assign, ast.AugAssign, ast.AnnAssign)) and changed(target)
            ] == []


def test_every_shell_exists():
    assert [pattern for pattern in SHELLS
            if not any(fnmatch(name, pattern) for name in PATHS)] == []
