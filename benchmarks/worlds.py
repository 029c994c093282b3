"""
Measure a diagnosis on worlds: arms, motions, rates and forms of law that are drawn by seeds.

    worlds.py [--final] [--scale S] [--first SEED] [--group NAME] [--workers N]
              [--limit SECONDS] [--kept FILE] [--page FILE] [--figure FILE] [--quick]

The study of development draws nothing that is held out, and its seeds are below a million. Those
of the final study (`--final`) are above, and used for nothing else. Outcomes are kept in FILE as
they come: a study that was stopped goes on where it was, for one state of the code. FIRST counts
within the study. One page of Markdown and, where probabilities are stated, a reliability diagram.
"""

from argparse import Namespace
from collections import Counter
from collections.abc import Sequence
from pathlib import Path
import sys
import tempfile

from hidden_truth import worlds
from kept import outcomes
from reliability import draw_diagram
from size import parser
from world_cases import attempted, Case, cases
from world_tables import page

OUT = Path(__file__).resolve().parents[1] / 'out'
LAST = ('fifteen', 'duration')  # groups that take long, and are begun last


def asked_for(words: Sequence[str]) -> Namespace:
    """Return the size of the study."""
    known = parser(__doc__)
    known.add_argument('--final', action='store_true', help='seeds, forms and motion held out')
    known.add_argument('--scale', type=float, default=0.05, help='1 for some 2300 records')
    known.add_argument('--group', action='append', help='only these groups of records')
    for name, default in (('first', 0), ('workers', 2), ('limit', 0)):
        known.add_argument(f'--{name}', type=int, default=default)
    for name in ('kept.jsonl', 'page.md', 'figure.png'):
        known.add_argument(f'--{name.partition(".")[0]}', type=Path,
                           default=OUT / f'worlds_{name}')
    return known.parse_args(words)


def main() -> int:
    """Run the study and write the page."""
    asked = asked_for(sys.argv[1:])
    if not asked.quick:
        return run(asked, planned(asked))
    with tempfile.TemporaryDirectory() as folder:
        here = Path(folder)
        tiny = Namespace(**{**vars(asked), 'workers': 1, 'kept': here / 'kept.jsonl',
                            'page': here / 'page.md', 'figure': here / 'figure.png'})
        return run(tiny, [Case('rich, 250 Hz', 1, ('viscous_friction',), motion='rich', rate=250,
                               joints=1, seconds=15.0)])


def planned(asked: Namespace) -> list[Case]:
    """Return the records that are asked for."""
    first = asked.first + (worlds.SEEDS if asked.final else 0)
    return [case for case in cases(first, asked.scale)
            if not asked.group or case.group in asked.group]


def run(asked: Namespace, wanted: Sequence[Case]) -> int:
    """Run what is left of the study and write page and figure."""
    results = outcomes(wanted, attempted, asked, LAST)
    seeds = [case.seed for case in wanted]
    print(Counter(result['group'] for result in results))
    asked.page.write_text(page(results, len(wanted), first=min(seeds), last=max(seeds),
                               final=asked.final), encoding='utf-8')
    draw_diagram(results, asked.figure)
    return 0


if __name__ == '__main__':
    sys.exit(main())
