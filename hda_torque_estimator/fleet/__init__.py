"""A fleet of arms: many recordings diagnosed at once, each on its own."""
