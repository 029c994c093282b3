"""Read the links of a chain from an arm file, and the robot description that they name."""

from collections.abc import Sequence
from importlib import resources
from pathlib import Path
from typing import Any, TYPE_CHECKING

from .arm import ArmError
from .chain_links import ChainLinks, kept
from .documents import mapping, number, part, sequence
from .link_numbers import LinkTolerance
from .urdf import LARGEST, UrdfError

if TYPE_CHECKING:
    from importlib.abc import Traversable       # where Python 3.10 has it

CHAIN_MEANINGS = {
    'urdf': 'robot description: a path, seen from the arm file, or the text itself',
    'tip': 'link of the description whose frame is the tip',
    'joints': "its joints from the base to the tip; the names of the arm's joints unless given",
    'home': 'angles where motions start, one for each joint [rad]',
    'rpy': 'turns the root of the description in the base frame, about its fixed x, y and z [rad]',
    'tolerances': 'by the joint that moves it, how well a link is known'}
CHAIN_KEYS = tuple(CHAIN_MEANINGS)


def chain_links(value: Any, labels: Sequence[str], source: Path) -> ChainLinks:
    """Return the links that a mapping states of an arm with these joints; raises ArmError."""
    given = mapping(value, 'links with a URDF', CHAIN_KEYS)
    for key in CHAIN_KEYS[:2]:
        if not isinstance(given.get(key), str) or not given[key]:
            raise ArmError(f'links.{key} must be a text, got {given.get(key)!r:.60}')
    names = tuple(map(str, sequence(given.get('joints', list(labels)), 'links.joints')))
    where = 'links.urdf' if _is_inline(given['urdf']) else f'links.urdf {given["urdf"]}'
    try:
        return ChainLinks(kept(_description(given['urdf'], source)), given['tip'], names,
                          _angles(given, 'home', None), _stands(given), _known(given, names))
    except UrdfError as error:
        raise ArmError(f'{where}: {error}') from None


def _known(given: dict[str, Any], names: tuple[str, ...]) -> tuple[LinkTolerance | None, ...]:
    """Return how well each link is known, by the joint that moves it; None where none says."""
    stated = mapping(given.get('tolerances', {}), 'links.tolerances', names)
    known = {name: part(LinkTolerance, values, f'links.tolerances.{name}')
             for name, values in stated.items()}
    return tuple(map(known.get, names)) if known else ()


def _angles(given: dict[str, Any], key: str, count: int | None) -> tuple[float, ...]:
    """Return the angles of a list, of which there may have to be so many; raises ArmError."""
    numbers = list(map(number, sequence(given.get(key, [0.0] * (count or 0)), f'links.{key}')))
    if not all(isinstance(angle, (int, float)) and abs(angle) < 1e3 for angle in numbers):
        raise ArmError(f'links.{key} must be angles in rad, got {numbers!r:.60}')
    if count is not None and len(numbers) != count:
        raise ArmError(f'links.{key} needs {count} angles, got {len(numbers)}')
    return tuple(map(float, numbers))


def _stands(given: dict[str, Any]) -> tuple[float, float, float]:
    """Return how the root of the description stands in the base frame [rad]."""
    roll, pitch, yaw = _angles(given, 'rpy', 3)
    return roll, pitch, yaw


def _is_inline(urdf: str) -> bool:
    return urdf.lstrip().startswith('<')


def _description(urdf: str, source: Path) -> str:
    """Return the text of a robot description: itself, or a file beside the arm's own."""
    if _is_inline(urdf):
        return urdf
    if '://' in urdf:
        raise UrdfError('it must be a path, seen from the arm file; nothing is fetched')
    beside = source.parent / urdf
    shipped = resources.files('hda_arm_sim.config') / urdf
    place = beside if beside.exists() or source.name != str(source) else shipped
    return description_in(place, f' beside {source.name}')


def description_in(place: 'Path | Traversable', where: str = '') -> str:
    """
    Return the text of a robot description, read no further than one may be.

    Raises UrdfError for what is no file, which says `where` it was looked for.
    """
    if place.is_dir():
        raise UrdfError('it is a folder, not a file')
    if not place.is_file():
        raise UrdfError(f'no such file{where}')
    with place.open('rb') as stream:
        content = stream.read(LARGEST + 1)
    try:
        return str(content.decode())
    except UnicodeDecodeError:
        raise UrdfError('it is no text in UTF-8') from None
