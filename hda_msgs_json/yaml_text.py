"""YAML of strangers: read in bounded time, and every mistake in it one sentence."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from hda_msgs_json.errors import HdaError
import yaml

LARGEST = 1 << 18
"""Bytes of a file: a hundred times what an arm or a map has, read in five seconds."""
MOST_VALUES = 300_000
"""Values of a document, and every 32 characters of its texts, as often as an alias names them."""
LONGEST_NUMBER = 1 << 12
"""Bits of a whole number; beyond some thousand digits Python does not print it."""

# What the constructors of the library raise on values that only look like what they say.
UNREADABLE = (yaml.YAMLError, ValueError, LookupError, TypeError, AttributeError,
              ArithmeticError, RecursionError, MemoryError)


class YamlError(HdaError):
    """A text that cannot be read as YAML."""


def text_of(path: Path) -> str:
    """Return the text of a file; raises YamlError where it has none, or far too much."""
    try:
        with path.open('rb') as stream:
            content = stream.read(LARGEST + 1)
        if len(content) > LARGEST:
            raise YamlError(f'{path} is too long: at most {LARGEST >> 10} KiB are read')
        return content.decode()
    except OSError as error:
        raise YamlError(f'{path} cannot be read: {error.strerror}') from None
    except UnicodeDecodeError as error:
        raise YamlError(f'{path} cannot be read as text: {error}') from None


def yaml_document(text: str, largest: int = LARGEST) -> Any:
    """
    Return what YAML text holds: mappings, lists, texts, numbers.

    Raises YamlError, with the line where it is known, for what is no YAML, longer than `largest`
    characters, or grows beyond measure by aliases.
    """
    if len(text) > largest:
        raise YamlError(f'too long: {len(text)} characters of YAML, at most {largest} are read')
    try:
        document = yaml.safe_load(text)
    except UNREADABLE as error:
        where = getattr(error, 'problem_mark', None)
        line = f' at line {where.line + 1}' if where else ''
        problem = ' '.join(str(getattr(error, 'problem', None) or error).split())
        raise YamlError(f'not YAML{line}: {problem or type(error).__name__}') from None
    _check_size(document)
    return document


def _check_size(document: Any) -> None:
    """Raise YamlError for a document that would not end when it is walked through or printed."""
    waiting, count = [document], 0
    while waiting:
        value = waiting.pop()
        count += 1 + (len(value) >> 5 if isinstance(value, str) else 0)
        if count > MOST_VALUES:
            raise YamlError(f'no document of this kind: it holds more than {MOST_VALUES} values')
        if isinstance(value, Mapping):
            waiting += [*value.keys(), *value.values()]
        elif isinstance(value, (list, tuple, set)):
            waiting += value
        elif isinstance(value, int) and value.bit_length() > LONGEST_NUMBER:
            raise YamlError('no document of this kind: one of its numbers has '
                            f'{value.bit_length()} bits')
