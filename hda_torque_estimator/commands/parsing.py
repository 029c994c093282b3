"""How `hda` reads its words: one line for a mistake, with what was meant, and help that shows."""

import argparse
from collections.abc import Sequence
from gettext import gettext
import sys
from typing import Any, NoReturn

from hda_msgs_json.nearest import did_you_mean, nearest
from hda_msgs_json.printable import one_line

from .terminal import complain

MISUSED = 2
_NAMES = 26             # columns of the names in a help
_ITSELF = 'unless given'        # in a help that states its default in words


class HelpFormatter(argparse.RawDescriptionHelpFormatter):
    """Help with the default of every option that has one, and examples as they are typed."""

    def __init__(self, prog: str) -> None:
        """Give names the room that the longest of them takes."""
        super().__init__(prog, max_help_position=_NAMES)

    def add_argument(self, action: argparse.Action) -> None:
        """Note how long the names of an argument are; those of commands stand further right."""
        super().add_argument(action)
        if isinstance(action, argparse._SubParsersAction):
            self._action_max_length += self._indent_increment

    def _get_help_string(self, action: argparse.Action) -> str | None:
        said = action.help or ''
        plain = action.default in (None, argparse.SUPPRESS) or isinstance(
            action.default, (bool, list))
        is_stated = plain or '%(default)' in said or _ITSELF in said
        return said if is_stated else f'{said} (default: %(default)s)'

    def _format_args(self, action: argparse.Action, default_metavar: str) -> str:
        if action.nargs == argparse.ONE_OR_MORE:
            return f'{self._metavar_formatter(action, default_metavar)(1)[0]} ...'
        return super()._format_args(action, default_metavar)


class Parser(argparse.ArgumentParser):
    """A parser that says what is wrong in one line, and what was probably meant."""

    def __init__(self, **words: Any) -> None:
        """Make the parser; all have one kind of help."""
        super().__init__(formatter_class=HelpFormatter, **words)
        self._given: Sequence[str] = ()

    def parse_known_args(self, args: Any = None, namespace: Any = None) -> Any:
        """Read words; what a command does not know is refused by its own parser."""
        self._given = list(args or ())
        options, unknown = super().parse_known_args(args, namespace)
        if unknown:
            self.error(gettext('unrecognized arguments: %s') % ' '.join(unknown))
        return options, unknown

    def _check_value(self, action: argparse.Action, value: Any) -> None:
        names = [str(choice) for choice in action.choices or ()]
        near = did_you_mean(str(value), names)
        if near and value not in (action.choices or ()):
            raise argparse.ArgumentError(action, f'invalid choice: {value!r}{near}')
        super()._check_value(action, value)

    def error(self, message: str) -> NoReturn:
        """Print one line and leave with 2."""
        complain(one_line(f'{self.prog}: {message}{self._misspelt()}; see {self.prog} --help'),
                 sys.stderr)
        self.exit(MISUSED)

    def _misspelt(self) -> str:
        """Return what an option that does not exist may mean, or nothing."""
        known = [name for name in self._option_string_actions if name.startswith('--')]
        for word in self._given:
            name = word.partition('=')[0]
            begun = any(other.startswith(name) for other in known)
            if name.startswith('--') and len(name) > 2 and not begun and (
                    near := nearest(name, known)):
                return f'; there is no option {name}, did you mean {" or ".join(near)}?'
        return ''
