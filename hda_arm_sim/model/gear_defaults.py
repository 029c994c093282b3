"""Defaults of a gear: what an arm file leaves open about it, and which values stand there."""

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

from .parts import Joint, Tolerances
from .torsion import TorsionLaw

_OF_JOINT = ('ratio', 'motor_inertia')
_OF_TORSION = ('flexspline_stiffness', 'flexspline_curvature', 'wave_generator_stiffness',
               'wave_generator_curvature', 'damping', 'valid_torque')
_INFINITE = float('inf')
# Choices unless stated otherwise.
# (source: K1 of the catalogue's sizes 14 to 40, from 4.7 to 130 kN*m/rad at ratios from 80 on)
_UNKNOWN = 1.0          # one sigma of a stiffness and a damping that nobody stated, relative
_STIFFNESS = 'flexspline_stiffness'
_SURE = f'known to {100.0 * _UNKNOWN:g} %'
CLASS_DEFAULT = 'class default'
"""How the origin of a number begins that nobody has stated for this arm."""


def unstated(joint: Mapping[str, Any]) -> dict[str, str]:
    """
    Return the keys of a gear that the entry of a joint does not have, and what stands for them.

    Keys without a use are not missed: curvatures of a wave generator that is rigid, or of a
    flexspline in straight segments.
    """
    torsion = joint.get('torsion')
    given = torsion if isinstance(torsion, Mapping) else {}
    found = {key: _value(Joint, key) for key in _OF_JOINT if key not in joint}
    if not given:
        stiffness = _value(TorsionLaw, 'flexspline_stiffness')
        return {**found, 'torsion': f'a flexspline of {stiffness}, {_SURE}'}
    return {**found, **{f'torsion.{key}': _value(TorsionLaw, key) + f', {_SURE}' * (
        key == _STIFFNESS) for key in _OF_TORSION if key not in given and _is_missed(key, given)}}


def sentence(label: str, missing: Mapping[str, str]) -> str:
    """Return one sentence on what a joint does not state."""
    values = ', '.join(f'{key} ({value})' for key, value in missing.items())
    return f'{label} does not state what its gear is; class defaults stand for {values}'


def as_known(joint: Mapping[str, Any], tolerances: Tolerances) -> Tolerances | None:
    """
    Return tolerances that hold a stiffness and damping of class defaults, None where none is.

    What the entry of the joint states of its tolerances stays.
    """
    missing, stated = unstated(joint), joint.get('tolerances') or {}
    wide = {name: _UNKNOWN for name, key in (('stiffness', _STIFFNESS), ('damping', 'damping'))
            if name not in stated and {'torsion', f'torsion.{key}'} & {*missing}}
    return replace(tolerances, **wide) if wide else None


def defaults_sentence(provenance: Mapping[str, str]) -> str:
    """Return one sentence on the numbers that are class defaults, empty if none is."""
    joints: dict[str, list[str]] = {}
    for place, origin in provenance.items():
        if origin.startswith(CLASS_DEFAULT):
            joint, _, name = place.partition('.')
            joints.setdefault(name, []).append(joint)
    names = ', '.join(f'{name} ({", ".join(labels)})' for name, labels in joints.items())
    return f'class defaults stand for {names}, until hda calibrate' if names else ''


def _value(kind: type[Joint] | type[TorsionLaw], key: str) -> str:
    rule = kind.declaration(key)
    return f'{rule.default:g} {rule.unit}'.strip()


def _is_missed(key: str, torsion: Mapping[str, Any]) -> bool:
    if key == 'flexspline_curvature':
        return not torsion.get('knee_1')
    if key == 'wave_generator_curvature':
        return torsion.get('wave_generator_stiffness') != _INFINITE
    return True
