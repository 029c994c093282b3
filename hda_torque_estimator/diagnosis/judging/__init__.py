"""Which causes are named: search, model comparison, goodness of fit, discrepancy, verdict."""
