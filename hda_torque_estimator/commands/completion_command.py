"""`hda completion`: what a shell reads to complete commands, options, effects and motions."""

import argparse
from collections.abc import Callable, Iterator
import os
from pathlib import Path
from typing import Any

from argcomplete import autocomplete
from argcomplete.completers import FilesCompleter, SuppressCompleter
from argcomplete.shell_integration import shellcode
from hda_msgs_json.errors import HdaError

from .outcome import Outcome

Completer = Callable[..., Any]
SHELLS = ('bash', 'zsh', 'fish', 'tcsh')
_PLACES = ('FILE', 'DIR', 'BAG', 'BAG2')
EXAMPLES = (
    'eval "$(hda completion bash)"                  # in this shell',
    'hda completion bash > ~/.local/share/bash-completion/completions/hda',
    'hda completion zsh > ~/.zfunc/_hda')


class CompletionError(HdaError):
    """A shell that is not known."""


def configure(parser: argparse.ArgumentParser) -> None:
    """Declare the arguments."""
    parser.add_argument('shell', nargs='?', choices=SHELLS, metavar='SHELL',
                        help=f'{", ".join(SHELLS)}; yours unless given')


def execute(options: argparse.Namespace) -> Outcome:
    """Return the lines for the shell; raises CompletionError."""
    shell = options.shell or Path(os.environ.get('SHELL', '')).name
    if shell not in SHELLS:
        raise CompletionError(f'your shell is not known; name one of {", ".join(SHELLS)}')
    text = shellcode(['hda'], shell=shell)
    return Outcome(text.strip(), {'shell': shell, 'script': text})


def complete(parser: argparse.ArgumentParser) -> None:
    """Answer the shell that asks what may stand at the cursor, and end the process."""
    for action in _actions(parser):
        vars(action)['completer'] = _completer(action)      # where argcomplete looks for it
    autocomplete(parser, always_complete_options='long')


def _actions(parser: argparse.ArgumentParser) -> Iterator[argparse.Action]:
    """Yield the arguments of a parser and of its commands that take a value."""
    for action in parser._actions:
        if isinstance(action, argparse._SubParsersAction):
            for each in action.choices.values():
                yield from _actions(each)
        elif action.nargs != 0 and not action.choices:
            yield action


def _completer(action: argparse.Action) -> Completer:
    if action.dest in _WORDS:
        return _WORDS[action.dest]
    is_place = action.type is Path or action.metavar in _PLACES
    return FilesCompleter() if is_place else SuppressCompleter()


def _effects(prefix: str, **asked: Any) -> list[str]:
    from hda_arm_sim.model.effects import EFFECTS       # half a second that few words need
    return [effect.name for effect in EFFECTS]


def _arms(prefix: str, **asked: Any) -> list[str]:
    from hda_arm_sim.model.files import shipped_arms
    return [*shipped_arms(), *FilesCompleter()(prefix, **asked)]


def _motions(prefix: str, **asked: Any) -> list[str]:
    from hda_arm_sim.motions import MOTIONS
    return [*MOTIONS, *FilesCompleter()(prefix, **asked)]


def _maps(prefix: str, **asked: Any) -> list[str]:
    from ..importing.maps import shipped_maps
    return [*shipped_maps(), *FilesCompleter()(prefix, **asked)]


def _figures(prefix: str, **asked: Any) -> list[str]:
    from ..reproduction.catalogue import FIGURES
    return list(FIGURES)


_WORDS: dict[str, Completer] = {
    'about': _effects, 'arm': _arms, 'between': _effects, 'figures': _figures, 'map': _maps,
    'motion': _motions, 'names': _effects}
