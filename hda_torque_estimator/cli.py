"""The `hda` command: everything that works offline."""

import argparse
from collections.abc import Sequence
from importlib import import_module
import json
import os
import sys
from types import ModuleType
from typing import NoReturn
import warnings

from hda_msgs_json.printable import one_line, printable

from .commands.outcome import without_nan
from .commands.remarks import Remarks
from .told_errors import DEBUG, ToldErrors
from .version import version

# A command's module is imported only when it is asked for, so that `hda` starts at once.
COMMANDS = {
    'new': 'an arm file from a few answers: gear by its catalogue name, motor, encoders, links',
    'simulate': 'simulate the arm to a bag',
    'estimate': 'joint torques and tip force from a bag',
    'import': 'turn a table (CSV or other text, JSON lines, Parquet, MAT, NPZ) into bags',
    'export': 'turn a bag into a table (CSV, Parquet)',
    'calibrate': 'a new model file from recordings',
    'diagnose': 'what the simulation gets wrong, why, and the extended model',
    'plan': 'a motion that separates two effects',
    'compare': 'two bags laid over each other, and how they differ',
    'reproduce': 'the figures and tables of the paper, with the numbers beside its own',
    'repair': 'make a bag that was cut off whole',
    'effects': 'the effects that an arm can have, with all their parameters',
    'info': 'what a bag holds, and what it can and cannot show',
}
DONE, MISUSED, INTERRUPTED = 0, 2, 130

# More threads double the processor time of matrices as small as ours, and move last bits.
THREADS = ('OPENBLAS_NUM_THREADS', 'OMP_NUM_THREADS', 'MKL_NUM_THREADS')


class _Parser(argparse.ArgumentParser):
    """A parser that says what is wrong in one line."""

    def error(self, message: str) -> NoReturn:
        """Print one line and leave with 2."""
        self.exit(MISUSED, one_line(f'{self.prog}: {message}; see {self.prog} --help') + '\n')


def main(arguments: Sequence[str] | None = None) -> int:
    """Run one command and return its exit code: 0 done, 2 wrong use or unusable input."""
    for name in THREADS:                                # before the first import of numpy
        os.environ.setdefault(name, '1')
    words = list(sys.argv[1:] if arguments is None else arguments)
    command = next((word for word in words if not word.startswith('-')), None)
    told = ToldErrors()
    try:
        with told, warnings.catch_warnings(), Remarks() as remarks:
            if not os.environ.get(DEBUG):
                warnings.simplefilter('ignore')         # of libraries: they name no mistake
            return _run(command, words, remarks)
    except KeyboardInterrupt:
        print('hda: interrupted', file=sys.stderr)
        return INTERRUPTED
    print(one_line(f'hda {command}: {told.sentence}'), file=sys.stderr)
    return MISUSED


def _run(command: str | None, words: Sequence[str], remarks: Remarks) -> int:
    """Run a command and print what it found."""
    parser = _parser(command)
    options = parser.parse_args(words)
    if options.command is None:
        parser.print_help()
        return MISUSED
    outcome = _module(options.command).execute(options)
    remarks.tell()
    shown = (json.dumps(without_nan(outcome.report), allow_nan=False) if options.json else
             printable(outcome.text, keep='\n'))
    try:
        print(shown, flush=True)
    except OSError as error:                            # else Python tries it again at the end
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        if not isinstance(error, BrokenPipeError):
            raise
    return DONE


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


def _module(name: str) -> ModuleType:
    return import_module(f'.commands.{name}_command', __package__)


if __name__ == '__main__':
    sys.exit(main())
