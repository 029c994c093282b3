"""Which causes are named: search, acceptance, rivals, backing, verdict."""
