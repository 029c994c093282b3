"""The balances of an arm along a measured motion, and what it would do from there."""
