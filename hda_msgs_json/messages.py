"""
Messages as strict JSON: frozen dataclasses to text and back.

A message class names its schema in the class variable `SCHEMA`; the text carries it as the field
"schema". Reading refuses fields that are unknown, missing or of another type. JSON has no NaN and
no infinity: a number that may be unknown is a `MaybeNan`, NaN in Python and null in the text.
"""

from collections.abc import Callable, Mapping
import dataclasses
from functools import lru_cache
import json
import math
import types
import typing
from typing import Annotated, Any, ClassVar, TypeVar

from hda_msgs_json.errors import HdaError

MAY_BE_NAN = 'may be NaN'
MaybeNan = Annotated[float, MAY_BE_NAN]
SCHEMA_FIELD = 'schema'

Message = TypeVar('Message')
Convert = Callable[[Any, str], Any]


class MessageError(HdaError):
    """Raised when a text is not the message that it should be, or a message has no text."""


@dataclasses.dataclass(frozen=True)
class EstimatorState:
    """
    State what the estimator knows after one sample; all tuples but the force have one per joint.

    Numbers that could not be estimated are NaN. `valid` says whether the estimate of a joint may
    be used, `flags` why not, or what else is remarkable about a joint or the arm.
    """

    SCHEMA: ClassVar[str] = 'hda.estimator_state/2'

    stamp: int
    """Time of the sample that was answered [ns]."""
    names: tuple[str, ...]
    """Joints."""
    torsion: tuple[MaybeNan, ...]
    """Motor angle through the gear minus link angle [rad]."""
    kinematic_torsion: tuple[MaybeNan, ...]
    """The part of the torsion that the gear makes without any torque [rad]."""
    torque: tuple[MaybeNan, ...]
    """Torque through the gear [N*m]."""
    torque_std: tuple[MaybeNan, ...]
    """Its standard deviation [N*m]."""
    external_torque: tuple[MaybeNan, ...]
    """Torque of the environment on the joint [N*m]."""
    external_torque_std: tuple[MaybeNan, ...]
    """Its standard deviation [N*m]."""
    motor_share: tuple[MaybeNan, ...]
    """Share of the motor's torque in what is known of the torque; the rest is the torsion's."""
    valid: tuple[bool, ...]
    """Whether the torque of a joint may be used."""
    flags: tuple[str, ...]
    """Sentences or names of what is remarkable."""
    tip_force: tuple[MaybeNan, ...]
    """Force of the environment on the tip, x and y in the base frame, of a chain z too [N]."""
    tip_force_covariance: tuple[MaybeNan, ...]
    """Its covariance, row by row [N^2]."""
    singular: bool
    """Whether the arm stands so that a component of the force cannot be observed."""
    conditioning: MaybeNan
    """Smallest over largest singular value of the Jacobian."""
    contact_deviations: MaybeNan
    """External torques over their standard deviations, all joints together."""
    payload: MaybeNan
    """Mass at the tip beyond that of the model [kg]."""
    payload_std: MaybeNan
    """Its standard deviation [kg]."""
    contact: str
    """'free', 'contact' while something pushes, 'collision' from a hard push to the reset."""
    torsion_zero: tuple[MaybeNan, ...] = ()
    """Torsion that is taken for none: by a tare and as learnt [rad]."""
    contact_beyond: str = ''
    """Outermost joint that feels the contact, '' for none: the push is on the links beyond it."""


def to_json(message: object) -> str:
    """Return a message as one line of JSON; raise MessageError if it has no such text."""
    kind: Any = type(message)
    content: dict[str, object] = {SCHEMA_FIELD: _schema(kind)}
    for name, (write, _) in _fields(kind).items():
        content[name] = write(getattr(message, name), f'{kind.__name__}.{name}')
    return json.dumps(content, allow_nan=False, separators=(',', ':'))


def assembled(kind: type, texts: Mapping[str, str]) -> str:
    """
    Return the text of a message from the JSON of each of its fields, as `to_json` orders them.

    It is for messages that are written by the thousand. Raise MessageError if a field is missing
    or unknown.
    """
    names = list(_fields(kind))
    if wrong := set(names) ^ texts.keys():
        raise MessageError(f'{kind.__name__} is made of other fields: {_listed(wrong)}')
    parts = [f'"{SCHEMA_FIELD}":"{_schema(kind)}"', *(f'"{name}":{texts[name]}' for name in names)]
    return '{' + ','.join(parts) + '}'


def from_json(kind: type[Message], text: str | bytes) -> Message:
    """Return the message of a class that a text holds; raise MessageError if it holds another."""
    content = _parse(text)
    schema, fields = _schema(kind), _fields(typing.cast(Any, kind))
    if (found := content.pop(SCHEMA_FIELD, None)) != schema:
        raise MessageError(f'the schema must be {schema!r}, got {found!r}')
    if unknown := content.keys() - fields.keys():
        raise MessageError(f'{kind.__name__} has no field {_listed(unknown)}')
    if missing := fields.keys() - content.keys():
        raise MessageError(f'{kind.__name__} lacks the field {_listed(missing)}')
    return kind(**{
        name: read(content[name], f'{kind.__name__}.{name}')
        for name, (_, read) in fields.items()})


def _parse(text: str | bytes) -> dict[str, Any]:
    try:
        content = json.loads(text, parse_constant=_refuse, object_pairs_hook=_unique)
    except (ValueError, RecursionError) as error:
        raise MessageError(f'the text is not JSON: {error}') from None
    if not isinstance(content, dict):
        raise MessageError(f'the text must be a JSON object, got a {type(content).__name__}')
    return content


def _refuse(constant: str) -> None:
    raise MessageError(f'{constant} is not a number of JSON; what is not known is null')


def _unique(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
    content = dict(pairs)
    if len(content) < len(pairs):
        raise MessageError('a field is given twice')
    return content


def _schema(kind: type) -> str:
    schema = getattr(kind, 'SCHEMA', None)
    if not dataclasses.is_dataclass(kind) or not isinstance(schema, str):
        raise MessageError(f'{kind.__name__} is no message: it is not a dataclass with a SCHEMA')
    return schema


@lru_cache
def _fields(kind: Any) -> dict[str, tuple[Convert, Convert]]:
    """Return how each field of a message class is written and read."""
    hints = typing.get_type_hints(kind, include_extras=True)
    return {field.name: _converters(hints[field.name])
            for field in dataclasses.fields(kind)}


def _converters(hint: Any) -> tuple[Convert, Convert]:
    """Return how values of a type are written and read."""
    if hint in _SCALARS:
        return _SCALARS[hint]
    arguments = typing.get_args(hint)
    if typing.get_origin(hint) is tuple and arguments[1:] == (...,):
        write, read = _converters(arguments[0])
        return _write_each(write), _read_each(read)
    if typing.get_origin(hint) in (types.UnionType, typing.Union) and type(None) in arguments:
        (inner,) = (argument for argument in arguments if argument is not type(None))
        write, read = _converters(inner)
        return _optional(write), _optional(read)
    raise MessageError(f'no message can have a field of the type {hint}')


def _write_each(write: Convert) -> Convert:
    def write_each(value: Any, name: str) -> list[Any]:
        if not isinstance(value, tuple | list):
            raise _wrong(name, 'a tuple', value)
        return [write(item, name) for item in value]
    return write_each


def _read_each(read: Convert) -> Convert:
    def read_each(value: Any, name: str) -> tuple[Any, ...]:
        if not isinstance(value, list):
            raise _wrong(name, 'a list', value)
        return tuple(read(item, name) for item in value)
    return read_each


def _optional(convert: Convert) -> Convert:
    def convert_optional(value: Any, name: str) -> Any:
        return None if value is None else convert(value, name)
    return convert_optional


def _exact(kind: type, what: str) -> Convert:
    def convert_exact(value: Any, name: str) -> Any:
        if type(value) is not kind:
            raise _wrong(name, what, value)
        return value
    return convert_exact


def _number(value: Any, name: str) -> float:
    if isinstance(value, bool) or not isinstance(value, int | float) or not math.isfinite(value):
        raise _wrong(name, 'a finite number', value)
    return float(value)


def _write_maybe_nan(value: Any, name: str) -> float | None:
    if isinstance(value, float) and math.isnan(value):
        return None
    return _number(value, name)


def _read_maybe_nan(value: Any, name: str) -> float:
    return math.nan if value is None else _number(value, name)


_INTEGER = _exact(int, 'an integer')
_TEXT = _exact(str, 'a text')
_TRUTH = _exact(bool, 'true or false')
_SCALARS: dict[Any, tuple[Convert, Convert]] = {
    int: (_INTEGER, _INTEGER),
    str: (_TEXT, _TEXT),
    bool: (_TRUTH, _TRUTH),
    float: (_number, _number),
    MaybeNan: (_write_maybe_nan, _read_maybe_nan),
}


def _wrong(name: str, what: str, value: object) -> MessageError:
    shown = repr(value)
    return MessageError(f'{name} must be {what}, got {shown[:40]}{"..." * (len(shown) > 40)}')


def _listed(names: set[str]) -> str:
    return ', '.join(repr(name) for name in sorted(names))
