"""Effects as terms, and their least-squares fit to the balances."""
