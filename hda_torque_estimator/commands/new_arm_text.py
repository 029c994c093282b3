"""An arm file with a comment on every number: who stated it, or that it is a class default."""

from collections.abc import Iterator, Sequence
import json
import math
from textwrap import wrap

from hda_arm_sim.model.effects.catalogue import known_as, unmeasured_at, usual_at
from hda_arm_sim.model.effects.place import (CLOCK, GEAR, LINK_READING, LOOP, MOTOR_INERTIA,
                                             STIFFNESS, TRANSMISSION)
from hda_arm_sim.model.gear_catalogue import (ARC_MINUTE, HYSTERESIS_SOURCE, INERTIA_SOURCE,
                                              RATING_SOURCE, STIFFNESS_SOURCE)
from hda_arm_sim.model.gear_defaults import CLASS_DEFAULT
import yaml

from .arm_answers import JointAnswers, NewError, Rods
from .gear_table import UrdfLinks

STATED = 'as stated'
DAMPING_TIME = 8e-4     # class default of damping over stiffness, as in hda_arm.yaml [s]
_WIDTH = 90
_SOURCES = STIFFNESS_SOURCE, HYSTERESIS_SOURCE, RATING_SOURCE, INERTIA_SOURCE
_LOOP, _DAMPING = unmeasured_at(LOOP).name, unmeasured_at(GEAR).name
_INERTIA = unmeasured_at(MOTOR_INERTIA).name
_UNKNOWN_INERTIA = usual_at(MOTOR_INERTIA).sigma['error']
_DRY, _VISCOUS = known_as('dry_friction').name, known_as('viscous_friction').name

# One sigma of what is known before a calibration (docs/new_arm.md).
_TOLERANCES = (
    ('stiffness', usual_at(STIFFNESS).sigma['error'], 'catalogues state an average'),
    ('link_inertia', 0.2, 'uniform rods'),
    ('torque_constant', 0.1, 'data sheets of motors'),
    ('dry_friction', 0.5, 'differs with grease, load and age'),
    ('viscous_friction', 0.5, 'differs with temperature'),
    ('damping', 1.0, 'not stated by anybody'),
    ('torsion_zero', 1e-3, 'not taken yet [rad]'),
    ('kinematic_error', usual_at(TRANSMISSION).sigma['amplitude'], 'about 1 arcmin [rad]'),
    ('eccentricity', usual_at(LINK_READING).sigma['amplitude'],
     'of an encoder nobody has measured [rad]'),
    ('clock_skew', usual_at(CLOCK).sigma['skew'], 'of encoders nobody has measured [s]'))
_DRAWN = 'masses of a drawing; links.tolerances states each link'
_MOTOR_TOLERANCES = ('torque_ripple', 'drive_offset')
_OF_MOTOR = 0.02        # one sigma of ripple and offset, as a share of the largest torque


def arm_text(joints: Sequence[JointAnswers], rods: Rods | UrdfLinks | None) -> str:
    """Return the arm as commented YAML; raises NewError where something has to be stated."""
    lines = [*_head(joints), 'joints:']
    drawn = isinstance(rods, UrdfLinks)
    for joint in joints:
        lines += [*_joint_lines(joint, drawn), *_own_tolerances(joint, joints)]
    lines += [*_link_lines(rods), *_effect_lines(joints), *_tolerance_lines(joints, drawn),
              *_provenance_lines(joints)]
    return '\n'.join(lines) + '\n'


def _head(joints: Sequence[JointAnswers]) -> Iterator[str]:
    names = ', '.join(dict.fromkeys(joint.gear.name for joint in joints))
    yield f'# Made by hda new: {len(joints)} joint{"s" * (len(joints) > 1)} with {names}.'
    yield '# Angles in rad, torques in N*m; friction, inertia and limits at the motor shaft,'
    yield '# torsion at the output of the gear. hda calibrate replaces catalogue by measurement.'
    for place, source in enumerate(_SOURCES, 1):
        yield from wrap(f'[{place}] {source}', _WIDTH, initial_indent='# ',
                        subsequent_indent='#     ')


def _joint_lines(joint: JointAnswers, drawn: bool) -> Iterator[str]:
    """Yield what is known of a joint; limits of its angle are `drawn` if a description is."""
    gear = joint.gear
    k1, k2, k3 = gear.stiffness
    t1, t2 = gear.knees
    rows = (
        ('ratio', *_ratio(joint)),
        ('motor_inertia', *_inertia(joint)),
        ('dry_friction', joint.starting_torque or 0.0, _stated(joint.starting_torque)),
        ('viscous_friction', joint.viscous_friction or 0.0, _stated(joint.viscous_friction)),
        ('torque_limit', *_motor_torque(joint)),
        ('velocity_limit', *_speed(joint)),
        ('angle_limit', 1e3, 'none but that of the description' if drawn
                             else 'not stated: no limit'),
        *((('effort_lag', joint.effort_lag, 'as stated [samples]'),)
          if joint.effort_lag is not None else ()))
    torsion = (
        ('flexspline_stiffness', k1, 'K1 [N*m/rad], wave generator blocked [1]'),
        ('knee_1', t1, 'T1 [1]'), ('second_stiffness', k2, 'K2 [1]'), ('knee_2', t2, 'T2 [1]'),
        ('third_stiffness', k3, 'K3 [1]'),
        ('wave_generator_stiffness', math.inf, 'its wind-up is in K1, and in the hysteresis'),
        ('damping', DAMPING_TIME * k1, f'{CLASS_DEFAULT}: {DAMPING_TIME:g} s times K1'),
        ('valid_torque', *_peak(joint)))
    yield f'  - name: {_word(joint.label)}'
    yield from (_row(4, *row) for row in rows)
    yield '    torsion:'
    yield from (_row(6, *row) for row in torsion)
    for side, counts in (('motor', joint.motor_counts), ('link', joint.link_counts)):
        origin = joint.origin(f'{side}_counts')
        yield _beside(f'    {side}_encoder: {{counts: {yaml_number(counts)}}}',
                      f'per turn, {origin}' if counts else
                      origin.replace(STATED, f'{STATED}: perfect'))


def _own_tolerances(joint: JointAnswers, joints: Sequence[JointAnswers]) -> Iterator[str]:
    """Yield what is smaller at a joint whose motor is weaker than the strongest."""
    weaker = (own := _of_motor([joint])) < _of_motor(joints)
    if weaker or joint.motor_inertia is None:
        yield '    tolerances:'
    if joint.motor_inertia is None:
        yield _row(6, 'motor_inertia', _UNKNOWN_INERTIA, 'actuators of one size differ')
    if weaker:
        for name in _MOTOR_TOLERANCES:
            yield _row(6, name, own, f'{_OF_MOTOR:g} of its own largest torque [N*m]')


def _of_motor(joints: Sequence[JointAnswers]) -> float:
    """Return one sigma of ripple and offset of the strongest of some motors [N*m]."""
    return min(_OF_MOTOR * max(joint.motor_torque for joint in joints), 1.0)


def _ratio(joint: JointAnswers) -> tuple[float, str]:
    if joint.ratio is None:
        return joint.gear.ratio, joint.gear.name
    return joint.ratio, joint.origin('ratio')


def _inertia(joint: JointAnswers) -> tuple[float, str]:
    own = joint.gear.inertia
    if joint.motor_inertia is None:
        return joint.gear.usual_inertia, f'{CLASS_DEFAULT}: of servo actuators of this size [4]'
    if own is None:
        return joint.motor_inertia, f'as stated; that of the {joint.gear.name} is not known to us'
    return joint.motor_inertia + own, f'rotor as stated, and wave generator {own:g} [3]'


def _motor_torque(joint: JointAnswers) -> tuple[float, str]:
    if joint.torque_constant is not None and joint.motor_current is not None:
        return joint.motor_torque, (f'{joint.torque_constant:g} N*m/A times '
                                    f'{joint.motor_current:g} A, as stated')
    return joint.motor_torque, joint.origin('motor_torque')


def _speed(joint: JointAnswers) -> tuple[float, str]:
    if joint.motor_speed is not None:
        return joint.motor_speed, 'as stated [rad/s]'
    return (_of_table(joint, joint.gear.speed, '--motor-speed in rad/s'),
            'largest input speed of the gear [rad/s] [3]')


def _peak(joint: JointAnswers) -> tuple[float, str]:
    if joint.peak_torque is not None:
        return joint.peak_torque, 'repeated peak torque, as stated'
    return (_of_table(joint, joint.gear.peak_torque, '--peak-torque in N*m'),
            'repeated peak torque of the gear [3]')


def _of_table(joint: JointAnswers, rating: float | None, option: str) -> float:
    """Return a rating of the joint's gear; raises NewError where no table has it."""
    if rating is None:
        raise NewError(f'{joint.label} needs {option}: no public table of its gear '
                       f'{joint.gear.name} was found')
    return rating


def _stated(value: float | None) -> str:
    return 'not stated: unknown until hda calibrate' if value is None else 'as stated'


def _link_lines(rods: Rods | UrdfLinks | None) -> Iterator[str]:
    if isinstance(rods, UrdfLinks):
        yield _beside('links:', 'as the robot description states')
        yield from (f'  {name}: {_word(value)}' for name, value in
                    (('urdf', rods.urdf), ('tip', rods.tip)))
        return
    if rods is None:
        yield _beside('links: none', 'not stated: torsion only, no tip force')
        return
    yield _beside('links:', f'uniform rods of {_numbers(rods.masses)} kg')
    yield f'  lengths: {_numbers(rods.lengths)}'
    yield f'  inertia: {_numbers(rods.inertia())}'
    yield f'  mass_moments: {_numbers(rods.mass_moments())}'
    yield _beside('base: {tilt: 0.0, direction: 0.0}', 'not stated: level')


def _effect_lines(joints: Sequence[JointAnswers]) -> Iterator[str]:
    if not any(map(_loss, joints)):
        yield 'effects: []'
        return
    yield 'effects:'
    for joint in joints:
        if loss := _loss(joint):
            source = 'at most [2]' if joint.hysteresis_loss is None else 'as stated'
            yield _beside(f'  - effect: {_LOOP}',
                          f'loss {loss / ARC_MINUTE:g} arcmin, {source}')
            yield f'    joint: {_word(joint.label)}'
            yield '    parameters:'
            yield _row(6, 'level', 0.5 * loss * joint.gear.stiffness[0], 'half the loss times K1')
            yield _row(6, 'width', 0.5 * loss, f'{CLASS_DEFAULT}: half of the loss')


def _tolerance_lines(joints: Sequence[JointAnswers], drawn: bool) -> Iterator[str]:
    """Yield how well numbers are known; links are `drawn` if a description states them."""
    yield _beside('tolerances:', 'one sigma, relative unless a unit is given')
    for name, size, why in _TOLERANCES:
        yield _row(2, name, size, _DRAWN if drawn and name == 'link_inertia' else why)
    for name in _MOTOR_TOLERANCES:
        yield _row(2, name, _of_motor(joints), f'{_OF_MOTOR:g} of the largest torque [N*m]')


def _provenance_lines(joints: Sequence[JointAnswers]) -> Iterator[str]:
    yield _beside('provenance:', 'by the names under which hda calibrate states its own')
    for joint in joints:
        origins = {
            'torsion': f'{joint.gear.name}, catalogue',
            f'{_DAMPING}.coefficient': f'{CLASS_DEFAULT}, {DAMPING_TIME:g} s times K1'}
        for name, value in ((f'{_DRY}.level', joint.starting_torque),
                            (f'{_VISCOUS}.slope', joint.viscous_friction)):
            if value is None:
                origins[name] = f'{CLASS_DEFAULT}, 0, unknown'
        if joint.motor_inertia is None:
            origins[f'{_INERTIA}.error'] = f'{CLASS_DEFAULT}, {INERTIA_SOURCE}'
        if _loss(joint):
            origins[f'{_LOOP}.width'] = f'{CLASS_DEFAULT}, half of the loss'
        for name, origin in origins.items():
            yield f"  {_word(f'{joint.label}.{name}')}: {_word(origin)}"


def _loss(joint: JointAnswers) -> float:
    """Return the hysteresis loss of a joint [rad at the output]."""
    if joint.hysteresis_loss is None:
        return joint.gear.hysteresis_loss
    return joint.hysteresis_loss * ARC_MINUTE


def _word(text: str) -> str:
    """Return a text as YAML reads it as one, whatever is in it."""
    plain = str(yaml.safe_dump([text], default_flow_style=True, width=math.inf)).strip()[1:-1]
    return json.dumps(text) if '\n' in plain else plain


def _row(indent: int, name: str, value: float, comment: str) -> str:
    return _beside(f'{" " * indent + name}: {yaml_number(value)}', comment)


def _beside(text: str, comment: str) -> str:
    return f'{text:<43} # {comment}'


def _numbers(values: Sequence[float]) -> str:
    return f'[{", ".join(map(yaml_number, values))}]'


def yaml_number(value: float) -> str:
    """Return a number that YAML 1.1 reads as a number, on ten digits."""
    if math.isinf(value):
        return '.inf'
    text = repr(float(f'{value:.10g}'))
    return text.replace('e', '.0e') if 'e' in text and '.' not in text else text
