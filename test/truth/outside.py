"""Effects that no catalogue lists: a diagnosis must call them unknown, and say where they live."""

from .effect import angle, between, Effect, either_sign, one_of, Parameter

OUTSIDE = (
    Effect('link_torque_line', 'link', 'time', (
        Parameter('amplitude', 'N*m', 0.0, between((0.5, 1.5))),
        Parameter('frequency', 'Hz', 4.0, between((1.0, 9.0))),
        Parameter('phase', 'rad', 0.0, angle()))),
    Effect('motor_torque_line', 'motor', 'time', (
        Parameter('amplitude', 'N*m', 0.0, between((0.006, 0.015))),
        Parameter('frequency', 'Hz', 6.0, between((3.0, 12.0))),
        Parameter('phase', 'rad', 0.0, angle()))),
    # About the middle of joint 1's motions, so that no straight line takes most of it.
    Effect('cubic_spring', 'link', 'link_angle', (
        Parameter('coefficient', 'N*m/rad^3', 0.0, either_sign(3.0, 7.0)),
        Parameter('centre', 'rad', 0.3, between((0.2, 0.4)))), joints=('joint1',)),
    Effect('crossed_friction', 'motor', 'other_link_angle', (
        Parameter('amplitude', '1', 0.0, between((0.3, 0.6))),
        Parameter('order', '1', 2.0, one_of(2, 3, 4)),
        Parameter('phase', 'rad', 0.0, angle()))),
    Effect('angle_dependent_stiffness', 'torsion', 'link_angle', (
        Parameter('amplitude', '1', 0.0, between((0.15, 0.35))),
        Parameter('order', '1', 3.0, one_of(3, 4, 5)),
        Parameter('phase', 'rad', 0.0, angle()))),
    Effect('third_order_kinematic_error', 'torsion', 'motor_angle', (
        Parameter('amplitude', 'rad', 0.0, between((0.5e-4, 1.5e-4))),
        Parameter('phase', 'rad', 0.0, angle()))),
    Effect('tooth_torque', 'link', 'link_angle', (
        Parameter('amplitude', 'N*m', 0.0, between((0.5, 1.5))),
        Parameter('order', '1', 7.0, one_of(5, 6, 7, 8, 9)),
        Parameter('phase', 'rad', 0.0, angle()))),
    Effect('encoder_drift', 'torsion', 'time', (
        Parameter('rate', 'rad/s', 0.0, either_sign(3e-6, 1e-5)),)),
)
