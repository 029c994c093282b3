"""What a command hands back: lines for people and the same for machines."""

from typing import Any, NamedTuple


class Outcome(NamedTuple):
    """The result of a command that did its job."""

    text: str
    report: dict[str, Any]
