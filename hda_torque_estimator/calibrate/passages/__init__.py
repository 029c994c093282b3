"""What a calibration reads of recordings: joints, loads, and what the user states."""
