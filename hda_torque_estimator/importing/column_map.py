"""
The column map: what each column of a table means, and how it becomes a value of a bag.

    value = factor * (mean or formula of the columns - zero)

`factor` holds the unit, the sign, the constants of the device and the gear ratio. A bag states
`joint1` at the link and `joint1_motor` at the motor shaft, whatever side the table uses.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Literal

from hda_msgs_json.errors import HdaError
import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Zero = float | Literal['first', 'mean']


class ColumnMapError(HdaError):
    """A column map that cannot be read, or that does not fit its table."""


@dataclass(frozen=True)
class Winding:
    """A torque at the shaft is `kt * (voltage - kt * speed) / resistance`."""

    torque_constant: float          # [N*m/A], which is the back EMF as well [V*s/rad]
    resistance: float               # [ohm]


@dataclass(frozen=True)
class Column:
    """One quantity: where it stands in the table and how it becomes a value of the bag."""

    entry: str                      # its place in the map, for messages
    names: tuple[str, ...]          # averaged when there are several, unless a formula says
    factor: float = 1.0
    zero: Zero = 0.0                # in the table's unit, or taken from each recording
    formula: Callable[[Mapping[str, Floats]], Floats] | None = None     # of columns by name
    winding: Winding | None = None  # of the motor, where the column is a voltage


@dataclass(frozen=True)
class Side:
    """The columns of one side of a joint; None is a quantity that the table does not have."""

    position: Column | None = None
    velocity: Column | None = None
    effort: Column | None = None

    def columns(self) -> tuple[Column, ...]:
        """Return the columns that the table has of this side."""
        return tuple(c for c in (self.position, self.velocity, self.effort) if c is not None)


@dataclass(frozen=True)
class JointColumns:
    """The columns of one joint: both sides, and the torque that a sensor of its own measured."""

    name: str
    motor: Side = field(default_factory=Side)
    link: Side = field(default_factory=Side)
    reference: Column | None = None

    def columns(self) -> tuple[Column, ...]:
        """Return every column that the table has of this joint."""
        reference = () if self.reference is None else (self.reference,)
        return (*self.motor.columns(), *self.link.columns(), *reference)


@dataclass(frozen=True)
class ColumnMap:
    """
    All joints, the time (a column, or a rate [Hz]), and the column that splits recordings.

    The wrench on the tip has six columns, force and torque, or none. `even` makes the stamps of a
    host even.
    """

    joints: tuple[JointColumns, ...]
    time: Column | float
    split: Column | None = None
    wrench: tuple[Column, ...] = ()
    even: bool = False

    def columns(self) -> tuple[Column, ...]:
        """Return every column that the map asks of a table."""
        time = (self.time,) if isinstance(self.time, Column) else ()
        split = () if self.split is None else (self.split,)
        joints = (column for joint in self.joints for column in joint.columns())
        return (*time, *split, *self.wrench, *joints)
