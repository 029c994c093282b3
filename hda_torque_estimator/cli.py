"""The `hda` command: everything that works offline."""

import argparse
from collections.abc import Sequence
from importlib import import_module
import json
import os
import sys
from textwrap import fill
from types import ModuleType
import warnings

from hda_msgs_json.printable import one_line

from .commands.outcome import without_nan
from .commands.parsing import MISUSED, Parser
from .commands.progress import starting
from .commands.remarks import Remarks
from .commands.terminal import complain, show
from .error_sentences import DEBUG, OneLineErrors
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
    'live': 'a page on this machine that shows a running arm',
    'info': 'what a bag holds, and what it can and cannot show',
    'completion': 'what a shell reads to complete all words of hda',
}
HELP = 'help'           # hda help COMMAND is hda COMMAND --help
INTERRUPTED = 130
COMPLETING = '_ARGCOMPLETE'     # set by a shell that asks what may come next

_FIRST = """to begin:
  hda simulate --arm hda_arm.yaml --motion rich --duration 30 --out bag
  hda diagnose bag --arm hda_arm.yaml --out report
  hda help diagnose"""

# More threads double the processor time of matrices as small as ours, and move last bits.
THREADS = ('OPENBLAS_NUM_THREADS', 'OMP_NUM_THREADS', 'MKL_NUM_THREADS')


def main(arguments: Sequence[str] | None = None) -> int:
    """
    Run one command and return its exit code.

    It is 0 when done, 2 for wrong use or unusable input, and 3 for an alarm.
    """
    for name in THREADS:                                # before the first import of numpy
        os.environ.setdefault(name, '1')
    words = list(sys.argv[1:] if arguments is None else arguments)
    if COMPLETING in os.environ:
        words = os.environ.get('COMP_LINE', '').split()[1:]
    if words[:1] == [HELP]:
        words = [*words[1:], '--help']
    command = next((word for word in words if not word.startswith('-')), None)
    errors = OneLineErrors()
    try:
        with errors, warnings.catch_warnings(), Remarks() as remarks:
            if not os.environ.get(DEBUG):
                warnings.simplefilter('ignore')         # of libraries: they name no mistake
            return _run(command, words, remarks)
    except KeyboardInterrupt:
        print('hda: interrupted', file=sys.stderr)
        return INTERRUPTED
    complain(one_line(f'hda {command}: {errors.sentence}'), sys.stderr)
    return MISUSED


def _run(command: str | None, words: Sequence[str], remarks: Remarks) -> int:
    """Run a command and print what it found."""
    if COMPLETING in os.environ:
        _module('completion').complete(parser_of(command))
    with starting(command if command in COMMANDS else ''):
        parser = parser_of(command)
    options = parser.parse_args(words)
    if options.command is None:
        parser.print_help()
        return MISUSED
    outcome = _module(options.command).execute(options)
    remarks.show()
    try:
        if options.json:
            print(json.dumps(without_nan(outcome.report), allow_nan=False))
        else:
            show(outcome.text, outcome.report, sys.stdout)
        sys.stdout.flush()
    except OSError as error:                            # else Python tries it again at the end
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        if not isinstance(error, BrokenPipeError):
            raise
    return outcome.code


def parser_of(command: str | None) -> argparse.ArgumentParser:
    """Return the parser of all commands, with the arguments of the one that is asked for."""
    parser = Parser(prog='hda', description='Torque estimation and diagnosis for robot arms '
                                            'with harmonic drives.', epilog=_FIRST)
    parser.add_argument('--version', action='version', version=version())
    commands = parser.add_subparsers(dest='command', metavar='COMMAND', parser_class=Parser)
    for name, meaning in COMMANDS.items():
        one = commands.add_parser(name, help=meaning,
                                  description=fill(f'{meaning[0].upper()}{meaning[1:]}.'))
        if name == command:
            _module(name).configure(one)
            one.epilog = '\n  '.join(['examples:', *_module(name).EXAMPLES])
        one.add_argument('--json', action='store_true', help='print one JSON object')
    commands.add_parser(HELP, help='the options of a command, with examples: hda help COMMAND')
    return parser


def _module(name: str) -> ModuleType:
    return import_module(f'.commands.{name}_command', __package__)


if __name__ == '__main__':
    sys.exit(main())
