"""Recordings without link angles, diagnosed by the torque of their motors."""
