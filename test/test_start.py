"""The first start after an installation: it compiles, says so, and ends when it is asked to."""

from collections.abc import Iterator
from contextlib import contextmanager
import os
from pathlib import Path
import signal
import subprocess
import sys
import time

from hda_arm_sim.live import FIRST_STAMP, LiveArm, SimulationSettings
from hda_arm_sim.model.files import read_arm
from hda_arm_sim.model.typical_sizes import typical
from hda_arm_sim.motions import motion_of
from hda_torque_estimator import warm_up
from hda_torque_estimator.controlling.live_controller import LiveController
from hda_torque_estimator.diagnosis.balances.balance import Balancer
from hda_torque_estimator.diagnosis.diagnose import diagnose
from hda_torque_estimator.estimating.live_estimator import LiveEstimator
from hda_torque_estimator.measurements.measurement import Measurement
from hda_torque_estimator.simulating.closed_loop import run
from node_processes import PATIENCE
import numpy as np
import pytest
from test_compiled import compiled_functions

START = 'import sys; from hda_torque_estimator.executables import {0}; sys.exit({0}())'
ENDS = [(signal.SIGINT, signal.SIGINT), (signal.SIGTERM,)]
pytestmark = pytest.mark.xdist_group('nodes')


@contextmanager
def starting(name: str, folder: Path, **environment: str) -> Iterator[subprocess.Popen[str]]:
    """Have an executable start as `ros2 run` starts it, with a cache that is empty."""
    with subprocess.Popen(
            [sys.executable, '-c', START.format(name)], stderr=subprocess.PIPE, text=True,
            env={**os.environ, 'HDA_CACHE_DIR': str(folder), **environment}) as process:
        try:
            yield process
        finally:
            process.kill()


def interrupted(process: subprocess.Popen[str], *numbers: int) -> tuple[int, str]:
    """Return the exit code of a process that is asked to end, and what it said on the way."""
    for number in numbers:
        process.send_signal(number)
    return process.wait(PATIENCE), process.stderr.read()


def catches(process: subprocess.Popen[str], number: int) -> bool:
    """Return whether a process has a handler for a signal."""
    status = Path(f'/proc/{process.pid}/status').read_text()
    caught, = (line.split()[1] for line in status.splitlines() if line.startswith('SigCgt'))
    return bool(int(caught, 16) >> number - 1 & 1)


@pytest.mark.parametrize(('name', 'numbers'), zip(('torque_estimator', 'arm_sim'), ENDS))
def test_a_signal_ends_a_node_that_compiles(name, numbers, tmp_path):
    with starting(name, tmp_path) as process:
        said = process.stderr.readline()
        assert said == f'{name}: compiling, once after an installation, for a minute or two\n'
        assert interrupted(process, *numbers) == (0, '')


@pytest.mark.parametrize('name', ['jtf_controller', 'bag_recorder'])
def test_a_signal_ends_a_node_that_loads(name, tmp_path):
    with starting(name, tmp_path) as process:
        end = time.monotonic() + PATIENCE
        while not catches(process, signal.SIGTERM):
            assert time.monotonic() < end
        assert interrupted(process, signal.SIGTERM) == (0, '')


def test_a_cache_that_cannot_be_written_is_reported(tmp_path):
    file = tmp_path / 'file'
    file.touch()
    with starting('torque_estimator', file) as process:
        said = process.stderr.readline()
        assert said == (
            'torque_estimator: compiling, for a minute or two and at every start anew: '
            f'{file}/hda_torque_estimator cannot be written; HDA_CACHE_DIR can name another '
            'folder\n')
        assert interrupted(process, signal.SIGTERM) == (0, '')


@pytest.mark.parametrize('full', [False, True])
def test_laws_work_without_a_cache(tmp_path, full):
    """Neither a folder that cannot be made nor a disk that is full is needed."""
    place = tmp_path / 'file'
    place.mkdir() if full else place.touch()
    limit = 'import resource; resource.setrlimit(resource.RLIMIT_FSIZE, (0, 0))\n' if full else ''
    (tmp_path / 'own_law.py').write_text('def law(x):\n    return 2.0 * x\n')
    done = subprocess.run(
        [sys.executable, '-c', limit + 'from own_law import law\n'
         'from hda_arm_sim.foundation.compiled import compiled\nprint(compiled(law)(21.0))'],
        env={**os.environ, 'HDA_CACHE_DIR': str(place), 'PYTHONPATH': os.pathsep.join(
            [str(tmp_path), str(Path(__file__).parents[1])])}, capture_output=True, text=True)
    assert (done.stdout, done.stderr, done.returncode) == ('42.0\n', '', 0)


def test_warm_up_compiles_all_that_the_nodes_call():
    for name in warm_up.ARMS:
        warm_up.warm_up(read_arm(name))
    laws = compiled_functions()
    before = {name: set(law.signatures) for name, law in laws.items()}
    for name in ('hda_arm.yaml', 'paper_table1.yaml', 'paper_single_axis.yaml'):
        arm = read_arm(name)
        LiveEstimator(arm)
        LiveController(arm)
        live = LiveArm(arm, SimulationSettings(), FIRST_STAMP)
        live.sample()
        live.advance()
    LiveEstimator(read_arm('voraus_yucobot.yaml'))
    assert {name: set(law.signatures) - before[name] for name, law in laws.items()
            if set(law.signatures) - before[name]} == {}


def test_warm_up_compiles_all_that_a_diagnosis_calls():
    arm = read_arm('hda_arm.yaml')
    warm_up.warm_up_diagnosis(arm)
    laws = compiled_functions()
    before = {name: set(law.signatures) for name, law in laws.items()}
    made = run(arm, arm, motion_of(arm, 'rich', 12.0, 1e-3, 1), 1, estimator=None)
    measurement = Measurement(arm.labels, 1e-3, np.ascontiguousarray(made.reading[:, :, :2]),
                              made.command)
    diagnose(measurement, arm)
    bent = arm.with_effect(typical(arm, 'torsional_hysteresis', 'joint1'), 'joint1')
    assert Balancer(measurement).memory(bent).any()
    assert {name: set(law.signatures) - before[name] for name, law in laws.items()
            if set(law.signatures) - before[name]} == {}


def test_nothing_is_compiled_while_an_arm_moves():
    """A law that is compiled between two samples costs more time than a controller waits."""
    done = subprocess.run([sys.executable, '-m', 'compiled_late'], capture_output=True, text=True,
                          cwd=Path(__file__).parent)
    assert (done.stdout, done.stderr) == ('', '')


@pytest.mark.parametrize(('words', 'code', 'said'), [
    (['--help'], 0, 'usage: warm_up'), (['--now'], 2, "there are no arguments, got '--now'")])
def test_warm_up_explains_itself(words, code, said, monkeypatch, capsys):
    monkeypatch.setattr(sys, 'argv', ['warm_up', *words])
    assert warm_up.main() == code
    output = capsys.readouterr()
    assert said in output.out + output.err
    assert len(output.err.splitlines()) == (code > 0)
