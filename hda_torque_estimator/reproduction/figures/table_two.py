"""Table II: what can and what cannot be read from the coefficients of the kinematic torsion."""

import math

from hda_arm_sim.foundation.arrays import Array
import numpy as np

from ..rig.exhibit import Arms, Drawing, Exhibit, Look, Panel, PaperNumber, Trace
from ..rig.printed import PRINTED

READABLE = (6.5719e-5, 0.0018, 0.0032)      # in the order in which the table prints them
_CLASS = 1.5 * math.pi / 10800.0            # accuracy of gears of this class [rad]
_RADIUS = 0.025                             # of the scale's disc [m]
_CYCLES = 200.0                             # of a wave generator per turn of the link


def table_two(arms: Arms) -> Exhibit:
    """Return what three coefficients without their rows may mean, and what a quintic can hold."""
    stiffness = PRINTED.linear_stiffness
    numbers = (
        *(PaperNumber(f'largest torsion, {name}', 'N*m', None,
                      stiffness * float(np.abs(curve).max()),
                      None, 'as torque at K_f') for name, curve in _readings().items()),
        PaperNumber('the term 0.0018 alone, as rad per rad of the link', 'N*m', None,
                    stiffness * READABLE[1] * 2.0 * math.pi, None, 'after one turn, at K_f'),
        PaperNumber('the same as a disc off its axis', 'um', None, 1e6 * READABLE[1] * _RADIUS,
                    None,
                    'disc of 50 mm'),
        PaperNumber('accuracy class of such gears', 'N*m', None, None, stiffness * _CLASS,
                    '1.5 arcmin at K_f'),
        PaperNumber('power of 200 waves per turn that a quintic can hold', '%', None,
                    100.0 * quintic_share(_CYCLES), 100.0, 'consistent: Fourier terms'),
        PaperNumber('power of 1 wave per turn that a quintic can hold', '%', None,
                    100.0 * quintic_share(1.0), 100.0))
    return Exhibit(numbers, (
        'Three of six coefficients can be read, 6.5719e-5, 0.0018 and 0.0032, and which of a_0 to '
        'a_5 the last two are is lost. The curve cannot be drawn from that.',
        'Read as a_0, a_1, a_2 in radians of the link the torsion would be a hundred times what '
        'such gears err by. Only in degrees over turns would it be in their class; the table '
        'gives no unit.',
        'A polynomial is not periodic: it jumps where the turn closes, and its a_0 cannot be '
        "separated from the encoders' zero or a constant torque. It holds the eccentricity of a "
        'disc and nothing of the wave generator, whose 200 waves per turn the estimator needs as '
        'sin(2 theta_m).'),
        (_curves(),),
        ('a_3 to a_5 and the rows of the two others: not in the table as it is stored.',
         "Which angle (10) takes, the motor's or the link's, is not said."))


def _readings() -> dict[str, Array]:
    """Return the torsion over a turn [rad] by what the three numbers may be in."""
    turn = np.linspace(0.0, 1.0, 200)

    def polynomial(angle: Array) -> Array:
        return np.asarray(sum(a * angle ** k for k, a in enumerate(READABLE)))

    return {
        'radians of the link': polynomial(2.0 * math.pi * turn),
        'radians of the shaft, torsion at the shaft': polynomial(2.0 * math.pi * turn)
        / PRINTED.ratio,
        'turns and radians': polynomial(turn),
        'turns and degrees': np.radians(polynomial(turn))}


def quintic_share(cycles: float) -> float:
    """Return the share of a sine's power that a polynomial of degree 5 holds over its turn."""
    place = np.linspace(-1.0, 1.0, 20001)
    wave = np.stack([np.sin(math.pi * cycles * place), np.cos(math.pi * cycles * place)], axis=1)
    basis = np.polynomial.legendre.legvander(place, 5)
    held = basis @ np.linalg.lstsq(basis, wave, rcond=None)[0]
    return float((held ** 2).sum() / (wave ** 2).sum())


def _curves() -> Drawing:
    turn = np.linspace(0.0, 1.0, 200)
    looks = (Look.PRINTED, Look.THIRD, Look.FOURTH, Look.CONSISTENT)
    traces = tuple(Trace(turn, 1e3 * curve, name, look)
                   for look, (name, curve) in zip(looks, _readings().items()))
    limit = Trace(turn, np.full_like(turn, 1e3 * _CLASS), 'accuracy class, 1.5 arcmin', Look.MARK)
    return Drawing('readings', 'The three readable coefficients as a_0, a_1, a_2, by the units '
                   'that they may have. None of them closes after a turn.',
                   ((Panel('kinematic torsion by Table II', 'turn', 'torsion [mrad]',
                           (*traces, limit), log_y=True),),))
