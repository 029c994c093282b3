"""`hda reproduce`: the figures and tables of the paper, with the numbers next to the paper's."""

import argparse
from collections.abc import Callable, Mapping
from pathlib import Path
import time
from typing import Any

from hda_arm_sim.model.files import read_arm

from .out_option import add_out
from .outcome import Outcome
from .progress import progress
from .whole_directory import elements, save_figures, whole_directory, write_json
from ..reproduction.catalogue import chosen, FIGURES, PaperItem
from ..reproduction.page import page
from ..reproduction.plots import draw
from ..reproduction.report import document, file_name
from ..reproduction.rig.exhibit import Arms, Exhibit
from ..version import version

_ARMS = ('paper_single_axis.yaml', 'hda_arm.yaml', 'paper_table1.yaml')
EXAMPLES = (
    'hda reproduce --out paper',
    'hda reproduce fig7 --out paper')


def configure(parser: argparse.ArgumentParser) -> None:
    """Declare the arguments."""
    parser.add_argument('figures', nargs='*', metavar='FIGURE',
                        help=f'{", ".join(FIGURES)}; all unless given')
    add_out(parser, 'DIR', 'directory to write: paper.html, paper.json, figures')


def execute(options: argparse.Namespace) -> Outcome:
    """Make the figures and write them; raises the project's errors."""
    begin = time.monotonic()
    entries = chosen(options.figures)
    with whole_directory(options.out, force=options.force) as partial, \
            progress(quiet=options.json) as notify:
        made = _made(entries, notify)
        report = document(made, version(), time.monotonic() - begin)
        _write(made, report, partial, notify)
    return Outcome(_in_words(options.out, made), report)


def _made(entries: Mapping[str, PaperItem], notify: Callable[[str], None]) -> dict[str, Exhibit]:
    """Return the exhibits; `notify` hears which one is being made."""
    arms = Arms(*(read_arm(name) for name in _ARMS))
    made = {}
    for number, (name, entry) in enumerate(entries.items(), 1):
        notify(f'{number} of {len(entries)}: {name}')
        made[name] = entry.build(arms)
    return made


def _write(made: Mapping[str, Exhibit], report: dict[str, Any], out: Path,
           notify: Callable[[str], None]) -> None:
    """Write the numbers, every figure twice, and the page; `notify` hears what is drawn."""
    write_json(out / 'paper.json', report)
    inline: dict[str, str] = {}
    for figure, exhibit in made.items():
        notify(f'drawing {figure}')
        drawn = {file_name(figure, drawing.name): draw(drawing) for drawing in exhibit.drawings}
        save_figures(drawn, out)
        inline |= elements(drawn)
    (out / 'paper.html').write_text(page(made, inline, version()), encoding='utf-8')


def _in_words(out: Path, made: Mapping[str, Exhibit]) -> str:
    """Return what was written, and every number that the paper has as well."""
    beside = [f'  {name}: {number.name}: paper {number.paper:.4g}'
              + ''.join(f', {kind} {value:.4g}' for kind, value in (
                  ('printed', number.printed), ('consistent', number.consistent))
                  if value is not None) + f' {number.unit}'
              for name, exhibit in made.items() for number in exhibit.numbers
              if number.paper is not None]
    return '\n'.join([f'{out}: {", ".join(made)} of the paper in paper.html, and all numbers in '
                      'paper.json', *beside])
