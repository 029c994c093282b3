"""What a command hands back: lines for people and the same for machines."""

import math
from typing import Any, NamedTuple


class Outcome(NamedTuple):
    """The result of a command that did its job, and the exit code that says so."""

    text: str
    report: dict[str, Any]
    code: int = 0


def without_nan(value: Any) -> Any:
    """Return a report with null for each number that JSON does not have."""
    if isinstance(value, dict):
        return {key: without_nan(one) for key, one in value.items()}
    if isinstance(value, (list, tuple)):
        return [without_nan(one) for one in value]
    return None if isinstance(value, float) and not math.isfinite(value) else value
