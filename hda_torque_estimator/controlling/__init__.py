"""The controller: torque feedback, references that an arm can follow, and its safety."""
