"""Where the compiled estimator keeps what: memory and results of joints, results of the tip."""

from hda_arm_sim.model.effects.place import SLIDERS

from . import contact, fusion_memory, payload

# Memory, per joint.
(LAST_MOTOR, LAST_LINK,                 # last readings [rad]
 MOTOR_VELOCITY, LINK_VELOCITY,         # low-passed [rad/s]
 LAST_TORSION, TURNED_TORSION,          # elastic torsion, and where the hysteresis stands [rad]
 LAST_MOMENTUM, LATE_RATE, EXTERNAL,    # of the momentum observer
 LATE, LAST_SPEED, ACCELERATION,        # what it lags behind [N*m]; of the link, low-passed
 OBSERVED,                              # variance of the torques that it still holds [N^2*m^2]
 ZERO, TARE_SUM,                        # torsion taken for zero [rad], its running sum
 QUICK_MOTOR, QUICK_LINK,               # velocities, less low-passed, for the torsion [rad/s]
 STRETCH,                               # of the elements of the hysteresis, the first [rad]
 ) = range(18)
FUSION = STRETCH + SLIDERS              # from here on the memory of the fusion
CONTACT = FUSION + fusion_memory.MEMORY       # in row 0: the memory of contacts
PAYLOAD = CONTACT + contact.MEMORY       # in row 0: the memory of the payload
MEMORY = PAYLOAD + payload.MEMORY

# Results, per joint.
(TORSION, KINEMATIC_TORSION,            # total and kinematic torsion, output side [rad]
 TORQUE, TORQUE_DEVIATION,              # through the gear [N*m]
 EXTERNAL_TORQUE, EXTERNAL_DEVIATION,   # by the environment [N*m], NaN without links
 BEYOND_RANGE,                          # 1 where the torque exceeds the law's valid range
 MOTOR_SHARE,                           # of the motor's torque in what is known of the torque
 DOUBT,                                 # why a torque is not believed, a number of `belief.py`
 ZERO_TAKEN,                            # torsion taken for none: by tare and as learnt [rad]
 ) = range(10)
RESULTS = 10

# Results of the tip: force ON the tip [N], covariances [N^2] by rows.
TOOL_X, TOOL_Y, BASE_X, BASE_Y, TOOL_COVARIANCE, BASE_COVARIANCE = 0, 1, 2, 3, 4, 8
SINGULAR, CONDITIONING = 12, 13
CONTACT_DEVIATIONS, CONTACT_LEVEL = 14, 15      # external torques over their deviations
MASS, MASS_DEVIATION = 16, 17                   # at the tip, beyond the model's [kg]
TIP_RESULTS = 18
# Of a chain come more behind them: the wrench ON the tip in base and tool frame, force [N] and
# moment about the tip [N*m], and its covariance (6, 6) in the base frame by rows.
BASE_WRENCH, TOOL_WRENCH, WRENCH_COVARIANCE = 18, 24, 30
CHAIN_TIP_RESULTS = 66
