"""The benchmark of faults in the estimator's streams runs, and finds nothing silent."""

from pathlib import Path
import subprocess
import sys

BENCHMARKS = Path(__file__).parents[1] / 'benchmarks'


def test_the_benchmark_runs_on_a_tiny_case():
    done = subprocess.run([sys.executable, 'estimator_faults.py', '--quick'], cwd=BENCHMARKS,
                          capture_output=True, text=True, check=True)
    rows = {line.rsplit(maxsplit=4)[0]: line.split()[-4:] for line in done.stdout.splitlines()
            if line[-1:].isdigit()}
    assert int(rows['all'][0]) == 20
    assert int(rows['all'][3]) == 0
    assert '0 false alarms' in done.stdout
