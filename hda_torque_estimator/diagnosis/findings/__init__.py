"""What a diagnosis can find: causes with intervals, their gains, the smallest sizes."""
