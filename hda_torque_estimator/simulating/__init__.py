"""Arm, estimator and controller in one compiled loop, and its run as a bag."""
