"""
Measure the simulation of seven joints beside that of MuJoCo: same chain, springs and torques.

    bench_mujoco.py [--quick]

MuJoCo reads the robot description by itself. Each joint is two hinges there: a rotor, its inertia
as armature, and behind it the spring of the gear. Springs are linear, as it knows no wind-up. An
error is the largest of any link against the program's own solution at a far finer step, without
dry friction: MuJoCo's gives way where friction holds. So with dry friction there are times alone.
MuJoCo is no dependency of this package: `pip install mujoco` puts it beside.
"""

from collections.abc import Sequence
from dataclasses import replace
from importlib.util import find_spec
import sys
import time
from typing import Any, NamedTuple, Protocol

from hda_arm_sim.foundation.arrays import Array
from hda_arm_sim.model.arm import Arm
from hda_arm_sim.model.chain_links import ChainLinks
from hda_arm_sim.model.files import read_arm
from hda_arm_sim.motions import home_of
from hda_arm_sim.simulate import InputHistory, longest_step, rollout
from hda_arm_sim.start import Start, start_of
import numpy as np
from size import parser, verdict

ARM = read_arm('cobot7.yaml')
DT = 1e-3                           # for which a torque is held [s]
SECONDS, REPEATS = 2.0, 20
TINY = 0.02, 1                      # of a tiny case
ACCURATE = 1e-6                     # error that the tests of this simulator allow [rad]
FINEST = 32                         # steps a sample of the solutions that errors count from
WAYS = (('ours', 1), ('ours', 2), ('ours', 3), ('ours', 4), ('MuJoCo RK4', 1), ('MuJoCo RK4', 2),
        ('MuJoCo RK4', 3), ('MuJoCo RK4', 4), ('MuJoCo implicitfast', 1),
        ('MuJoCo implicitfast', 10))


class Row(NamedTuple):
    """What a program reaches with so many steps a sample."""

    program: str
    steps: int
    error: float                    # largest of a link [rad]
    faster: float                   # than real time, without dry friction
    rough: float                    # the same with dry friction


class Program(Protocol):
    """A simulator of the chain."""

    def __call__(self, torque: Array, steps: int) -> Array:
        """Return link angles (k, n) at every sample, under torques (k, n) [rad, N*m]."""


class Ours:
    """The simulator of this project."""

    def __init__(self, arm: Arm, start: Start) -> None:
        """Keep the arm and its state."""
        self._arm, self._state = arm, start.state

    def __call__(self, torque: Array, steps: int) -> Array:
        """Return link angles (k, n) at every sample [rad]."""
        inputs = InputHistory(torque, np.zeros((len(torque), 2)))
        return rollout(self._arm, self._state, inputs, DT, step=DT / steps).link_angle


class Theirs:
    """MuJoCo, whose loop over all steps is compiled as well."""

    def __init__(self, arm: Arm, start: Start, integrator: str) -> None:
        """Build the chain from its robot description."""
        import mujoco
        from mujoco import rollout as run
        self._model, self._run = mujoco_chain(arm), run.rollout
        self._model.opt.integrator = getattr(mujoco.mjtIntegrator, f'mjINT_{integrator.upper()}')
        self._data = mujoco.MjData(self._model)
        shaft = start.state[:, 0] / [joint.ratio for joint in arm.joints]
        self._data.qpos[::2], self._data.qpos[1::2] = shaft, start.state[:, 2] - shaft
        size = mujoco.mj_stateSize(self._model, mujoco.mjtState.mjSTATE_FULLPHYSICS)
        self._start: Array = np.empty(size)
        mujoco.mj_getState(self._model, self._data, self._start,
                           mujoco.mjtState.mjSTATE_FULLPHYSICS)

    def __call__(self, torque: Array, steps: int) -> Array:
        """Return link angles (k, n) at every sample [rad]."""
        self._model.opt.timestep = DT / steps
        states, _ = self._run(self._model, self._data, self._start[None],
                              np.repeat(torque, steps, axis=0)[None])
        angles = states[0, steps - 1::steps, 1:1 + self._model.nq]
        first = self._start[1:1 + self._model.nq]
        return np.vstack([first, angles[:-1]]).reshape(len(torque), -1, 2).sum(axis=2)


def linear(arm: Arm, *, rough: bool) -> Arm:
    """Return an arm with linear springs, with its dry friction or without."""
    return replace(arm, joints=tuple(
        replace(joint, dry_friction=joint.dry_friction if rough else 0.0,
                torsion=replace(joint.torsion, flexspline_curvature=0.0,
                                wave_generator_curvature=0.0)) for joint in arm.joints))


def mujoco_chain(arm: Arm) -> Any:
    """Return MuJoCo's model of an arm with linear springs."""
    import mujoco
    assert isinstance(arm.links, ChainLinks)
    spec = mujoco.MjSpec.from_string(arm.links.description)
    spec.option.gravity = (0.0, 0.0, -arm.base.gravity)
    for joint, hinge in zip(arm.joints, list(spec.joints)):
        law, square = joint.torsion, joint.ratio ** 2
        hinge.limited = hinge.actfrclimited = mujoco.mjtLimited.mjLIMITED_FALSE
        hinge.armature, hinge.frictionloss = (
            joint.motor_inertia * square, joint.dry_friction * joint.ratio)
        hinge.damping[0] = joint.viscous_friction * square
        spring = hinge.parent.add_joint(name=f'{hinge.name} gear', axis=hinge.axis,
                                        type=mujoco.mjtJoint.mjJNT_HINGE)
        spring.stiffness[0] = 1.0 / (1.0 / law.flexspline_stiffness
                                     + 1.0 / (square * law.wave_generator_stiffness))
        spring.damping[0] = law.damping
        motor = spec.add_actuator(name=hinge.name, target=hinge.name,
                                  trntype=mujoco.mjtTrn.mjTRN_JOINT)
        motor.gear[0] = joint.ratio
    return spec.compile()


def pushed(start: Start, seconds: float) -> Array:
    """Return what holds the arm, and waves of a fifth of it on top (k, n) [N*m]."""
    moments, joints = np.arange(0.0, seconds, DT), np.arange(len(start.command))
    return start.command + 0.2 * np.abs(start.command).max() * np.sin(
        2.0 * np.outer(moments, 1.0 + joints)) / (1.0 + joints)


def programs(rough: bool) -> dict[str, Program]:
    """Return every simulator of the chain with dry friction or without."""
    arm = linear(ARM, rough=rough)
    start = start_of(linear(ARM, rough=False), home_of(ARM))
    return {'ours': Ours(arm, start),
            **{f'MuJoCo {name}': Theirs(arm, start, name) for name in ('RK4', 'implicitfast')}}


def spent(program: Program, torque: Array, steps: int) -> float:
    """Return the processor time of a run [s]."""
    began = time.process_time()
    program(torque, steps)
    return time.process_time() - began


def measured(seconds: float, repeats: int) -> tuple[list[Row], float]:
    """Return what each way reaches, all in turn, and how far the fine solutions are apart."""
    torque = pushed(start_of(linear(ARM, rough=False), home_of(ARM)), seconds)
    smooth, rough = programs(rough=False), programs(rough=True)
    fine = {name: smooth[name](torque, FINEST) for name in ('ours', 'MuJoCo RK4')}
    fine['MuJoCo implicitfast'] = fine['MuJoCo RK4']
    longest = longest_step(linear(ARM, rough=False))
    ways = [(name, steps) for name, steps in WAYS if name != 'ours' or DT / steps <= longest]
    errors = [np.abs(smooth[name](torque, steps) - fine[name]).max() for name, steps in ways]
    times = np.array([[[spent(made[name], torque, steps) for made in (smooth, rough)]
                       for name, steps in ways] for _ in range(repeats)])
    rows = [Row(name, steps, float(error), *(seconds / best)) for (name, steps), error, best
            in zip(ways, errors, times.min(axis=0))]
    return rows, float(np.abs(fine['ours'] - fine['MuJoCo RK4']).max())


def fastest(rows: Sequence[Row], ours: bool) -> Row:
    """Return the fastest way that is accurate enough."""
    return max((row for row in rows if (row.program == 'ours') is ours and row.error <= ACCURATE),
               key=lambda row: row.faster)


def main() -> int:
    """Measure both and print a table."""
    quick = parser(__doc__).parse_args().quick
    if find_spec('mujoco') is None:
        print('not measured: MuJoCo is not installed (pip install mujoco)')
        return 0
    rows, apart = measured(*(TINY if quick else (SECONDS, REPEATS)))
    print(f'seven joints; both at {FINEST} steps a sample agree to {apart:.1g} rad')
    print(f'{"":22}{"step [ms]":>10}{"error [rad]":>13}{"times real time":>17}'
          f'{"with dry friction":>19}')
    for row in rows:
        print(f'{row.program:22}{1e3 * DT / row.steps:>10.3g}{row.error:>13.1e}'
              f'{row.faster:>17.0f}{row.rough:>19.0f}')
    by_way = {(row.program, row.steps): row for row in rows}
    for program, steps in by_way:
        if program == 'ours':
            same, other = by_way[program, steps], by_way['MuJoCo RK4', steps]
            print(f'step {1e3 * DT / steps:.3g} ms, errors {same.error:.1e} and {other.error:.1e} '
                  f'rad: {same.faster / other.faster:.2f} times as fast, with dry friction '
                  f'{same.rough / other.rough:.2f} times')
    own, other = fastest(rows, ours=True), fastest(rows, ours=False)
    return verdict(f'any step with errors of at most {ACCURATE:g} rad: '
                   f'{own.faster / other.faster:.2f} times as fast as {other.program}, at least 1',
                   own.faster >= other.faster, quick=quick)


if __name__ == '__main__':
    sys.exit(main())
