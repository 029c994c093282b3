"""JSON messages: nothing is lost, nothing is guessed, and every refusal says why."""

from dataclasses import dataclass, fields, replace
import json
import math
from typing import ClassVar

from hda_msgs_json.messages import EstimatorState, from_json, MaybeNan, MessageError, to_json
from hypothesis import given, strategies as st
import pytest

NUMBERS = st.floats(allow_infinity=False)
STATE = EstimatorState(
    stamp=5, names=('joint1', 'joint2'), torsion=(1e-4, math.nan), kinematic_torsion=(0.0, 0.0),
    torque=(1.5, math.nan), torque_std=(0.1, math.nan), external_torque=(0.0, 0.25),
    external_torque_std=(0.1, 0.1), motor_share=(0.0, 0.6), valid=(True, False),
    flags=('joint2: no position',),
    tip_force=(1.0, -2.0), tip_force_covariance=(1.0, 0.0, 0.0, 1.0), singular=False,
    conditioning=0.3, contact_deviations=1.5, payload=0.2, payload_std=0.1,
    contact='free')


@dataclass(frozen=True)
class Sample:
    """One of each kind of field."""

    SCHEMA: ClassVar[str] = 'test.sample/3'

    count: int
    size: float
    guess: MaybeNan
    name: str
    note: str | None
    grid: tuple[tuple[float, ...], ...]


SAMPLE = Sample(1, 0.5, math.nan, 'a', None, ((1.0, 2.0), ()))


def plain(message: EstimatorState) -> dict[str, object]:
    """Return the fields with NaN as a text, so that equal messages compare equal."""
    return {field.name: repr(getattr(message, field.name)) for field in fields(message)}


@given(st.builds(
    EstimatorState,
    **{name: st.lists(NUMBERS, max_size=3).map(tuple) for name in (
        'torsion', 'kinematic_torsion', 'torque', 'torque_std', 'external_torque',
        'external_torque_std', 'motor_share', 'tip_force', 'tip_force_covariance')},
    conditioning=NUMBERS, contact_deviations=NUMBERS, payload=NUMBERS, payload_std=NUMBERS))
def test_estimator_state_round_trip(state: EstimatorState) -> None:
    """A state comes back as it was, to the last bit of every number."""
    assert plain(from_json(EstimatorState, to_json(state))) == plain(state)


def test_text_is_plain_json() -> None:
    """Readers in other languages find the schema first, null for NaN, and no NaN anywhere."""
    content = json.loads(to_json(STATE))
    assert list(content)[0] == 'schema'
    assert content['schema'] == 'hda.estimator_state/2'
    assert content['torque'] == [1.5, None]
    assert 'NaN' not in to_json(STATE)


def test_every_kind_of_field_comes_back() -> None:
    """Nested tuples and optional texts survive, and a whole number is a float where one is due."""
    assert repr(from_json(Sample, to_json(SAMPLE))) == repr(SAMPLE)
    assert from_json(Sample, to_json(SAMPLE).replace('0.5', '2')).size == 2.0


@pytest.mark.parametrize('change, error', [
    ({'extra': 1}, "Sample has no field 'extra'"),
    ({'name': ...}, "Sample lacks the field 'name'"),
    ({'schema': 'test.sample/2'}, "the schema must be 'test.sample/3', got 'test.sample/2'"),
    ({'schema': ...}, 'got None'),
    ({'count': 1.0}, 'Sample.count must be an integer, got 1.0'),
    ({'count': True}, 'Sample.count must be an integer, got True'),
    ({'size': None}, 'Sample.size must be a finite number, got None'),
    ({'size': False}, 'Sample.size must be a finite number, got False'),
    ({'guess': '1'}, "Sample.guess must be a finite number, got '1'"),
    ({'name': 5}, 'Sample.name must be a text, got 5'),
    ({'note': 5}, 'Sample.note must be a text, got 5'),
    ({'grid': [1.0]}, 'Sample.grid must be a list, got 1.0'),
    ({'name': ['x' * 90]}, r"must be a text, got \['xxx.*\.\.\.$"),
])
def test_what_does_not_fit_is_refused(change: dict[str, object], error: str) -> None:
    """Unknown, missing and mistyped fields are named with what was got."""
    content = {**json.loads(to_json(SAMPLE)), **change}
    content = {name: value for name, value in content.items() if value is not ...}
    with pytest.raises(MessageError, match=error):
        from_json(Sample, json.dumps(content))


@pytest.mark.parametrize('text, error', [
    ('', 'not JSON'), ('{', 'not JSON'), ('[]', 'must be a JSON object, got a list'),
    (b'\xff', 'not JSON'), ('[' * 100_000, 'not JSON'),
    ('{"schema": NaN}', 'NaN is not a number'), ('{"size": -Infinity}', 'Infinity is not'),
    ('{"a": 1, "a": 1}', 'given twice'),
])
def test_what_is_not_json_is_refused(text: str | bytes, error: str) -> None:
    """No text makes the reader fail in another way than with one clear error."""
    with pytest.raises(MessageError, match=error):
        from_json(Sample, text)


def test_numbers_beyond_the_range_are_refused() -> None:
    """A number that would become infinite is not read as one."""
    with pytest.raises(MessageError, match='Sample.size must be a finite number'):
        from_json(Sample, to_json(SAMPLE).replace('0.5', '1e999'))


@pytest.mark.parametrize('message, error', [
    (replace(SAMPLE, size=math.nan), 'Sample.size must be a finite number, got nan'),
    (replace(SAMPLE, guess=math.inf), 'Sample.guess must be a finite number, got inf'),
    (replace(SAMPLE, name=3), 'Sample.name must be a text, got 3'),
    ('text', 'str is no message'),
])
def test_a_message_without_text_is_refused(message: object, error: str) -> None:
    """A number that JSON lacks, a wrong type and a class that is no message are named."""
    with pytest.raises(MessageError, match=error):
        to_json(message)


@given(st.data())
def test_mutated_text_is_read_or_refused(data: st.DataObject) -> None:
    """Any change of the text gives a message or a MessageError."""
    text = list(to_json(STATE))
    for _ in range(data.draw(st.integers(1, 3))):
        at = data.draw(st.integers(0, len(text) - 1))
        text[at] = data.draw(st.sampled_from(['', '"', ',', '9', '[', '}', 'e', '\\', '\0']))
    try:
        from_json(EstimatorState, ''.join(text))
    except MessageError as error:
        assert '\n' not in str(error)
