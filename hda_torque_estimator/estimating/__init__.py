"""The estimator: from samples to messages, live or over a bag, and what it reports."""
