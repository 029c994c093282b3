"""A page on this machine that shows a running arm: its motion, torques, pushes and health."""
