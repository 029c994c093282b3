"""A recorder that one click starts and another ends: a process of its own, as `ros2 run` has."""

from datetime import datetime
from pathlib import Path
import signal
import subprocess
import sys
import time
from typing import Any

from .requests import Done

PATIENCE = 10.0         # with a node that was asked to end [s]
MODULE = 'hda_torque_estimator.recording.recorder_node'


class Recorder:
    """Run the recorder at most once at a time, each bag in a new directory."""

    def __init__(self, folder: Path, arm: str) -> None:
        """Record below a folder what belongs to an arm, given as nodes are given it."""
        self._folder, self._arm = folder, arm
        self._process: subprocess.Popen[bytes] | None = None
        self._path, self._began = Path(), 0.0

    def state(self) -> dict[str, Any] | None:
        """Return what is recorded and for how long [s]; None while nothing is."""
        if self._process is None or self._process.poll() is not None:
            return None
        return {'path': str(self._path), 'seconds': time.monotonic() - self._began}

    def start(self) -> Done:
        """Begin a bag."""
        if self.state():
            return Done(False, f'already recording to {self._path}')
        self._path = self._folder / f'{datetime.now():live_%Y%m%d_%H%M%S}'
        try:
            self._folder.mkdir(parents=True, exist_ok=True)
        except OSError as error:
            return Done(False, f'{self._folder} cannot be written: {error.strerror}')
        self._process = subprocess.Popen(
            [sys.executable, '-m', MODULE, '--ros-args', '-p', f'output:={self._path}',
             '-p', f'arm:={self._arm}'])
        self._began = time.monotonic()
        return Done(True, f'recording to {self._path}')

    def stop(self) -> Done:
        """End the bag, whole."""
        process, self._process = self._process, None
        if process is None:
            return Done(False, 'nothing is being recorded')
        if code := ended(process):
            return Done(False, f'the recorder ended with {code}; `hda repair {self._path}` makes '
                               'its bag whole')
        return Done(True, f'{self._path} holds the recording')


def ended(process: subprocess.Popen[bytes]) -> int:
    """Return the exit code of a node that is asked to end, or killed if it does not."""
    if process.poll() is None:
        process.send_signal(signal.SIGINT)
    try:
        return process.wait(PATIENCE)
    except subprocess.TimeoutExpired:
        process.kill()
        return process.wait()
