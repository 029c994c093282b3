"""What the axes of figures and plots are called."""

from ..findings.rest import SENSOR

COORDINATES = {
    'time': 'time [s]',
    'motor_velocity': 'motor velocity, shaft [rad/s]',
    'link_velocity': 'link velocity [rad/s]',
    'motor_angle': 'motor angle in its turn, shaft [rad]',
    'link_angle': 'link angle [rad]',
    'other_link_angle': 'link angle of the other joint [rad]',
    'joint_torque': 'joint torque, output [N·m]',
    'motor_torque': 'motor torque, shaft [N·m]',
}
GIVEN, EXTENDED, ADJUSTED = 'arm as given', 'extended arm', 'within its tolerances'
RESIDUAL = 'residual, output [N·m]'
BALANCES = ('A, motor', 'B, torsion', 'C, sensor')
SIDES = ('motor', 'torsion', SENSOR)     # sites of their residuals
