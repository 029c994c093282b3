"""
The arm as a URDF, for RViz, Foxglove and TF.

It describes how the arm looks and how its frames lie. Masses are not in it: the model file has the
numbers that matter, and those of single links cannot be known from them.
"""

from xml.etree import ElementTree as Tree

from hda_msgs_json.topics import BASE_FRAME, link_frame, TOOL_FRAME

from .arm import Arm
from .chain_description import chain_urdf
from .chain_links import ChainLinks
from .parts import Links

RADIUS = 0.025          # of what is drawn for a link: a choice [m]
SPACING = 0.3           # between joints whose place is not known: a choice [m]


def urdf(arm: Arm) -> str:
    """Return the URDF of an arm: frames `base`, one of each joint, and `tool` with links."""
    if isinstance(arm.links, ChainLinks):
        return chain_urdf(arm, arm.links)
    robot = Tree.Element('robot', name='hda_arm')
    Tree.SubElement(robot, 'link', name=BASE_FRAME)
    lengths = _lengths(arm)
    parent, distance = BASE_FRAME, 0.0
    for joint, length in zip(arm.joints, lengths):
        frame = link_frame(joint.label)
        _revolute(robot, joint.label, (parent, frame), distance, joint.angle_limit)
        _bar(Tree.SubElement(robot, 'link', name=frame), length)
        parent, distance = frame, length
        if arm.links is None:
            parent, distance = BASE_FRAME, (arm.joints.index(joint) + 1) * SPACING
    if arm.links is not None:
        Tree.SubElement(robot, 'link', name=TOOL_FRAME)
        _fixed(robot, 'tool_mount', (parent, TOOL_FRAME), distance)
    Tree.indent(robot)
    return Tree.tostring(robot, 'unicode', xml_declaration=True) + '\n'


def _lengths(arm: Arm) -> list[float]:
    """Return the length of what each joint turns [m]."""
    if not isinstance(arm.links, Links):
        return [SPACING * 0.7] * len(arm.joints)
    links = arm.moving_links()
    return [links.length1, links.length2][:len(arm.joints)]


def _revolute(robot: Tree.Element, name: str, frames: tuple[str, str], distance: float,
              limit: float) -> None:
    joint = _joint(robot, name, 'revolute', frames, distance)
    Tree.SubElement(joint, 'axis', xyz='0 0 1')
    Tree.SubElement(joint, 'limit', lower=f'{-limit:g}', upper=f'{limit:g}', effort='0',
                    velocity='0')


def _fixed(robot: Tree.Element, name: str, frames: tuple[str, str], distance: float) -> None:
    _joint(robot, name, 'fixed', frames, distance)


def _joint(robot: Tree.Element, name: str, kind: str, frames: tuple[str, str],
           distance: float) -> Tree.Element:
    """Add a joint that lies at a distance along x of its parent [m], and return it."""
    joint = Tree.SubElement(robot, 'joint', name=name, type=kind)
    Tree.SubElement(joint, 'parent', link=frames[0])
    Tree.SubElement(joint, 'child', link=frames[1])
    Tree.SubElement(joint, 'origin', xyz=f'{distance:g} 0 0', rpy='0 0 0')
    return joint


def _bar(link: Tree.Element, length: float) -> None:
    """Have a link drawn as a bar along x."""
    visual = Tree.SubElement(link, 'visual')
    Tree.SubElement(visual, 'origin', xyz=f'{length / 2:g} 0 0', rpy='0 0 0')
    Tree.SubElement(Tree.SubElement(visual, 'geometry'), 'box',
                    size=f'{length:g} {2 * RADIUS:g} {2 * RADIUS:g}')
