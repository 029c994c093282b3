"""The links of a serial arm from a robot description: one chain of turning joints to a tip."""

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from math import inf
from typing import NamedTuple

import numpy as np

from .link_numbers import gyration, LinkTolerance
from .urdf import Element, read_description, UrdfError
from .urdf_bodies import (body_of, Frame, joint_of, NO_BODY, onto, RigidBody, turned, TURNING,
                          UrdfJoint)
from ..foundation.arrays import Array
from ..foundation.chain import CONSTANTS, INERTIA, MASS, MOMENT, MOST, OFFSET, ROTATION

_CIRCLE = 'the links of the description hang on each other in a circle'


class Tree(NamedTuple):
    """A description: its bodies by link, and its joints by the link that each moves."""

    bodies: Mapping[str, RigidBody | None]
    joints: Mapping[str, UrdfJoint]

    def children(self, link: str) -> list[UrdfJoint]:
        """Return the joints that hang on a link."""
        return [joint for joint in self.joints.values() if joint.parent == link]


class Built(NamedTuple):
    """A chain as numbers: its rows, the links that were merged into each body, and remarks."""

    parts: Array                            # (n + 2, CONSTANTS) base, links, tip
    joints: tuple[UrdfJoint, ...]
    remarks: tuple[str, ...]


@dataclass(frozen=True)
class ChainLinks:
    """
    Links as a chain of turning joints, from the text of a robot description.

    `description` holds links and joints alone (`kept`), `tip` is the link whose frame the tip is.
    `names` are the joints of the chain from the base on. Frames without moving joints between
    them are one body. `home` are the angles where motions start [rad]. `rpy` turns the root of the
    description in the base frame, about its fixed axes [rad]. `tolerances` say how well each link
    is known, None where nobody said. Raises UrdfError.
    """

    description: str
    tip: str
    names: tuple[str, ...]
    home: tuple[float, ...] = ()
    rpy: tuple[float, float, float] = (0.0, 0.0, 0.0)
    tolerances: tuple[LinkTolerance | None, ...] = ()

    def __post_init__(self) -> None:
        """Check that there is such a chain, and that it can move."""
        if not 1 <= len(self.names) <= MOST:
            raise UrdfError(f'a chain has 1 to {MOST} joints, got {len(self.names)}')
        if self.home and len(self.home) != len(self.names):
            raise UrdfError(f'home needs {len(self.names)} angles, got {len(self.home)}')
        _ = self.built

    def known(self, usual: float) -> tuple[LinkTolerance, ...]:
        """
        Return how well each link is known; `usual` is the relative tolerance of the others.

        A link that is too heavy is so in one place more than in another. So its centre is off by
        as large a share of its radius of gyration.
        """
        stated = self.tolerances or len(self.names) * (None,)
        return tuple(one or LinkTolerance(mass=usual, inertia=usual, centre=usual * gyration(row))
                     for one, row in zip(stated, self.parts[1:]))

    @cached_property
    def built(self) -> Built:
        """Return the chain as numbers."""
        stands = Frame(turned(*self.rpy), np.zeros(3))
        return _build(_tree(read_description(self.description)), self.tip, self.names, stands)

    @property
    def ranges(self) -> Array:
        """Return how far the description lets each joint turn (n, 2), infinite if it says not."""
        return np.array([
            (joint.limits['lower'], joint.limits['upper']) if _is_bounded(joint) else (-inf, inf)
            for joint in self.built.joints])

    @property
    def last_length(self) -> float:
        """Return how long the forearm is, hand and tip with it: half of the joints' reach [m]."""
        return 0.5 * float(np.linalg.norm(self.parts[2:, OFFSET:OFFSET + 3], axis=1).sum())

    @property
    def parts(self) -> Array:
        """Return the rows of base, links and tip (n + 2, CONSTANTS), see foundation.chain."""
        return self.built.parts


def kept(text: str) -> str:
    """Return a description without what is seen and touched; raises UrdfError."""
    return read_description(text).text()


def _tree(robot: Element) -> Tree:
    """Return what hangs on what; raises UrdfError unless it is one tree."""
    links, joints = list(robot.named('link')), [joint_of(item) for item in robot.named('joint')]
    bodies = {link.label: body_of(link) for link in links}
    if not bodies:
        raise UrdfError('the description has no links')
    for kind, names in (('link', [link.label for link in links]),
                        ('joint', [joint.name for joint in joints])):
        if twice := {name for name in names if names.count(name) > 1}:
            raise UrdfError(f'two {kind}s of the description are called {min(twice)}')
    for joint in joints:
        for end in (joint.parent, joint.child):
            if end not in bodies:
                raise UrdfError(f'joint {joint.name}: the description has no link {end!r:.60}')
    moved = {joint.child: joint for joint in joints}
    if len(moved) < len(joints):
        raise UrdfError('a link of the description hangs on two joints; an arm is a tree')
    return Tree(bodies, moved)


def _path(tree: Tree, tip: str) -> list[UrdfJoint]:
    """Return the joints from the root to a link; raises UrdfError."""
    if tip not in tree.bodies:
        some = ', '.join(list(tree.bodies)[-8:])
        raise UrdfError(f'the description has no link {tip!r:.60} to be the tip; it has {some}')
    path: list[UrdfJoint] = []
    while tip in tree.joints:
        path.append(tree.joints[tip])
        tip = path[-1].parent
        if len(path) > len(tree.joints):
            raise UrdfError(_CIRCLE)
    return path[::-1]


def chain_to(text: str, tip: str) -> tuple[str, ...]:
    """Return the names of the turning joints that lead to a link; raises UrdfError."""
    return tuple(joint.name for joint in _path(_tree(read_description(text)), tip)
                 if joint.kind in TURNING)


def tips(text: str) -> list[str]:
    """
    Return the links that may be the tip, those beyond most turning joints first.

    Nothing hangs on them but what a gripper is: joints that slide or mimic others. Raises
    UrdfError where links hang on each other in a circle, if only some of them.
    """
    tree = _tree(read_description(text))
    paths = {link: _path(tree, link) for link in tree.bodies}
    found = dict.fromkeys(_held(paths[link], link) for link in tree.bodies
                          if not tree.children(link))
    inner = {joint.parent for link in found for joint in paths[link]}
    return sorted((link for link in found if link not in inner),
                  key=lambda link: -sum(joint.kind in TURNING for joint in paths[link]))


def _held(path: list[UrdfJoint], link: str) -> str:
    """Return the link on the way to another one that holds its gripper; itself if it has none."""
    for joint in reversed(path):
        if _turns(joint):
            break
        if joint.kind != 'fixed':
            link = joint.parent
    return link


def _turns(joint: UrdfJoint) -> bool:
    return joint.kind in TURNING and not joint.mimics


def _is_bounded(joint: UrdfJoint) -> bool:
    """Return whether a description says how far a joint turns; drawings state two zeros."""
    low, high = (joint.limits.get(end, 0.0) for end in ('lower', 'upper'))
    return joint.kind == 'revolute' and low < high


def _check_path(path: list[UrdfJoint], tip: str, names: tuple[str, ...]) -> None:
    """Raise UrdfError unless exactly these joints lead to the tip, in this order."""
    moving = [joint for joint in path if joint.kind != 'fixed']
    there = ', '.join(joint.name for joint in moving) or 'none'
    for joint in moving:
        if not _turns(joint):
            what = 'mimics another one' if joint.mimics else f'is {joint.kind or "of no type"}'
            raise UrdfError(f'joint {joint.name} on the way to {tip} {what}; only joints that '
                            'turn by themselves are modelled (revolute, continuous)')
        low, high = (joint.limits.get(end, 0.0) for end in ('lower', 'upper'))
        if joint.kind == 'revolute' and low > high:
            raise UrdfError(f'joint {joint.name}: its limits are reversed, lower is {low:g} rad '
                            f'and upper {high:g} rad')
    if tuple(joint.name for joint in moving) != names:
        raise UrdfError(f'the joints that lead to {tip} are {there}, got {", ".join(names)}; '
                        '"joints" under links lists them in this order, one for each joint of '
                        'the arm')


def _build(tree: Tree, tip: str, names: tuple[str, ...], frame: Frame) -> Built:
    path = _path(tree, tip)
    _check_path(path, tip, names)
    parts = np.zeros((len(names) + 2, CONSTANTS))
    parts[:, [ROTATION, ROTATION + 4, ROTATION + 8]] = 1.0
    remarks = _beside(tree, path[0].parent if path else tip, names)
    row, turning = 0, []
    for joint in path:
        frame = frame.then(joint.frame)
        if joint.kind == 'fixed':
            continue
        row += 1
        lain = Frame(onto(joint.axis), np.zeros(3))
        _set_frame(parts[row], frame.then(lain))
        frame = Frame(lain.rotation.T, np.zeros(3))         # the link's own, in that of the row
        body = _merged(tree, joint.child, frame, names, remarks)
        if not body.mass > 0.0:
            raise UrdfError(f'link {joint.child} has no inertial, nor has anything fixed to it: '
                            f'what {joint.name} turns must have a mass')
        _set_body(parts[row], body)
        turning.append(joint)
    _set_frame(parts[-1], frame)
    return Built(parts, tuple(turning), tuple(remarks))


def _beside(tree: Tree, standing: str, names: tuple[str, ...]) -> list[str]:
    """Return a line for each joint that hangs on what stands still, and is not in the chain."""
    remarks = []
    for joint in tree.children(standing):
        if joint.kind == 'fixed':
            remarks += _beside(tree, joint.child, names)
        elif joint.name not in names:
            remarks.append(f'{joint.name} ({_kind(joint)}) is not in the chain and left aside: '
                           f'it hangs on {standing}, which stands still')
    return remarks


def _kind(joint: UrdfJoint) -> str:
    return 'mimic' if joint.mimics else joint.kind


def _merged(tree: Tree, link: str, frame: Frame, names: tuple[str, ...],
            remarks: list[str]) -> RigidBody:
    """Return a link with all that hangs on it but the rest of the chain, in its row's frame."""
    body = (tree.bodies[link] or NO_BODY).seen_from(frame)
    for joint in tree.children(link):
        if joint.name in names:
            continue
        more = _merged(tree, joint.child, frame.then(joint.frame), names, remarks)
        if joint.kind != 'fixed':
            remarks.append(f'{joint.name} ({_kind(joint)}) is not in '
                           f'the chain and left aside: what hangs on it, {more.mass:.3g} kg, '
                           f'stands at its zero and moves with {link}')
        body = body.with_body(more)
    return body


def _set_frame(row: Array, frame: Frame) -> None:
    row[ROTATION:ROTATION + 9], row[OFFSET:OFFSET + 3] = frame.rotation.ravel(), frame.place


def _set_body(row: Array, body: RigidBody) -> None:
    row[MASS], row[MOMENT:MOMENT + 3] = body.mass, body.moment
    row[INERTIA:INERTIA + 6] = body.inertia[[0, 1, 2, 0, 0, 1], [0, 1, 2, 1, 2, 2]]
