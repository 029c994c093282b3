"""The `hda` command: everything that works offline."""

import argparse
from collections.abc import Sequence
from importlib import import_module
import json
import os
import sys
from typing import NoReturn

from .version import version

# A command's module is imported only when it is asked for, so that `hda` starts at once.
COMMANDS = {
    'simulate': 'simulate the arm to a bag',
    'estimate': 'joint torques and tip force from a bag',
    'import': 'turn a table (CSV, Parquet, MAT, NPZ) into bags',
    'calibrate': 'a new model file from recordings',
    'diagnose': 'what the simulation gets wrong, why, and the extended model',
    'plan': 'a motion that separates two effects',
    'compare': 'two bags laid over each other, and how they differ',
    'reproduce': 'the figures and tables of the paper, with the numbers beside its own',
    'repair': 'make a bag that was cut off whole',
    'info': 'what a bag holds, and what it can and cannot show',
}
DONE, MISUSED = 0, 2
_OWN_PACKAGES = ('hda_msgs_json', 'hda_arm_sim', 'hda_torque_estimator')


class _Parser(argparse.ArgumentParser):
    """A parser that says what is wrong in one line."""

    def error(self, message: str) -> NoReturn:
        """Print one line and leave with 2."""
        self.exit(MISUSED, f'{self.prog}: {message}; see {self.prog} --help\n')


def main(arguments: Sequence[str] | None = None) -> int:
    """Run one command and return its exit code: 0 done, 2 wrong use or unusable input."""
    words = list(sys.argv[1:] if arguments is None else arguments)
    command = next((word for word in words if not word.startswith('-')), None)
    parser = _parser(command)
    options = parser.parse_args(words)
    if options.command is None:
        parser.print_help()
        return MISUSED
    return _run(options)


def _parser(command: str | None) -> argparse.ArgumentParser:
    """Return the parser of all commands, with the arguments of the one that is asked for."""
    parser = _Parser(prog='hda', description='Torque estimation and diagnosis for robot arms '
                                             'with harmonic drives.')
    parser.add_argument('--version', action='version', version=version())
    commands = parser.add_subparsers(dest='command', metavar='COMMAND', parser_class=_Parser)
    for name, meaning in COMMANDS.items():
        one = commands.add_parser(name, help=meaning, description=meaning[0].upper()
                                  + meaning[1:] + '.')
        one.add_argument('--json', action='store_true', help='print one JSON object')
        if name == command:
            _module(name).configure(one)
    return parser


def _module(name: str):                                             # type: ignore[no-untyped-def]
    return import_module(f'.commands.{name}_command', __package__)


def _run(options: argparse.Namespace) -> int:
    try:
        outcome = _module(options.command).execute(options)
        print(json.dumps(outcome.report, allow_nan=False) if options.json else outcome.text)
        sys.stdout.flush()
    except BrokenPipeError:
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
    except KeyboardInterrupt:
        print('hda: interrupted', file=sys.stderr)
        return 130
    except ValueError as error:
        if type(error).__module__.split('.')[0] not in _OWN_PACKAGES:
            raise
        print(f'hda {options.command}: {error}', file=sys.stderr)
        return MISUSED
    return DONE


if __name__ == '__main__':
    sys.exit(main())
