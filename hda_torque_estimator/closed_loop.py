"""Arm, estimator and controller in one compiled loop, the same functions as the three nodes."""

from dataclasses import dataclass

from hda_arm_sim.drive import act
from hda_arm_sim.model.arm import Arm
from hda_arm_sim.model.compiled import compiled
from hda_arm_sim.model.kernel import registers, STATE, STATES
from hda_arm_sim.model.link_side import loaded_inertia
from hda_arm_sim.motions import Motion
from hda_arm_sim.plant import observe
from hda_arm_sim.sensors import DRAWS
from hda_arm_sim.simulate import checked, rest, step_count
import numpy as np
from numpy.typing import NDArray

from . import control, estimate
from .controller import compiled_settings as controller_settings, ControllerSettings
from .estimator import compiled_settings as estimator_settings, EstimatorSettings

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Run:
    """A closed-loop run, over time: what the encoders showed and what was true."""

    time: Array                 # (k,) [s]
    reading: Array              # (k, n, 4) angles and velocities of shaft and link
    command: Array              # (k, n) motor torque in force from the sample on, shaft [N*m]
    joint_torque: Array         # (k, n) true, through the gear [N*m]
    estimated_torque: Array     # (k, n) as the controller saw it [N*m]
    force: Array                # (k, 2) on the tip, base frame [N]
    state: Array                # (k, n, STATES) true


def run(true_arm: Arm, known_arm: Arm, motion: Motion, seed: int, *,
        controller: ControllerSettings = ControllerSettings(),
        estimator: EstimatorSettings = EstimatorSettings()) -> Run:
    """
    Let `true_arm` follow a motion under a controller that believes in `known_arm`.

    A command answers the sample before it, as over a bus. Raises ArmError where the arm cannot be
    simulated.
    """
    dt = float(motion.time[1] - motion.time[0])
    plant, belief = checked(true_arm, dt).record(), known_arm.record()
    samples, joints = motion.angle.shape
    noise = np.random.default_rng(seed).standard_normal((samples, joints, DRAWS))
    reference = np.stack([motion.angle, motion.rate], axis=2)
    reading, states = np.empty((samples, joints, 4)), np.empty((samples, joints, STATES))
    torques = np.zeros((3, samples, joints))
    _run(plant, belief, estimator_settings(known_arm, estimator),
         controller_settings(known_arm, controller), registers(rest(true_arm, motion.angle[0])),
         np.ascontiguousarray(reference), motion.force, noise, dt, step_count(dt), reading,
         states, torques)
    return Run(motion.time, reading, torques[0], torques[1], torques[2], motion.force, states)


@compiled
def _run(                                                           # type: ignore[no-untyped-def]
        plant, belief, estimating, controlling, w, reference, force, noise, dt, count, reading,
        states, torques):
    joints = reference.shape[1]
    inertia, believed = loaded_inertia(plant.body), loaded_inertia(belief.body)
    memory = np.zeros((joints, estimate.MEMORY))
    control_memory = np.zeros((joints, control.MEMORY))
    result, tip = np.zeros((joints, estimate.RESULTS)), np.zeros(estimate.TIP_RESULTS)
    now, command = np.zeros((joints, 4)), np.zeros(joints)
    for k in range(reference.shape[0]):
        since = dt if k > 0 else 0.0
        torques[0, k] = command
        observe(plant, inertia, w, noise[k], dt, k == 0, now, torques[1, k])
        reading[k], states[k] = now, w[:joints, STATE:STATE + STATES]
        estimate.step(belief, estimating, believed, memory, now, command, since, result,
                      tip)
        torques[2, k] = result[:, estimate.TORQUE]
        act(plant, inertia, w, command, force[k], dt, count)
        control.step(belief, controlling, control_memory, reference[k], now[:, 0],
                     torques[2, k], since, command)
