"""Mutated bags through the commands: no traceback, no hang, bounded memory, one clear line."""

from collections.abc import Iterator
from contextlib import redirect_stderr, redirect_stdout
from io import StringIO
from pathlib import Path
import random
import resource
import shutil
import signal

from bag_mutations import KINDS, mutated, write_sound
from hda_msgs_json.bag import open_recording
from hda_torque_estimator.cli import main
from hda_torque_estimator.commands import compare_command
from hypothesis import given, HealthCheck, settings, strategies as st
import pytest

LONGEST = 60                # [s], a hundred times what any of these bags should take
ROOM = 2 << 30              # [bytes], more than the commands may ask for
FUZZED = ('info', 'repair', 'estimate', 'compare')
OPTIONS = {'estimate': ['--arm', 'hda_arm.yaml', '--out', 'made'], 'repair': ['--out', 'made'],
           'compare': ['sound.mcap', '--align', 'none', '--out', 'made']}


class Hanging(Exception):
    """Raised in a command that does not come to an end."""


def _stop(*_: object) -> None:
    raise Hanging


@pytest.fixture(scope='module')
def bounds() -> Iterator[None]:
    """Bound what this process may ask for on top of what it has, and how long a command takes."""
    pages = int(Path('/proc/self/statm').read_text().split()[0])
    before = resource.getrlimit(resource.RLIMIT_AS)
    resource.setrlimit(resource.RLIMIT_AS, (
        pages * resource.getpagesize() + ROOM, before[1]))
    handler = signal.signal(signal.SIGALRM, _stop)
    yield
    signal.signal(signal.SIGALRM, handler)
    resource.setrlimit(resource.RLIMIT_AS, before)


def draw_nothing(*_: object, **__: object) -> dict[str, str]:
    """Leave out the figures of a comparison: they take longer than all the rest."""
    return {}


def run(command: str, bag: Path) -> tuple[int, str]:
    """Run a command on a bag; return its exit code and what it says on standard error."""
    shutil.rmtree('made', ignore_errors=True)
    said = StringIO()
    signal.alarm(LONGEST)
    try:
        with redirect_stdout(StringIO()), redirect_stderr(said):
            return main([command, str(bag), *OPTIONS.get(command, [])]), said.getvalue()
    finally:
        signal.alarm(0)


@pytest.mark.parametrize('kind', KINDS)
def test_sound_bags_are_taken(
        kind: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """What the mutations start from is a bag that every command takes."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(compare_command, 'figures', draw_nothing)
    write_sound(tmp_path / 'bag.mcap', kind)
    shutil.copy('bag.mcap', 'sound.mcap')
    for command in FUZZED:
        assert run(command, tmp_path / 'bag.mcap') == (0, '')


@pytest.mark.parametrize('kind', [
    'zstd', 'unchunked', *(pytest.param(kind, marks=pytest.mark.study)
                           for kind in sorted({*KINDS} - {'zstd', 'unchunked'}))])
@settings(suppress_health_check=list(HealthCheck))
@given(seed=st.integers(0, 2 ** 64 - 1))
def test_mutated_bags_give_a_result_or_one_line(
        bounds: None, kind: str, tmp_path_factory: pytest.TempPathFactory, seed: int) -> None:
    """Whatever happened to a bag, a command does its job or says in one line why it cannot."""
    place = tmp_path_factory.getbasetemp() / f'fuzz_{kind}'
    shutil.rmtree(place, ignore_errors=True)
    place.mkdir()
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(place)
        patch.setattr(compare_command, 'figures', draw_nothing)
        bag = place / 'bag.mcap'
        write_sound(place / 'sound.mcap', kind)
        content = mutated(write_sound(bag, kind), random.Random(seed))
        for command in FUZZED:
            bag.write_bytes(content)
            code, said = run(command, bag)
            assert code in (0, 2)
            assert said.count('\n') == (code == 2), said
            assert said == '' or said[:-1].isprintable()
            if command == 'repair' and code == 0:
                assert open_recording('made').warnings == []
