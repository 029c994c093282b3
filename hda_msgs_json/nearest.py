"""Names near one that does not exist: what somebody meant who has mistyped it."""

from collections.abc import Iterable
from difflib import get_close_matches

SUGGESTIONS = 3         # names that a sentence offers (choice)
NEAR = 0.6              # share of the letters that two names have in common (choice)


def nearest(name: str, names: Iterable[str], *, most: int = SUGGESTIONS,
            near: float = NEAR) -> list[str]:
    """Return the names most like one, the likest first; capitals do not count."""
    spelled = {other.lower(): other for other in names}
    return [spelled[found] for found in get_close_matches(name.lower(), spelled, most, near)]


def did_you_mean(name: str, names: Iterable[str]) -> str:
    """Return `; did you mean ...?` for a name that is near others, or nothing."""
    found = nearest(name, names)
    return f'; did you mean {" or ".join(found)}?' if found else ''
