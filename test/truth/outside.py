"""Effects that no catalogue lists: a diagnosis must call them unknown, and say where they live."""

from .effect import angle, between, Effect, either_sign, one_of, shape, size

OUTSIDE = (
    Effect('link_torque_line', 'link', 'time', (
        size('amplitude', 'N*m', 0.0, between((0.5, 1.5))),
        shape('frequency', 'Hz', 4.0, between((1.0, 9.0))),
        shape('phase', 'rad', 0.0, angle()))),
    Effect('motor_torque_line', 'motor', 'time', (
        size('amplitude', 'N*m', 0.0, between((0.006, 0.015))),
        shape('frequency', 'Hz', 6.0, between((3.0, 12.0))),
        shape('phase', 'rad', 0.0, angle()))),
    # About the middle of joint 1's motions, so that no straight line takes most of it.
    Effect('cubic_spring', 'link', 'link_angle', (
        size('coefficient', 'N*m/rad^3', 0.0, either_sign(3.0, 7.0)),
        shape('centre', 'rad', 0.3, between((0.2, 0.4)))), joints=('joint1',)),
    Effect('crossed_friction', 'motor', 'other_link_angle', (
        size('amplitude', '1', 0.0, between((0.3, 0.6))),
        shape('order', '1', 2.0, one_of(2, 3, 4)),
        shape('phase', 'rad', 0.0, angle()))),
    Effect('angle_dependent_stiffness', 'torsion', 'link_angle', (
        size('amplitude', '1', 0.0, between((0.15, 0.35))),
        shape('order', '1', 3.0, one_of(3, 4, 5)),
        shape('phase', 'rad', 0.0, angle()))),
    Effect('third_order_kinematic_error', 'torsion', 'motor_angle', (
        size('amplitude', 'rad', 0.0, between((0.5e-4, 1.5e-4))),
        shape('phase', 'rad', 0.0, angle()))),
    Effect('tooth_torque', 'link', 'link_angle', (
        size('amplitude', 'N*m', 0.0, between((0.5, 1.5))),
        shape('order', '1', 7.0, one_of(5, 6, 7, 8, 9)),
        shape('phase', 'rad', 0.0, angle()))),
    Effect('encoder_drift', 'torsion', 'time', (
        size('rate', 'rad/s', 0.0, either_sign(3e-6, 1e-5)),)),
)
