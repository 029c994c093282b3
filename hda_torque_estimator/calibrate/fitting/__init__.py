"""The unknowns of a joint as terms, and how they are found and chosen."""
