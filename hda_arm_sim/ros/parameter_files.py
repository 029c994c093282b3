"""Files of parameters that were meant for a node and miss it: ROS itself says nothing of them."""

from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
import re
from typing import Any, NamedTuple

import yaml

PARAMETERS = 'ros__parameters'


class Missed(NamedTuple):
    """A file, and the names in it that are like that of the node but another one's."""

    file: str
    names: list[str]


def missed_files(arguments: Sequence[str], full_name: str) -> list[Missed]:
    """
    Return the files among ROS arguments that speak of the node by its own name alone.

    `full_name` has the namespace, which the name in a file must have as well: `arm_sim` means
    `/arm_sim`, and `/**/arm_sim` means it in every namespace.
    """
    files = [file for word, file in zip(arguments, arguments[1:]) if word == '--params-file']
    own = full_name.rpartition('/')[2]
    found = []
    for file in files:
        names = [name for name in _names(file) if name.rpartition('/')[2] == own]
        if names and not any(_means(name, full_name) for name in names):
            found.append(Missed(file, names))
    return found


def _names(file: str) -> list[str]:
    """Return the names of nodes in a file; none if it cannot be read, which rcl has said."""
    try:
        content = yaml.safe_load(Path(file).read_text())
    except (OSError, ValueError, yaml.YAMLError):
        return []
    return list(_named(content, '')) if isinstance(content, dict) else []


def _named(content: Mapping[Any, Any], above: str) -> Iterator[str]:
    for key, value in content.items():
        if key == PARAMETERS:
            yield above
        elif isinstance(value, dict):
            yield from _named(value, f'{above}/{key}' if above else str(key))


def _means(name: str, full_name: str) -> bool:
    parts = re.split(r'(/\*\*|/\*)', f'/{name.lstrip("/")}')
    forms = {'/**': '(/[^/]+)*', '/*': '/[^/]+'}
    return re.fullmatch(''.join(forms.get(part, re.escape(part)) for part in parts),
                        full_name) is not None
