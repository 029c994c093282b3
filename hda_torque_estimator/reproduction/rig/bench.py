"""
Run an arm as its nodes do: plant, estimator and controller of the product.

What is pushed is given as torques at the joints, which the tip force follows as the arm turns.
`run` goes sample by sample, `follow` takes the compiled loop along a known path.
"""

from typing import NamedTuple

from hda_arm_sim.foundation.arrays import Array
from hda_arm_sim.foundation.rigid import tool_jacobian
from hda_arm_sim.model.arm import Arm
from hda_arm_sim.model.kernel import LINK_ANGLE, MOTOR_ANGLE
from hda_arm_sim.model.parts import Links
from hda_arm_sim.motions import Motion
from hda_arm_sim.plant import Plant
from hda_arm_sim.simulate import rest
import numpy as np
from numpy.typing import NDArray

from ...controlling.controller import Controller, ControllerSettings
from ...controlling.reference import hold
from ...estimating.estimator import Estimator, EstimatorSettings
from ...estimating.laws.layout import KINEMATIC_TORSION, TORQUE, TORSION
from ...simulating import closed_loop

STEP = 1e-3                         # between samples [s]
TORSION_ALONE = EstimatorSettings(fusion=0.0)   # as in the paper, without the motor's torque


class Inputs(NamedTuple):
    """What acts on an arm over time, (k, n): motor torque beside the controller's, and a load."""

    current: Array                  # [N*m, shaft]
    load: Array                     # torque of the environment on the joints [N*m]

    @property
    def time(self) -> Array:
        """Return the times of the samples (k,) [s]."""
        return STEP * np.arange(float(len(self.current)))


class BenchRun(NamedTuple):
    """What was true, what the encoders showed and what was estimated, (k, n)."""

    time: Array                     # (k,) [s]
    motor_angle: Array              # true [rad, shaft]
    link_angle: Array               # true [rad]
    joint_torque: Array             # true, through the gear [N*m]
    reading: Array                  # (k, n, READINGS)
    torque: Array                   # estimated, through the gear [N*m]
    torsion: Array                  # total, measured [rad]
    kinematic: Array                # of it, what the estimator takes for kinematic [rad]
    command: Array                  # motor torque [N*m, shaft]

    @property
    def stamps(self) -> NDArray[np.int64]:
        """Return the stamps of the samples (k,) [ns]."""
        return stamps(len(self.time))


def stamps(count: int) -> NDArray[np.int64]:
    """Return the stamps of so many samples [ns]."""
    return np.arange(1, count + 1, dtype=np.int64) * round(1e9 * STEP)


def quiet(joints: int, seconds: float) -> Inputs:
    """Return inputs of zero."""
    nothing = np.zeros((round(seconds / STEP) + 1, joints))
    return Inputs(nothing, nothing.copy())


def run(true: Arm, known: Arm, inputs: Inputs, start: tuple[float, ...], *,
        controller: ControllerSettings | None = None, seed: int = 0) -> BenchRun:
    """
    Run an arm from rest at link angles `start` [rad] under its inputs.

    A controller holds where the arm starts. Estimator and controller believe in `known`. A
    command answers the sample before it, as over a bus.
    """
    plant, estimator = Plant(true, rest(true, start), STEP, seed), Estimator(known, TORSION_ALONE)
    law = Controller(known, controller or ControllerSettings())
    if controller is not None:
        law.enable()
        law.follow(hold(np.array(start)), 0)
    made = _empty(len(inputs.current), len(start))
    command = np.zeros(len(start))
    for k, stamp in enumerate(made.stamps.tolist()):
        reading = plant.sample()
        estimator.update(stamp, reading)
        state, torques = plant.state, estimator.joints
        made.motor_angle[k], made.link_angle[k] = state[:, MOTOR_ANGLE], state[:, LINK_ANGLE]
        made.joint_torque[k], made.reading[k] = plant.joint_torque, reading
        made.torque[k], made.torsion[k] = torques[:, TORQUE], torques[:, TORSION]
        made.kinematic[k], made.command[k] = torques[:, KINEMATIC_TORSION], command
        plant.advance(command + inputs.current[k],
                      tip_force(_pair(true), made.link_angle[k], inputs.load[k]))
        command = law.update(stamp, reading[:, 0], torques[:, TORQUE]).copy()
    return made


def follow(true: Arm, known: Arm, rate: Array, load: Array, *,
           controller: ControllerSettings = ControllerSettings(), seed: int = 0) -> BenchRun:
    """
    Let a single axis follow a rate (k,) [rad/s] from angle 0 under a load (k,) [N*m].

    Both must begin with zero: the estimator takes the first half second for its tare.
    """
    time = STEP * np.arange(float(len(rate)))
    angle = STEP * (np.cumsum(rate) - 0.5 * (rate + rate[0]))
    across = load / _pair(true).length1
    force = np.stack([-across * np.sin(angle), across * np.cos(angle)], axis=1)
    made = closed_loop.run(true, known, Motion(time, angle[:, None], rate[:, None], force), seed,
                           controller=controller, estimator=TORSION_ALONE)
    estimated = _tared(known, made.reading)
    return BenchRun(time, made.state[:, :, MOTOR_ANGLE], made.state[:, :, LINK_ANGLE],
                    made.joint_torque, made.reading, estimated[:, :, TORQUE],
                    estimated[:, :, TORSION],
                    estimated[:, :, KINEMATIC_TORSION], made.command)


def _tared(known: Arm, reading: Array) -> Array:
    """Return the estimates (k, n, RESULTS) of readings (k, n, READINGS) that begin with a tare."""
    estimator, when = Estimator(known, TORSION_ALONE), stamps(len(reading))
    estimator.tare()
    first: list[Array] = []
    while estimator.taring:
        estimator.update(int(when[len(first)]), reading[len(first)])
        first.append(estimator.joints.copy())
    later = estimator.run(when[len(first):], reading[len(first):])
    return np.concatenate([np.array(first), later.joints])


def _empty(samples: int, joints: int) -> BenchRun:
    shape = samples, joints
    return BenchRun(STEP * np.arange(float(samples)), np.empty(shape), np.empty(shape),
                    np.empty(shape), np.empty((*shape, 4)), np.empty(shape), np.empty(shape),
                    np.empty(shape), np.empty(shape))


def _pair(arm: Arm) -> Links:
    """Return two links in a plane, or what they are unless an arm has them."""
    return arm.links if isinstance(arm.links, Links) else Links()


def tip_force(links: Links, angles: Array, load: Array) -> Array:
    """Return the tip force (2,) [N, base] that loads the joints (n,) with these torques [N*m]."""
    if not load.any():
        return np.zeros(2)
    if len(angles) == 1:
        across = load[0] / links.length1
        return across * np.array([-np.sin(angles[0]), np.cos(angles[0])])
    j11, _, j21, j22 = tool_jacobian(links.length1, links.length2, angles[1])
    across = load[1] / j22
    along = (load[0] - j21 * across) / j11
    c, s = np.cos(angles.sum()), np.sin(angles.sum())
    return np.array([c * along - s * across, s * along + c * across])
