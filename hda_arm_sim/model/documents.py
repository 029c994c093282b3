"""What a parsed YAML document holds: mappings, lists, numbers and declared groups, checked."""

from typing import Any

from .arm import ArmError
from ..foundation.parameter import Declared, ParameterError


def mapping(value: Any, owner: str, allowed: tuple[str, ...]) -> dict[str, Any]:
    """Return a mapping whose keys are all allowed; raises ArmError."""
    if not isinstance(value, dict):
        raise ArmError(f'{owner} must be a mapping with {", ".join(allowed)}, got {value!r:.60}')
    for key in value:
        if key not in allowed:
            raise ArmError(f'{owner} has the unknown key {key!r}; valid keys: '
                           f'{", ".join(allowed)}')
    return value


def sequence(value: Any, owner: str) -> list[Any]:
    """Return a list; raises ArmError."""
    if not isinstance(value, list):
        raise ArmError(f'{owner} must be a list, got {value!r:.60}')
    return value


def group(kind: type[Declared], values: Any, owner: str = '') -> Any:
    """Return declared parameters from a mapping; raises ArmError and ParameterError."""
    names = tuple(rule.name for rule in kind.declarations())
    given = mapping(values, owner or kind.name, names)
    return kind(**{key: number(value) for key, value in given.items()})


def number(value: Any) -> Any:
    """Return a number that YAML 1.1 takes for text (4e6) as the number that it looks like."""
    try:
        return float(value) if isinstance(value, str) else value
    except ValueError:
        return value


def part(kind: type[Declared], values: Any, owner: str) -> Any:
    """Return declared parameters whose errors name their owner; raises ArmError."""
    try:
        return group(kind, values, owner)
    except ParameterError as error:
        raise ArmError(str(error).replace(kind.name, owner, 1)) from None
