"""Every benchmark starts: each is run on its tiny case, and keeps what holds there as well."""

import os
from pathlib import Path
import shutil
import subprocess
import sys

from project_files import files, ROOT
import pytest

FOLDER = ROOT / 'benchmarks'
PATIENCE = 300.0        # until a tiny case has ended: nothing is measured by it [s]


def is_program(path: Path) -> bool:
    """Return whether a file of the folder is started by itself."""
    return "if __name__ == '__main__'" in path.read_text(encoding='utf-8')


def has_nodes(path: Path) -> bool:
    """Return whether a benchmark starts nodes, which go in one group with all other nodes."""
    text = path.read_text(encoding='utf-8')
    return 'from nodes import' in text or 'rclpy' in text


PROGRAMS = [path for path in files('*.py', FOLDER) if is_program(path)]
CASES = [pytest.param(path, id=path.stem,
                      marks=[pytest.mark.xdist_group('nodes')] if has_nodes(path) else [])
         for path in PROGRAMS]


def no_limit_is_broken(said: str) -> None:
    """Check that no hostile stream breaks a limit, and that every bad sample stops."""
    assert 'violations of torque, rate, angle, NaN: 0' in said
    assert ' 0 without a stop' in said


def no_fault_is_silent(said: str) -> None:
    """Check that the estimator reports every fault of its streams, and no other."""
    rows = {line.rsplit(maxsplit=4)[0]: line.split()[-4:] for line in said.splitlines()
            if line[-1:].isdigit()}
    assert int(rows['all'][0]) == 20
    assert int(rows['all'][3]) == 0
    assert '0 false alarms' in said


def no_message_is_lost(said: str) -> None:
    """Check that the recorder has heard all that it was sent."""
    assert said.startswith('recorder: 18000 messages on 6 topics in ')


PROMISED = {'controller_faults': no_limit_is_broken, 'estimator_faults': no_fault_is_silent,
            'recorder_slope': no_message_is_lost}


def contents() -> dict[Path, bytes]:
    """Return what the folders hold that a study might write to."""
    return {path: path.read_bytes() for folder in (FOLDER, ROOT / 'docs', ROOT / 'config')
            for path in files(within=folder)}


def test_benchmarks_are_found():
    assert {'bench_estimator_node', 'diagnosis', 'torque', *PROMISED} <= {
        path.stem for path in PROGRAMS}


@pytest.mark.study
@pytest.mark.parametrize('program', CASES)
def test_a_tiny_case_of_a_benchmark_runs_to_its_end(program, tmp_path):
    before = contents()
    done = subprocess.run([sys.executable, str(program), '--quick'], cwd=tmp_path,
                          capture_output=True, text=True, timeout=PATIENCE)
    assert done.returncode == 0, done.stdout + done.stderr
    assert 'Traceback' not in done.stderr
    assert done.stdout.strip()
    PROMISED.get(program.stem, str)(done.stdout)
    assert contents() == before
    assert list(tmp_path.iterdir()) == []


def make_bench(tmp_path: Path, *words: str) -> subprocess.CompletedProcess[str]:
    """Run `make bench` on two benchmarks of its own, the first of which fails."""
    for name, code in (('bad', 3), ('good', 0)):
        (tmp_path / f'{name}.py').write_text(
            f'import sys\nprint("{name}", sys.argv[1:])\nsys.exit({code})\n', encoding='utf-8')
    (tmp_path / 'ready').touch()            # nothing is set up: this interpreter has it all
    (tmp_path / 'bin').mkdir()
    (tmp_path / 'bin' / 'python').symlink_to(sys.executable)
    environment = {name: value for name, value in os.environ.items() if 'MAKE' not in name}
    return subprocess.run(
        ['make', '-C', str(ROOT), 'bench', f'READY={tmp_path}/ready', f'BIN={tmp_path}/bin',
         f'BENCHMARKS={tmp_path}/bad.py {tmp_path}/good.py', *words],
        capture_output=True, text=True, env=environment)


@pytest.mark.skipif(shutil.which('make') is None, reason='there is no make')
def test_make_bench_goes_on_and_reports_which_failed(tmp_path):
    done = make_bench(tmp_path)
    assert 'good []' in done.stdout
    assert done.returncode != 0
    failed = [line for line in done.stderr.splitlines() if line.startswith('failed: ')]
    assert failed == [f'failed: {tmp_path}/bad.py']


@pytest.mark.skipif(shutil.which('make') is None, reason='there is no make')
def test_make_bench_hands_on_that_it_is_to_be_quick(tmp_path):
    assert "good ['--quick']" in make_bench(tmp_path, 'QUICK=1').stdout


@pytest.mark.skipif(shutil.which('make') is None, reason='there is no make')
def test_make_bench_knows_every_benchmark_of_speed(tmp_path):
    ready = tmp_path / 'ready'
    ready.touch()
    listed = subprocess.run(['make', '-C', str(ROOT), '-n', 'bench', f'READY={ready}'],
                            capture_output=True, text=True).stdout
    missing = [path.name for path in PROGRAMS if path.stem.startswith('bench_')
               and f'benchmarks/{path.name}' not in listed]
    assert missing == []
