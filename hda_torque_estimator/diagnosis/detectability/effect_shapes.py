"""The shape in which each effect is put into a recording, to see how small it may be there."""

from collections.abc import Iterator
from dataclasses import replace

from hda_arm_sim.model.arm import Arm
from hda_arm_sim.model.effects import (BaseVibration, ExternalContact, MotorCogging,
                                       NonlinearViscousFriction, PositionDependentFriction,
                                       StiffeningError, TorqueSaturation)
import numpy as np

from ..fitting.fit import Fitter
from ..fitting.hypotheses import terms_of
from ...least_squares.term import looked_for, Term

_ONLY = {                                       # of many shapes one that stands for all
    NonlinearViscousFriction.name: ('exponent', 0.5),
    MotorCogging.name: ('order', 14.0),
    PositionDependentFriction.name: ('order', 2.0),
    StiffeningError.name: ('knee_1', 0.0),
}
AT_LEAST_SEEN = (BaseVibration.name,)           # whose shapes nobody chooses: the faintest counts
# Choices unless told otherwise.
_CLIPPED = (0.6, 0.8, 0.92, 1.0)    # limits of torque, over the largest command: one a start
_TOUCH = 1.0            # duration of a contact [s]
_CREEPS = 2.0           # damping of a base that shows least: twice what keeps it from ringing
_SWINGS = (0.0, 0.5 * np.pi)        # directions of it, along x and y [rad]


def shapes(fitter: Fitter, arm: Arm, name: str) -> Iterator[Term]:
    """Yield an effect at every place in the shapes in which it is looked for, or some of them."""
    for number, term in enumerate(terms_of(arm, name)):
        if name == ExternalContact.name:
            yield looked_for(_touch(fitter), None, {}, {('force', 'direction'): 1.0}, {})
        elif name == BaseVibration.name:
            for along in _SWINGS:
                yield replace(term, effect=replace(term.effect, damping=_CREEPS, direction=along))
        elif name == TorqueSaturation.name:
            yield _clipped(fitter, arm, term, _CLIPPED[number % len(_CLIPPED)])
        elif _stands(term):
            yield term


def _stands(term: Term) -> bool:
    """Tell whether a shape stands for the others of its effect, or for itself."""
    number, value = _ONLY.get(term.name, ('', 0.0))
    return not number or bool(getattr(term.effect, number) == value)


def _touch(fitter: Fitter) -> ExternalContact:
    """Return a contact without force in the middle of the longest stretch that is fitted."""
    edges = np.flatnonzero(np.diff(fitter.rows.astype(int), prepend=0, append=0))
    time = np.append(fitter.balancer.time, fitter.balancer.time[-1])
    longest = max(zip(time[edges[::2]], time[edges[1::2]]), key=lambda span: span[1] - span[0])
    return ExternalContact(onset=float(0.5 * sum(longest) - 0.5 * _TOUCH), duration=_TOUCH)


def _clipped(fitter: Fitter, arm: Arm, term: Term, share: float) -> Term:
    """Return a limit of torque as a share of the largest command of its joint."""
    column = fitter.balancer.measurement.command[:, arm.labels.index(str(term.joint))]
    return replace(term, effect=TorqueSaturation(max(share * float(np.abs(column).max()), 1e-6)))
