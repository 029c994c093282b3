"""The joints of a robot description and a table of their gears, for `hda new --urdf`."""

import csv
import os
from pathlib import Path
from typing import Any, NamedTuple

from hda_arm_sim.model.chain_files import description_in
from hda_arm_sim.model.chain_links import chain_to, ChainLinks, kept, tips
from hda_arm_sim.model.gear_catalogue import gear
from hda_arm_sim.model.urdf import UrdfError

from .arm_answers import ANSWERS, JointOption, NewError
from .remarks import remark_on

_OWN = ('joint', 'gear', 'ratio')
COLUMNS = tuple(dict.fromkeys((*_OWN, *(answer.name for answer in ANSWERS))))


class UrdfLinks(NamedTuple):
    """Links that a description states: its path beside the arm file, its tip, its joints."""

    urdf: str
    tip: str
    joints: tuple[str, ...]


def described(urdf: Path, tip: str | None, out: Path) -> UrdfLinks:
    """Return the chain of a description to a frame, or to its only tip; raises NewError."""
    try:
        text = description_in(urdf)
        ends = tips(text)
        far = [end for end in ends if len(chain_to(text, end)) == len(chain_to(text, ends[0]))]
        if tip is None and len(far) > 1:
            raise NewError(f'{urdf} has several tips, choose one by --tip: {", ".join(far)}')
        chosen = tip or ends[0]
        joints = chain_to(text, chosen)
        links = ChainLinks(kept(text), chosen, joints)      # what no chain can be is said now
    except UrdfError as error:
        raise NewError(f'{urdf}: {error}') from None
    except OSError as error:
        raise NewError(f'{urdf} cannot be read: {error}') from None
    for remark in links.built.remarks:
        remark_on(f'{urdf}: {remark}')
    return UrdfLinks(os.path.relpath(urdf, out.parent), chosen, joints)


def gears_of(table: Path, joints: tuple[str, ...]) -> list[dict[str, Any]]:
    """Return what a table states of each of these joints, in their order; raises NewError."""
    try:
        with table.open(encoding='utf-8-sig', newline='') as file:
            reader = csv.DictReader(file)
            given, columns = list(reader), reader.fieldnames or ()
    except (OSError, UnicodeDecodeError, csv.Error) as error:
        raise NewError(f'{table} cannot be read: {error}') from None
    if strange := [str(name) for name in columns if name not in COLUMNS]:
        raise NewError(f'{table} has columns that nobody knows: {", ".join(strange)}; known are '
                       f'{", ".join(COLUMNS)}')
    if lacking := [name for name in _OWN[:2] if name not in columns]:
        raise NewError(f'{table} lacks the columns {", ".join(lacking)}')
    names = [row['joint'] for row in given]
    if strange := [str(name) for name in names if name not in joints]:
        raise NewError(f'{table} states {", ".join(strange)}; the joints to the tip are '
                       f'{", ".join(joints)}')
    if lacking := [name for name in joints if names.count(name) != 1]:
        raise NewError(f'{table} needs one row for each of {", ".join(lacking)}')
    rows = dict(zip(names, given))
    return [_answers(table, rows[name]) for name in joints]


def _answers(table: Path, row: dict[str, Any]) -> dict[str, Any]:
    """Return the answers of one row; raises NewError or GearError."""
    where = f'{table}, {row["joint"]}'
    if None in row or None in row.values():
        raise NewError(f'{where}: the row has not as many fields as the table has columns')
    stated: dict[str, Any] = {answer.name: _number(where, answer, row.get(answer.name, ''))
                              for answer in ANSWERS}
    whole = stated['ratio'] is None or row['gear'].count('-') > 1     # as CSG-32-100
    stated['gear'] = row['gear'] if whole else f'{row["gear"]}-{stated["ratio"]:g}'
    lacking = [answer.name for answer in ANSWERS
               if answer.required and not answer.unless and stated[answer.name] is None]
    if None not in (stated['torque_constant'], stated['motor_current']):
        lacking = [name for name in lacking if name != 'motor_torque']
    if lacking:
        raise NewError(f'{where}: an arm needs {", ".join(lacking)}')
    gear(stated['gear'])
    return {'joint': row['joint']} | stated


def _number(where: str, answer: JointOption, text: str) -> float | None:
    """Return a number that an answer takes, None for an empty field; raises NewError."""
    if not text.strip():
        return None
    value = answer.read(text)
    if value is None:
        raise NewError(f'{where}: {answer.name} must be {answer.takes}, got {text!r:.60}')
    return value
