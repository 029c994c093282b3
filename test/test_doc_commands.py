"""Every command of README and docs runs as it is written, in order, from a fresh clone."""

from collections.abc import Iterator
from contextlib import suppress
import json
import os
from pathlib import Path
import re
import shutil
import signal
import subprocess
import sys
from typing import NamedTuple

from hda_msgs_json.bag import open_recording
from hda_torque_estimator.reproduction.catalogue import FIGURES
import numpy as np
from project_files import files, made_by_tools, ROOT
import pytest
from ways_in import FIRST_OF_ALL, WAYS

FENCE = re.compile(r'^```([^\n]*)\n(.*?)^```$', re.MULTILINE | re.DOTALL)
COMMAND = re.compile(r'^(?:    )?(?:hda|make|ros2|pip|python3?|colcon|\.ci/run|arm_sim|bag_\w+'
                     r'|torque_estimator|jtf_controller) ', re.MULTILINE)
STARTED, NEEDS = 'sh takes minutes', 'sh needs '
WANTING = {'a ROS 2 installation', 'the recordings', 'another interpreter'}
NODES = re.compile(r'^(?:arm_sim|torque_estimator)\b.*&$', re.MULTILINE)
PATIENCE = 900.0        # with one page: nothing is measured by it [s]
LOOK = 3.0              # at what was started, before it is stopped [s]
LATE = 'demo_operator: '    # says that the loop stood still: the machine has too much to do,
TURNS = 3               # and gets these
AT_END = "trap 'kill $(jobs -p) 2> /dev/null || true' EXIT"     # a command that fails ends all


class Block(NamedTuple):
    """A fenced block of a page: what it is said to be, and its lines."""

    kind: str
    text: str


def pages() -> list[Path]:
    """Return README, CONTRIBUTING and all pages of docs."""
    return [ROOT / 'README.md', ROOT / 'CONTRIBUTING.md', *files('*.md', ROOT / 'docs')]


def blocks(page: Path) -> list[Block]:
    """Return the fenced blocks of a page."""
    return [Block(kind, text) for kind, text in FENCE.findall(page.read_text(encoding='utf-8'))]


def script(page: Path, kind: str = 'sh') -> str:
    """Return all commands of one kind of a page, in order."""
    return ''.join(block.text for block in blocks(page) if block.kind == kind)


def typed(page: Path) -> str:
    """Return the commands of a page; the demo, which test_demo.py runs, is only asked for."""
    return script(page).replace('make demo', 'make -n demo')


LONG = {'tutorial'}     # a page of many diagnoses


def marks(page: Path) -> list[pytest.MarkDecorator]:
    """Return how a page is run: with those of nodes, or by `make study`."""
    grouped = [pytest.mark.xdist_group('nodes')] if NODES.search(typed(page)) else []
    return [*grouped, pytest.mark.study] if page.stem in LONG else grouped


RUNNING = [pytest.param(page, id=page.stem, marks=marks(page)) for page in pages() if script(page)]
STARTING = [pytest.param(line, id=f'{stem}: {line}') for line, stem in {
    line: page.stem for page in pages() for line in script(page, STARTED).splitlines()}.items()]


def clone(folder: Path) -> dict[str, str]:
    """Make a folder with all that a clone has, set up, and return its environment."""
    folder.mkdir()
    for path in ROOT.iterdir():
        if path.name == 'examples':         # writes beside itself
            shutil.copytree(path, folder / path.name)
        elif not made_by_tools(path.name) or path.name == '.ci':
            (folder / path.name).symlink_to(path)
    (folder / '.venv').symlink_to(sys.prefix)
    ready = folder / 'ready'
    ready.touch()                           # nothing is installed anew: this interpreter has it
    environment = {name: value for name, value in os.environ.items() if 'MAKE' not in name}
    return {**environment, 'PYTHONPATH': str(ROOT), 'PYTHONDONTWRITEBYTECODE': '1',
            'PATH': f'{Path(sys.executable).parent}:{os.environ["PATH"]}',
            'MAKEFLAGS': f'READY={ready} BIN={Path(sys.executable).parent}'}


def run(text: str, folder: Path, environment: dict[str, str]) -> subprocess.CompletedProcess[str]:
    """Run a script as a user types it, up to the first command that fails."""
    with subprocess.Popen(['bash', '-euo', 'pipefail', '-c', f'{AT_END}\n{text}'],
                          cwd=folder, env=environment,
                          stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
                          start_new_session=True) as shell:
        try:
            said, complained = shell.communicate(timeout=PATIENCE)
        finally:
            end(shell)
    return subprocess.CompletedProcess(text, shell.returncode, said, complained)


def end(shell: subprocess.Popen[str]) -> None:
    """Stop whatever a shell has left running."""
    with suppress(ProcessLookupError):
        os.killpg(shell.pid, signal.SIGKILL)


@pytest.mark.parametrize('page', RUNNING)
def test_commands_of_a_page_run_in_order(page, tmp_path):
    for folder in (tmp_path / f'clone_{turn}' for turn in range(TURNS)):
        done = run(typed(page), folder, clone(folder))
        if LATE not in done.stderr:
            break
    assert done.returncode == 0, done.stdout + done.stderr
    assert 'Traceback' not in done.stderr
    for promised in PROMISED.get(page.stem, ()):
        promised(folder)


def finds_what_is_hidden(folder: Path) -> None:
    """Check that the diagnosis names the play of 0.2 mrad that README hides, and nothing else."""
    found, = json.loads((folder / 'diagnosis' / 'report.json').read_text())['findings']
    assert (found['effect'], found['joint']) == ('backlash', 'joint1')
    assert found['parameters']['half_width']['value'] == pytest.approx(1e-4, rel=0.1)


def moves(folder: Path) -> None:
    """Check that the arm has moved in the recording of the nodes."""
    positions = open_recording(folder / 'my_bag').joint_states().position
    assert (np.nanmax(positions, axis=0) - np.nanmin(positions, axis=0) > 0.1).all()


def differs(folder: Path) -> None:
    """Check that the two runs that are compared differ."""
    assert ' differ' in (folder / 'comparison' / 'compare.html').read_text()


PROMISED = {'README': (finds_what_is_hidden,), 'nodes': (moves,), 'recording': (moves,),
            'comparing': (differs,)}


@pytest.mark.parametrize('line', STARTING)
def test_what_takes_minutes_starts(line, tmp_path):
    folder = tmp_path / 'clone'
    environment = clone(folder)
    with subprocess.Popen(['bash', '-ec', line], cwd=folder, env=environment, text=True,
                          stdout=subprocess.PIPE, stderr=subprocess.STDOUT,
                          start_new_session=True) as started:
        with suppress(subprocess.TimeoutExpired):
            started.wait(LOOK)
        code = started.poll()
        end(started)
        said = started.stdout.read()
    assert code in (None, 0), said
    assert 'Traceback' not in said


def test_what_is_not_run_says_what_it_needs():
    needed = {block.kind.removeprefix(NEEDS) for page in pages() for block in blocks(page)
              if block.kind.startswith('sh') and block.kind not in ('sh', STARTED)}
    assert needed <= WANTING


def test_every_command_stands_in_a_block_that_is_run():
    assert [(page.name, found) for page in pages() for found in unfenced(page)] == []


def unfenced(page: Path) -> Iterator[str]:
    """Yield what looks like a command and is not in a block of the shell."""
    text = page.read_text(encoding='utf-8')
    rest = FENCE.sub('', text) + ''.join(
        block.text for block in blocks(page) if not block.kind.startswith('sh'))
    for line in rest.splitlines():
        if COMMAND.match(line) and not re.search(r'\b(?:FILE|DIR|BAG|OUT)\b', line):
            yield line


def test_figures_that_pages_name_can_be_reproduced():
    named = {name for page in pages() for words in re.findall(
        r'`hda\s+reproduce\s+([\w ]+?)\s+--out', page.read_text(encoding='utf-8'))
        for name in words.split()}
    assert named <= set(FIGURES)


def test_readme_is_short():
    assert len((ROOT / 'README.md').read_text(encoding='utf-8').split()) <= 600


def shown_lines() -> Iterator[tuple[str, str]]:
    """Yield files and the lines that CONTRIBUTING.md shows of them."""
    name = ''
    for block in blocks(ROOT / 'CONTRIBUTING.md'):
        for line in block.text.splitlines() if block.kind == 'diff' else ():
            if line.startswith('+++ b/'):
                name = line.removeprefix('+++ b/')
            else:
                yield name, line.removeprefix('+')


def test_the_worked_effect_stands_in_the_code_as_it_is_shown():
    shown = list(shown_lines())
    assert len(shown) > 20
    code = {name: (ROOT / name).read_text(encoding='utf-8').splitlines() for name, _ in shown}
    assert [(name, line) for name, line in shown if line not in code[name]] == []


GUIDES = [page for page in pages() if page.stem in (
    'README', 'commands', 'comparing', 'fleet', 'nodes', 'planning', 'recording', 'reproduction')]
WORDS = 25              # of a sentence that a non-native engineer reads once


@pytest.mark.parametrize('page', GUIDES, ids=lambda page: page.stem)
def test_sentences_of_guides_are_short(page):
    prose = FENCE.sub('\n\n', page.read_text(encoding='utf-8'))
    prose = re.sub(r'^[|#!].*$', '\n', prose, flags=re.MULTILINE)
    parts = [part for text in re.split(r'\n\n|^- ', prose, flags=re.MULTILINE)
             for part in re.split(r'(?<=[.?!])\s+', text)]
    assert [part for part in parts if len(part.split()) > WORDS] == []


LINK = re.compile(r'\]\(([^)\s]+)\)')


@pytest.mark.parametrize('page', pages(), ids=lambda page: page.stem)
def test_links_lead_somewhere(page):
    for link in LINK.findall(page.read_text(encoding='utf-8')):
        path, _, anchor = link.partition('#')
        if '://' in link:
            continue
        target = (page.parent / path).resolve() if path else page
        assert target.exists(), link
        assert not anchor or anchor in anchors(target), link


def anchors(page: Path) -> set[str]:
    """Return the anchors of a page's headings, as they are made for Markdown."""
    heads = re.findall(r'^#+ (.*)$', page.read_text(encoding='utf-8'), re.MULTILINE)
    return {re.sub(r'[^\w\- ]', '', head.lower()).replace(' ', '-') for head in heads}


@pytest.mark.parametrize('way', WAYS, ids=lambda way: way.user)
def test_the_ways_that_are_measured_stand_in_the_manual(way):
    """What `benchmarks/ways_in.py` types is what the page shows, to the letter."""
    shown = {line.partition('  # ')[0].strip()
             for line in script(ROOT / 'docs' / way.page).splitlines()}
    assert {*way.given, *way.typed} <= shown
    installed = script(ROOT / 'README.md').splitlines()
    assert list(FIRST_OF_ALL) == installed[:len(FIRST_OF_ALL)]
