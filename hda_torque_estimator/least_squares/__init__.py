"""Least squares of an arm's numbers: terms, priors, a damped descent, and what it is worth."""
