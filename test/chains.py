"""Chains for tests: random ones, a pair of links in a plane as a description, and real arms."""

from dataclasses import replace

from hda_arm_sim.foundation import chain as of
from hda_arm_sim.model.arm import Arm
from hda_arm_sim.model.files import read_arm
from hda_arm_sim.model.parts import Links
from hypothesis import strategies as st
import numpy as np

AXES = ('1 0 0', '0 1 0', '0 0 1', '0 -1 0', '0.6 0 0.8')


def description(bodies: list[str], joints: list[str]) -> str:
    """Return a description of links and joints."""
    return f'<robot name="r">{"".join(bodies)}{"".join(joints)}</robot>'


def body(name: str, mass: float = 1.0, at: str = '0 0 0', inertia: str = '0.02 0.03 0.04') -> str:
    """Return a link with its principal inertias [kg*m^2]."""
    xx, yy, zz = inertia.split()
    return (f'<link name="{name}"><inertial><origin xyz="{at}"/><mass value="{mass!r}"/>'
            f'<inertia ixx="{xx}" iyy="{yy}" izz="{zz}" ixy="0" ixz="0" iyz="0"/></inertial>'
            '</link>')


def joint(name: str, parent: str, child: str, at: str = '0 0 0', rpy: str = '0 0 0',
          axis: str = '0 0 1', kind: str = 'continuous') -> str:
    """Return a joint."""
    return (f'<joint name="{name}" type="{kind}"><origin xyz="{at}" rpy="{rpy}"/>'
            f'<parent link="{parent}"/><child link="{child}"/><axis xyz="{axis}"/></joint>')


def bounded(text: str, name: str, low: float, high: float) -> str:
    """Return a description in which a joint turns from one angle to another one only [rad]."""
    head, found, tail = text.partition(f'<joint name="{name}" type="')
    assert found
    own, end, rest = tail.partition('</joint>')
    _, quote, inner = own.partition('"')
    return f'{head}{found}revolute{quote}{inner}<limit lower="{low}" upper="{high}"/>{end}{rest}'


def narrow(low: float, high: float) -> Arm:
    """Return the arm of seven joints whose fourth may turn from one angle to another only."""
    arm = read_arm('cobot7.yaml')
    head, found, tail = arm.links.description.partition('lower="-2.6" upper="2.6"')
    assert found
    text = f'{head}lower="{low}" upper="{high}"{tail}'
    return replace(arm, links=replace(arm.links, description=text, home=()))


def planar(links: Links, masses: tuple[float, float] = (10.0, 8.0)) -> str:
    """Return two links in a plane as a description with the same inertia about every joint."""
    (m1, m2), (l1, l2) = masses, (links.length1, links.length2)
    c2 = links.second / m2
    c1 = (links.first - m2 * l1) / m1
    i2 = links.p2 - m2 * c2 ** 2
    i1 = links.p1 - i2 - m1 * c1 ** 2 - m2 * (l1 ** 2 + c2 ** 2)
    return description(
        ['<link name="base"/>', body('one', m1, f'{c1!r} 0 0', f'{i1!r} {i1!r} {i1!r}'),
         body('two', m2, f'{c2!r} 0 0', f'{i2!r} {i2!r} {i2!r}'), '<link name="tip"/>'],
        [joint('joint1', 'base', 'one'), joint('joint2', 'one', 'two', f'{l1!r} 0 0'),
         joint('end', 'two', 'tip', f'{l2!r} 0 0', kind='fixed')])


def iiwa() -> str:
    """Return seven joints that stand as those of a KUKA iiwa 14 (0.36, 0.42, 0.4, 0.126 m)."""
    half = np.pi / 2.0
    steps = (
        ('0 0 0.1575', (0.0, 0.0, 0.0)), ('0 0 0.2025', (half, 0.0, np.pi)),
        ('0 0.2045 0', (half, 0.0, np.pi)), ('0 0 0.2155', (half, 0.0, 0.0)),
        ('0 0.1845 0', (-half, np.pi, 0.0)), ('0 0 0.2155', (half, 0.0, 0.0)),
        ('0 0.081 0', (-half, np.pi, 0.0)))
    names = ['base', *(f'link{k}' for k in range(1, 8))]
    return description(
        ['<link name="base"/>',
         *(body(name, 6.0 - 0.7 * k, f'0.01 {0.02 * k - 0.05:.3f} 0.06', '0.05 0.04 0.03')
           for k, name in enumerate(names[1:])), '<link name="ee"/>'],
        [*(joint(f'joint{k + 1}', names[k], names[k + 1], at, ' '.join(map(repr, rpy)))
           for k, (at, rpy) in enumerate(steps)),
         joint('end', 'link7', 'ee', '0 0 0.045', kind='fixed')])


@st.composite
def tables(draw: st.DrawFn) -> of.Array:
    """Return the table of a random chain that can be, in a random state under gravity."""
    random = np.random.default_rng(draw(st.integers(0, 2 ** 32 - 1)))
    joints = draw(st.integers(1, of.MOST))
    parts = np.zeros((joints + 2, of.CONSTANTS))
    for row in parts:
        turn = np.linalg.qr(random.normal(size=(3, 3)))[0]
        row[of.ROTATION:of.ROTATION + 9] = (turn * np.linalg.det(turn)).ravel()
        row[of.OFFSET:of.OFFSET + 3] = random.uniform(-0.5, 0.5, 3)
        points, weights = random.uniform(-0.3, 0.3, (8, 3)), random.uniform(0.05, 1.0, 8)
        inertia = sum(w * (p @ p * np.eye(3) - np.outer(p, p)) for p, w in zip(points, weights))
        row[of.MASS], row[of.MOMENT:of.MOMENT + 3] = weights.sum(), weights @ points
        row[of.INERTIA:of.INERTIA + 6] = inertia[[0, 1, 2, 0, 0, 1], [0, 1, 2, 1, 2, 2]]
    parts[0, of.DOWN:of.DOWN + 3] = random.uniform(-10.0, 10.0, 3)
    table = of.chain(parts).table
    table[1:-1, of.ANGLE:of.SPEEDING + 1] = random.uniform(-3.0, 3.0, (joints, 3))
    table[-1, of.WRENCH:of.WRENCH + 6] = random.uniform(-20.0, 20.0, 6)
    return table
