"""
Declare a parameter once; validation, fit bounds, YAML, ROS descriptors and reports read it here.

A class of parameters is a frozen dataclass derived from `Declared` whose fields are made by
`parameter`. Compiled code sees the same fields, by the same names, as a numpy record.
"""

from dataclasses import dataclass, field, fields
from functools import cache, cached_property
import math
from typing import Any, ClassVar

from hda_msgs_json.errors import HdaError
from hda_msgs_json.nearest import did_you_mean
import numpy as np


_LARGEST = 10 ** 300    # whole numbers far beyond it do not become floats


class ParameterError(HdaError):
    """A value that its declaration does not allow."""


@dataclass(frozen=True)
class Declaration:
    """What is known of a parameter before it has a value; bounds are inclusive."""

    name: str
    default: float
    unit: str
    low: float
    high: float
    meaning: str

    def checked(self, owner: str, value: object) -> float:
        """Return `value` as a float, or raise ParameterError naming owner, rule and value."""
        if isinstance(value, (bool, str)) or not isinstance(value, (int, float, np.number)):
            raise ParameterError(
                f'{owner}.{self.name} must be a number in {self.unit or "no unit"} '
                f'({self.meaning}), got {value!r}')
        number = float(min(max(value, -_LARGEST), _LARGEST) if isinstance(value, int) else value)
        number = number if self.low <= number <= self.high else self._at_bound(number)
        if not self.low <= number <= self.high:                        # also refuses NaN
            raise ParameterError(
                f'{owner}.{self.name} must lie in [{self.low:g}, {self.high:g}] '
                f'{self.unit} ({self.meaning}), got {number:g}'.replace('  ', ' '))
        return number

    def _at_bound(self, number: float) -> float:
        """Return the bound that a number is but for rounding, as 1.5708 is a right angle."""
        return next((bound for bound in (self.low, self.high) if number == float(f'{bound:g}')),
                    number)


def parameter(default: float, unit: str, low: float, high: float, meaning: str) -> Any:
    """Declare one parameter of a `Declared` dataclass: default, unit, bounds, meaning."""
    rule = {'default': default, 'unit': unit, 'low': low, 'high': high, 'meaning': meaning}
    return field(default=default, metadata={'rule': rule})


@dataclass(frozen=True)
class Declared:
    """A group of declared parameters; every value is checked when the group is made."""

    name: ClassVar[str] = 'parameters'

    def __post_init__(self) -> None:
        """Check every parameter; raises ParameterError."""
        for rule in self.declarations():
            value = getattr(self, rule.name)
            if type(value) is not float or not rule.low <= value <= rule.high:
                object.__setattr__(self, rule.name, rule.checked(self.name, value))

    @classmethod
    @cache
    def declarations(cls) -> tuple[Declaration, ...]:
        """Return the declarations in the order of the fields."""
        return tuple(Declaration(f.name, **f.metadata['rule'])
                     for f in fields(cls) if 'rule' in f.metadata)

    @classmethod
    def declaration(cls, name: str) -> Declaration:
        """Return one declaration; raises ParameterError with the valid names."""
        for rule in cls.declarations():
            if rule.name == name:
                return rule
        names = [rule.name for rule in cls.declarations()]
        near = did_you_mean(name, names) or ';'
        raise ParameterError(f'{cls.name} has no parameter {name!r}{near} valid names: '
                             f'{", ".join(names) or "none"}')

    @classmethod
    def record_type(cls) -> np.dtype[Any]:
        """Return the numpy record type in which compiled code reads the parameters."""
        return np.dtype([(rule.name, float) for rule in cls.declarations()])

    def values(self) -> tuple[float, ...]:
        """Return the values in the order of the declarations."""
        return self._values

    @cached_property
    def _values(self) -> tuple[float, ...]:         # a fit makes thousands of arms of them
        return tuple(getattr(self, rule.name) for rule in self.declarations())

    def is_neutral(self) -> bool:
        """Return whether every value is its default."""
        return all(math.isclose(getattr(self, rule.name), rule.default, rel_tol=0.0, abs_tol=0.0)
                   for rule in self.declarations())
