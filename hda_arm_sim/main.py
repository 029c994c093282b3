"""The `arm_sim` executable."""

import sys

from .node import ArmSim
from .ros.process import run


def main() -> int:
    """Simulate the arm until asked to end, and return the exit code."""
    return run('arm_sim', lambda: [ArmSim()], kinds=[ArmSim])


if __name__ == '__main__':
    sys.exit(main())
