"""Read the parameters of other nodes as they appear."""

from collections import Counter
from collections.abc import Callable, Sequence
from functools import partial
from typing import Any

from rcl_interfaces.srv import GetParameters, ListParameters
from rclpy.clock import Clock
from rclpy.clock_type import ClockType
from rclpy.node import Node
from rclpy.parameter import parameter_value_to_python
from rclpy.task import Future

PERIOD = 0.25           # between two looks at which nodes are there [s]
AGAIN = 8               # looks until a node that has not answered is asked anew: a choice


class RemoteParameters:
    """
    Ask each of some nodes for all of its parameters, when it is there, until it has answered.

    An answer can get lost: a service may be found before the way back from it is.
    """

    def __init__(self, node: Node, names: Sequence[str],
                 heard: Callable[[str, dict[str, Any]], None]) -> None:
        """Pass to `heard` the parameters of every node that answers."""
        self._heard = heard
        self._lists = {name: node.create_client(ListParameters, f'{name}/list_parameters')
                       for name in names}
        self._gets = {name: node.create_client(GetParameters, f'{name}/get_parameters')
                      for name in names}
        self._waiting = set(names)
        self._looks: Counter[str] = Counter()       # at each node since its services are there
        self._timer = node.create_timer(PERIOD, self._look,
                                        clock=Clock(clock_type=ClockType.STEADY_TIME))

    def _look(self) -> None:
        for name in sorted(self._waiting):
            if not (self._lists[name].service_is_ready() and self._gets[name].service_is_ready()):
                continue
            if self._looks[name] % AGAIN == 0:
                future = self._lists[name].call_async(ListParameters.Request())
                future.add_done_callback(partial(self._on_names, name))
            self._looks[name] += 1

    def _on_names(self, name: str, future: Future) -> None:
        names = list(future.result().result.names)
        answer = self._gets[name].call_async(GetParameters.Request(names=names))
        answer.add_done_callback(partial(self._on_values, name, names))

    def _on_values(self, name: str, names: Sequence[str], future: Future) -> None:
        if name not in self._waiting:
            return                                  # the answer to an earlier question came late
        self._waiting.discard(name)
        values = [parameter_value_to_python(value) for value in future.result().values]
        self._heard(name, dict(zip(names, values)))
