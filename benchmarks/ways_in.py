"""
Measure how far it is to a first report, for four users: commands, keystrokes and seconds.

Each user types what one page of the manual shows, after the installation. Keystrokes are
characters with the end of each line, without any completion. Seconds are those of a clock: first
with no compiled code at all, then as on every later day. There is no bar: others use this machine.
"""

from collections.abc import Mapping
import os
from pathlib import Path
import subprocess
import sys
import tempfile
import time
from typing import NamedTuple

from size import parser

ROOT = Path(__file__).resolve().parents[1]
SIMULATED = 'hda simulate --arm hda_arm.yaml --motion rich --duration 20 --seed {0} --out {1}'


class Way(NamedTuple):
    """What one user types after what is there already, the page that says so, and the report."""

    user: str
    page: str
    given: tuple[str, ...]
    typed: tuple[str, ...]
    report: str

    def keys(self) -> int:
        """Return the keystrokes."""
        return sum(len(line) + 1 for line in self.typed)


WAYS = (
    Way('engineer with CSV logs', 'your_robot.md',
        ('cp examples/logs/joint_log.csv.gz log.csv.gz',), (
            'hda import log.csv.gz --guess > map.yaml',
            "sed -i 's/counts_per_turn: FILL_IN/counts_per_turn: 4096/; "
            "s/torque_constant: FILL_IN/torque_constant: 0.0525/' map.yaml",
            'hda import log.csv.gz --map map.yaml --out run',
            'hda diagnose run --arm paper_single_axis.yaml --out found'), 'found/report.html'),
    Way('student', 'tutorial.md', (), (
        "printf -- '- {effect: load_dependent_friction, joint: joint2, "
        "parameters: {coefficient: 0.15}}\\n' > secret.yaml",
        'hda simulate --arm hda_arm.yaml --effects secret.yaml --motion rich --duration 30 '
        '--seed 5 --out measured',
        'hda diagnose measured --arm hda_arm.yaml --out found'), 'found/report.html'),
    Way('reader of the paper', 'reproduction.md', (), (
        'hda reproduce table1 equation_14 --out two_of_them',), 'two_of_them/paper.html'),
    Way('fleet manager', 'fleet.md', (
        SIMULATED.format(1, 'bags/left/monday'), SIMULATED.format(2, 'bags/left/tuesday')), (
        'hda diagnose --each bags/ --arm hda_arm.yaml --update --out fleet',), 'fleet/fleet.html'))
FIRST_OF_ALL = ('make setup', '. .venv/bin/activate')       # what all type before


def walked(way: Way, folder: Path, environment: Mapping[str, str]) -> float:
    """Go a way in a new folder, and return how long what is typed takes [s]."""
    folder.mkdir()
    (folder / 'examples').symlink_to(ROOT / 'examples')
    _run(way.given, folder, environment)
    began = time.monotonic()
    _run(way.typed, folder, environment)
    took = time.monotonic() - began
    if not (folder / way.report).is_file():
        raise SystemExit(f'{way.user}: there is no {way.report}')
    return took


def _run(lines: tuple[str, ...], folder: Path, environment: Mapping[str, str]) -> None:
    subprocess.run(['sh', '-e', '-c', '\n'.join(lines)], cwd=folder, env=dict(environment),
                   stdout=subprocess.DEVNULL, check=True)


def main() -> int:
    """Print a row for each user."""
    quick = parser(__doc__).parse_args().quick
    begun = sum(len(line) + 1 for line in FIRST_OF_ALL)
    print(f'before: {len(FIRST_OF_ALL)} commands, {begun} keystrokes for all users')
    print('| user | commands | keystrokes | first time [s] | later [s] |\n|---|---|---|---|---|')
    for way in WAYS[2:3] if quick else WAYS:
        with tempfile.TemporaryDirectory() as place:
            environment = {
                **os.environ, 'PATH': f'{Path(sys.executable).parent}:{os.environ["PATH"]}',
                **({} if quick else {'HDA_CACHE_DIR': f'{place}/compiled'})}
            first, later = (walked(way, Path(place) / name, environment)
                            for name in ('first', 'later'))
        print(f'| {way.user} | {len(way.typed)} | {way.keys()} | {first:.0f} | {later:.0f} |')
    return 0


if __name__ == '__main__':
    sys.exit(main())
