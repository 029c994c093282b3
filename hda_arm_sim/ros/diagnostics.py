"""Say once a second on /diagnostics how a node is doing."""

from collections.abc import Callable

from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus, KeyValue
from hda_arm_sim.health import Report
from hda_msgs_json.topics import DIAGNOSTICS
from rclpy.clock import Clock
from rclpy.clock_type import ClockType
from rclpy.node import Node

from .topics import publisher

PERIOD = 1.0        # [s]


class Diagnostics:
    """Publish the report of a node every second of real time."""

    def __init__(self, node: Node, report: Callable[[], Report], hardware: str) -> None:
        """Ask `report` for what to say of some hardware, whenever it is time."""
        self._node, self._report, self._hardware = node, report, hardware
        self._publisher = publisher(node, DIAGNOSTICS)
        steady = Clock(clock_type=ClockType.STEADY_TIME)
        self._timer = node.create_timer(PERIOD, self.publish, clock=steady)

    def publish(self) -> None:
        """Publish a report now."""
        self._publisher.publish(self._message(self._report()))

    def _message(self, report: Report) -> DiagnosticArray:
        status = DiagnosticStatus(
            level=bytes([report.level]), name=self._node.get_fully_qualified_name().lstrip('/'),
            message=report.message, hardware_id=self._hardware)
        status.values = [KeyValue(key=key, value=_shown(value))
                         for key, value in report.values.items()]
        message = DiagnosticArray(status=[status])
        message.header.stamp = self._node.get_clock().now().to_msg()
        return message


def _shown(value: object) -> str:
    return f'{value:.6g}' if isinstance(value, float) else str(value)
