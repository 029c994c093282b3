"""Read arms from YAML files; every mistake in a file becomes one clear sentence."""

from collections.abc import Sequence
from dataclasses import replace
from functools import cache
from importlib import resources
import logging
from pathlib import Path
import re
from typing import Any

from hda_msgs_json.nearest import did_you_mean
from hda_msgs_json.yaml_text import text_of, yaml_document, YamlError

from .arm import Arm, ArmError, Placed
from .chain_links import ChainLinks, kept
from .effects import Effect, effect_named
from .parts import Base, Encoder, Joint, Links, Tolerances
from .torsion import TorsionLaw
from .typical_sizes import SIZED, typical
from .unstated import defaults_sentence, sentence, unstated
from .urdf import LARGEST, UrdfError
from ..foundation.parameter import Declared, ParameterError

_LOG = logging.getLogger(__name__)      # without any settings its lines go to stderr
_NAME = re.compile(r'[A-Za-z_][A-Za-z0-9_]*')       # of a part of a topic's name in ROS
_LONGEST = 100          # of the 247 that a whole name of ROS may have
_CHAIN = ('urdf', 'tip', 'joints', 'home', 'rpy')
_PARTS = ('joints', 'links', 'base', 'effects', 'tolerances', 'provenance')
JOINT_PARTS = {'torsion': TorsionLaw, 'motor_encoder': Encoder, 'link_encoder': Encoder}
LINK_LISTS = {'lengths': ('length1', 'length2'), 'inertia': ('p1', 'p2', 'p3'),
              'mass_moments': ('first', 'second')}


def read_arm(path: str | Path) -> Arm:
    """
    Read an arm from a file or by the name of a shipped one; raises ArmError.

    What the file leaves open about a gear is said once, a line for each joint. One line more
    says which of its numbers are class defaults.
    """
    text = _text(Path(path))
    arm = arm_from_text(text, str(path))
    for item in _document(text, str(path))['joints']:
        if missing := unstated(item):
            _say(f'{path}: {sentence(item["name"], missing)}')
    if defaults := defaults_sentence(dict(arm.provenance)):
        _say(f'{path}: {defaults}')
    if isinstance(arm.links, ChainLinks):
        for remark in arm.links.built.remarks:
            _say(f'{path}: {remark}')
    return arm


@cache
def _say(line: str) -> None:
    _LOG.warning(line)


def arm_from_text(text: str, source: str) -> Arm:
    """Read an arm from YAML text; `source` names it in errors. Raises ArmError."""
    document = _document(text, source)
    try:
        return _arm(_mapping(document, 'the file', _PARTS), Path(source))
    except (ArmError, ParameterError) as error:
        raise ArmError(f'{source}: {error}') from None


def read_effects(path: str | Path, arm: Arm | None = None) -> tuple[Placed, ...]:
    """
    Read effects that an arm file does not have: a list as under `effects` of an arm file.

    The file is such a list, or a mapping that has one under `effects`, as an arm file. Effects
    without parameters have their typical size on `arm`. Raises ArmError.
    """
    if not Path(path).is_file():
        raise ArmError(f'no file {str(path)!r} to read effects from')
    document = _document(_text(Path(path)), str(path))
    try:
        if isinstance(document, dict):
            document = _mapping(document, 'the file', _PARTS).get('effects')
        if not isinstance(document, list):
            raise ArmError('it must be a list of effects, or have one under "effects"')
        return _sized(document, arm)
    except (ArmError, ParameterError) as error:
        raise ArmError(f'{path}: {error}') from None


def shipped_arms() -> tuple[str, ...]:
    """Return the names of the arms that come with the package."""
    folder = resources.files('hda_arm_sim.config')
    return tuple(sorted(item.name for item in folder.iterdir() if item.name.endswith('.yaml')))


def _document(text: str, source: str) -> Any:
    try:
        return yaml_document(text)
    except YamlError as error:
        raise ArmError(f'{source} is {error}') from None


def _text(path: Path) -> str:
    if path.is_file():
        try:
            return text_of(path)
        except YamlError as error:
            raise ArmError(str(error)) from None
    if path.name == str(path) and path.name in shipped_arms():
        return (resources.files('hda_arm_sim.config') / path.name).read_text(encoding='utf-8')
    near = did_you_mean(str(path), shipped_arms()) or ';'
    raise ArmError(f'no arm file {str(path)!r}{near} the shipped ones are '
                   f'{", ".join(shipped_arms())}')


def _mapping(value: Any, owner: str, allowed: tuple[str, ...]) -> dict[str, Any]:
    """Return a mapping whose keys are all allowed; raises ArmError."""
    if not isinstance(value, dict):
        raise ArmError(f'{owner} must be a mapping with {", ".join(allowed)}, got {value!r:.60}')
    for key in value:
        if key not in allowed:
            raise ArmError(f'{owner} has the unknown key {key!r}; valid keys: '
                           f'{", ".join(allowed)}')
    return value


def _sequence(value: Any, owner: str) -> list[Any]:
    if not isinstance(value, list):
        raise ArmError(f'{owner} must be a list, got {value!r:.60}')
    return value


def _arm(document: dict[str, Any], source: Path) -> Arm:
    if 'joints' not in document or 'links' not in document:
        raise ArmError('an arm needs "joints" and "links" (or "links: none" for torsion only)')
    tolerances = _group(Tolerances, document.get('tolerances', {}))
    joints = tuple(_joint(item, index, tolerances) for index, item in
                   enumerate(_sequence(document['joints'], 'joints')))
    Arm(joints)                                     # they must fit before links are counted
    arm = Arm(joints, _links(document['links'], joints, source),
              _group(Base, document.get('base', {})), (),
              tolerances, _provenance(document.get('provenance', {})))
    return replace(arm, effects=_sized(_sequence(document.get('effects', []), 'effects'), arm))


def _sized(items: Sequence[Any], arm: Arm | None) -> tuple[Placed, ...]:
    """Return the effects of a list, each once, those without parameters at a typical size."""
    listed: list[Placed] = []
    for item in items:
        placed = _placed(item)
        name, joint = placed.effect.name, placed.joint
        if (name, joint) in [(other.effect.name, other.joint) for other in listed]:
            raise ArmError(f'{name} of {joint or "the arm"} is listed twice; an effect has one '
                           'entry')
        listed.append(placed if item.get('parameters') else Placed(_typical(placed, arm), joint))
    return tuple(listed)


def _typical(placed: Placed, arm: Arm | None) -> Effect:
    """Return an effect at the size that is typical for the arm; raises ArmError if none is."""
    name = placed.effect.name
    if arm is None or name not in SIZED:
        rules = ', '.join(f'{rule.name} [{rule.unit}]' if rule.unit else rule.name
                          for rule in placed.effect.declarations())
        raise ArmError(f'{name} is listed without parameters, which is nothing; give some of: '
                       f'{rules}')
    return typical(arm, name, placed.joint)


def _group(kind: type[Declared], values: Any, owner: str = '') -> Any:
    names = tuple(rule.name for rule in kind.declarations())
    given = _mapping(values, owner or kind.name, names)
    return kind(**{key: _number(value) for key, value in given.items()})


def _number(value: Any) -> Any:
    """Return a number that YAML 1.1 takes for text (4e6) as the number that it looks like."""
    try:
        return float(value) if isinstance(value, str) else value
    except ValueError:
        return value


def _joint(item: Any, index: int, tolerances: Tolerances) -> Joint:
    own = tuple(rule.name for rule in Joint.declarations())
    keys = ('name', *JOINT_PARTS, 'tolerances', *own)
    values = {key: _number(value) for key, value in
              _mapping(item, f'joints[{index}]', keys).items()}
    label = values.pop('name', None)
    if not isinstance(label, str) or not _is_name(label):
        raise ArmError(f'joints[{index}].name must be a name like joint1, got {label!r:.60}')
    for part, kind in JOINT_PARTS.items():
        if part in values:
            values[part] = _part(kind, values[part], f'{label}.{part}')
    if 'tolerances' in values:      # what the joint does not state is the arm's
        stated = _part(Tolerances, values['tolerances'], f'{label}.tolerances')
        values['tolerances'] = replace(tolerances, **{
            name: getattr(stated, name) for name in values['tolerances']})
    try:
        return Joint(label=label, **values)
    except ParameterError as error:
        raise ArmError(str(error).replace('joint.', f'{label}.', 1)) from None


def _is_name(label: str) -> bool:
    """Tell whether topics of ROS can have this name: ASCII, and no two underscores in a row."""
    return bool(_NAME.fullmatch(label)) and '__' not in label and len(label) <= _LONGEST


def _part(kind: type[Declared], values: Any, owner: str) -> Any:
    try:
        return _group(kind, values, owner)
    except ParameterError as error:
        raise ArmError(str(error).replace(kind.name, owner, 1)) from None


def _links(value: Any, joints: Sequence[Joint], source: Path) -> Links | ChainLinks | None:
    if value is None or value == 'none':
        return None
    given = _mapping(value, 'links', (*LINK_LISTS, 'coupled', *_CHAIN))
    if not any(key in given for key in _CHAIN):
        return _pair(given, len(joints))
    given = _mapping(value, 'links with a URDF', _CHAIN)
    for key in _CHAIN[:2]:
        if not isinstance(given.get(key), str) or not given[key]:
            raise ArmError(f'links.{key} must be a text, got {given.get(key)!r:.60}')
    names = _sequence(given.get('joints', [joint.label for joint in joints]), 'links.joints')
    where = 'links.urdf' if _is_inline(given['urdf']) else f'links.urdf {given["urdf"]}'
    try:
        return ChainLinks(kept(_description(given['urdf'], source)), given['tip'],
                          tuple(map(str, names)), _angles(given, 'home', None), _stands(given))
    except UrdfError as error:
        raise ArmError(f'{where}: {error}') from None


def _angles(given: dict[str, Any], key: str, count: int | None) -> tuple[float, ...]:
    """Return the angles of a list, of which there may have to be so many; raises ArmError."""
    numbers = list(map(_number, _sequence(given.get(key, [0.0] * (count or 0)), f'links.{key}')))
    if not all(isinstance(number, (int, float)) and abs(number) < 1e3 for number in numbers):
        raise ArmError(f'links.{key} must be angles in rad, got {numbers!r:.60}')
    if count is not None and len(numbers) != count:
        raise ArmError(f'links.{key} needs {count} angles, got {len(numbers)}')
    return tuple(map(float, numbers))


def _stands(given: dict[str, Any]) -> tuple[float, float, float]:
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
    place = beside if beside.is_file() or source.name != str(source) else shipped
    if not place.is_file():
        raise UrdfError(f'no such file beside {source.name}')
    with place.open('rb') as stream:
        content = stream.read(LARGEST + 1)
    try:
        return content.decode()
    except UnicodeDecodeError:
        raise UrdfError('it is no text in UTF-8') from None


def _pair(given: dict[str, Any], joints: int) -> Links:
    values: dict[str, Any] = {}
    counts = {'lengths': joints, 'inertia': 1 if joints == 1 else 3, 'mass_moments': joints}
    for key, names in LINK_LISTS.items():
        numbers = _sequence(given.get(key, [0.0] * counts[key]), f'links.{key}')
        if len(numbers) != counts[key]:
            raise ArmError(f'links.{key} needs {counts[key]} numbers '
                           f'({", ".join(names[:counts[key]])}), got {len(numbers)}')
        values.update(zip(names, numbers))
    coupled = given.get('coupled', True)
    if not isinstance(coupled, bool):
        raise ArmError(f'links.coupled must be true or false, got {coupled!r}')
    return Links(**values, coupled=float(coupled))


def _placed(item: Any) -> Placed:
    given = _mapping(item, 'an entry of effects', ('effect', 'joint', 'parameters'))
    kind = effect_named(str(given.get('effect')))
    return Placed(_group(kind, given.get('parameters', {})), given.get('joint'))


def _provenance(value: Any) -> tuple[tuple[str, str], ...]:
    if not isinstance(value, dict) or not all(isinstance(text, str) for text in value.values()):
        raise ArmError('provenance must map the name of a number to a sentence on its origin')
    return tuple((str(key), text) for key, text in value.items())
