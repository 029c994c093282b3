"""What is inferred from the arm's encoders: torque, force, control, calibration, diagnosis."""
