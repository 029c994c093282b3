"""Arm, estimator and controller in one compiled loop, the same functions as the three nodes."""

from dataclasses import dataclass
import math
from typing import NamedTuple

from hda_arm_sim.drive import act
from hda_arm_sim.foundation.arrays import Array
from hda_arm_sim.foundation.compiled import compiled
from hda_arm_sim.model.arm import Arm, ArmRecord
from hda_arm_sim.model.effect_loops import any_acts
from hda_arm_sim.model.effects.place import SAMPLE
from hda_arm_sim.model.kernel import registers, STATE, STATES
from hda_arm_sim.model.link_side import loaded_inertia
from hda_arm_sim.motions import Motion, pushed_link
from hda_arm_sim.plant import observe
from hda_arm_sim.sensors import DRAWS, sample_lost
from hda_arm_sim.simulate import checked, longest_step, on_tip, STEP, step_count
from hda_arm_sim.stamping import Stamper
from hda_arm_sim.start import start_of
import numpy as np
from numpy.typing import NDArray

from ..controlling import control
from ..controlling.controller import (
    bearable, compiled_settings as controller_settings, ControllerSettings)
from ..estimating.estimator import compiled_settings as estimator_settings, EstimatorSettings
from ..estimating.laws import estimate, layout
from ..estimating.laws.compiled_settings import Model

# Choices unless stated otherwise.
CONTROL_PERIOD = 1e-3   # longest between two commands: a slow log is that of a faster loop [s]
SAME_RATE = 0.02        # share by which clocks of one rate may differ: 1.000002 ms is 1 ms


@dataclass(frozen=True)
class ClosedLoopRun:
    """A closed-loop run, over time: what the encoders showed and what was true."""

    time: Array                 # (k,) [s]
    reading: Array              # (k, n, 4) angles and velocities of shaft and link
    command: Array              # (k, n) motor torque in force from the sample on, shaft [N*m]
    joint_torque: Array         # (k, n) true, through the gear [N*m]
    estimated_torque: Array     # (k, n) as the controller saw it [N*m], NaN without an estimator
    force: Array                # (k, 2) on the tip, base frame [N]; of a chain the wrench (k, 6)
    state: Array                # (k, n, STATES) true
    late: NDArray[np.int64]     # (k,) by how much each was stamped after its time [ns]
    pushed: int = 0             # link that the wrench acted on at its end, 0 for the tip


def run(true_arm: Arm, known_arm: Arm, motion: Motion, seed: int, *,
        controller: ControllerSettings | None = None,
        estimator: EstimatorSettings | None = EstimatorSettings(),
        drive_noise: Array | None = None) -> ClosedLoopRun:
    """
    Let `true_arm` follow a motion under a controller that believes in `known_arm`.

    A command answers the sample before it, as over a bus. Where samples are further apart than
    CONTROL_PERIOD, the loop runs at a whole multiple of their rate. They are every so many of its
    samples, as most logs come about. Without a `controller` the gains are the usual ones, or less
    where the lightest rotor of `known_arm` would chatter. Where nobody reads estimated torques
    `estimator` may be None. Raises ArmError where the arm cannot be simulated, ValueError where
    the controller needs an estimator and has none.
    """
    if controller is None:
        controller = bearable(known_arm, ControllerSettings())
    if drive_noise is None:
        drive_noise = np.zeros(motion.angle.shape)
    if estimator is None and controller.torque_feedback:
        raise ValueError('torque feedback needs an estimator: controller.torque_feedback is '
                         f'{controller.torque_feedback:g} and estimator is None')
    dt = float(motion.time[1] - motion.time[0])
    plant = checked(true_arm, dt).record()
    motion = motion._replace(force=on_tip(true_arm, motion.force))
    every = max(1, math.ceil(dt / CONTROL_PERIOD - SAME_RATE))
    if every > 1:
        made = run(true_arm, known_arm, _refined(motion, every), seed, controller=controller,
                   estimator=estimator, drive_noise=_held(drive_noise, every))
        return _thinned(made, motion, every, _lost(true_arm, len(made.time), seed))
    believed, start = known_arm.torsion_only(), start_of(true_arm, motion.angle[0])
    belief, whole = believed.record(), known_arm.record()
    samples, joints = motion.angle.shape
    noise, late = _noise(samples, joints, seed), _late(true_arm, motion, seed)
    reference = np.stack([motion.angle, motion.rate], axis=2)
    reading, states = np.empty((samples, joints, 4)), np.empty((samples, joints, STATES))
    torques = np.zeros((3, samples, joints))
    minds = _Minds(Model(belief, estimator_settings(believed, estimator or EstimatorSettings()),
                         loaded_inertia(belief.body)),
                   controller_settings(known_arm, controller),
                   control.ControlledArm(whole, loaded_inertia(whole.body)), estimator is not None)
    _run(plant, minds, registers(start.state, pushed_link(true_arm, motion)),
         _Plan(np.ascontiguousarray(reference), motion.force, noise, drive_noise, start.command,
               _since(late, dt), dt, step_count(dt, min(STEP, longest_step(true_arm)))),
         _RunArrays(reading, states, torques))
    if estimator is None:
        torques[2] = np.nan
    return ClosedLoopRun(motion.time, reading, torques[0], torques[1], torques[2], motion.force,
                         states, late, motion.pushed)


def _late(arm: Arm, motion: Motion, seed: int) -> NDArray[np.int64]:
    """Return how late each sample is stamped (k,) [ns]."""
    taken = np.round(motion.time * 1e9).astype(np.int64)
    return Stamper(arm, seed)(taken) - taken


def _since(late: NDArray[np.int64], dt: float) -> Array:
    """Return the time from stamp to stamp (k,), by which all who read them reckon [s]."""
    since = dt + np.diff(late, prepend=0) * 1e-9
    since[0] = 0.0
    return np.asarray(since)


def _noise(samples: int, joints: int, seed: int) -> Array:
    return np.random.default_rng(seed).standard_normal((samples, joints, DRAWS))


def _refined(motion: Motion, every: int) -> Motion:
    """Return a motion with so many times its samples: cubic between them, the force straight."""
    from scipy.interpolate import CubicHermiteSpline    # a third of a second few need to wait
    count = (len(motion.time) - 1) * every + 1
    time = (motion.time[1] - motion.time[0]) / every * np.arange(float(count))
    path = CubicHermiteSpline(motion.time, motion.angle, motion.rate)
    at = np.minimum(motion.time[0] + time, motion.time[-1])
    force = np.stack([np.interp(at, motion.time, axis) for axis in motion.force.T], axis=1)
    return Motion(time, path(at), path.derivative()(at), force, motion.pushed)


def _held(values: Array, every: int) -> Array:
    """Return values (k, n) at so many times their samples, each held until the next."""
    return np.repeat(values, every, axis=0)[:(len(values) - 1) * every + 1]


def _lost(arm: Arm, samples: int, seed: int) -> NDArray[np.bool_]:
    """Return which samples (k,) of a run were lost on their way."""
    record = arm.record()
    if not any_acts(record.body, SAMPLE):
        return np.zeros(samples, np.bool_)
    lost = [sample_lost(record, each) for each in _noise(samples, len(arm.joints), seed)]
    return np.array([False, *lost[1:]])


def _thinned(made: ClosedLoopRun, motion: Motion, every: int,
             lost: NDArray[np.bool_]) -> ClosedLoopRun:
    """Return every so many of the samples; a lost one repeats the one before that arrived."""
    rows = np.arange(0, len(made.time), every)
    latest = np.maximum.accumulate(np.where(lost[rows], 0, rows))
    reading = made.reading[latest]
    kept = np.flatnonzero(latest == rows)
    angles, dt = reading[kept, :, :2], motion.time[1] - motion.time[0]
    rate = np.concatenate([np.full_like(angles[:1], np.nan), np.diff(angles, axis=0) / dt])
    reading[:, :, 2:] = rate[np.searchsorted(kept, np.arange(len(rows)), side='right') - 1]
    return ClosedLoopRun(motion.time, reading, made.command[rows], made.joint_torque[rows],
                         made.estimated_torque[rows], motion.force, made.state[rows],
                         made.late[rows], motion.pushed)


class _Minds(NamedTuple):
    """What estimator and controller believe, and whether anything is estimated."""

    estimator: Model
    controller: control.CompiledControlSettings
    body: control.ControlledArm          # that the controller believes in
    estimates: bool


class _Plan(NamedTuple):
    """What is asked of every sample: references (k, n, 2), forces (k, 2), random numbers."""

    reference: Array
    force: Array
    noise: Array
    drive: Array                # (k, n) that drives give beyond the commands [N*m]
    held: Array                 # (n,) motor torques until the first answer [N*m]
    since: Array                # (k,) from the stamp before [s]
    dt: float                   # [s]
    steps: int                  # of the plant in a sample


class _RunArrays(NamedTuple):
    """What a run fills: readings, states, and torques: commanded, true, estimated (3, k, n)."""

    reading: Array
    states: Array
    torques: Array


@compiled
def _run(plant: ArmRecord, minds: _Minds, w: Array, plan: _Plan, made: _RunArrays) -> None:
    joints, dt, torques = plan.reference.shape[1], plan.dt, made.torques
    inertia = loaded_inertia(plant.body)
    memory = np.zeros((joints, layout.MEMORY))
    control_memory = np.zeros((joints, control.MEMORY))
    result, tip = np.zeros((joints, layout.RESULTS)), np.zeros(layout.TIP_RESULTS)
    now, command = np.zeros((joints, 4)), plan.held.copy()
    for k in range(plan.reference.shape[0]):
        since = plan.since[k]
        torques[0, k] = command
        observe(plant, inertia, w, plan.noise[k], dt if k > 0 else 0.0, now, torques[1, k])
        made.reading[k], made.states[k] = now, w[:joints, STATE:STATE + STATES]
        if minds.estimates:
            estimate.step(minds.estimator, memory, estimate.EncoderSample(now, command, since),
                          result,
                          tip)
            torques[2, k] = result[:, layout.TORQUE]
        act(plant, inertia, w, command + plan.drive[k], plan.force[k], dt, plan.steps)
        control.step(minds.body, minds.controller, control_memory,
                     control.Asked(plan.reference[k], now[:, 0], torques[2, k], since), command)
