"""Estimate joint torques and the force at the tip from a recording, and their error."""

from pathlib import Path
import sys

from hda_arm_sim.model.files import read_arm
from hda_arm_sim.motions import motion
from hda_torque_estimator.estimating.estimator import Estimator
from hda_torque_estimator.simulating.closed_loop import run
import numpy as np

out = Path(sys.argv[1] if len(sys.argv) > 1 else 'out/03')
arm = read_arm('hda_arm.yaml')
made = run(arm, arm, motion('push', 2, 8.0, 1e-3, 3), 3)        # two pushes at the tip

stamps = 1 + np.round(made.time * 1e9).astype(np.int64)         # [ns]
estimates = Estimator(arm).run(stamps, made.reading, made.command)

error = estimates.torque - made.joint_torque                    # (k, 2) [N*m]
for label, column in zip(arm.labels, error.T):
    print(f'{label}: torque within {np.sqrt(np.nanmean(column ** 2)):.3f} N*m rms')

out.mkdir(parents=True, exist_ok=True)
np.savetxt(out / 'torques.csv', np.column_stack([made.time, estimates.torque]),
           delimiter=',', header='time,joint1,joint2', comments='', fmt='%.6g')
