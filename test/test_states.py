"""The estimator state as a message: every number in its field, in the form of all messages."""

from dataclasses import replace
import json

from hda_arm_sim.model.files import read_arm
from hda_msgs_json.messages import assembled, EstimatorState, from_json, MessageError, to_json
from hda_torque_estimator.estimating.belief_words import believed, doubts_in_words
from hda_torque_estimator.estimating.estimates import Estimates
from hda_torque_estimator.estimating.laws import layout
from hda_torque_estimator.estimating.state_messages import state_samples, StateWriter
from hypothesis import given, strategies as st
from hypothesis.extra.numpy import arrays
import numpy as np
import pytest

SHIPPED = read_arm('hda_arm.yaml')
ARM = replace(SHIPPED, joints=tuple(
    replace(joint, label=label)
    for joint, label in zip(SHIPPED.joints, ('100 %s "quoted"', 'elbow\u00e9'))))
NUMBERS = st.floats(width=64)
RESULTS = arrays(np.float64, (3, 2, layout.RESULTS), elements=NUMBERS)
TIPS = arrays(np.float64, (3, layout.TIP_RESULTS), elements=NUMBERS)
FIELDS = {'torsion': layout.TORSION, 'kinematic_torsion': layout.KINEMATIC_TORSION,
          'torque': layout.TORQUE, 'torque_std': layout.TORQUE_DEVIATION,
          'external_torque': layout.EXTERNAL_TORQUE,
          'external_torque_std': layout.EXTERNAL_DEVIATION}


def known(values: np.ndarray) -> list[float]:
    """Return numbers as a message holds them: what is infinite is as unknown as NaN."""
    return np.where(np.isfinite(values), values, np.nan).tolist()


@given(joints=RESULTS, tip=TIPS, taring=st.booleans())
def test_a_text_is_the_message_of_its_numbers(
        joints: np.ndarray, tip: np.ndarray, taring: bool) -> None:
    """Reading a text gives the numbers to the last bit, and writing what was read the text."""
    stamps = [0, 5, 2 ** 62]
    for row, text in enumerate(StateWriter(ARM).texts(stamps, joints, tip, taring=taring)):
        state = from_json(EstimatorState, text)
        assert to_json(state) == text
        assert (state.stamp, state.names) == (stamps[row], ARM.labels)
        for field, index in FIELDS.items():
            np.testing.assert_array_equal(getattr(state, field), known(joints[row, :, index]))
        np.testing.assert_array_equal(state.tip_force, known(
            tip[row, [layout.BASE_X, layout.BASE_Y]]))
        covariance = tip[row, layout.BASE_COVARIANCE:][:4]
        np.testing.assert_array_equal(state.tip_force_covariance, known(covariance))
        np.testing.assert_array_equal(
            state.conditioning, known(tip[row, layout.CONDITIONING]))
        beyond = joints[row, :, layout.BEYOND_RANGE] > 0
        doubts = joints[row, :, layout.DOUBT].tolist()
        reported = doubts_in_words(ARM.labels, doubts)
        assert state.valid == tuple(~beyond & [believed(doubt) for doubt in doubts])
        assert state.singular == (tip[row, layout.SINGULAR] > 0)
        assert len(state.flags) == len(reported) + beyond.sum() + state.singular + taring


@given(joints=RESULTS, tip=TIPS)
def test_one_state_is_that_of_a_recording(joints: np.ndarray, tip: np.ndarray) -> None:
    """The node writes one state after another, the command all at once: the same texts."""
    stamps = np.array([1, 2, 3]) * 10 ** 9
    reported = state_samples(ARM, Estimates(stamps, joints, tip, np.empty(0, np.int64)))
    write = StateWriter(ARM)
    assert reported.texts == tuple(map(write, stamps.tolist(), joints, tip))
    assert reported.stamps.tolist() == stamps.tolist()


def test_no_estimates_have_no_states() -> None:
    """A recording of which nothing was used states nothing."""
    nothing = Estimates(np.empty(0, np.int64), np.empty((0, 2, layout.RESULTS)),
                        np.empty((0, layout.TIP_RESULTS)), np.empty(0, np.int64))
    assert len(state_samples(ARM, nothing)) == 0


def test_a_message_is_assembled_of_all_its_fields() -> None:
    """A field too few or too many is a defect of the program, not of a message."""
    fields = json.loads(StateWriter(ARM)(1, np.zeros((2, layout.RESULTS)),
                                         np.zeros(layout.TIP_RESULTS)))
    texts = {name: json.dumps(value) for name, value in fields.items() if name != 'schema'}
    assert json.loads(assembled(EstimatorState, texts)) == fields
    with pytest.raises(MessageError, match="made of other fields: 'colour'"):
        assembled(EstimatorState, texts | {'colour': '0'})
    del texts['torque']
    with pytest.raises(MessageError, match="made of other fields: 'torque'"):
        assembled(EstimatorState, texts)
