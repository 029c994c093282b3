"""The reproduction as one JSON document."""

from collections.abc import Mapping
import math
from typing import Any

from .catalogue import FIGURES
from .rig.exhibit import Exhibit, PaperNumber


def document(made: Mapping[str, Exhibit], version: str, seconds: float) -> dict[str, Any]:
    """Return all numbers and sentences by figure, ready for strict JSON."""
    return {'schema': 'hda.paper/1', 'version': version, 'seconds': round(seconds, 1),
            'figures': {name: _figure(name, exhibit) for name, exhibit in made.items()}}


def _figure(name: str, exhibit: Exhibit) -> dict[str, Any]:
    return {'title': FIGURES[name].title,
            'numbers': [_number(number) for number in exhibit.numbers],
            'findings': list(exhibit.findings), 'not_computed': list(exhibit.not_computed),
            'drawings': [file_name(name, drawing.name) for drawing in exhibit.drawings]}


def _number(number: PaperNumber) -> dict[str, Any]:
    """Return a number as JSON knows it: what is not finite is null."""
    return {key: None if isinstance(value, float) and not math.isfinite(value) else value
            for key, value in number._asdict().items()}


def file_name(figure: str, drawing: str) -> str:
    """Return the name of a drawing's files, without their ending."""
    return f'{figure}_{drawing}'
