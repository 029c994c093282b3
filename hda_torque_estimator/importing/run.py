"""Import a table into bags: `hda import TABLE --map FILE --out BAG`, or guess its map."""

from collections.abc import Iterator, Sequence
from contextlib import ExitStack
from pathlib import Path
import re
import shutil

from hda_arm_sim.foundation.parameter import ParameterError
from hda_msgs_json.bag import BagWriter
from hda_msgs_json.nearest import did_you_mean
from hda_msgs_json.topics import JOINT_STATES, reference_joint_torque, REFERENCE_TIP_WRENCH
from hda_msgs_json.yaml_text import text_of, yaml_document, YamlError

from .column_map import ColumnMap, ColumnMapError
from .convert import convert, Imported
from .guess import guess
from .guess_text import map_text
from .map_document import read_column_map
from .maps import SHIPPED, shipped_maps
from .side_by_side import names_of, read_tables

NOT_IN_A_NAME = re.compile(r'[^\w.+-]')


def run_import(tables: Path | Sequence[Path], map_file: Path, out: Path, *,
               force: bool = False) -> list[Path]:
    """
    Write the recordings of a table, or of several side by side, as bags, and return their paths.

    A map that splits the table makes one bag for each value, OUT_VALUE, else there is OUT alone.
    All bags appear or none. Raises TableError, ColumnMapError or BagError.
    """
    paths = [tables] if isinstance(tables, Path) else [*tables]
    text = _map_text(map_file)
    try:
        column_map = read_column_map(_document(text))
        recordings = convert(column_map, read_tables(paths).columns)
        bags = dict(_named(out, column_map, recordings))
    except (ColumnMapError, ParameterError) as error:
        raise ColumnMapError(f'{map_file}: {error}') from None
    with ExitStack() as undo:
        for path, recording in bags.items():
            about = {'table': names_of(paths), 'map': text, 'split': recording.label}
            _write(path, recording, about, force)
            undo.callback(shutil.rmtree, path, ignore_errors=True)
        undo.pop_all()
    return list(bags)


def guess_map(tables: Path | Sequence[Path]) -> str:
    """Return a column map guessed from a table, or several, as text; raises TableError."""
    paths = [tables] if isinstance(tables, Path) else [*tables]
    try:
        read = read_tables(paths)
        return map_text(guess(read.columns, read.tables), names_of(paths))
    except ColumnMapError as error:
        raise ColumnMapError(f'{", ".join(map(str, paths))}: {error}') from None


def _map_text(path: Path) -> str:
    shipped = path.name == str(path) and path.name in shipped_maps() and not path.is_file()
    if not shipped and not path.is_file():
        near = did_you_mean(str(path), shipped_maps()) or ';'
        raise ColumnMapError(f'no map file {str(path)!r}{near} the shipped ones are '
                             f'{", ".join(shipped_maps())}')
    try:
        return (SHIPPED / path.name).read_text(encoding='utf-8') if shipped else text_of(path)
    except YamlError as error:
        raise ColumnMapError(str(error)) from None


def _document(text: str) -> object:
    try:
        return yaml_document(text)
    except YamlError as error:
        raise ColumnMapError(str(error)) from None


def _named(out: Path, column_map: ColumnMap,
           recordings: tuple[Imported, ...]) -> Iterator[tuple[Path, Imported]]:
    """Yield every recording with the path of its bag."""
    taken: dict[str, str] = {}
    for recording in recordings:
        ending = f'_{NOT_IN_A_NAME.sub("_", recording.label)}' if column_map.split else ''
        if ending in taken:
            raise ColumnMapError(f'split: the values {taken[ending]!r} and {recording.label!r} '
                                 f'both give the name {out.name + ending!r}')
        taken[ending] = recording.label
        yield out.with_name(out.name + ending), recording


def _write(path: Path, recording: Imported, metadata: dict[str, str], force: bool) -> None:
    with BagWriter(path, metadata, force=force) as bag:
        bag.write_joint_states(JOINT_STATES, recording.joint_states)
        for joint, wrench in recording.references.items():
            bag.write_wrenches(reference_joint_torque(joint), wrench)
        if recording.wrench is not None:
            bag.write_wrenches(REFERENCE_TIP_WRENCH, recording.wrench)
