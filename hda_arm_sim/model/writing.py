"""Write arms as YAML files; reading one gives an equal arm."""

from pathlib import Path
from typing import Any

from hda_msgs_json.outputs import OutputError, whole_file
import yaml

from .arm import Arm, ArmError, Placed
from .chain_links import ChainLinks
from .files import JOINT_PARTS, LINK_LISTS
from .parts import Joint
from ..foundation.parameter import Declared


def write_arm(arm: Arm, path: str | Path, *, force: bool = False) -> None:
    """Write an arm; the file appears whole or not at all. Raises ArmError."""
    try:
        with whole_file(Path(path), force=force) as file:
            file.write(arm_to_text(arm))
    except OutputError as error:
        raise ArmError(str(error)) from None


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
    parts = {name: _values(getattr(joint, name)) for name in JOINT_PARTS}
    own = {} if joint.tolerances is None else {'tolerances': _values(joint.tolerances)}
    return {'name': joint.label, **_values(joint), **parts, **own}


def _links_document(arm: Arm) -> Any:
    if arm.links is None:
        return 'none'
    if isinstance(arm.links, ChainLinks):
        return _chain_document(arm.links)
    single = len(arm.joints) == 1
    lists = {key: [getattr(arm.links, name) for name in names][:1 if single else None]
             for key, names in LINK_LISTS.items()}
    return {**lists, 'coupled': bool(arm.links.coupled)}


def _chain_document(links: ChainLinks) -> dict[str, Any]:
    home = {'home': list(links.home)} if links.home else {}
    tolerances = {name: _values(one) for name, one in zip(links.names, links.tolerances) if one}
    return {'urdf': links.description, 'tip': links.tip, 'joints': list(links.names), **home,
            'rpy': list(links.rpy), **({'tolerances': tolerances} if tolerances else {})}


def _placed_document(placed: Placed) -> dict[str, Any]:
    place = {} if placed.joint is None else {'joint': placed.joint}
    return {'effect': placed.effect.name, **place, 'parameters': _values(placed.effect)}
