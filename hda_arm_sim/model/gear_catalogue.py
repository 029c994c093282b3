"""
Gears by their catalogue name: stiffness, hysteresis loss and ratings, as manufacturers state them.

Only what a public page of the manufacturer, or a copy of its table, states is here. A rating that
none was found for is None, and nobody guesses it.
"""

from collections.abc import Iterable
import math
from typing import NamedTuple

from hda_msgs_json.errors import HdaError
import numpy as np

STIFFNESS_SOURCE = ('Harmonic Drive LLC, catalogue "CSF & CSG Series", tables 41 and 42; '
                    'Harmonic Drive SE, CHA manual 1018854, chapter "Torsional Stiffness"')
HYSTERESIS_SOURCE = 'Harmonic Drive SE, CHA manual 1018854, chapter "Accuracy": an upper limit'
RATING_SOURCE = ('Harmonic Drive SE, rating table of CSG-2A, as copied in '
                 'github.com/AimanHaidar/harmonic-drive-selector')

INERTIA_SOURCE = ('Harmonic Drive LLC, FHA-C series manual, section 1-4-2, inertia of actuators '
                  'of ratio 100')

ARC_MINUTE = math.pi / 10800.0      # [rad]
_RPM = 2.0 * math.pi / 60.0
_OF_ACTUATORS = 100.0               # their ratio

_KNEES = {14: (2.0, 6.9), 17: (3.9, 12.0), 20: (7.0, 25.0), 25: (14.0, 48.0),
          32: (29.0, 108.0), 40: (54.0, 196.0)}             # T1, T2 [N*m]
_STIFFNESS = {                                              # K1, K2, K3 [1e3 N*m/rad]
    30: {14: (1.9, 2.4, 3.4), 17: (3.4, 4.4, 6.7), 20: (5.7, 7.1, 11.0), 25: (10.0, 13.0, 21.0),
         32: (24.0, 30.0, 49.0)},
    50: {14: (3.4, 4.7, 5.7), 17: (8.1, 11.0, 13.0), 20: (13.0, 18.0, 23.0),
         25: (25.0, 34.0, 44.0), 32: (54.0, 78.0, 98.0), 40: (100.0, 140.0, 180.0)},
    80: {14: (4.7, 6.1, 7.1), 17: (10.0, 14.0, 16.0), 20: (16.0, 25.0, 29.0),
         25: (31.0, 50.0, 57.0), 32: (67.0, 110.0, 120.0), 40: (130.0, 200.0, 230.0)}}
_LOSS = {30: 3.0, 50: 1.0, 80: 1.0}                         # at most [arc minutes]

_RATIOS = {                                                 # that are made
    'CSF': {14: (30, 50, 80, 100), 17: (30, 50, 80, 100, 120), 20: (30, 50, 80, 100, 120, 160),
            25: (30, 50, 80, 100, 120, 160), 32: (30, 50, 80, 100, 120, 160),
            40: (50, 80, 100, 120, 160)},
    'CSG': {14: (50, 80, 100), 17: (50, 80, 100, 120), 20: (50, 80, 100, 120, 160),
            25: (50, 80, 100, 120, 160), 32: (50, 80, 100, 120, 160),
            40: (50, 80, 100, 120, 160)}}
_PEAK = {                                                   # repeated, of CSG [N*m]
    14: (23.0, 30.0, 36.0), 17: (44.0, 56.0, 70.0, 70.0), 20: (73.0, 96.0, 107.0, 113.0, 120.0),
    25: (127.0, 178.0, 204.0, 217.0, 229.0), 32: (281.0, 395.0, 433.0, 459.0, 484.0),
    40: (523.0, 675.0, 738.0, 802.0, 841.0)}
_INERTIA = {14: 3.3e-6, 17: 7.9e-6, 20: 1.93e-5, 25: 4.13e-5, 32: 1.69e-4, 40: 4.5e-4}
_ACTUATORS = {17: 0.7, 25: 3.4, 32: 7.3, 40: 19.8}      # FHA-C, at the output [kg*m^2]
_SPEED = {14: 8500.0, 17: 7300.0, 20: 6500.0, 25: 5600.0, 32: 4800.0, 40: 4000.0}


class GearError(HdaError):
    """A name that no gear of the catalogue has."""


class Gear(NamedTuple):
    """A gear as its catalogue states it; None where no public table was found."""

    name: str
    ratio: float
    knees: tuple[float, float]                  # T1, T2 at the output [N*m]
    stiffness: tuple[float, float, float]       # K1, K2, K3 at the output [N*m/rad]
    hysteresis_loss: float                      # at the output, at most [rad]
    peak_torque: float | None                   # repeated, at the output [N*m]
    inertia: float | None                       # of the wave generator [kg*m^2]
    speed: float | None                         # at the input, with grease [rad/s]
    usual_inertia: float                        # of rotor and wave generator of its size [kg*m^2]


def gear(name: str) -> Gear:
    """Return the gear of a catalogue name like CSG-17-100; raises GearError."""
    series, size, ratio = _read(name)
    if series not in _RATIOS:
        raise GearError(f'the catalogue has no gear {name!r:.60}: its series are '
                        f'{", ".join(_RATIOS)}, written as CSG-17-100')
    if size not in _RATIOS[series]:
        raise GearError(f'{series} is known in sizes {_listed(_RATIOS[series])}, got {name!r:.60}')
    ratios = _RATIOS[series][size]
    if ratio not in ratios:
        raise GearError(f'{series}-{size} is made with ratios {_listed(ratios)}, got {name!r:.60}')
    group = min(ratio, 80)
    k1, k2, k3 = _STIFFNESS[group][size]
    rated = series == 'CSG'
    return Gear(f'{series}-{size}-{ratio}', float(ratio), _KNEES[size],
                (1e3 * k1, 1e3 * k2, 1e3 * k3), _LOSS[group] * ARC_MINUTE,
                _PEAK[size][ratios.index(ratio)] if rated else None,
                _INERTIA[size] if rated else None, _SPEED[size] * _RPM if rated else None,
                _usual_inertia(size))


def gear_names() -> tuple[str, ...]:
    """Return the names of all gears."""
    return tuple(f'{series}-{size}-{ratio}' for series, sizes in _RATIOS.items()
                 for size, ratios in sizes.items() for ratio in ratios)


def _usual_inertia(size: int) -> float:
    """
    Return what turns at the input of a servo actuator of a size [kg*m^2].

    Between the sizes of the table, and beyond, it goes with a power of the size. Others of the
    same size have 0.6 to 1.8 times as much.
    """
    sizes, found = np.log([*_ACTUATORS]), np.log([*_ACTUATORS.values()])
    place = int(np.clip(np.searchsorted(sizes, math.log(size)) - 1, 0, len(sizes) - 2))
    power = (found[place + 1] - found[place]) / (sizes[place + 1] - sizes[place])
    at_output = math.exp(found[place] + power * (math.log(size) - sizes[place]))
    return float(at_output / _OF_ACTUATORS ** 2)


def _read(name: str) -> tuple[str, int, int]:
    """Return series, size and ratio of a name; zeros where it has none."""
    parts = name.strip().upper().split('-')[:3]
    numbers = [int(part) if part.isascii() and part.isdigit() and len(part) < 5 else 0
               for part in (*parts[1:], '', '')]
    return parts[0], numbers[0], numbers[1]


def _listed(numbers: Iterable[int]) -> str:
    return ', '.join(map(str, numbers))
