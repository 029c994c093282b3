"""The rest of a diagnosis: what no effect of the catalogue explains, as the report states it."""

from dataclasses import dataclass

NOTHING = 'nothing'     # what a rest follows that no coordinate explains
GEAR = 'gear'           # site of a rest that may be of a motor or in its torsion
SENSOR = 'sensor'       # site of a rest in a torque that two other witnesses contradict
IN_WORDS = {
    'time': 'time', 'motor_velocity': 'the speed of the motor',
    'link_velocity': 'the speed of the link', 'motor_angle': 'the motor angle',
    'link_angle': 'the link angle', 'other_link_angle': 'the link angle of the other joint',
    'joint_torque': 'the joint torque', 'motor_torque': 'the motor torque',
}


@dataclass(frozen=True)
class Unexplained:
    """A rest that no effect of the catalogue explains: where it is and what it follows."""

    site: str
    joint: str | None
    depends_on: str
    line: float | None          # of a wave: over time [Hz], over an angle [1/turn]; or None
    share: float                # of the unexplained power that is explained by this, in [0, 1]

    def sentence(self) -> str:
        """Return where the rest is and what it follows."""
        place = f'the {self.site} of {self.joint or "the arm"}'
        if self.depends_on == NOTHING:
            return f'the rest sits in {place} and follows nothing that was measured'
        line = '' if self.line is None else f', strongest at {self.line:.4g} {self._scale()}'
        return (f'{100.0 * self.share:.0f} % of the rest sits in {place} and follows '
                f'{IN_WORDS.get(self.depends_on, self.depends_on)}{line}')

    def _scale(self) -> str:
        return {'time': 'Hz', 'motor_angle': 'per motor turn'}.get(self.depends_on,
                                                                   'per link turn')
