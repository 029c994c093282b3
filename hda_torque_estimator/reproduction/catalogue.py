"""The table of figures: what the paper shows, and who makes it again."""

from collections.abc import Callable
from typing import NamedTuple

from hda_msgs_json.nearest import did_you_mean

from .figures.back_driving import back_driving
from .figures.block_diagrams import arm_diagram, control_diagram
from .figures.feedback import feedback
from .figures.feedback_experiments import feedback_experiments
from .figures.kinematic_torsion import kinematic_torsion
from .figures.motor_friction import motor_friction
from .figures.responses import responses
from .figures.table_one import table_one
from .figures.table_two import table_two
from .figures.tip_forces import tip_forces
from .figures.torque_budget import resting, turning
from .figures.torque_check import torque_check
from .rig.exhibit import Arms, Exhibit, ReproductionError


class PaperItem(NamedTuple):
    """A figure, table or equation of the paper."""

    title: str
    said: str               # what the paper shows or says
    build: Callable[[Arms], Exhibit]


FIGURES: dict[str, PaperItem] = {
    'table1': PaperItem('Table I: parameters', 'The parameters of the arm, eleven numbers.',
                        table_one),
    'equation_a1': PaperItem('(A.1): friction of the motor',
                             "Viscous friction from the motor's data sheet.", motor_friction),
    'table2': PaperItem('Table II: kinematic torsion', 'Coefficients of a polynomial of degree 5.',
                        table_two),
    'fig2': PaperItem('Fig. 2: block diagram of the arm', 'The two-axis arm as a block diagram.',
                      arm_diagram),
    'fig3': PaperItem('Fig. 3: control with torque feedback', 'The PD loop with joint torque '
                      'feedback.', control_diagram),
    'fig5': PaperItem('Fig. 5: responses of both joints',
                      'A unit step of current makes the angles '
                      'grow; a sine makes them grow and fluctuate.', responses),
    'fig6': PaperItem('Fig. 6: estimated torque',
                      'Close agreement of real and estimated link-side '
                      'torque, step and sine, both arms.', torque_check),
    'fig7': PaperItem('Fig. 7: joint torque feedback', 'With feedback the arm follows an external '
                      'torque (torque mode) or rejects it (position mode).', feedback),
    'fig9': PaperItem('Fig. 9: torque at a held angle', 'Step and periodic torque on the rig at '
                      'rest; differences are "due to the backlash".', resting),
    'fig10': PaperItem('Fig. 10: kinematic torsion',
                       'Kinematic torsion for several torques and both '
                       'directions, fitted by a quintic.', kinematic_torsion),
    'fig11': PaperItem('Fig. 11: torque while turning', 'Mean and largest errors (1.27, 5.89) and '
                       '(1.33, 4.5) N*m; the encoder, vibration or acquisition may be the cause.',
                       turning),
    'fig12': PaperItem('Fig. 12: experiments with torque feedback',
                       'With feedback the arm follows a '
                       'push under constant motor torque, and departs less from 90 deg.',
                       feedback_experiments),
    'fig14': PaperItem('Fig. 14: the arm moved by hand',
                       'Torque and displacement go together; peaks '
                       'are one-sided where the curve is flat, by the resolution of the encoder.',
                       back_driving),
    'equation_14': PaperItem('(14), (15): force at the tip', 'Size and direction of the external '
                             'force from two joint torques.', tip_forces),
}


def chosen(names: list[str]) -> dict[str, PaperItem]:
    """Return the figures of these names in the paper's order, all for none; may raise."""
    for name in names:
        if name not in FIGURES:
            near = did_you_mean(name, FIGURES) or ';'
            raise ReproductionError(f'the paper has no figure {name!r} that can be made again'
                                    f'{near} valid names: {", ".join(FIGURES)}')
    return {name: entry for name, entry in FIGURES.items() if not names or name in names}
