"""What every node of this project is: parameters, refusals, and a report once a second."""

import time

from hda_arm_sim.health import Refusals, Refused, Report
from hda_arm_sim.model.arm import Arm
from hda_arm_sim.model.files import read_arm
from hda_msgs_json.topics import Topic
from rclpy.node import Node

from .diagnostics import Diagnostics
from .parameters import Parameters

NOMINAL_ARM = 'hda_arm.yaml'


class StartError(ValueError):
    """What ROS was given to start with cannot be used."""


class ReportingNode(Node):
    """A node of this project; `report` and `close` are for the nodes to fill in."""

    LINGER = 0.0            # time to go on after the process is told to end [s]
    failure = ''            # why the node cannot go on, once it cannot
    finished = False        # whether the node has done all that it had to do

    def __init__(self, name: str) -> None:
        """Take the values that are given to the node; raises StartError."""
        try:
            super().__init__(name, automatically_declare_parameters_from_overrides=True)
        except ValueError:                                      # the only one, and it names none
            raise StartError('a parameter was given an empty list, which has no type; '
                             'give it a value or leave it out') from None
        self.parameters = Parameters(self)
        self.refusals = Refusals()

    def begin(self) -> None:
        """Start to report, when all parameters are declared and everything is ready."""
        if unknown := self.parameters.unknown():
            self.get_logger().warning(
                f'unknown parameters are ignored: {", ".join(unknown)}; '
                f'there are {", ".join(self.parameters.names())}')
        self.diagnostics = Diagnostics(self, self.report)

    def report(self) -> Report:
        """Return how the node is doing."""
        raise NotImplementedError

    def refuse(self, topic: Topic, refused: Refused) -> None:
        """Count a message that cannot be used, and say so now and then."""
        if self.refusals.add(refused.reason, time.monotonic()):
            self.get_logger().warning(
                f'{topic.name}: {refused} (refused so far for this reason: '
                f'{self.refusals.counts[refused.reason]})')

    def close(self) -> None:
        """Finish what must not be cut off; topics still work."""


class ArmNode(ReportingNode):
    """A node that knows an arm."""

    def __init__(self, name: str) -> None:
        """Read the arm; raises StartError, ParameterError, ArmError."""
        super().__init__(name)
        self.arm: Arm = read_arm(self.parameters.text(
            'arm', NOMINAL_ARM, 'model file, or the name of a shipped one'))
