"""Topics that a user names, or describes by patterns such as `joint?/*`."""

from collections.abc import Iterable, Sequence
from fnmatch import fnmatchcase

from hda_msgs_json.errors import HdaError


class TopicError(HdaError):
    """A name or pattern that no topic has."""


def chosen(names: Iterable[str], wanted: Sequence[str], unwanted: Sequence[str] = ()) -> list[str]:
    """
    Return those names that are wanted, all without any, and not unwanted, in their order.

    A leading slash makes no difference. Raise TopicError for what is wanted and not there.
    """
    known = list(names)
    for pattern in wanted:
        if not any(matches(name, [pattern]) for name in known):
            raise TopicError(f'no topic is named {pattern}; there are '
                             f'{", ".join(known) or "none at all"}')
    return [name for name in known if (not wanted or matches(name, wanted))
            and not matches(name, unwanted)]


def matches(name: str, patterns: Sequence[str]) -> bool:
    """Return whether a name is one of the patterns."""
    return any(fnmatchcase(name.strip('/'), pattern.strip('/')) for pattern in patterns)
