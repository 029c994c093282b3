"""The demo does the main job, says one line, and leaves no process behind."""

import os
from pathlib import Path
import re
import subprocess
import sys

from hda_msgs_json.bag import open_recording
from project_files import ROOT
import pytest

TURNS = 3               # a machine gets that does not run a node for so long
STARVED = 'of the samples for 1 s'     # what the controller says that had no torques for so long
pytestmark = pytest.mark.xdist_group('nodes')


def demo(out: Path, *options: str) -> subprocess.CompletedProcess[str]:
    """Run the demo, and fail if one of its processes outlives it."""
    with subprocess.Popen(
            [sys.executable, str(ROOT / 'examples' / 'demo.py'), '--out', str(out), *options],
            stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
            start_new_session=True) as process:
        said, complained = process.communicate()
    with pytest.raises(ProcessLookupError):
        os.killpg(process.pid, 0)
    return subprocess.CompletedProcess([], process.returncode, said, complained)


def test_demo_shows_small_errors(tmp_path):
    for out in (tmp_path / f'demo_{turn}' for turn in range(TURNS)):
        done = demo(out, '--duration', '4')
        assert done.returncode == 0 or STARVED in done.stderr, done.stderr
        if done.returncode == 0:
            break
    assert done.returncode == 0, done.stderr
    assert len(done.stdout.splitlines()) == 1
    assert done.stdout.startswith('errors: torque [N*m] joint1 0.0')
    assert ' 0 lost; figure ' in done.stdout
    assert (out / 'demo.png').stat().st_size > 50_000
    recording = open_recording(out / 'recording')
    pushed = recording.wrenches('/truth/tip/wrench').force[:, 0]
    assert pushed.max() == pytest.approx(20.0)
    assert recording.topics['/motor_command'].count > 3000


def test_failure_is_one_line(tmp_path):
    done = demo(tmp_path / 'demo', '--arm', 'none.yaml')
    assert done.returncode == 1
    assert done.stdout == ''
    assert len(done.stderr.splitlines()) == 1
    said = re.fullmatch(r"demo: (\w+) ended early with 2: (\w+): no arm file 'none.yaml'.*\n",
                        done.stderr)
    assert said, done.stderr
    nodes = {'arm_sim', 'torque_estimator', 'jtf_controller', 'bag_recorder'}   # all read it
    assert said[1] == said[2] and said[1] in nodes
