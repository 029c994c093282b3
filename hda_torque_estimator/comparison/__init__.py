"""Two recordings laid over each other: aligned in time, and what differs then."""
