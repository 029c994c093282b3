"""What a diagnosis frees stays with its process, and serves the next array."""

import platform
import subprocess
import sys

from hda_torque_estimator.commands import kept_memory
import pytest

TWICE = """
import resource
import numpy as np
{first}

def new_pages():
    before = resource.getrusage(resource.RUSAGE_SELF).ru_minflt
    np.ones(2 ** 23)                    # 64 MB: more than the C library keeps by itself
    return resource.getrusage(resource.RUSAGE_SELF).ru_minflt - before

new_pages()
print(new_pages())
"""
KEPT = ('from hda_torque_estimator.commands.kept_memory import keep_freed_memory\n'
        'keep_freed_memory()')


def pages_of_the_second(first: str) -> int:
    """Return how many pages a new process needs for a second array as large as the first."""
    done = subprocess.run([sys.executable, '-c', TWICE.format(first=first)], check=True,
                          capture_output=True, text=True)
    return int(done.stdout)


@pytest.mark.skipif(platform.libc_ver()[0] != 'glibc', reason='another C library than glibc')
def test_a_second_array_takes_the_pages_of_the_first():
    assert pages_of_the_second(KEPT) < 0.2 * pages_of_the_second('')


def test_other_systems_are_left_as_they_are(monkeypatch):
    monkeypatch.setattr(kept_memory, 'CDLL', None)
    monkeypatch.setattr(kept_memory.sys, 'platform', 'darwin')
    kept_memory.keep_freed_memory()
