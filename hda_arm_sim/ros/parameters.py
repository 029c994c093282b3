"""
ROS parameters made from declarations: description, unit and range stand in one place only.

A value that a declaration does not allow is refused with its sentence, at the start and while
the node runs. Whole numbers are taken where a double is declared.
"""

from collections.abc import Callable, Sequence
from typing import Any, TypeVar

from hda_arm_sim.foundation.parameter import Declaration, Declared, ParameterError
from rcl_interfaces.msg import FloatingPointRange, ParameterDescriptor, SetParametersResult
from rclpy.node import Node
from rclpy.parameter import Parameter

Group = TypeVar('Group', bound=Declared)
_OF_EVERY_NODE = ('use_sim_time', 'start_type_description_service')
_OF_RCL = ('qos_overrides.',)


class Parameters:
    """
    The parameters of one node.

    The node must be made with `automatically_declare_parameters_from_overrides`: only so can it
    be informed which of the given values nobody asked for.
    """

    def __init__(self, node: Node) -> None:
        """Take over the values that were given to the node."""
        self._node = node
        self._given: dict[str, Any] = {
            name: node.get_parameter(name).value for name in node.list_parameters([], 0).names}
        self._asked: set[str] = set()
        self._groups: dict[str, tuple[Declared, Callable[[Any], None]]] = {}
        self._allowed: dict[str, Callable[[Any], None]] = {}
        node.add_on_set_parameters_callback(self._check)
        node.add_post_set_parameters_callback(self._apply)

    def group(self, kind: type[Group], changed: Callable[[Group], None] | None = None, *,
              allowed: Callable[[Group], None] | None = None) -> Group:
        """
        Declare a group of numbers and return it with the values given; raises ParameterError.

        With `changed` the numbers can be set while the node runs, and it is given the new group.
        What `allowed` then raises a ParameterError for is not set.
        """
        rules = kind.declarations()
        values = kind(**{rule.name: self._given.get(rule.name, rule.default) for rule in rules})
        for rule in rules:
            self._declare(rule.name, getattr(values, rule.name),
                          _number_descriptor(rule, read_only=changed is None))
        if changed is not None:
            self._groups[kind.name] = values, changed
            self._allowed[kind.name] = allowed or (lambda group: None)
        return values

    def text(self, name: str, default: str, meaning: str) -> str:
        """Declare a text that is read at the start only; raises ParameterError."""
        return self._fixed(name, default, meaning, str, 'a text')

    def word(self, name: str, default: str, meaning: str) -> str:
        """Declare a text that may be `nan`, which YAML takes for a number; as `text` else."""
        if (given := self._given.get(name)) != given:
            self._given[name] = str(given)
        return self.text(name, default, meaning)

    def texts(self, name: str, default: Sequence[str], meaning: str) -> list[str]:
        """Declare a list of texts that is read at the start only; raises ParameterError."""
        return self._fixed(name, list(default), meaning, list, 'a list of texts')

    def flag(self, name: str, default: bool, meaning: str) -> bool:
        """Declare a truth value that is read at the start only; raises ParameterError."""
        return self._fixed(name, default, meaning, bool, 'true or false')

    def unknown(self) -> list[str]:
        """Return the names of given values that nobody asked for."""
        return sorted(name for name in self._given if name not in self._asked
                      and name not in _OF_EVERY_NODE and not name.startswith(_OF_RCL))

    def names(self) -> list[str]:
        """Return the names of all parameters that were declared here."""
        return sorted(self._asked)

    def values(self) -> dict[str, Any]:
        """Return all parameters that were declared here with their values now."""
        return {name: self._node.get_parameter(name).value for name in self.names()}

    def _fixed(self, name: str, default: Any, meaning: str, kind: type, what: str) -> Any:
        value = self._given.get(name, default)
        value = list(value) if kind is list and not isinstance(value, str) else value
        if not isinstance(value, kind):
            raise ParameterError(f'{name} must be {what} ({meaning}), got {value!r}')
        self._declare(name, value, ParameterDescriptor(description=meaning, read_only=True))
        return value

    def _declare(self, name: str, value: Any, descriptor: ParameterDescriptor) -> None:
        self._asked.add(name)
        if self._node.has_parameter(name):
            self._node.undeclare_parameter(name)
        self._node.declare_parameter(name, value, descriptor, ignore_override=True)

    def _check(self, changes: list[Parameter]) -> SetParametersResult:
        """Return whether all changes are allowed."""
        try:
            for group in self._changed(changes):
                self._allowed[group.name](group)
        except ParameterError as error:
            return SetParametersResult(successful=False, reason=str(error))
        return SetParametersResult(successful=True)

    def _apply(self, changes: list[Parameter]) -> None:
        for group in self._changed(changes):
            changed = self._groups[group.name][1]
            self._groups[group.name] = group, changed
            changed(group)

    def _changed(self, changes: list[Parameter]) -> list[Declared]:
        """Return the groups that the changes make other ones; raises ParameterError."""
        given = {change.name: change.value for change in changes}
        made = []
        for group, _ in self._groups.values():
            values = {rule.name: given.get(rule.name, getattr(group, rule.name))
                      for rule in group.declarations()}
            if (new := type(group)(**values)) != group:
                made.append(new)
        return made


def _number_descriptor(rule: Declaration, *, read_only: bool) -> ParameterDescriptor:
    """Return what ROS tools show of a number; its type is open, so that 1 does for 1.0."""
    unit = f' [{rule.unit}]' if rule.unit else ''
    bounds = FloatingPointRange(from_value=rule.low, to_value=rule.high, step=0.0)
    return ParameterDescriptor(
        description=f'{rule.meaning}{unit}', read_only=read_only, dynamic_typing=True,
        floating_point_range=[bounds])
