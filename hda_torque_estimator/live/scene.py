"""
What the live page shows, made of the last message of every topic.

Messages come by the thousand and are kept as bytes. They are read when somebody looks.
"""

import math
from typing import Any, NamedTuple

from hda_arm_sim.model.arm import Arm
from hda_msgs_json.cdr import CdrError, decode_joint_state, decode_string, decode_wrench
from hda_msgs_json.messages import EstimatorState, from_json, MessageError
from hda_msgs_json.topics import ESTIMATOR_STATE, JOINT_STATES, TIP_WRENCH, Topic

from .skeleton import stance

SILENCE = 1.0           # a stream that was quiet for so long is shown as stopped: a choice [s]
FORGOTTEN = 5.0         # a node that has not reported for so long is shown as gone [s]


class NodeHealth(NamedTuple):
    """What a node said of itself last."""

    name: str
    level: int              # 0 well, 1 warning, 2 error, as in diagnostic_msgs
    message: str
    at: float               # [s]


class Scene:
    """The arm as it was heard last; times are seconds of one steady clock that callers read."""

    def __init__(self, arm: Arm) -> None:
        """Begin with nothing heard."""
        self._arm = arm
        self._last: dict[Topic, tuple[float, bytes]] = {}
        self._health: dict[str, NodeHealth] = {}
        self._counted = 0
        self._rate, self._since, self._before = 0.0, 0.0, 0

    def hear(self, topic: Topic, message: bytes, now: float) -> None:
        """Keep the last message of a topic."""
        self._last[topic] = now, message
        self._counted += topic is JOINT_STATES

    def hear_health(self, health: NodeHealth) -> None:
        """Keep the last report of a node."""
        self._health[health.name] = health

    def picture(self, now: float) -> dict[str, Any]:
        """Return all that is shown, as JSON has it: what is not known is null."""
        self._measure_rate(now)
        angles, state = self._angles(), self._state(now)
        whole = angles is not None and all(map(math.isfinite, angles))
        return {
            'names': list(self._arm.labels),
            'age': self._age(JOINT_STATES, now), 'rate': self._rate,
            'angles': angles and [_known(angle) for angle in angles],
            'pieces': stance(self._arm, angles) if angles and whole else None,
            'estimate': state, 'tip_force': self._tip_force(now) if state else None,
            'nodes': [{'name': each.name, 'level': each.level, 'message': each.message,
                       'gone': now - each.at > FORGOTTEN}
                      for each in sorted(self._health.values())]}

    def _measure_rate(self, now: float) -> None:
        """Count the samples of at least half a second."""
        if (seconds := now - self._since) >= 0.5:
            self._rate = (self._counted - self._before) / seconds if self._since else 0.0
            self._since, self._before = now, self._counted

    def _age(self, topic: Topic, now: float) -> float | None:
        """Return how long ago a message came [s]."""
        known = self._last.get(topic)
        return None if known is None else now - known[0]

    def _angles(self) -> list[float] | None:
        """Return the angles of the links [rad], of the last sample that had all."""
        if JOINT_STATES not in self._last:
            return None
        try:
            state = decode_joint_state(self._last[JOINT_STATES][1])
        except CdrError:
            return None
        named = dict(zip(state.names, state.position.tolist()))
        return [named.get(label, math.nan) for label in self._arm.labels]

    def _state(self, now: float) -> dict[str, Any] | None:
        """Return the state of the estimator, None where it is silent or says something else."""
        age = self._age(ESTIMATOR_STATE, now)
        if age is None or age > SILENCE:
            return None
        try:
            state = from_json(EstimatorState,
                              decode_string(self._last[ESTIMATOR_STATE][1]))
        except (CdrError, MessageError):
            return None
        joints = {name: [_known(value) for value in getattr(state, name)] for name in (
            'torque', 'torque_std', 'external_torque', 'external_torque_std', 'torsion',
            'motor_share')}
        return {**joints, 'valid': list(state.valid), 'flags': list(state.flags),
                'contact': state.contact, 'payload': _known(state.payload),
                'payload_std': _known(state.payload_std), 'singular': state.singular}

    def _tip_force(self, now: float) -> list[float | None] | None:
        """Return the force of the environment on the tip, x, y, z in the base frame [N]."""
        age = self._age(TIP_WRENCH, now)
        if age is None or age > SILENCE:
            return None
        try:
            return [_known(value) for value in decode_wrench(self._last[TIP_WRENCH][1]).force]
        except CdrError:
            return None


def _known(value: float) -> float | None:
    return float(value) if math.isfinite(value) else None
