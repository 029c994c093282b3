"""
Write a table as a data logger might: time, link angle, shaft angle and torque of one joint.

    some_table.py FILE
"""

import sys

import numpy as np

RATIO, RATE, SECONDS = 100.0, 1000.0, 10.0
HEADS = 't,q1,motor_pos_1,motor_torque_1'


def main() -> int:
    """Write the table and return the exit code."""
    time = np.arange(0.0, SECONDS, 1.0 / RATE)
    link = 0.5 * np.sin(1.3 * time)
    torque = 0.1 * np.cos(1.3 * time)
    np.savetxt(sys.argv[1], np.stack([time, link, RATIO * link, torque], axis=1),
               delimiter=',', header=HEADS, comments='', fmt='%.9g')
    return 0


if __name__ == '__main__':
    sys.exit(main())
