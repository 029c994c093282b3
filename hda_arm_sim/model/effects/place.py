"""
Where effects act on an arm, and what the laws of each place read.

A law takes the record of its effect and the signals of its place. Signals are numbers, or arrays
over time; a NamedTuple holds them, so that compiled code reads them by name. Who hands in numbers
gets numbers, which no type of a NamedTuple's fields can say: hence `Any` for the arrays.
"""

from dataclasses import dataclass
from typing import Any, NamedTuple, TypeAlias

Signal: TypeAlias = float | Any             # a number, or an array over time
SLIDERS = 4             # friction elements of a loop, each with a state of its own


class Commanded(NamedTuple):
    """A command on its way through the drive."""

    command: Signal = 0.0               # motor torque asked for, at the shaft [N*m]
    last_command: Signal = 0.0          # the one before it [N*m]
    state: Signal = 0.0                 # torque of the current loop before [N*m motor]
    elapsed: Signal = 0.0               # time since the command, or since the state [s]


class Delivered(NamedTuple):
    """What the current loop gives to the motor."""

    torque: Signal = 0.0                # [N*m motor]


class Turned(NamedTuple):
    """A motor on its turn."""

    motor_angle: Signal = 0.0           # shaft [rad]


class Dragged(NamedTuple):
    """A shaft in grease."""

    motor_velocity: Signal = 0.0        # shaft [rad/s]
    time: Signal = 0.0                  # since the start of the recording [s]


class Rubbed(NamedTuple):
    """A dry contact at the shaft that slides one way, or is about to."""

    budget: Signal = 0.0                # dry friction before the law, at the shaft [N*m]
    sense: Signal = 0.0                 # of sliding: 1, -1, or 0 at rest
    motor_velocity: Signal = 0.0        # shaft [rad/s]
    joint_torque: Signal = 0.0          # through the gear, at the output [N*m]
    ratio: Signal = 100.0               # of the gear
    link_angle: Signal = 0.0            # of the joint [rad]


class Bent(NamedTuple):
    """Bristles of a dry contact."""

    motor_velocity: Signal = 0.0        # shaft [rad/s]
    state: Signal = 0.0                 # deflection [rad]
    state_rate: Signal = 0.0            # [rad/s]
    budget: Signal = 0.0                # at which they slide [N*m motor]


class Twisted(NamedTuple):
    """A gear under load."""

    torsion: Signal = 0.0               # motor side minus link side, at the output [rad]
    torsion_rate: Signal = 0.0          # at the output [rad/s]
    state: Signal = 0.0                 # of the hysteresis, from -1 to 1


class Read(NamedTuple):
    """An encoder on its shaft."""

    angle: Signal = 0.0                 # of that shaft [rad]
    tilt_moment: Signal = 0.0           # of the weight on its bearing [N*m]


class Counted(NamedTuple):
    """Both encoders before they count."""

    motor_angle: Signal = 0.0           # shaft [rad]
    link_angle: Signal = 0.0            # of the joint [rad]


class Triggered(NamedTuple):
    """Both encoders when a sample is taken."""

    motor_late: Signal = 0.0            # reading of the motor encoder after the stamp [s]


class Sent(NamedTuple):
    """A sample on its way."""

    chance: Signal = 0.0                # evenly drawn from [0, 1)


class Stamped(NamedTuple):
    """A sample that waits for its stamp."""

    chance: Signal = 0.0                # evenly drawn from [0, 1)


class Stated(NamedTuple):
    """A number of the arm file."""

    nominal: Signal = 0.0               # in its own unit


class Carried(NamedTuple):
    """Links without what they carry."""

    inertia: Any = None                 # rigid.Inertia
    length1: Signal = 0.0               # of the links [m]
    length2: Signal = 0.0


class Pulled(NamedTuple):
    """A link."""

    link_angle: Signal = 0.0            # of its joint [rad]


class Weighed(NamedTuple):
    """Free fall."""

    gravity: Signal = 9.80665           # [m/s^2]


class Touched(NamedTuple):
    """The tip."""

    time: Signal = 0.0                  # since the start of the recording [s]


class Swung(NamedTuple):
    """A base that swings along one direction."""

    push: Signal = 0.0                  # of the links on it [N]
    offset: Signal = 0.0                # [m]
    offset_rate: Signal = 0.0           # [m/s]


@dataclass(frozen=True)
class Place:
    """A place on the arm: the signals that its laws read, and what they return."""

    name: str
    reads: Any                          # the NamedTuple of its signals
    returns: str                        # with its unit and side


WIRE = Place('wire', Commanded, 'command in force at the drive [N*m motor]')
LIMIT = Place('limit of the drive', Commanded, 'torque asked of the motor [N*m motor]')
CURRENT_LOOP = Place('current loop', Commanded, 'torque that the loop delivers [N*m motor]')
SHAFT = Place('shaft', Delivered, 'torque at the shaft behind the law [N*m motor]')
TURN = Place('turn of the motor', Turned, 'torque that drives the shaft [N*m motor]')
DRAG = Place('drag', Dragged, 'torque against the motion [N*m motor]')
DRY_LEVEL = Place('dry level', Rubbed, 'what is added to the budget so far [N*m motor]')
BREAKAWAY = Place('breakaway', Rubbed, 'what is added to the budget near rest [N*m motor]')
MESH = Place('mesh', Rubbed, 'what a load adds to the budget [N*m motor]')
BRISTLES = Place('bristles', Bent, 'torque against the motion [N*m motor]')
PLAY = Place('play', Twisted, 'torsion and its rate left to the spring [rad, rad/s]')
LOOP = Place('loop', Twisted, 'torque of friction beside the spring [N*m output]')
GEAR = Place('gear', Twisted, 'torque beside the spring, drives the link [N*m output]')
TRANSMISSION = Place('transmission', Turned, 'what is added to the torsion [rad at the output]')
LOADED_GEAR = Place(
    'loaded gear', Turned, 'what each N*m of either sign adds to the torsion [rad/(N*m) output]')
MOTOR_READING = Place('motor reading', Read, 'what is added to the shaft angle shown [rad]')
LINK_READING = Place('link reading', Read, 'what is added to the link angle shown [rad]')
TILTED_READING = Place(
    'tilted link reading', Read, 'what a tilting moment adds to the link angle shown [rad]')
COUNTS = Place('counts', Counted, 'both angles as they are counted [rad]')
CLOCK = Place('clock', Triggered, 'reading of the link encoder after the motor encoder [s]')
SAMPLE = Place('sample', Sent, 'whether the sample is lost')
STAMP = Place('stamp', Stamped, 'time from the sampling to the stamp [s]')
MOTOR_INERTIA = Place('motor inertia', Stated, 'the inertia in force [kg*m^2 motor]')
STIFFNESS = Place('stiffness', Stated, 'the stiffness in force [N*m/rad output]')
STIFFENING = Place('stiffening', Stated, 'curvature, knees and stiffnesses in force')
WIND_UP = Place('wind-up', Stated, 'the compliance in force [rad/(N*m) motor]')
LINK_INERTIA = Place('link inertia', Stated, 'the inertia in force [kg*m^2]')
COUPLING = Place('coupling', Stated, 'how far links feel each other, 0 to 1')
LOAD = Place('load', Carried, 'the inertia of the loaded links, rigid.Inertia')
LINK_TORQUE = Place('link torque', Pulled, 'torque on the link [N*m output]')
BEARING = Place('bearing', Pulled, 'most torque that the bearing can oppose [N*m output]')
WEIGHT = Place('weight', Weighed, 'gravity in the plane, x and y in base [m/s^2]')
TIP = Place('tip', Touched, 'force on the tip, x and y in base [N]')
BASE = Place('base', Swung, 'acceleration of the base along its swing [m/s^2]')
