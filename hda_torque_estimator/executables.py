"""
The executables of the package, as light as can be: a signal ends them while they still load.

What a node needs takes a second to load, and a signal would give a traceback meanwhile.
"""

from importlib import import_module
import os
import signal
from types import FrameType

_SIGNALS = (signal.SIGINT, signal.SIGTERM)


def arm_sim() -> int:
    """Run the simulated arm, and return the exit code."""
    return _run('hda_arm_sim.main')


def torque_estimator() -> int:
    """Run the estimator, and return the exit code."""
    return _run('hda_torque_estimator.estimating.estimator_node')


def jtf_controller() -> int:
    """Run the controller, and return the exit code."""
    return _run('hda_torque_estimator.controlling.controller_node')


def bag_recorder() -> int:
    """Run the recorder, and return the exit code."""
    return _run('hda_torque_estimator.recording.recorder_node')


def bag_player() -> int:
    """Run the player, and return the exit code."""
    return _run('hda_torque_estimator.playing.player_node')


def live_view() -> int:
    """Serve the page that shows a running arm, and return the exit code."""
    return _run('hda_torque_estimator.live.live_node')


def warm_up() -> int:
    """Compile everything into the cache, and return the exit code."""
    return _run('hda_torque_estimator.warm_up')


def _run(module: str) -> int:
    for number in _SIGNALS:
        signal.signal(number, _leave)
    code: int = import_module(module).main()
    return code


def _leave(number: int, frame: FrameType | None) -> None:
    """End as if it had been asked to a moment later: nothing has begun yet."""
    os._exit(0)
