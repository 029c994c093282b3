"""The steps of the Dockerfile are those of the docs, in a shell's language, with what is there."""

import re
import runpy
import subprocess

from catkin_pkg.package import parse_package
from project_files import ROOT
import pytest
import setuptools

TEXT = (ROOT / 'Dockerfile').read_text()
# One instruction a line: comments left out, continued lines joined.
LINES = re.sub(r'\\\n', ' ', re.sub(r'^#.*\n', '', TEXT, flags=re.MULTILINE)).splitlines()
STEPS = [tuple(line.split(maxsplit=1)) for line in LINES if line.strip()]
DOCS = (ROOT / 'docs' / 'dependencies.md').read_text()


@pytest.fixture
def described(monkeypatch) -> dict[str, object]:
    """Return what setup.py tells setuptools."""
    arguments: dict[str, object] = {}
    monkeypatch.setattr(setuptools, 'setup', arguments.update)
    monkeypatch.chdir(ROOT)
    runpy.run_path('setup.py')
    return arguments


def ran(pattern: str) -> str:
    """Return what the first group of a pattern is in the commands that build the image."""
    return re.search(pattern, '\n'.join(words for kind, words in STEPS if kind == 'RUN'))[1]


def test_instructions_are_known_and_begin_with_the_release_of_ros():
    assert {kind for kind, _ in STEPS} == {
        'FROM', 'WORKDIR', 'COPY', 'RUN', 'ENTRYPOINT', 'CMD'}
    assert STEPS[0] == ('FROM', 'ros:jazzy-ros-base')
    assert set(re.findall(r'jazzy|humble|rolling|kilted', TEXT)) == {'jazzy'}


@pytest.mark.parametrize('words', [words for kind, words in STEPS if kind == 'RUN'])
def test_a_shell_reads_every_command(words):
    """A `;` or a pipe would hide that a command failed."""
    assert subprocess.run(['sh', '-n', '-c', words], check=False).returncode == 0
    assert not re.search(r'[;|]', words.replace('&&', ''))


def test_pip_brings_exactly_what_has_no_rosdep_key(described):
    keys = {depend.name for depend in parse_package(str(ROOT / 'package.xml')).exec_depends}
    needed = {re.split(r'[<>=!~ ]', word)[0].lower() for word in described['install_requires']}
    without = {name for name in needed if f'python3-{name.removeprefix("py")}' not in keys
               and f'python3-{name}' not in keys}
    brought = set(ran(r'pip install --no-cache-dir ([a-z0-9 ]+)').split())
    assert brought == without
    assert set(re.search(r'^pip install ([a-z0-9 ]+)$', DOCS, re.MULTILINE)[1].split()) == brought


def test_what_is_skipped_is_a_key_and_what_runs_is_an_executable(described):
    package = parse_package(str(ROOT / 'package.xml'))
    assert ran(r'--skip-keys (\w+)') in {depend.name for depend in package.exec_depends}
    assert ran(r'--packages-select (\w+)') == package.name
    scripts = {word.split(' = ')[0] for word in described['entry_points']['console_scripts']}
    started = re.findall(r'ros2",? "?run",? "?(\w+)",? "?(\w+)', TEXT)
    started += re.findall(r'ros2 run (\w+) (\w+)', TEXT)
    assert len(started) == 2
    assert {name for name, _ in started} == {package.name}
    assert {name for _, name in started} <= scripts


def test_the_image_holds_no_environment_of_this_checkout():
    """Everything that make and colcon leave behind stays out of it."""
    ignored = (ROOT / '.dockerignore').read_text().split()
    assert {'.git', '.venv*', 'build', 'install', 'log', 'out'} <= set(ignored)
    assert ('COPY', '. src/hda_torque_estimator') in STEPS
