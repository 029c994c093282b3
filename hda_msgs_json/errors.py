"""What all errors that a user reads in one line have in common."""


class HdaError(ValueError):
    """A mistake that one line explains: what is wrong, what was got, what would be right."""
