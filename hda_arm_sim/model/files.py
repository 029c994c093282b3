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
from .chain_files import CHAIN_KEYS, chain_links
from .chain_links import ChainLinks
from .documents import group, mapping, number, part, sequence
from .effects import Effect, effect_named
from .gear_defaults import as_known, defaults_sentence, sentence, unstated
from .parts import Base, Encoder, Joint, Links, Tolerances
from .torsion import TorsionLaw
from .typical_sizes import SIZED, typical
from ..foundation.parameter import ParameterError

_LOG = logging.getLogger(__name__)      # without any settings its lines go to stderr
_NAME = re.compile(r'[A-Za-z_][A-Za-z0-9_]*')       # of a part of a topic's name in ROS
_LONGEST = 100          # of the 247 that a whole name of ROS may have
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
        return _arm(mapping(document, 'the file', _PARTS), Path(source))
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
            document = mapping(document, 'the file', _PARTS).get('effects')
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


def _arm(document: dict[str, Any], source: Path) -> Arm:
    if 'joints' not in document or 'links' not in document:
        raise ArmError('an arm needs "joints" and "links" (or "links: none" for torsion only)')
    tolerances = group(Tolerances, document.get('tolerances', {}))
    joints = tuple(_joint(item, index, tolerances) for index, item in
                   enumerate(sequence(document['joints'], 'joints')))
    Arm(joints)                                     # they must fit before links are counted
    arm = Arm(joints, _links(document['links'], joints, source),
              group(Base, document.get('base', {})), (),
              tolerances, _provenance(document.get('provenance', {})))
    return replace(arm, effects=_sized(sequence(document.get('effects', []), 'effects'), arm))


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


def _joint(item: Any, index: int, tolerances: Tolerances) -> Joint:
    own = tuple(rule.name for rule in Joint.declarations())
    keys = ('name', *JOINT_PARTS, 'tolerances', *own)
    values = {key: number(value) for key, value in
              mapping(item, f'joints[{index}]', keys).items()}
    label = values.pop('name', None)
    if not isinstance(label, str) or not _is_name(label):
        raise ArmError(f'joints[{index}].name must be a name like joint1, got {label!r:.60}')
    for name, kind in JOINT_PARTS.items():
        if name in values:
            values[name] = part(kind, values[name], f'{label}.{name}')
    if 'tolerances' in values:      # what the joint does not state is the arm's
        stated = part(Tolerances, values['tolerances'], f'{label}.tolerances')
        values['tolerances'] = replace(tolerances, **{
            name: getattr(stated, name) for name in values['tolerances']})
    if (known := as_known(item, values.get('tolerances', tolerances))) is not None:
        values['tolerances'] = known
    try:
        return Joint(label=label, **values)
    except ParameterError as error:
        raise ArmError(str(error).replace('joint.', f'{label}.', 1)) from None


def _is_name(label: str) -> bool:
    """Return whether topics of ROS can have this name: ASCII, and no two underscores in a row."""
    return bool(_NAME.fullmatch(label)) and '__' not in label and len(label) <= _LONGEST


def _links(value: Any, joints: Sequence[Joint], source: Path) -> Links | ChainLinks | None:
    if value is None or value == 'none':
        return None
    given = mapping(value, 'links', (*LINK_LISTS, 'coupled', *CHAIN_KEYS))
    if any(key in given for key in CHAIN_KEYS):
        return chain_links(value, [joint.label for joint in joints], source)
    return _pair(given, len(joints))


def _pair(given: dict[str, Any], joints: int) -> Links:
    values: dict[str, Any] = {}
    counts = {'lengths': joints, 'inertia': 1 if joints == 1 else 3, 'mass_moments': joints}
    for key, names in LINK_LISTS.items():
        numbers = sequence(given.get(key, [0.0] * counts[key]), f'links.{key}')
        if len(numbers) != counts[key]:
            raise ArmError(f'links.{key} needs {counts[key]} numbers '
                           f'({", ".join(names[:counts[key]])}), got {len(numbers)}')
        values.update(zip(names, numbers))
    coupled = given.get('coupled', True)
    if not isinstance(coupled, bool):
        raise ArmError(f'links.coupled must be true or false, got {coupled!r}')
    return Links(**values, coupled=float(coupled))


def _placed(item: Any) -> Placed:
    given = mapping(item, 'an entry of effects', ('effect', 'joint', 'parameters'))
    kind = effect_named(str(given.get('effect')))
    return Placed(group(kind, given.get('parameters', {})), given.get('joint'))


def _provenance(value: Any) -> tuple[tuple[str, str], ...]:
    if not isinstance(value, dict) or not all(isinstance(text, str) for text in value.values()):
        raise ArmError('provenance must map the name of a number to a sentence on its origin')
    return tuple((str(key), text) for key, text in value.items())
