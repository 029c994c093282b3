"""What the simulation gets wrong: show it, name the cause, extend the model, measure the gain."""
