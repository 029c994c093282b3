"""Run `hda` in this process on a recording, and bring rough tables into a form it imports."""

from collections.abc import Mapping
from contextlib import redirect_stderr, redirect_stdout
from io import StringIO
import json
from pathlib import Path
from typing import Any

from hda_torque_estimator.cli import main
import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Numbers = dict[str, Any]


class CommandError(RuntimeError):
    """Raised when a command ends otherwise than it should."""


def hda(*words: object) -> Numbers:
    """Return what a command says in JSON."""
    code, out, err = _run(*words, '--json')
    if code:
        raise CommandError(f'hda {words[0]}: {err}')
    said: Numbers = json.loads(out)
    return said


def refused(*words: object) -> str:
    """Return the line with which a command refuses."""
    code, _, err = _run(*words)
    if not code:
        raise CommandError(f'hda {words[0]} did not refuse')
    return err.strip()


def _run(*words: object) -> tuple[int, str, str]:
    out, err = StringIO(), StringIO()
    with redirect_stdout(out), redirect_stderr(err):
        try:
            code = main([str(word) for word in words])
        except SystemExit as wrong:             # options that argparse does not take
            code = int(wrong.code or 0)
    return code, out.getvalue(), err.getvalue()


def log_of(path: Path) -> dict[str, Floats]:
    """Return the columns of a table of numbers by their names."""
    table = np.genfromtxt(path, delimiter=',', names=True)
    return {name: table[name] for name in table.dtype.names}


def write_table(path: Path, columns: Mapping[str, Floats]) -> Path:
    """Write columns as a table that keeps every bit of them, and return its path."""
    np.savetxt(path, np.stack(list(columns.values()), axis=1), fmt='%.17g', delimiter=',',
               header=','.join(columns), comments='')
    return path


def rms(values: Floats) -> float:
    """Return the root of the mean square."""
    return float(np.sqrt(np.mean(np.square(values))))


def line(columns: Floats, aim: Floats) -> Floats:
    """Return the factors with which columns (k, p) come nearest to an aim (k,)."""
    return np.asarray(np.linalg.lstsq(columns, aim, rcond=None)[0])
