"""Detectability: the smallest size of every effect that a recording could have shown."""
