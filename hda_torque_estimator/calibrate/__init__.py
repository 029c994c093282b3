"""What recordings with an independent torque say about the parameters of a joint."""
