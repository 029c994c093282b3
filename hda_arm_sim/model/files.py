"""Read and write arms as YAML files; every mistake in a file becomes one clear sentence."""

from importlib import resources
from pathlib import Path
from typing import Any

import yaml

from .arm import Arm, ArmError, Placed
from .effects import effect_named
from .parameter import Declared, ParameterError
from .parts import Base, Encoder, Joint, Links, Tolerances
from .torsion import TorsionLaw

_PARTS = ('joints', 'links', 'base', 'effects', 'tolerances', 'provenance')
_JOINT_PARTS = {'torsion': TorsionLaw, 'motor_encoder': Encoder, 'link_encoder': Encoder}
_LINK_LISTS = {'lengths': ('length1', 'length2'), 'inertia': ('p1', 'p2', 'p3'),
               'mass_moments': ('first', 'second')}


def read_arm(path: str | Path) -> Arm:
    """Read an arm from a file or by the name of a shipped one; raises ArmError."""
    return arm_from_text(_text(Path(path)), str(path))


def arm_from_text(text: str, source: str) -> Arm:
    """Read an arm from YAML text; `source` names it in errors. Raises ArmError."""
    document = _document(text, source)
    try:
        return _arm(_mapping(document, 'the file', _PARTS))
    except (ArmError, ParameterError) as error:
        raise ArmError(f'{source}: {error}') from None


def read_effects(path: str | Path) -> tuple[Placed, ...]:
    """
    Read effects that an arm file does not have: a list as under `effects` of an arm file.

    The file is such a list, or a mapping that has one under `effects`, as an arm file. Raises
    ArmError.
    """
    if not Path(path).is_file():
        raise ArmError(f'no file {str(path)!r} to read effects from')
    document = _document(_text(Path(path)), str(path))
    try:
        if isinstance(document, dict):
            document = _mapping(document, 'the file', _PARTS).get('effects')
        if not isinstance(document, list):
            raise ArmError('it must be a list of effects, or have one under "effects"')
        return tuple(_placed(item) for item in document)
    except (ArmError, ParameterError) as error:
        raise ArmError(f'{path}: {error}') from None


def shipped_arms() -> tuple[str, ...]:
    """Return the names of the arms that come with the package."""
    folder = resources.files('hda_arm_sim.config')
    return tuple(sorted(item.name for item in folder.iterdir() if item.name.endswith('.yaml')))


def _document(text: str, source: str) -> Any:
    try:
        return yaml.safe_load(text)
    except yaml.YAMLError as error:
        where = getattr(error, 'problem_mark', None)
        line = f' at line {where.line + 1}' if where else ''
        problem = ' '.join(str(getattr(error, 'problem', error)).split())
        raise ArmError(f'{source} is not YAML{line}: {problem}') from None


def _text(path: Path) -> str:
    if path.is_file():
        try:
            return path.read_text(encoding='utf-8')
        except (OSError, UnicodeDecodeError) as error:
            raise ArmError(f'{path} cannot be read as text: {error}') from None
    if path.name == str(path) and path.name in shipped_arms():
        return (resources.files('hda_arm_sim.config') / path.name).read_text(encoding='utf-8')
    raise ArmError(f'no arm file {str(path)!r}; the shipped ones are {", ".join(shipped_arms())}')


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


def _arm(document: dict[str, Any]) -> Arm:
    if 'joints' not in document or 'links' not in document:
        raise ArmError('an arm needs "joints" and "links" (or "links: none" for torsion only)')
    joints = tuple(_joint(item, index) for index, item in
                   enumerate(_sequence(document['joints'], 'joints')))
    Arm(joints)                                     # they must fit before links are counted
    return Arm(joints, _links(document['links'], len(joints)),
               _group(Base, document.get('base', {})),
               tuple(_placed(item) for item in _sequence(document.get('effects', []), 'effects')),
               _group(Tolerances, document.get('tolerances', {})),
               _provenance(document.get('provenance', {})))


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


def _joint(item: Any, index: int) -> Joint:
    own = tuple(rule.name for rule in Joint.declarations())
    values = {key: _number(value) for key, value in
              _mapping(item, f'joints[{index}]', ('name', *_JOINT_PARTS, *own)).items()}
    label = values.pop('name', None)
    if not isinstance(label, str) or not label.isidentifier():
        raise ArmError(f'joints[{index}].name must be a name like joint1, got {label!r}')
    for part, kind in _JOINT_PARTS.items():
        if part in values:
            values[part] = _part(kind, values[part], f'{label}.{part}')
    try:
        return Joint(label=label, **values)
    except ParameterError as error:
        raise ArmError(str(error).replace('joint.', f'{label}.', 1)) from None


def _part(kind: type[Declared], values: Any, owner: str) -> Any:
    try:
        return _group(kind, values, owner)
    except ParameterError as error:
        raise ArmError(str(error).replace(kind.name, owner, 1)) from None


def _links(value: Any, joints: int) -> Links | None:
    if value is None or value == 'none':
        return None
    given = _mapping(value, 'links', (*_LINK_LISTS, 'coupled'))
    values: dict[str, Any] = {}
    counts = {'lengths': joints, 'inertia': 1 if joints == 1 else 3, 'mass_moments': joints}
    for key, names in _LINK_LISTS.items():
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


def write_arm(arm: Arm, path: str | Path) -> None:
    """Write an arm; the file appears whole or not at all. Raises ArmError."""
    target = Path(path)
    partial = target.with_name(target.name + '.partial')
    try:
        partial.write_text(arm_to_text(arm), encoding='utf-8')
        partial.replace(target)
    except OSError as error:
        partial.unlink(missing_ok=True)
        raise ArmError(f'{target} cannot be written: {error.strerror}') from None


def arm_to_text(arm: Arm) -> str:
    """Return an arm as YAML; reading it gives an equal arm."""
    document: dict[str, Any] = {
        'joints': [_joint_document(joint) for joint in arm.joints],
        'links': _links_document(arm),
        'base': _values(arm.base),
        'effects': [_placed_document(placed) for placed in arm.effects],
        'tolerances': _values(arm.tolerances)}
    if arm.provenance:
        document['provenance'] = dict(arm.provenance)
    return yaml.safe_dump(document, sort_keys=False, width=99)


def _values(group: Declared) -> dict[str, float]:
    return {rule.name: getattr(group, rule.name) for rule in group.declarations()}


def _joint_document(joint: Joint) -> dict[str, Any]:
    parts = {name: _values(getattr(joint, name)) for name in _JOINT_PARTS}
    return {'name': joint.label, **_values(joint), **parts}


def _links_document(arm: Arm) -> Any:
    if arm.links is None:
        return 'none'
    single = len(arm.joints) == 1
    lists = {key: [getattr(arm.links, name) for name in names][:1 if single else None]
             for key, names in _LINK_LISTS.items()}
    return {**lists, 'coupled': bool(arm.links.coupled)}


def _placed_document(placed: Placed) -> dict[str, Any]:
    place = {} if placed.joint is None else {'joint': placed.joint}
    return {'effect': placed.effect.name, **place, 'parameters': _values(placed.effect)}
