"""
What a page says of each effect: a sentence with its size, the part that has it, and the check.

A sentence goes on after a joint or the arm. `{size}` is the largest of the named numbers in the
unit in which people say it, times `scale`; other numbers stand there by their names.
"""

from typing import NamedTuple


class Words(NamedTuple):
    """How people speak of an effect; `less` is the sentence for a negative size."""

    said: str
    element: str                    # of the drawing: ELEMENTS
    check: str                      # what a mechanic does about it
    size: tuple[str, ...] = ()
    scale: float = 1.0
    less: str = ''


ELEMENTS = {
    'drive': 'drive', 'motor': 'motor', 'motor_encoder': 'motor encoder',
    'wave_generator': 'wave generator', 'flexspline': 'flexspline', 'flange': 'output flange',
    'bearing': 'link bearing', 'link_encoder': 'link encoder', 'link': 'link', 'tip': 'tip',
    'base': 'base',
}
_GREASE = 'Feel whether it turns evenly by hand with the drive off; check grease and seals.'
_MESH = 'Check grease, alignment and wear of the teeth; compare with a gear of the same size.'
_MOTOR = 'Turn the motor uncoupled, or compare with a spare one.'
_DRIVE = 'Read the settings of the drive, and measure its current beside the command.'
_ENCODER = 'Check how the disc is seated, and the error curve that the encoder itself can show.'
_CLOCK = 'Check the time stamps of the drive: trigger both encoders from one clock.'

WORDS = {
    'coulomb_friction': Words(
        'has {size} of dry friction at its motor, not what its model says', 'wave_generator',
        _GREASE, ('level',)),
    'viscous_friction': Words(
        'has {size} of viscous friction at its motor, not what its model says', 'wave_generator',
        _GREASE, ('slope',)),
    'nonlinear_viscous_friction': Words(
        'has friction of {size} at 1 rad/s that grows with speed to the power {exponent}',
        'wave_generator', _GREASE, ('coefficient',)),
    'stribeck_friction': Words(
        'needs {size} more at its motor to break away at low speed', 'wave_generator',
        'Check the grease: too little or too old makes surfaces touch at low speed.',
        ('excess',)),
    'presliding_friction': Words(
        'builds up its friction over a displacement after each reversal ({size} at the motor)',
        'wave_generator', 'Check the preload of the bearings and the seals of the motor shaft.',
        ('stiffness',)),
    'asymmetric_friction': Words(
        'has dry friction that is {size} larger forwards than its mean', 'wave_generator',
        'Check seals and brake, and read the current at standstill.', ('asymmetry',),
        less='has dry friction that is {size} larger backwards than its mean'),
    'load_dependent_friction': Words(
        'loses {size} of the torque through its gear to friction of the mesh', 'flexspline', _MESH,
        ('coefficient',)),
    'thermal_viscosity': Words(
        'has {size} more viscous friction cold, gone after some {time_constant} s',
        'wave_generator',
        'Warm the joint up before a measurement, or log the temperature of the gear.',
        ('amplitude',)),
    'position_dependent_friction': Words(
        'has dry friction that varies by {size}, {order} times per link turn', 'bearing',
        'Turn the link by hand and feel for a tight spot; check the seats of its bearing.',
        ('amplitude',)),
    'torque_ripple': Words(
        'has a torque ripple of {size} at its motor, twice or four times per motor turn',
        'wave_generator', 'Check how the wave generator is centred on the motor shaft.',
        ('amplitude_2', 'amplitude_4')),
    'motor_cogging': Words(
        'has {size} of cogging at its motor, {order} times per motor turn', 'motor', _MOTOR,
        ('amplitude',)),
    'torque_constant_error': Words(
        'gives {size} more torque than its motor is told', 'motor', _DRIVE, ('error',),
        less='gives {size} less torque than its motor is told'),
    'drive_offset': Words(
        'has a drive that adds {size} at its motor', 'drive',
        'Zero the current sensors of the drive at standstill.', ('offset',),
        less='has a drive that takes {size} away at its motor'),
    'current_loop_lag': Words('has a torque that lags {size} behind its command', 'drive', _DRIVE,
                              ('time_constant',)),
    'command_delay': Words('has a torque that comes {size} after its command', 'drive',
                           'Check the cycle time of bus and drive.', ('delay',)),
    'torque_saturation': Words('has a drive that gives {size} at most', 'drive',
                               'Read the current limit of the drive and its supply voltage.',
                               ('limit',)),
    'motor_inertia_error': Words(
        'has a rotor inertia that is {size} larger than stated', 'motor',
        'Compare the data sheets of motor, brake and wave generator.', ('error',),
        less='has a rotor inertia that is {size} smaller than stated'),
    'stiffness_error': Words(
        'has a flexspline that is {size} stiffer than stated', 'flexspline',
        'Check the size of the gear that is built in, and the screws of the flexspline.',
        ('error',), less='has a flexspline that is {size} softer than stated'),
    'stiffening_error': Words(
        'has a flexspline that stiffens {size} more with torque than stated', 'flexspline',
        'Load the joint in steps with its motor held, and read the torsion.', ('error',),
        less='has a flexspline that stiffens {size} less with torque than stated'),
    'wave_generator_compliance': Words(
        'winds up {size} more at its wave generator near zero torque', 'wave_generator',
        'Check the wear of the wave generator bearing.', ('compliance',),
        less='winds up {size} less at its wave generator near zero torque'),
    'torsional_hysteresis': Words(
        'has a torsion with a hysteresis of {size}', 'flexspline',
        'Load the joint slowly both ways with its motor held; check the screws of the flexspline.',
        ('level',)),
    'structural_damping': Words(
        'has a gear that damps torsion by {size}, not as stated', 'flexspline', _MESH,
        ('coefficient',)),
    'backlash': Words(
        'has {size} of play', 'flange',
        'Hold the motor, rock the link by hand, and feel or dial the play; '
        'tighten the screws and the key of the output flange.', ('half_width',), 2.0),
    'kinematic_error': Words(
        'has a gear with a transmission error of {size}', 'wave_generator',
        'Check how wave generator and circular spline are centred.',
        ('amplitude_1', 'amplitude_2', 'amplitude_4', 'amplitude_a', 'amplitude_b',
         'amplitude_c', 'amplitude_d')),
    'loaded_kinematic_error': Words(
        'has a transmission error that grows by {size} of torque', 'flexspline', _MESH,
        ('amplitude',)),
    'link_encoder_eccentricity': Words(
        'has a link encoder that is wrong by {size} along its turn', 'link_encoder', _ENCODER,
        ('amplitude_1', 'amplitude_2')),
    'motor_encoder_eccentricity': Words(
        'has a motor encoder that is wrong by {size} along its turn', 'motor_encoder', _ENCODER,
        ('amplitude',)),
    'encoder_scale_error': Words(
        'has a link encoder that counts {size} too much', 'link_encoder',
        'Check counts per turn and gear ratio in the settings of the drive.', ('error',),
        less='has a link encoder that counts {size} too little'),
    'encoder_interpolation_error': Words(
        'has a link encoder that is wrong by {size} at each of its lines', 'link_encoder',
        _ENCODER, ('amplitude',)),
    'coarse_quantisation': Words(
        'has an encoder that counts in steps of {size}', 'link_encoder',
        'Read resolution and bits of the encoder in the settings of the drive.',
        ('motor_step', 'link_step')),
    'clock_skew': Words('has a link encoder that is read {size} after its motor encoder',
                        'link_encoder', _CLOCK, ('skew',),
                        less='has a link encoder that is read {size} before its motor encoder'),
    'dropped_samples': Words('loses {size} of its samples', 'drive',
                             'Check bus load, cable and the queue of the recorder.', ('rate',)),
    'link_bearing_friction': Words(
        'has {size} of dry friction in its link bearing', 'bearing',
        'Turn the link by hand with the gear free; check preload, seal and cables.', ('level',)),
    'payload': Words('carries {size} more at its tip', 'tip',
                     'Look what is mounted at the tip, and weigh it.', ('mass',),
                     less='carries {size} less at its tip'),
    'link_inertia_error': Words(
        'has a link with {size} more mass or inertia than stated', 'link',
        'Compare the link with its drawing: tool, cover or cable that the file does not know.',
        ('error', 'mass'), less='has a link with {size} less mass or inertia than stated'),
    'inertial_coupling': Words(
        'has links that feel each other otherwise than the model says', 'link',
        'None: give the arm file inertias that depend on the posture.'),
    'base_tilt': Words('stands on a base that is tilted by {size}', 'base',
                       'Put a spirit level on the base.', ('tilt',)),
    'cable_spring': Words('is pulled by a cable or hose of {size}', 'link',
                          'Unhook cables and hoses, and record again.', ('stiffness',)),
    'external_contact': Words('was touched at the tip with {size}', 'tip',
                              'Look what the arm met there; keep its space free.', ('force',)),
    'base_vibration': Words('stands on a base that swings at {frequency} Hz', 'base',
                            'Tighten the feet of the base, or stiffen its stand.'),
    'bearing_crosstalk': Words(
        'shows {size} of tilting moment as torsion', 'bearing',
        'Check preload and play of the link bearing.', ('coefficient',)),
}
