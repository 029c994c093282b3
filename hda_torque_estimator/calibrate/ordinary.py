"""
Calibrate the joints of an arm from ordinary recordings: no rig, and no torque sensor needed.

What a joint's torque was follows from a sensor where there is one. Else it follows from the motion
of the links and from weights and forces that are known.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict, dataclass
from typing import Any

from hda_arm_sim.model.arm import Arm
import numpy as np
from numpy.typing import NDArray

from .calibration import Calibration, LITTLE_TORQUE, one_joint, SPARSE
from .fitting import laws
from .fitting.arm_numbers import ArmNumber, number, numbers, rest, with_numbers, with_tolerances
from .fitting.friction import friction
from .fitting.orders import chosen, error_held_out, Fitted, fitted_waves, worthwhile
from .fitting.polynomial import held_out_error, polynomial_method
from .fitting.torsion_fits import BESIDE, TorsionFits, TorsionProblem, ZERO_KNOWN
from .passages.joint_recording import CalibrationError
from .passages.passage import Passage
from .passages.suitability import check, check_of_one_piece
from ..least_squares.descent import Minimum, places
from ..least_squares.term import Term

Floats = NDArray[np.float64]
# Choices unless stated otherwise.
FIXED = 0.7             # of what was known: a number that stays this unsure says nothing new
BENT = 5.0              # torque from which laws of the flexspline part [N*m]
FORM_GAIN = 0.03        # by which another form of the law must predict torques better
Progress = Callable[[str], None]


@dataclass(frozen=True)
class JointFinding:
    """
    What ordinary recordings said about one joint; errors are on stretches the fit had not seen.

    `before` is the arm as given, but for the zero of its link encoder. `polynomial` is the paper's
    method, and `coefficients` its (10) fitted to everything. These are a_0 to a_5 of a kinematic
    torsion over the link encoder's angle, both in rad.
    """

    joint: str
    recordings: tuple[str, ...]
    scale: str                          # what fixes the scale of the torque
    numbers: tuple[ArmNumber, ...]
    nominal: tuple[str, ...]            # numbers that the recordings could not fix
    torque: float                       # deviation of the torque [N*m]
    before: float                       # [N*m rms]
    after: float
    polynomial: float
    coefficients: tuple[float, ...]
    kept: str = ''

    def lines(self) -> list[str]:
        """Return the report on this joint."""
        return [f'{self.joint}: error {self.before:.3g} -> {self.after:.3g} N*m rms where the fit '
                f'has not seen; a polynomial of degree 5 leaves {self.polynomial:.3g}; the torque '
                f'varies by {self.torque:.3g}',
                f'    scale of the torque: {self.scale}',
                *([SPARSE] if self.torque < LITTLE_TORQUE else []),
                *(f'    {number}' for number in self.numbers),
                *([f'    nominal, because the recordings do not show: {", ".join(self.nominal)}']
                  if self.nominal else [])]

    def document(self) -> dict[str, Any]:
        """Return the report for machines."""
        return {**vars(self), 'recordings': list(self.recordings), 'nominal': list(self.nominal),
                'coefficients': list(self.coefficients),
                'numbers': [asdict(number) for number in self.numbers]}


def calibrate_ordinary(arm: Arm, passages: Mapping[str, Sequence[Passage]],
                       scales: Mapping[str, str], notify: Progress = lambda text: None
                       ) -> Calibration:
    """
    Return the arm that passages of its joints call for; `scales` say what fixes each torque.

    Raises CalibrationError where a joint's passages cannot calibrate it.
    """
    _check_all(arm, passages)
    found = []
    for label, seen in passages.items():
        notify(f'calibrating {label}')
        finding = _joint(one_joint(arm, label), seen, scales[label])
        found.append(finding)
        arm = with_numbers(arm, label, finding.numbers,
                           f'{", ".join(finding.recordings)}; scale: {finding.scale}')
    arm = with_tolerances(arm, {finding.joint: finding.numbers for finding in found})
    return Calibration(arm, tuple(found))


def _check_all(arm: Arm, passages: Mapping[str, Sequence[Passage]]) -> None:
    """Raise CalibrationError where a joint cannot be calibrated, and name those that can."""
    able, refused = [], []
    for label, seen in passages.items():
        try:
            check(arm, label, seen)
            able.append(f'--joint {label}')
        except CalibrationError as why:
            refused.append(why)
    if refused:
        others = f'; or calibrate the others: {" ".join(able)}' if able else ''
        raise CalibrationError(f'{refused[0]}{others}')


def _joint(arm: Arm, passages: Sequence[Passage], scale: str) -> JointFinding:
    """Return what passages say about the only joint of an arm."""
    label, fits = arm.labels[0], TorsionFits(arm, passages)
    plain = laws.without_waves(arm)
    found, nominal = _decided(TorsionFits(plain, passages), plain)
    _check_pieces(label, fits, found)
    error = TorsionProblem(fits, ()).error(np.zeros(BESIDE))
    after = error_held_out(found)
    found_numbers = (*_numbers(plain, found), *friction(arm, passages),
                     rest(after, len(np.unique(fits.stretch))))
    return JointFinding(
        label, tuple(passage.recording for passage in passages), scale, found_numbers, nominal,
        float(np.concatenate([p.reference[p.usable] for p in passages]).std()),
        float((error - error.mean()).std()),
        after, held_out_error(plain, passages),
        tuple(polynomial_method(plain, passages).kinematic.convert().coef.tolist()))


def law_terms(arm: Arm) -> list[Term]:
    """Return the terms of a joint but for the waves."""
    law, terms = arm.joints[0].torsion, [laws.stiffness(arm)]
    if law.flexspline_curvature > 0.0 and law.knee_1 == 0.0:
        terms.append(laws.curvature(arm))
    if np.isfinite(law.wave_generator_stiffness):
        terms.append(laws.soft_wind_up(arm))
    return [*terms, laws.loop(arm), laws.damping(arm), laws.skew(arm)]


def _decided(fits: TorsionFits, arm: Arm) -> tuple[Minimum, tuple[str, ...]]:
    """Return the fit with the waves and laws that recordings show, and the numbers left out."""
    terms = law_terms(arm)
    light = [terms[0], terms[-1]]               # stiffness and skew; loops come after waves
    orders = chosen(fits, fits.fit(light), ())
    fitted = fitted_waves(fits, terms, orders, fitted_waves(fits, light, orders))
    orders, thinner = worthwhile(fitted)
    more = chosen(fits, thinner, orders)
    if more != fitted.orders:
        fitted = fitted_waves(fits, terms, more, fitted)
    fitted, terms = _best_form(fits, arm, fitted, terms)
    determined = [term for term, keep in zip(terms, _determined(fitted.found)) if keep]
    if len(determined) < len(terms):
        fitted = fitted_waves(fits, determined, fitted.orders, fitted)
    left_out = tuple(name for term in terms if term not in determined for name in term.numbers())
    return fitted.found, left_out


def _best_form(fits: TorsionFits, arm: Arm, fitted: Fitted,
               terms: list[Term]) -> tuple[Fitted, list[Term]]:
    """Return the fit with three straight segments if it predicts better, and its terms."""
    largest = max(float(np.abs(p.reference[p.usable]).max()) for p in fits.passages)
    law = arm.joints[0].torsion
    if law.flexspline_curvature == 0.0 or law.knee_1 > 0.0 or largest < BENT:
        return fitted, terms
    straight = [laws.segments(arm, largest) if place == 1 else term
                for place, term in enumerate(terms)]
    other = fitted_waves(fits, straight, fitted.orders, fitted)
    better = error_held_out(other.found) < (1.0 - FORM_GAIN) * error_held_out(fitted.found)
    return (other, straight) if better else (fitted, terms)


def _determined(found: Minimum) -> list[bool]:
    """Return for each term whether the recordings show more of it than was known."""
    sigma = np.sqrt(np.diag(found.covariance()))
    # of its size; a shape follows
    return [bool(sigma[place.start] < FIXED) for place in places(found.terms)]


def _check_pieces(label: str, fits: TorsionFits, found: Minimum) -> None:
    """Check that one law fits all recordings."""
    first, parts = 0, []
    for passage in fits.passages:
        torque = passage.thinned(passage.reference)[passage.rows_used()]
        parts.append((passage.recording, found.rows.error[first:first + len(torque)], torque))
        first += len(torque)
    check_of_one_piece(label, parts)


def _numbers(arm: Arm, found: Minimum) -> tuple[ArmNumber, ...]:
    """Return the numbers of a fit with their intervals, the zero of the link encoder last."""
    covariance, size = found.covariance(), found.unknowns
    zero = arm.joints[0].link_encoder.zero + float(found.scaled[size] * ZERO_KNOWN)
    return (*numbers(found, covariance), number('link_encoder.zero', zero,
                                                float(np.sqrt(covariance[size, size]))))
