"""Hide an effect in a simulated arm, diagnose the recording, and compare with the truth."""

from pathlib import Path
import sys

from hda_arm_sim.model.effects import Backlash
from hda_arm_sim.model.files import read_arm
from hda_arm_sim.motions import motion
from hda_msgs_json.bag import BagWriter, open_recording
from hda_torque_estimator.diagnosis.diagnose import diagnose
from hda_torque_estimator.measurements.sample_grid import measurement_from
from hda_torque_estimator.simulating.closed_loop import run
from hda_torque_estimator.simulating.recorded import write_run

out = Path(sys.argv[1] if len(sys.argv) > 1 else 'out/02')
nominal = read_arm('hda_arm.yaml')
hidden = Backlash(half_width=1.0e-4)                    # [rad] at the output
true = nominal.with_effect(hidden, 'joint1')            # its controller knows the nominal arm

made = run(true, nominal, motion('rich', 2, 15.0, 1e-3, 4), 4)
with BagWriter(out / 'bag', {}) as bag:
    write_run(bag, nominal, made)

samples = open_recording(out / 'bag').joint_states()
found = diagnose(measurement_from(nominal.labels, samples), nominal).diagnosis
print('\n'.join(found.sentences()))
number = found.findings[0].parameters['half_width']
print(f'hidden {hidden.half_width:g} rad, found {number.value:.4g} '
      f'({number.low:.4g} to {number.high:.4g}) rad')
