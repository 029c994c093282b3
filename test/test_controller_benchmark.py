"""The benchmark of hostile streams runs, and finds nothing broken."""

import subprocess
import sys

from project_files import ROOT
import pytest

pytestmark = pytest.mark.xdist_group('nodes')


def test_no_hostile_stream_breaks_a_limit_and_every_bad_sample_stops():
    done = subprocess.run([sys.executable, str(ROOT / 'benchmarks' / 'controller_faults.py'),
                           '--quick'], capture_output=True, text=True, timeout=300)
    assert done.returncode == 0, done.stdout + done.stderr
    assert 'violations of torque, rate, angle, NaN: 0' in done.stdout
    assert ' 0 without a stop' in done.stdout
