"""Every example is short, is listed, and does what it says from any folder."""

import json
import os
from pathlib import Path
import subprocess
import sys

from hda_msgs_json.bag import open_recording
import numpy as np
from project_files import ROOT
import pytest

EXAMPLES = sorted((ROOT / 'examples').glob('[0-9][0-9]_*'))
MOST_LINES = 40


def finds_the_play(out: Path) -> None:
    """Check that the play of the log is named, and nothing else."""
    found, = json.loads((out / 'report' / 'report.json').read_text())['findings']
    assert (found['effect'], found['joint']) == ('backlash', 'joint1')
    assert found['parameters']['half_width']['value'] == pytest.approx(1e-4, rel=0.1)


def knows_both_devices(out: Path) -> None:
    """Check that the worn device comes first, and that the healthy one has nothing."""
    worn, new = json.loads((out / 'fleet' / 'fleet.json').read_text())['devices']
    assert (worn['device'], worn['verdict']) == ('worn', 'explained')
    assert (new['device'], new['causes']) == ('new', [])


def has(*names: str):
    """Return a check for files."""
    return lambda out: [(out / name).stat() for name in names]


def feels_the_push(out: Path) -> None:
    """Check that the wrench on the tip is the one that pushed, and that a joint shows it."""
    truth = open_recording(out / 'bag').wrenches('truth/tip/wrench')
    found = open_recording(out / 'estimates').wrenches('tip/wrench')
    force = np.stack([np.interp(found.stamps, truth.stamps, column)
                      for column in truth.force.T], axis=1)
    late = found.stamps > found.stamps[0] + 1_000_000_000
    assert np.sqrt(np.mean((found.force - force)[late] ** 2)) < 1.5
    assert np.abs(force).max() > 3.0
    assert '"contact_beyond":"joint' in open_recording(out / 'estimates').texts(
        'estimator_state').texts[-1]
    elbow = json.loads((out / 'elbow.json').read_text())['contacts']
    assert 'joint3' in {one['beyond'] for one in elbow} <= {'joint1', 'joint2', 'joint3'}


PROMISED = {'01': finds_the_play, '02': has('bag/metadata.yaml'), '03': has('torques.csv'),
            '04': finds_the_play, '05': knows_both_devices, '06': has('torques.csv', 'arm.yaml'),
            '07': has('paper.html'), '08': feels_the_push}


@pytest.mark.parametrize('example', EXAMPLES, ids=lambda example: example.stem)
def test_an_example_runs(example, tmp_path):
    (tmp_path / 'bin').mkdir()
    hda = tmp_path / 'bin' / 'hda'
    hda.write_text(f'#!/bin/sh\nexec "{sys.executable}" -m hda_torque_estimator.cli "$@"\n')
    hda.chmod(0o755)
    (tmp_path / 'bin' / 'python3').symlink_to(sys.executable)
    out = tmp_path / 'out'
    kind = [sys.executable] if example.suffix == '.py' else ['sh', '-e']
    done = subprocess.run(
        [*kind, str(example), str(out)], cwd=tmp_path, capture_output=True, text=True,
        env={**os.environ, 'PATH': f'{tmp_path / "bin"}:{os.environ["PATH"]}',
             'PYTHONPATH': os.pathsep.join([str(ROOT), *filter(None, sys.path)])})
    assert done.returncode == 0, done.stdout + done.stderr
    PROMISED[example.name[:2]](out)
    if example.name.startswith('02'):
        assert 'Explained' in done.stdout and 'hidden 0.0001 rad' in done.stdout


def test_examples_are_short_and_listed():
    listed = (ROOT / 'examples' / 'README.md').read_text()
    assert [example.name[:2] for example in EXAMPLES] == sorted(PROMISED)
    for example in EXAMPLES:
        assert example.read_text().count('\n') < MOST_LINES
        assert f'examples/{example.name}' in listed
