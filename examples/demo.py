"""
The main job, end to end over real ROS 2, in less than a minute.

Four processes: the simulated arm, the estimator, the controller with torque feedback, and the
recorder. The arm follows a sine while its tip is pushed twice. Then `hda estimate` runs over the
recording, and its estimates are compared with what the simulator knows. The simulated arm is the
one that the model file describes, with encoders that count in whole steps: what is left is their
resolution and the filters of the estimator, not a wrong model.
"""

import argparse
from collections.abc import Iterator
from contextlib import contextmanager, ExitStack
import json
import os
from pathlib import Path
import shutil
import signal
import socket
import subprocess
import sys
import time
from typing import Any

from demo_figure import draw, Shown
from demo_operator import operate, OperatorError
from hda_torque_estimator.commands.progress import progress
from hda_torque_estimator.live.recorder import ended

ROOT = Path(__file__).resolve().parents[1]
MODULES = {
    'arm_sim': 'hda_arm_sim.main',
    'torque_estimator': 'hda_torque_estimator.estimating.estimator_node',
    'jtf_controller': 'hda_torque_estimator.controlling.controller_node',
    'bag_recorder': 'hda_torque_estimator.recording.recorder_node',
    'live_view': 'hda_torque_estimator.live.live_node',
    'hda': 'hda_torque_estimator.cli',
}
# The arm is simulated and nobody stands beside it. Where a busy machine is late, its time stands
# still, and the controller waits for much longer than the 12 ms after which it would let go.
PARAMETERS = {
    'arm_sim': ['seed:=1', 'patience:=5.0'],
    'torque_estimator': [],
    'jtf_controller': ['torque_feedback:=0.5', 'position_gain:=0.1', 'velocity_gain:=0.008',
                       'sample_timeout:=1.0'],
    'bag_recorder': [],
}
Running = tuple[str, subprocess.Popen[bytes]]


class DemoError(RuntimeError):
    """What went wrong, in one sentence."""


def main() -> int:
    """Run the demo and return its exit code."""
    options = _options()
    out: Path = options.out
    signal.signal(signal.SIGTERM, _end)
    try:
        shutil.rmtree(out, ignore_errors=True)
        out.mkdir(parents=True)
        with _domain(out), ExitStack() as nodes:
            names = [*PARAMETERS, *(['live_view'] if options.live else [])]
            running = [nodes.enter_context(_node(name, options)) for name in names]
            if options.live:
                print(_address(running[-1], out), flush=True)
            with progress(f'moving the arm for {options.duration:g} s, with two pushes at its tip',
                          quiet=False):
                operate(options.duration, lambda: _check(running, out))
        with progress('estimating over the recording', quiet=False):
            report = _estimate(options)
            shown = Shown.read(out / 'recording', out / 'estimates')
            draw(shown, out / 'demo.png')
    except (DemoError, OperatorError, OSError) as error:
        sys.stderr.write(f'demo: {error}\n')
        return 1
    except KeyboardInterrupt:
        sys.stderr.write('demo: interrupted\n')
        return 130
    print(f'{_line(report, shown)}; figure {out / "demo.png"}')
    return 0


def _options() -> argparse.Namespace:
    parser = argparse.ArgumentParser(description='The main job, end to end over real ROS 2.')
    parser.add_argument('--arm', default='hda_arm.yaml', help='model file of all nodes')
    parser.add_argument('--duration', type=float, default=10.0, help='of the motion [s]')
    parser.add_argument('--out', type=Path, default=ROOT / 'out' / 'demo',
                        help='directory that is made anew')
    parser.add_argument('--live', action='store_true', help='show the arm on a page meanwhile')
    return parser.parse_args()


def _address(view: Running, out: Path) -> str:
    """Return what the live page says of its address, as soon as it is there."""
    while 'http' not in (said := _said(view[0], out)):
        _check([view], out)
        time.sleep(0.1)
    return said


def _end(number: int, frame: object) -> None:
    """Leave as an interrupt does, so that nothing keeps running."""
    raise KeyboardInterrupt


@contextmanager
def _domain(out: Path) -> Iterator[None]:
    """Use a ROS domain that no other run has, and stay on this machine unless asked otherwise."""
    with ExitStack() as claims:
        for domain in range(1, 102):
            claim = claims.enter_context(socket.socket(socket.AF_UNIX))
            try:
                claim.bind(f'\0hda_torque_estimator/ros_domain/{domain}')
                break
            except OSError:
                continue
        else:
            raise DemoError('all ROS domains are in use by other runs on this machine')
        os.environ.update(ROS_DOMAIN_ID=str(domain), ROS_LOG_DIR=str(out / 'log'))
        os.environ.setdefault('ROS_AUTOMATIC_DISCOVERY_RANGE', 'LOCALHOST')
        os.environ.pop('ROS_LOCALHOST_ONLY', None)
        yield


def _command(name: str) -> list[str]:
    """Return how an executable is started: it stands beside python, or is a module."""
    beside = Path(sys.executable).with_name(name)
    return [str(beside)] if beside.is_file() else [sys.executable, '-m', MODULES[name]]


@contextmanager
def _node(name: str, options: argparse.Namespace) -> Iterator[Running]:
    """Run a node; at the end it is asked to stop, and must do so cleanly."""
    parameters = [*PARAMETERS.get(name, ['open:=true']), f'arm:={options.arm}']
    if name == 'bag_recorder':
        parameters.append(f'output:={options.out / "recording"}')
    words = [word for parameter in parameters for word in ('-p', parameter)]
    with (options.out / f'{name}.log').open('wb') as log:
        process = subprocess.Popen([*_command(name), '--ros-args', *words], stdout=log, stderr=log)
        clean = False
        try:
            yield name, process
            clean = True
        finally:
            code = ended(process)
    if clean and code:
        raise DemoError(f'{name} ended with {code} instead of 0: {_said(name, options.out)}')


def _check(running: list[Running], out: Path) -> None:
    """Raise DemoError if a node has ended too early."""
    for name, process in running:
        if process.poll() is not None:
            raise DemoError(f'{name} ended early with {process.returncode}: {_said(name, out)}')


def _said(name: str, out: Path) -> str:
    """Return the last line that a node said."""
    lines = (out / f'{name}.log').read_text(errors='replace').split('\n')
    return next((line for line in reversed(lines) if line.strip()), 'it said nothing')


def _estimate(options: argparse.Namespace) -> dict[str, Any]:
    """Return the report of `hda estimate` on the recording."""
    made = subprocess.run(
        [*_command('hda'), 'estimate', str(options.out / 'recording'), '--arm', options.arm,
         '--out', str(options.out / 'estimates'), '--json'], capture_output=True, text=True)
    if made.returncode:
        raise DemoError(f'hda estimate ended with {made.returncode}: {made.stderr.strip()}')
    return json.loads(made.stdout)


def _line(report: dict[str, Any], shown: Shown) -> str:
    """Return the errors in one line."""
    found = report['errors']
    torques = ', '.join(
        f'{label} {found[f"truth/{label}/torque"]["rms"]:.3f} rms '
        f'{found[f"truth/{label}/torque"]["largest"]:.3f} max' for label in shown.labels)
    forces = ', '.join(f'{axis} {found[f"truth/tip/wrench.{axis}"]["rms"]:.2f}' for axis in 'xy')
    return (f'errors: torque [N*m] {torques}; tip force [N] {forces} rms; '
            f'{len(shown.stamps)} samples, {shown.lost} lost')


if __name__ == '__main__':
    sys.exit(main())
