"""What the arm is (model) and how it moves (simulate, node)."""
