"""The player: a recording onto its topics again, in time."""
