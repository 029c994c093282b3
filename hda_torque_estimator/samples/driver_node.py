"""The parameters that say how a driver names the joints, and on which topics."""

from hda_arm_sim.ros.arm_node import ArmNode

from .driver_states import Driver, DriverStates


def driver_states(node: ArmNode) -> DriverStates:
    """Return what makes joint states of those of a driver; raises DriverError."""
    link_topic, motor_topic = (node.parameters.text(name, *node.OPTIONS[name])
                               for name in ('link_topic', 'motor_topic'))
    return DriverStates(node.arm.labels, Driver(
        tuple(node.names('link')), tuple(node.names('motor')), link_topic, motor_topic))
