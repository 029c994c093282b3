"""What the sets of recordings share: commands run in this process, tables, and lines by hand."""

from collections.abc import Mapping, Sequence
from contextlib import redirect_stderr, redirect_stdout
from io import StringIO
import json
from pathlib import Path
from typing import Any

from hda_msgs_json.bag import open_recording
from hda_msgs_json.topics import reference_joint_torque
from hda_torque_estimator.calibrate.passages.joint_recording import Measured, measured
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


def joint_of(bag: Path, label: str) -> Measured:
    """Return one joint in a recording that has its reference torque."""
    recording = open_recording(bag)
    found = measured(bag.name, label, recording.joint_states(),
                     recording.wrenches(reference_joint_torque(label).name))
    assert found is not None
    return found


def line(columns: Floats, aim: Floats) -> Floats:
    """Return the factors with which columns (k, p) come nearest to an aim (k,)."""
    return np.asarray(np.linalg.lstsq(columns, aim, rcond=None)[0])


def missed_by_lines(tables: Sequence[Floats], aims: Sequence[Floats]) -> Floats:
    """Return what lines through columns miss of the aims, each left out in turn of their fit."""
    missed = []
    for place, (table, aim) in enumerate(zip(tables, aims)):
        others = [*range(place), *range(place + 1, len(tables))]
        factors = line(np.concatenate([tables[one] for one in others]),
                       np.concatenate([aims[one] for one in others]))
        missed.append(aim - table @ factors)
    return np.concatenate(missed)
