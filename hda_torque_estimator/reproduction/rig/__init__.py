"""What the figures share: the paper's rig, its printed numbers, and exhibits."""
