"""What every node of this project is: parameters, refusals, and a report once a second."""

from collections.abc import Callable, Mapping, Sequence
import sys
import time
from typing import Any, ClassVar

from hda_arm_sim.foundation.parameter import Declared
from hda_arm_sim.health import Refusals, Refused, Report
from hda_arm_sim.model.arm import Arm
from hda_arm_sim.model.files import read_arm
from hda_msgs_json.errors import HdaError
from hda_msgs_json.topics import Topic
from rclpy.node import Node

from .diagnostics import Diagnostics
from .parameter_files import missed_files
from .parameters import Parameters

NOMINAL_ARM = 'hda_arm.yaml'


class StartError(HdaError):
    """What ROS was given to start with cannot be used."""


class ReportingNode(Node):
    """A node of this project; `report` and `close` are for the nodes to fill in."""

    PURPOSE = ''            # what the node does, in one sentence
    OPTIONS: ClassVar[Mapping[str, tuple[Any, str]]] = {}     # default and meaning, by name
    GROUPS: ClassVar[Sequence[type[Declared]]] = ()           # of numbers
    LINGER = 0.0            # time to go on after the process is asked to end [s]
    hardware = ''           # what the node is about: the arm, or a recording
    failure = ''            # why the node cannot go on, once it cannot
    finished = False        # whether the node has done all that it had to do

    def __init__(self, name: str) -> None:
        """Take the values that are given to the node; raises StartError."""
        try:
            super().__init__(name, automatically_declare_parameters_from_overrides=True)
        except ValueError:                                      # the only one, and it names none
            raise StartError('a parameter was given an empty list, which has no type; '
                             'give it a value or leave it out') from None
        except RuntimeError as error:                           # of a keystore, for example
            raise StartError(f'ROS cannot make the node: {" ".join(str(error).split())}') from None
        self._usual_name = name
        self.parameters = Parameters(self)
        self.refusals = Refusals()

    def begin(self) -> None:
        """Start to report, when all parameters are declared and everything is ready."""
        if unknown := self.parameters.unknown():
            self.get_logger().warning(
                f'unknown parameters are ignored: {", ".join(unknown)}; '
                f'there are {", ".join(self.parameters.names())}')
        own = self.get_fully_qualified_name()
        for file, names in missed_files(sys.argv, own):
            self.get_logger().warning(
                f'{file} has parameters of {", ".join(names)}, not of {own}: in a namespace the '
                f'name must be that one, or /**/{self.get_name()}')
        self.diagnostics = Diagnostics(self, self.report, self.hardware)

    def report(self) -> Report:
        """Return how the node is doing."""
        raise NotImplementedError

    def names(self, option: str) -> list[str]:
        """Declare an option that is a list of names, and return those given."""
        return [each for each in self.parameters.texts(option, *self.OPTIONS[option]) if each]

    def serve(self, kind: type, name: str, answer: Callable[[Any, Any], Any]) -> None:
        """Offer a service below the usual name of the node, and below the one it was given."""
        self.create_service(kind, f'{self._usual_name}/{name}', answer)
        if self.get_name() != self._usual_name:
            self.create_service(kind, f'~/{name}', answer)

    def refuse(self, topic: Topic, refused: Refused) -> None:
        """Count a message that cannot be used, and say so now and then."""
        if self.refusals.add(refused.reason, time.monotonic()):
            self.say_refused(topic, refused)

    def say_refused(self, topic: Topic, refused: Refused) -> None:
        """Say that a message cannot be used, and how many there were."""
        self.get_logger().warning(
            f'{topic.name}: {refused} (refused so far for this reason: '
            f'{self.refusals.counts[refused.reason]})')

    def close(self) -> None:
        """Finish what must not be cut off; topics still work."""


class ArmNode(ReportingNode):
    """A node that knows an arm."""

    OPTIONS: ClassVar[Mapping[str, tuple[Any, str]]] = {
        'arm': (NOMINAL_ARM, 'model file, or the name of a shipped one')}

    def __init__(self, name: str) -> None:
        """Read the arm; raises StartError, ParameterError, ArmError."""
        super().__init__(name)
        self.hardware = self.parameters.text('arm', *self.OPTIONS['arm'])
        self.arm: Arm = read_arm(self.hardware)

    def say_started(self, waits: str) -> None:
        """Say in one line that the node has started, what it uses and what it waits for."""
        self.get_logger().info(f'started: uses the arm {self.hardware} '
                               f'({", ".join(self.arm.labels)}), waits for {waits}')
