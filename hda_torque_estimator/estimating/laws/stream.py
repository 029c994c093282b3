"""Samples one after another: which of them are believed, and what is estimated from those."""

from typing import Any, NamedTuple

from hda_arm_sim.foundation.arrays import Array
from hda_arm_sim.foundation.compiled import borrowed, compiled, inlined
from hda_arm_sim.model.arm import ArmRecord
from hda_arm_sim.model.arm_arrays import inertia_of
import numpy as np
from numpy.typing import NDArray

from . import belief, estimate, layout
from .compiled_settings import CompiledSettings, Model
from .contact import level
from .estimate import EncoderSample
from ...samples.stamp_order import AFRESH, BACK, TWO


class StreamArrays(NamedTuple):
    """An arm and settings in arrays alone, which a call passes on quickest."""

    joints: NDArray[Any]
    body: NDArray[Any]
    inertia: Array
    settings: Array


class Remembered(NamedTuple):
    """What no arm can do, and what is remembered of the samples so far."""

    limits: Array
    watch: Array
    doubts: Array
    memory: Array


class Stream(NamedTuple):
    """Samples: (k, n, READINGS), commands (k, n), and times since the last ones (k,)."""

    reading: Array
    command: Array
    seconds: Array


class Scratch(NamedTuple):
    """Room for what one sample is made into on its way."""

    clean: Array                # (n, READINGS) without absurd velocities
    given: Array                # (n,) without absurd motor torques
    held: Array                 # (n, 3) what pulls at a joint, as `belief.feel_standstill` has it
    details: Array                 # (5,) what is wrong with a sample


@inlined
def _settings(numbers: Array) -> CompiledSettings:
    n = numbers
    return CompiledSettings(
        n[0], n[1], n[2], n[3], n[4], n[5], n[6], n[7], n[8], n[9], n[10], n[11],
        n[12:].reshape(-1, 3))


@compiled
def run(plain: StreamArrays, of: Remembered, stream: Stream, result: Array, tip: Array) -> None:
    """
    Estimate samples.

    One sample and a recording take the same machine code, therefore the same bits. Where a
    compiler joins a step to two callers, it may round differently in each.
    """
    joints = stream.reading.shape[1]
    scratch = Scratch(np.empty(stream.reading.shape[1:]), np.empty(joints), np.empty((joints, 3)),
                      np.zeros(5))
    _run(plain, of, stream, scratch, result, tip)


@inlined
def _lent(plain: StreamArrays, of: Remembered, stream: Stream,
          scratch: Scratch) -> tuple[StreamArrays, Remembered, Stream, Scratch]:
    """Return the same arrays, of which nobody counts who holds them: that took half of a step."""
    return (StreamArrays(borrowed(plain.joints), borrowed(plain.body), borrowed(plain.inertia),
                         borrowed(plain.settings)),
            Remembered(borrowed(of.limits), borrowed(of.watch), borrowed(of.doubts),
                       borrowed(of.memory)),
            Stream(borrowed(stream.reading), borrowed(stream.command), borrowed(stream.seconds)),
            Scratch(borrowed(scratch.clean), borrowed(scratch.given), borrowed(scratch.held),
                    borrowed(scratch.details)))


@compiled
def _run(plain: StreamArrays, of: Remembered, stream: Stream, scratch: Scratch, result: Array,
         tip: Array) -> None:
    """Estimate samples; the caller keeps all arrays alive."""
    plain, of, stream, scratch = _lent(plain, of, stream, scratch)
    result, tip = borrowed(result), borrowed(tip)
    model = Model(ArmRecord(plain.joints, plain.body[0]), _settings(plain.settings),
                  inertia_of(plain.inertia))
    reading, (clean, given, held, details) = stream.reading, scratch
    for i in range(reading.shape[0]):
        back, two = stream.seconds[i] <= BACK, stream.seconds[i] >= TWO
        passed = AFRESH if back else stream.seconds[i] - TWO if two else stream.seconds[i]
        if back:
            _forget(of.memory, of.doubts)
        belief.sane(of.limits, plain.joints, reading[i], stream.command[i], clean, given)
        dt = belief.look(model.record, of.limits, of.watch, of.doubts, reading[i], passed, details)
        if back or two:
            belief.blame(of.doubts, belief.CLOCK_BACK if back else belief.TWO_PUBLISHERS)
        if dt < 0.0:
            result[i, :, :] = np.nan
            tip[i, :] = np.nan
            result[i, :, layout.DOUBT] = 0.0
            tip[i, layout.CONTACT_LEVEL] = level(of.memory[0, layout.CONTACT:])
        else:
            belief.feel_slips(model.record, of.limits, of.doubts, of.memory[:, layout.FUSION:],
                              clean, dt)
            estimate.step(model, of.memory, EncoderSample(clean, given, dt), result[i], tip[i])
            for j in range(result.shape[1]):
                held[j, 0] = result[i, j, layout.EXTERNAL_TORQUE]
                held[j, 1] = result[i, j, layout.EXTERNAL_DEVIATION]
                held[j, 2] = result[i, j, layout.TORQUE]
            belief.feel_standstill(model.record, of.limits, of.doubts, clean, held, dt)
        for j in range(result.shape[1]):
            result[i, j, layout.DOUBT] = belief.doubt(of.doubts, j, result[i, j, layout.DOUBT])


@compiled
def _forget(memory: Array, doubts: Array) -> None:
    """Begin as after a start, but with the zero of the last tare."""
    for j in range(memory.shape[0]):
        zero = memory[j, layout.ZERO]
        memory[j, :] = 0.0
        doubts[j, :] = 0.0
        memory[j, layout.ZERO] = zero
