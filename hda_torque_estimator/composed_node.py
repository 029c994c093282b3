"""The simulated arm, the estimator and the controller in one process: `composed:=true`."""

import sys

from hda_arm_sim.node import ArmSim
from hda_arm_sim.ros.process import run

from .controlling.controller_node import JtfController
from .estimating.estimator_node import TorqueEstimator


def main() -> int:
    """Run all three until asked to end, and return the exit code."""
    kinds = (ArmSim, TorqueEstimator, JtfController)
    return run('composed_node', lambda: [kind() for kind in kinds], kinds=kinds)


if __name__ == '__main__':
    sys.exit(main())
