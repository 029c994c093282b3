"""
The estimator as a node has it: the bytes of a joint state in, the bytes of its estimates out.

Nothing here reads a clock, so the same messages always get the same answers.
"""

from dataclasses import dataclass
from typing import ClassVar, NamedTuple

from hda_arm_sim.foundation.parameter import Declared, parameter
from hda_arm_sim.model.arm import Arm
from hda_msgs_json.cdr import encode_string
import numpy as np

from .estimate_messages import EstimateEncoder
from .estimator import Estimator, EstimatorSettings, Refusal
from .laws.layout import FUSION
from .number_messages import NumberEncoder
from .route_health import remarks
from .state_messages import Pacer, STATE_RATE, StateWriter
from ..samples.gaps import Gaps
from ..samples.readings import READINGS
from ..samples.sample_reader import not_later, SampleReader


@dataclass(frozen=True)
class StateSettings(Declared):
    """How often the state of the estimator is published."""

    name: ClassVar[str] = 'estimator_state'
    state_rate: float = parameter(STATE_RATE, 'Hz', 0.01, 1e4, 'messages on estimator_state')


class SampleAnswer(NamedTuple):
    """What one sample gave."""

    stamp: int                  # [ns]
    messages: list[bytes]       # in the order of the topics of `estimate_topics`
    state: bytes | None         # of samples at which it is due
    numbers: list[bytes]        # of these, in the order of the topics of `number_topics`


class LiveEstimator:
    """Answer one joint state after another."""

    def __init__(self, arm: Arm, settings: EstimatorSettings = EstimatorSettings(),
                 state: StateSettings = StateSettings(), unobserved: str = 'nan') -> None:
        """Prepare for an arm, with everything compiled before the first sample comes."""
        _warm_up(arm)
        self.estimator = Estimator(arm, settings)
        self.gaps = Gaps()
        self.answered = 0
        self._last = 0
        self._read = SampleReader(arm)
        self._encode = EstimateEncoder(arm, unobserved)
        self._write_state = StateWriter(arm)
        self._encode_numbers = NumberEncoder(arm)
        self._pacer = Pacer(state.state_rate)

    def __call__(self, message: bytes) -> SampleAnswer:
        """Return the estimates from a joint state; raises Refused and goes on as before it."""
        stamp, reading = self._read(message)
        estimator = self.estimator
        fault = estimator.update(stamp, reading, self._read.command)
        if fault is Refusal.NOT_FINITE:
            raise self._read.not_finite(stamp, reading)
        if fault is Refusal.NOT_LATER:
            raise not_later(stamp, self._last, '; after a jump back of less than 1 s call '
                            'torque_estimator/reset')
        if stamp <= self._last:
            self.gaps.restart()
        self._last = stamp
        self.answered += 1
        self.gaps.add(stamp)
        results = estimator.joints, estimator.tip
        messages = self._encode(stamp, *results)
        if not self._pacer.due(stamp):
            return SampleAnswer(stamp, messages, None, [])
        return SampleAnswer(stamp, messages, self._state(stamp),
                            self._encode_numbers(stamp, *results))

    def reset(self) -> None:
        """Forget every sample, filter and tare, so that stamps may begin anew."""
        self.estimator.reset()
        self.gaps.restart()

    def set_state(self, settings: StateSettings) -> None:
        """Publish the state at another rate from now on."""
        self._pacer = Pacer(settings.state_rate)

    def _state(self, stamp: int) -> bytes:
        estimator = self.estimator
        return encode_string(self._write_state(stamp, estimator.joints, estimator.tip,
                                               taring=estimator.taring))


def _warm_up(arm: Arm) -> None:
    """Have every compiled function loaded, which may take longer than a sample."""
    scratch = Estimator(arm)
    scratch.tare()
    for stamp in (1, 2):
        scratch.update(stamp, np.zeros((len(arm.joints), READINGS)), np.zeros(len(arm.joints)))
    for label, memory in zip(arm.labels, scratch.memory):
        remarks(arm.tolerances_of(label), memory[FUSION:])     # a report comes between two samples
