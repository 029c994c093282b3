"""
Links that stand in for those of an arm without a model, so that its gears can be simulated.

They turn about one upright axis through the base, each as heavy as the motor that moves it
appears there. Balances of links that are `led` do not depend on them (eq:balance-led).
"""

from dataclasses import replace

from hda_arm_sim.model.arm import Arm
from hda_arm_sim.model.chain_links import ChainLinks

# Numerics; choices unless stated otherwise.
_MASS = 1.0             # of each link, whose centre is on the axis: it matters to nothing [kg]


def with_stand_in(arm: Arm) -> Arm:
    """Return an arm without links (`links: none`) with such ones; another as it is."""
    if arm.links is not None:
        return arm
    links, joints, under = ['<link name="base"/>'], [], 'base'
    for joint in arm.joints:
        link, inertia = f'link of {joint.label}', joint.ratio ** 2 * joint.motor_inertia
        links.append(f'<link name="{link}"><inertial><mass value="{_MASS}"/><inertia '
                     f'ixx="{inertia}" iyy="{inertia}" izz="{inertia}" ixy="0" ixz="0" iyz="0"/>'
                     '</inertial></link>')
        joints.append(f'<joint name="{joint.label}" type="continuous"><parent link="{under}"/>'
                      f'<child link="{link}"/><axis xyz="0 0 1"/></joint>')
        under = link
    description = f'<robot name="stand_in">{"".join(links + joints)}</robot>'
    return replace(arm, links=ChainLinks(description, under, arm.labels))
