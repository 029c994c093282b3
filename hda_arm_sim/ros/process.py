"""
Run nodes as a process that starts, or says in one line why not, and ends when it is asked to.

The terminal and `ros2 launch` both send SIGINT, so a process is asked twice within milliseconds.
The first signal ends the spinning while topics still work, so that nodes can say their last word,
and have it arrive. What a busy listener has not taken yet ends with the process that sent it.
"""

from collections.abc import Callable, Sequence
from functools import partial
import gc
import os
import signal
import sys
import time
from types import FrameType

from hda_arm_sim.foundation.compiled import say_when_compiling
import rclpy
from rclpy.duration import Duration
from rclpy.executors import SingleThreadedExecutor
from rclpy.signals import SignalHandlerOptions
from rclpy.task import Future
from rclpy.utilities import ok, remove_ros_args, try_shutdown

from .arm_node import ReportingNode, StartError
from .node_help import ASKING, help_text
from .security import why_insecure
from .startup_signals import EarlyEnd

try:                        # a quarter of the cost; here, because messages wait for no import
    from rclpy.experimental.events_executor import EventsExecutor as QuickExecutor
except ImportError:
    QuickExecutor = SingleThreadedExecutor

# Of a spin: without an end, some releases of EventsExecutor hang; each spin loses 34 bytes [s].
LONGEST_WAIT = 0.2
LONGEST_END = 5.0       # of waiting for listeners: DDS sends again what is lost every 3 s [s]
DONE, FAILED, MISUSED = 0, 1, 2
_SIGNALS = (signal.SIGINT, signal.SIGTERM)
_OWN_PACKAGES = ('hda_msgs_json', 'hda_arm_sim', 'hda_torque_estimator')


class _Stop:
    """Take signals, and know whether one came."""

    requested = False

    def __call__(self, number: int, frame: FrameType | None) -> None:
        self.requested = True        # no more: the signal may have interrupted anything


def run(name: str, make_nodes: Callable[[], Sequence[ReportingNode]],
        arguments: Sequence[str] | None = None,
        kinds: Sequence[type[ReportingNode]] = ()) -> int:
    """
    Make nodes, spin them until SIGINT, SIGTERM or the end of their work; returns the exit code.

    It is 0 then, and 2 after one line on standard error for arguments, parameters or files that
    cannot be used. `--help` alone lists the parameters of nodes of these kinds.
    """
    given = list(sys.argv if arguments is None else arguments)
    if set(given[1:2]) & set(ASKING):
        sys.stdout.write(help_text(name, kinds))
        return DONE
    stop = _Stop()
    for number in _SIGNALS:
        signal.signal(number, stop)
    say_when_compiling(partial(_say, name))
    nodes: Sequence[ReportingNode] = ()
    code = MISUSED
    try:
        with EarlyEnd(DONE):
            _initialise(given)
            nodes = make_nodes()
        code = FAILED
        ended = _spin(name, nodes, stop)
        for node in nodes:
            node.close()
        _have_arrive(nodes)
        code = ended
    except ValueError as error:
        if type(error).__module__.partition('.')[0] not in _OWN_PACKAGES:
            raise
        _say(name, str(error))
    finally:
        _end(nodes)
    return code


def _say(name: str, said: str) -> None:
    sys.stderr.write(f'{name}: {said}\n')


def _initialise(arguments: list[str]) -> None:
    if insecure := why_insecure(os.environ):
        raise StartError(insecure)
    try:
        left = remove_ros_args(arguments)[1:]
        rclpy.init(args=arguments, signal_handler_options=SignalHandlerOptions.NO)
    except RuntimeError as error:
        raise StartError(f'the ROS arguments cannot be used: {_plain(str(error))}') from None
    if left:
        raise StartError(f'no argument {left[0]!r} is known; parameters are given as '
                         '--ros-args -p NAME:=VALUE, or --params-file FILE')


def _plain(error: str) -> str:
    """Return what rcl says of arguments in one line, without the places in its source."""
    said, _, _ = error.partition(', at /')
    return ' '.join(said.removeprefix('Failed to parse ROS arguments: ').split())


def _spin(name: str, nodes: Sequence[ReportingNode], stop: _Stop) -> int:
    """Spin until asked to end, or until a node is done or cannot go on; returns the exit code."""
    executor = QuickExecutor()
    for node in nodes:
        executor.add_node(node)
    gc.freeze()             # what is there stays: later collections need not look at it
    while ok() and not stop.requested and not any(node.failure or node.finished for node in nodes):
        executor.spin_until_future_complete(Future(), timeout_sec=LONGEST_WAIT)
    if linger := max(node.LINGER for node in nodes):
        executor.spin_until_future_complete(Future(), timeout_sec=linger)
    for node in nodes:
        executor.remove_node(node)
    failures = [node.failure for node in nodes if node.failure]
    for failure in failures:
        _say(name, failure)
    return FAILED if failures else DONE


def _have_arrive(nodes: Sequence[ReportingNode]) -> None:
    """Wait until every listener has all that the nodes sent, but not for ever."""
    end = time.monotonic() + LONGEST_END
    for node in nodes:
        for publisher in node.publishers:
            publisher.wait_for_all_acked(Duration(seconds=max(end - time.monotonic(), 0.0)))


def _end(nodes: Sequence[ReportingNode]) -> None:
    """
    Leave the graph; after LONGEST_END the process ends by SIGALRM.

    Fast DDS may spin for ever, and hold the interpreter, where another process leaves at the same
    time. All has arrived and is closed by then.
    """
    for number in _SIGNALS:
        signal.signal(number, signal.SIG_IGN)
    handler = signal.signal(signal.SIGALRM, signal.SIG_DFL)
    timer = signal.setitimer(signal.ITIMER_REAL, LONGEST_END)
    for node in nodes:
        node.destroy_node()
    try_shutdown()
    signal.setitimer(signal.ITIMER_REAL, *timer)
    signal.signal(signal.SIGALRM, handler)
