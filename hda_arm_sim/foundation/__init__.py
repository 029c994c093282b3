"""What laws are made of: compiled functions, declared parameters and rigid bodies."""
