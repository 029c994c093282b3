"""
What a figure or table of the paper becomes: drawings, numbers and sentences.

Builders fill these values and know nothing of pages or colours; `plots` draws them and `page`
writes them down.
"""

from enum import Enum
from typing import NamedTuple

from hda_arm_sim.foundation.arrays import Array
from hda_arm_sim.model.arm import Arm
from hda_msgs_json.errors import HdaError


class ReproductionError(HdaError):
    """A figure that is not in the paper, or a place where it cannot be written."""


class Arms(NamedTuple):
    """The arms that the figures are made with."""

    rig: Arm            # the single axis of the experiments
    two_axis: Arm       # the consistent two-axis arm
    table1: Arm         # two axes as Table I prints them, decoupled


class Look(Enum):
    """What a trace stands for, which decides its colour and line."""

    TRUTH = 'truth'
    PRINTED = 'printed'
    CONSISTENT = 'consistent'
    THIRD = 'third'
    FOURTH = 'fourth'
    PLAIN = 'plain'
    MARK = 'mark'


class Trace(NamedTuple):
    """One line of a panel; a name of '' stays out of the legend."""

    x: Array
    y: Array
    name: str
    look: Look
    points: bool = False


class Panel(NamedTuple):
    """Traces over a common axis; `shaded` are stretches of x, `top` and `bottom` limits of y."""

    title: str
    x_label: str
    y_label: str
    traces: tuple[Trace, ...]
    shaded: tuple[tuple[float, float], ...] = ()
    log_x: bool = False
    log_y: bool = False
    bottom: float | None = None
    top: float | None = None


class Bars(NamedTuple):
    """Named bars, each with a value per group."""

    title: str
    x_label: str
    names: tuple[str, ...]
    groups: tuple[tuple[str, Look, tuple[float, ...]], ...]


class Map(NamedTuple):
    """A value (rows of y, columns of x) over a plane, in colours up to `top`."""

    title: str
    x_label: str
    y_label: str
    value_label: str
    x: Array
    y: Array
    value: Array
    top: float


class DiagramBlock(NamedTuple):
    """A box of a diagram at a place in its grid."""

    name: str
    label: str
    x: float
    y: float


class Wire(NamedTuple):
    """An arrow from one block to another, with what it multiplies by."""

    start: str
    end: str
    label: str
    bend: float = 0.0


class Diagram(NamedTuple):
    """A block diagram."""

    title: str
    blocks: tuple[DiagramBlock, ...]
    wires: tuple[Wire, ...]


Content = Panel | Bars | Map | Diagram


class Drawing(NamedTuple):
    """Rows of panels that make one picture, and what to see in it."""

    name: str
    caption: str
    rows: tuple[tuple[Content, ...], ...]


class PaperNumber(NamedTuple):
    """
    A number beside the paper's.

    `paper` is what the paper states, `printed` what its equations give as they are printed,
    `consistent` what consistent physics gives; None where there is none.
    """

    name: str
    unit: str
    paper: float | None = None
    printed: float | None = None
    consistent: float | None = None
    remark: str = ''


class Exhibit(NamedTuple):
    """All that is made of one figure or table; `not_computed` says what a computer cannot give."""

    numbers: tuple[PaperNumber, ...]
    findings: tuple[str, ...]
    drawings: tuple[Drawing, ...] = ()
    not_computed: tuple[str, ...] = ()
