"""A chain as a URDF, for RViz, Foxglove and TF: frames by the names of the arm's joints."""

import math
from xml.etree import ElementTree as Tree

from hda_msgs_json.topics import BASE_FRAME, link_frame, TOOL_FRAME
import numpy as np

from .arm import Arm
from .chain_links import ChainLinks
from .urdf_bodies import onto
from ..foundation.arrays import Array
from ..foundation.chain import OFFSET, ROTATION

RADIUS = 0.03           # of what is drawn for a link: a choice [m]
_SEEN = 1e-3            # length from which on a link is drawn [m]


def chain_urdf(arm: Arm, links: ChainLinks) -> str:
    """Return the URDF of an arm with a chain: frames `base`, one of each joint, and `tool`."""
    robot = Tree.Element('robot', name='hda_arm')
    parent = Tree.SubElement(robot, 'link', name=BASE_FRAME)
    names = [(joint.label, link_frame(joint.label)) for joint in arm.joints]
    ranges = dict(zip(arm.labels, arm.ranges()))
    for row, (label, frame) in zip(links.parts[1:], [*names, ('tool_mount', TOOL_FRAME)]):
        joint = Tree.SubElement(robot, 'joint', name=label,
                                type='fixed' if frame == TOOL_FRAME else 'revolute')
        Tree.SubElement(joint, 'parent', link=parent.attrib['name'])
        Tree.SubElement(joint, 'child', link=frame)
        Tree.SubElement(joint, 'origin', xyz=_words(row[OFFSET:OFFSET + 3]),
                        rpy=_words(angles(row[ROTATION:ROTATION + 9].reshape(3, 3))))
        if frame != TOOL_FRAME:
            low, high = ranges[label]
            Tree.SubElement(joint, 'axis', xyz='0 0 1')
            Tree.SubElement(joint, 'limit', lower=f'{low:g}', upper=f'{high:g}', effort='0',
                            velocity='0')
        _draw(parent, row[OFFSET:OFFSET + 3])
        parent = Tree.SubElement(robot, 'link', name=frame)
    Tree.indent(robot)
    return Tree.tostring(robot, 'unicode', xml_declaration=True) + '\n'


def angles(rotation: Array) -> Array:
    """Return roll, pitch and yaw (3,) about fixed axes of a rotation (3, 3) [rad]."""
    (a, _, _), (b, _, _), (c, d, e) = rotation.tolist()
    level = math.hypot(a, b)
    if level > 1e-9:
        return np.array([math.atan2(d, e), math.atan2(-c, level), math.atan2(b, a)])
    return np.array([math.atan2(-rotation[1, 2], rotation[1, 1]), math.atan2(-c, level), 0.0])


def _draw(link: Tree.Element, reach: Array) -> None:
    """Have a link drawn as a bar to where the next joint is."""
    length = float(np.linalg.norm(reach))
    if length < _SEEN:
        return
    visual = Tree.SubElement(link, 'visual')
    Tree.SubElement(visual, 'origin', xyz=_words(0.5 * reach),
                    rpy=_words(angles(onto(reach / length))))
    Tree.SubElement(Tree.SubElement(visual, 'geometry'), 'cylinder', length=f'{length:g}',
                    radius=f'{RADIUS:g}')


def _words(numbers: Array) -> str:
    return ' '.join(f'{number:.10g}' for number in numbers)
