"""Table I against itself and against the gear's catalogue."""

import math

from hda_arm_sim.foundation.arrays import Array
from hda_arm_sim.model.gear_catalogue import ARC_MINUTE
from hda_arm_sim.model.parts import Joint
from hda_arm_sim.model.torsion import (segmented_torsion, stiffness_at, torsion_of_torque,
                                       wave_generator_torsion)
import numpy as np

from ..rig.exhibit import Arms, Drawing, Exhibit, Look, Panel, PaperNumber, Trace
from ..rig.printed import CATALOGUE, flexspline_torque, PRINTED

_RATED = 31.0                       # torque of a CSG-17-100 [N*m]


def table_one(arms: Arms) -> Exhibit:
    """Return what Table I says twice, what its laws say together, and how far they hold."""
    joint = arms.table1.joints[0]
    soft = float(stiffness_at(joint.torsion.record(joint.ratio), joint.ratio, 0.0))
    numbers = (*_itself(), *_laws(joint), *_inertia(arms))
    return Exhibit(numbers, (
        'Of c_w, K_w0, psi and T_fs only two are independent: c_w = 2/(N K_w0 psi) and '
        'K_w0 = 2 T_fs/(N psi) give c_w = 1/T_fs, and so it is printed.',
        'The tangent law passes through both knees of the catalogue, so it is the compliance of '
        'the whole gear. To add the wave generator counts that twice: at small torque the sum is '
        f'{100.0 * (1.0 - soft / CATALOGUE.first_stiffness):.0f} % '
        "softer than the catalogue's first stiffness. Data must decide; the arm file can say "
        'either (wave_generator_stiffness: .inf).',
        'The law has a pole at 1.94 mrad, which the gear reaches below its rated torque. It is '
        'used up to 37 N*m of its own scale and then continued along its last slope.'),
        (_curves(joint),),
        ('Where the catalogue numbers of Table I come from (which edition, which tolerance) is '
         'not said.',))


def _itself() -> tuple[PaperNumber, ...]:
    """Return the numbers that Table I holds more than once."""
    n, start, soft = PRINTED.ratio, PRINTED.starting_torque, PRINTED.wave_generator_stiffness
    psi = 2.0 * start / (n * soft)
    curve = PRINTED.wave_generator_curvature
    return (
        PaperNumber('c_w from K_w0 and psi', '1/(N*m)', 27.027, 2.0 / (n * soft * psi),
                    1.0 / start,
                    '1/T_fs: the definition collapses'),
        PaperNumber('psi from K_w0 and T_fs', 'arcmin', None, psi / ARC_MINUTE, None,
                    "the catalogue's 1.0 arcmin, rounded to 2.9e-4 rad"),
        PaperNumber('K_w0 from psi = 1 arcmin', 'N*m/rad', 2.5517, 2.0 * start / (n * ARC_MINUTE)),
        PaperNumber('saturation of the wave generator, shaft', 'rad', None, 1.0 / (curve * soft)),
        PaperNumber('the same at the output', 'rad', None, 1.0 / (n * curve * soft), psi / 2.0,
                    'psi/2, by construction'),
        PaperNumber('share of it reached at N T_fs', '%', None, None,
                    100.0 * float(wave_generator_torsion(n * start, n, soft, curve))
                    * n * curve * soft, 'at 3.7 N*m'))


def _laws(joint: Joint) -> tuple[PaperNumber, ...]:
    """Return how the tangent law meets the catalogue, alone and with the wave generator."""
    law, n = joint.torsion.record(joint.ratio), joint.ratio
    knee_1, knee_2 = (float(_catalogue(torque)) for torque in (CATALOGUE.knee_1, CATALOGUE.knee_2))
    pole = math.pi / (2.0 * PRINTED.flexspline_curvature * PRINTED.tangent_stiffness)
    at_pole = CATALOGUE.knee_2 + (pole - knee_2) * CATALOGUE.third_stiffness
    return (
        PaperNumber('tangent law at the first knee', 'N*m', None, float(flexspline_torque(knee_1)),
                    CATALOGUE.knee_1, f'catalogue: {1e6 * knee_1:.0f} urad'),
        PaperNumber('tangent law at the second knee', 'N*m', None,
                    float(flexspline_torque(knee_2)),
                    CATALOGUE.knee_2, f'catalogue: {1e6 * knee_2:.1f} urad'),
        PaperNumber('pole of the tangent law', 'mrad', None, 1e3 * pole),
        PaperNumber('torque at which the gear gets there', 'N*m', None, None, at_pole,
                    f'rated: {_RATED:g} N*m'),
        PaperNumber('K_f0 against K_f', '%', None,
                    100.0 * (PRINTED.tangent_stiffness / PRINTED.linear_stiffness - 1.0)),
        PaperNumber('stiffness at small torque, with the wave generator', 'N*m/rad', None,
                    float(stiffness_at(law, n, 0.0)), CATALOGUE.first_stiffness,
                    "consistent: the catalogue's K_1"),
        PaperNumber('torsion at 12 N*m, with the wave generator', 'urad', None,
                    1e6 * float(torsion_of_torque(law, n, CATALOGUE.knee_2)), 1e6 * knee_2,
                    "consistent: the catalogue's"),
        PaperNumber('stiffness of the tangent law at the rated torque', 'N*m/rad', None,
                    PRINTED.tangent_stiffness * (
                        1.0 + (PRINTED.flexspline_curvature * _RATED) ** 2),
                    CATALOGUE.third_stiffness, "consistent: the catalogue's K_3"))


def _inertia(arms: Arms) -> tuple[PaperNumber, ...]:
    """Return what the inertia and the length of a link mean together."""
    inertia, length = PRINTED.link_inertia, PRINTED.link_length
    return (
        PaperNumber('mass of a rod of 0.15 m with J_l', 'kg', None, 3.0 * inertia / length ** 2,
                    None,
                    'not a link: J_l must hold a fixture'),
        PaperNumber('point mass at 0.15 m with J_l', 'kg', None, inertia / length ** 2),
        PaperNumber('J_w as a share of J_m', '%', None,
                    100.0 * PRINTED.wave_generator_inertia / PRINTED.motor_inertia, None,
                    'listed and never used in (1)'))


def _catalogue(torque: Array | float) -> Array:
    """Return the torsion of the catalogue's three segments [rad]."""
    return np.asarray(segmented_torsion(
        np.asarray(torque, float), CATALOGUE.first_stiffness, CATALOGUE.knee_1,
        CATALOGUE.second_stiffness, CATALOGUE.knee_2, CATALOGUE.third_stiffness))


def _curves(joint: Joint) -> Drawing:
    law, n = joint.torsion.record(joint.ratio), joint.ratio
    torque = np.linspace(0.0, 45.0, 300)
    wound = wave_generator_torsion(torque, n, PRINTED.wave_generator_stiffness,
                                   PRINTED.wave_generator_curvature)
    bent = np.arctan(PRINTED.flexspline_curvature * torque) / (
        PRINTED.flexspline_curvature * PRINTED.tangent_stiffness)
    whole = torsion_of_torque(law, n, torque)
    curves = (('catalogue, three segments', _catalogue(torque), Look.TRUTH),
              ('tangent law (B.2)', bent, Look.PRINTED),
              ('with the wave generator (B.1)', whole, Look.CONSISTENT),
              ('wave generator alone', wound, Look.THIRD))
    rated = Trace(np.array([0.0, 3.0]), np.full(2, _RATED), 'rated torque', Look.MARK)
    left = Panel('torque over torsion', 'torsion [mrad]', 'torque [N·m]', (*(
        Trace(1e3 * torsion, torque, name, look) for name, torsion, look in curves), rated),
        top=45.0, bottom=0.0)
    right = Panel('local stiffness', 'torque [N·m]', 'stiffness [kN·m/rad]', tuple(
        Trace(torque, 1e-3 * np.gradient(torque, torsion), '', look)
        for _, torsion, look in curves[:3]), bottom=0.0, top=60.0)
    return Drawing('laws', 'The laws of Table I beside the catalogue of the gear. The tangent law '
                   'is good to 12 N·m and has its pole below the rated torque.',
                   ((left, right),))
