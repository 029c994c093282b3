"""What silence means: the smallest effects that a recording could have shown."""
