"""The one home of physics: laws, effects, the arm and its equation of motion, all pure."""
