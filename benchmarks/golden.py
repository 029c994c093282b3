"""
Prove that a change of the code changed no number: write what commands find, and compare.

    golden.py BEFORE            writes what simulate, estimate, calibrate, diagnose, reproduce find
    golden.py BEFORE AFTER      compares two such folders; exit code 1 where they differ

Numbers of recordings must be equal bit by bit, all others to 1e-9. Times are left out. Run both on
one machine, with the same packages: another one moves last bits.
"""

from collections.abc import Collection, Iterator
import hashlib
import json
import math
from pathlib import Path
import subprocess
import sys
import tempfile
from typing import Any

from hda_msgs_json.bag import open_recording
import numpy as np
from size import parser, verdict

CLOSE = 1e-9            # relative, of numbers that a fit has found
TIMES = {'seconds', 'processor_time', 'elapsed', 'created', 'version', 'paths', 'path', 'report'}
ARM = ('--arm', 'hda_arm.yaml')
HIDDEN = {              # effects that are hidden in the simulated arm, and diagnosed
    'healthy': [],
    'cogging': [{'effect': 'motor_cogging', 'joint': 'joint1',
                 'parameters': {'amplitude': 0.01, 'order': 14}}],
    'backlash': [{'effect': 'backlash', 'joint': 'joint1', 'parameters': {'half_width': 1e-4}}],
    'drag_and_skew': [{'effect': 'viscous_friction', 'joint': 'joint2'},
                      {'effect': 'clock_skew', 'joint': 'joint1'}]}
TINY = ('healthy',)      # of a tiny case
# One of every site and kind of law: plain, wave, memory, drive, timing, load, the arm as a whole.
HIDDEN |= {name: [{'effect': name, 'joint': 'joint1'}] for name in (
    'viscous_friction', 'stribeck_friction', 'position_dependent_friction',
    'load_dependent_friction', 'torque_constant_error', 'current_loop_lag', 'command_delay',
    'motor_inertia_error', 'stiffness_error', 'kinematic_error', 'torsional_hysteresis',
    'wave_generator_compliance', 'link_encoder_eccentricity', 'cable_spring')}
HIDDEN |= {'payload': [{'effect': 'payload'}],
           'payload_and_lag': [{'effect': 'payload'},
                               {'effect': 'current_loop_lag', 'joint': 'joint2'}]}
SECONDS = '20'
SHORT = '8'             # of a tiny case


def hda(folder: Path, *words: str) -> Any:
    """Return the report of a command that runs in a folder."""
    done = subprocess.run([sys.executable, '-m', 'hda_torque_estimator.cli', *words, '--json'],
                          cwd=folder, capture_output=True, text=True, check=False)
    if done.returncode:
        raise SystemExit(f'golden.py: hda {" ".join(words)}: {done.stderr.strip()}')
    return json.loads(done.stdout)


def bits(bag: Path) -> dict[str, str]:
    """Return a digest of every topic of a bag."""
    recording = open_recording(bag)
    digests = {}
    for topic in recording.topics:
        times, messages = recording.raw(topic)
        content = np.ascontiguousarray(times).tobytes() + b''.join(messages)
        digests[topic] = hashlib.sha256(content).hexdigest()
    return digests


def write(folder: Path, hidden: Collection[str] = HIDDEN, seconds: str = SECONDS) -> None:
    """Write the numbers of all commands into a new folder, a file for each command."""
    folder.mkdir(parents=True)
    with tempfile.TemporaryDirectory() as name:
        for part, found in parts(Path(name), hidden, seconds):
            (folder / f'{part}.json').write_text(json.dumps(found, indent=1, sort_keys=True))
            print(folder / f'{part}.json', flush=True)


def parts(here: Path, hidden: Collection[str], seconds: str) -> Iterator[tuple[str, Any]]:
    """Yield the name of each part and what it finds in recordings of so many seconds."""
    for name in hidden:
        (here / f'{name}.yaml').write_text(json.dumps(HIDDEN[name]))
        hda(here, 'simulate', *ARM, '--effects', f'{name}.yaml', '--motion', 'rich',
            '--duration', seconds, '--seed', '4', '--out', name)
    hda(here, 'simulate', *ARM, '--motion', 'push', '--duration', seconds, '--seed', '2',
        '--out', 'pushed')
    yield 'simulate', {name: bits(here / name) for name in (*hidden, 'pushed')}
    hda(here, 'estimate', 'pushed', *ARM, '--out', 'estimates')
    yield 'estimate', bits(here / 'estimates')
    yield 'calibrate', hda(here, 'calibrate', 'healthy', 'pushed', *ARM, '--out', 'mine.yaml')
    for name in hidden:
        hda(here, 'diagnose', name, *ARM, '--out', f'found_{name}')
        yield f'diagnose_{name}', json.loads((here / f'found_{name}/report.json').read_text())
    yield 'reproduce', hda(here, 'reproduce', 'table1', 'equation_14', '--out', 'paper')


def differences(before: Any, after: Any, place: str) -> Iterator[str]:
    """Yield where two values differ by more than rounding, times aside."""
    if isinstance(before, dict) and isinstance(after, dict):
        for name in sorted((before.keys() | after.keys()) - TIMES):
            yield from differences(before.get(name), after.get(name), f'{place}.{name}')
    elif isinstance(before, list) and isinstance(after, list) and len(before) == len(after):
        for number, pair in enumerate(zip(before, after)):
            yield from differences(*pair, f'{place}[{number}]')
    elif not same(before, after):
        yield f'{place}: {before!r:.60} became {after!r:.60}'


def same(before: Any, after: Any) -> bool:
    """Return whether two single values are equal, numbers to CLOSE."""
    if type(before) in (int, float) and type(after) in (int, float):
        return math.isclose(before, after, rel_tol=CLOSE, abs_tol=0.0)
    return bool(before == after)


def compare(before: Path, after: Path) -> list[str]:
    """Return where two folders differ; a file that one lacks is a difference."""
    names = sorted({path.name for folder in (before, after) for path in folder.glob('*.json')})
    if not names:
        raise SystemExit(f'golden.py: {before} and {after} hold no numbers')
    return [line for name in names for line in differences(
        *(json.loads((folder / name).read_text()) if (folder / name).is_file() else None
          for folder in (before, after)), name.removesuffix('.json'))]


def main() -> int:
    """Write or compare, and return the exit code."""
    known = parser(__doc__)
    known.add_argument('folders', nargs='*', type=Path, metavar='FOLDER',
                       help='one to write, two to compare')
    options = known.parse_args()
    if options.quick:
        return tiny()
    if len(options.folders) == 1:
        write(options.folders[0])
        return 0
    if len(options.folders) != 2:
        known.error('give one folder to write, or two to compare')
    found = compare(*options.folders)
    print('\n'.join(found) or 'nothing differs')
    return 1 if found else 0


def tiny() -> int:
    """Write the numbers of a tiny case, and return the exit code."""
    with tempfile.TemporaryDirectory() as name:
        write(Path(name) / 'numbers', TINY, SHORT)
    return verdict('written', True, quick=True)


if __name__ == '__main__':
    sys.exit(main())
