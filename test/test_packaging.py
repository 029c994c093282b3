"""One package: pip, colcon and a link to the checkout install the same things, ready to run."""

import importlib
from importlib import metadata
import os
from pathlib import Path
import re
import runpy
import signal
import subprocess
import sys
import xml.etree.ElementTree as ElementTree
import zipfile

from catkin_pkg.changelog import get_changelog_from_path
from catkin_pkg.package import parse_package
from hda_torque_estimator import executables
from project_files import copy_project, files, PACKAGES, ROOT
from project_imports import IMPORTS
import pytest
import setuptools

NAME = 'hda_torque_estimator'

# Everything that `ros2 run` must find, and the module behind it.
MODULES = {
    'arm_sim': 'hda_arm_sim.main',
    'torque_estimator': 'hda_torque_estimator.estimating.estimator_node',
    'jtf_controller': 'hda_torque_estimator.controlling.controller_node',
    'bag_recorder': 'hda_torque_estimator.recording.recorder_node',
    'bag_player': 'hda_torque_estimator.playing.player_node',
    'live_view': 'hda_torque_estimator.live.live_node',
    'warm_up': 'hda_torque_estimator.warm_up',
    'hda': 'hda_torque_estimator.cli',
}

# Packages whose modules have another name.
IMPORTED_AS = {'pyyaml': 'yaml'}

# Print where the pages come from, and a page with a plot and all that it needs.
SHOW_PAGE = """
from hda_torque_estimator.pages import plot, render
import numpy
line = plot.Plot('x', 'y', numpy.arange(3.0), [plot.PlotLine('z', numpy.arange(3.0), 'after')])
print(render.__file__, render.render('page.html', title='t', charts={
    'a': plot.PlotGroup('b', 'c', {'d': line})}))
"""

# Print where an installed package finds the model files.
FIND_CONFIG = "from importlib.resources import files; print(files('hda_arm_sim') / 'config')"


def expected_executables() -> dict[str, str]:
    """Return the entry points that this version must have."""
    return {name: f'{executables.__name__}:{name}' if name in vars(executables)
            else f'{module}:main' for name, module in MODULES.items()}


def run(*command: object, cwd: Path, **environment: str) -> str:
    """Return what a command prints, started without the paths of this run; fail if it fails."""
    env = {name: value for name, value in os.environ.items() if name != 'PYTHONPATH'}
    done = subprocess.run([str(word) for word in command], cwd=cwd, env=env | environment,
                          capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout


def tree(directory: Path) -> set[str]:
    """Return the paths of all files below a directory, relative to it."""
    return {str(path.relative_to(directory)) for path in files(within=directory)}


@pytest.fixture
def described(monkeypatch):
    """Return what setup.py passes to setuptools."""
    reported: dict[str, object] = {}
    monkeypatch.setattr(setuptools, 'setup', reported.update)
    monkeypatch.chdir(ROOT)
    runpy.run_path('setup.py')
    return reported


@pytest.fixture(scope='module')
def wheel(tmp_path_factory):
    """Build the wheel from a copy of the project."""
    if sys.prefix == sys.base_prefix:
        pytest.skip('a wheel is for virtual environments, this is none')
    source = copy_project(tmp_path_factory.mktemp('pip') / NAME)
    run(sys.executable, '-m', 'pip', 'wheel', '-q', '--no-deps', '--no-build-isolation',
        '-w', 'dist', source, cwd=source.parent)
    return next(source.parent.glob('dist/*.whl'))


COPIED: tuple[str, ...] = ()
LINKED = ('--symlink-install',)


@pytest.fixture(scope='module', params=[COPIED, LINKED], ids=['copied', 'linked'])
def workspace(request, tmp_path_factory):
    """Build a workspace that holds a copy of the project, with files copied and linked."""
    pytest.importorskip('colcon_core')
    space = tmp_path_factory.mktemp('workspace')
    copy_project(space / 'src' / NAME)
    run(sys.executable, '-m', 'colcon', 'build', *request.param, cwd=space)
    return space


def run_inside(workspace: Path, *command: object) -> str:
    """Return what a command prints where the workspace is set up."""
    return run('sh', '-ec', '. install/local_setup.sh; exec "$@"', 'sh', *command, cwd=workspace)


def test_ros_and_pip_read_the_same_description(described):
    package = parse_package(str(ROOT / 'package.xml'))
    assert package.name == described['name'] == NAME
    assert package.version == described['version']
    assert package.licenses[0] == described['license']
    assert [(person.name, person.email) for person in package.maintainers] == [
        (described['maintainer'], described['maintainer_email'])]


def test_changelog_lists_this_version(described):
    changelog = get_changelog_from_path(str(ROOT / 'CHANGELOG.rst'), NAME)
    released = [version for version, _, _ in changelog.foreach_version()]
    assert released[0] == described['version']


def test_every_executable_is_declared(described):
    declared = dict(line.split(' = ') for line in described['entry_points']['console_scripts'])
    assert declared == expected_executables()


@pytest.mark.parametrize('name', expected_executables())
def test_every_executable_has_a_main(name):
    assert callable(getattr(importlib.import_module(MODULES[name]), 'main', None))


@pytest.mark.parametrize('name', sorted(MODULES.keys() - {'hda'}))
def test_every_executable_leads_to_its_module(name, monkeypatch):
    """A signal ends it while its module loads; the handlers are those of this run again later."""
    before = {number: signal.getsignal(number) for number in (signal.SIGINT, signal.SIGTERM)}
    monkeypatch.setattr(importlib.import_module(MODULES[name]), 'main', lambda: 42)
    try:
        assert getattr(executables, name)() == 42
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)


def test_every_executable_has_a_shim():
    assert tree(ROOT / 'ament_bin') == expected_executables().keys()
    assert all(os.access(shim, os.X_OK) for shim in (ROOT / 'ament_bin').iterdir())


def test_everything_imported_is_declared(described):
    needed = {used.partition('.')[0] for uses in IMPORTS.values() for used in uses}
    wanted = [*described['install_requires'], *described['extras_require']['live']]
    packages = {re.split('[<>]', line)[0] for line in wanted}
    declared = {IMPORTED_AS.get(package, package) for package in packages}
    declared |= {depend.name for depend in parse_package(str(ROOT / 'package.xml')).exec_depends}
    assert needed - sys.stdlib_module_names - {*PACKAGES} <= declared


def test_ranges_start_at_the_oldest_versions_that_are_tested(described):
    lines = (ROOT / 'requirements/oldest.txt').read_text().splitlines()
    oldest = dict(line.split('==') for line in lines if line[0] != '#')
    lowest = dict(line.split('>=') for line in described['install_requires'])
    assert oldest.keys() == lowest.keys()
    assert {name: bound for name, bound in lowest.items()
            if not f'{oldest[name]}.'.startswith(f'{bound}.')} == {}


def test_every_pinned_version_has_the_hashes_of_its_files():
    for lock in ('lock.txt', 'fleet.txt'):
        text = (ROOT / 'requirements' / lock).read_text().replace('\\\n', '')
        pinned = [line for line in text.splitlines() if re.match(r'\w', line)]
        assert pinned and all(' --hash=sha256:' in line for line in pinned)


def test_what_is_asked_for_with_an_extra_is_locked_with_it():
    """Pip else takes the newest of it, which has no hash here: a release elsewhere ends setups."""
    locked = ''.join((ROOT / 'requirements' / lock).read_text()
                     for lock in ('lock.txt', 'fleet.txt'))
    pinned = dict(re.findall(r'^([\w.-]+)(\[.*\])?==', locked, re.MULTILINE))
    asked = [re.match(r'([\w.-]+)\[(\w+)\](?!.*extra ==)', text)
             for found in metadata.distributions() for text in found.requires or ()]
    with_extra = {(one[1].lower(), one[2]) for one in asked if one and one[1].lower() in pinned}
    assert ('coverage', 'toml') in with_extra
    assert {name for name, extra in with_extra if extra not in pinned[name]} == set()


def test_checkout_holds_config_as_resources():
    found = Path(run(sys.executable, '-c', FIND_CONFIG, cwd=ROOT).strip())
    assert tree(found) == tree(ROOT / 'config') != set()


@pytest.mark.xdist_group('wheel')
def test_wheel_holds_code_config_launch_and_index(wheel):
    with zipfile.ZipFile(wheel) as archive:
        held = set(archive.namelist())
    share = f'{wheel.name.rpartition("-py3")[0]}.data/data/share/'
    expected = {f'{share}ament_index/resource_index/packages/{NAME}',
                f'{share}{NAME}/package.xml', *(f'{package}/__init__.py' for package in PACKAGES)}
    for name in tree(ROOT / 'config'):
        expected |= {f'{share}{NAME}/config/{name}', f'hda_arm_sim/config/{name}'}
    expected |= {f'{share}{NAME}/launch/{name}' for name in tree(ROOT / 'launch')}
    for folder in ('assets', 'templates'):
        pages = f'{NAME}/pages/{folder}'
        expected |= {f'{pages}/{name}' for name in tree(ROOT / pages)}
    assert f'{NAME}/pages/assets/uplot/LICENSE' in expected
    assert expected <= held
    assert not {name for name in held if name.startswith(('test', 'config', 'launch'))}


@pytest.mark.xdist_group('wheel')
def test_wheel_runs_where_ros_looks(wheel, tmp_path):
    run(sys.executable, '-m', 'pip', 'install', '-q', '--no-deps', '--ignore-installed',
        '--prefix', tmp_path, wheel, cwd=tmp_path)
    python = next(tmp_path.glob('lib/python*/site-packages'))
    assert tree(tmp_path / 'lib' / NAME) == expected_executables().keys()
    hda = tmp_path / 'lib' / NAME / 'hda'
    assert 'usage: hda' in run(hda, '--help', cwd=tmp_path, PYTHONPATH=str(python))
    found = run(sys.executable, '-c', FIND_CONFIG, cwd=tmp_path, PYTHONPATH=str(python))
    assert Path(found.strip()) == python / 'hda_arm_sim/config'
    shown = run(sys.executable, '-c', SHOW_PAGE, cwd=tmp_path, PYTHONPATH=str(python))
    assert f'{python / NAME}' in shown and '</html>' in shown and 'uPlot' in shown


@pytest.mark.xdist_group('colcon')
def test_colcon_installs_where_ros_looks(workspace):
    install = workspace / 'install' / NAME
    assert tree(install / 'lib' / NAME) == expected_executables().keys()
    assert (install / 'share/ament_index/resource_index/packages' / NAME).is_file()
    for directory in ('config', 'launch'):
        assert tree(install / 'share' / NAME / directory) == tree(ROOT / directory)


@pytest.mark.xdist_group('colcon')
def test_colcon_installs_what_runs(workspace):
    hda = workspace / 'install' / NAME / 'lib' / NAME / 'hda'
    assert 'usage: hda' in run_inside(workspace, hda, '--help')
    found = Path(run_inside(workspace, sys.executable, '-c', FIND_CONFIG).strip())
    assert found.is_relative_to(workspace)
    assert tree(found) == tree(ROOT / 'config')


@pytest.mark.xdist_group('colcon')
@pytest.mark.parametrize('workspace', [
    pytest.param(COPIED, id='copied'),
    pytest.param(LINKED, id='linked', marks=pytest.mark.study)], indirect=True)
def test_colcon_runs_the_tests(workspace):
    run(sys.executable, '-m', 'colcon', 'test', '--return-code-on-test-failure',
        '--pytest-args', 'test/test_layering.py', '-k', 'test_packages_import', cwd=workspace)
    suite = ElementTree.parse(workspace / 'build' / NAME / 'pytest.xml').find('testsuite')
    assert int(suite.get('tests')) == len(PACKAGES)
