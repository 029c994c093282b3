"""
Write docs/real_data.md, and the numbers behind it, from public recordings of real joints.

    recordings.py DATA [--page FILE] [--numbers FILE] [--figures DIR] [--quick]

DATA holds the recordings, each set in a folder of its own; none is part of the project. Every
number is measured anew, which takes minutes. `--quick` needs no recordings: it fills the template
with the numbers in FILE and says whether the page is that.
"""

from argparse import Namespace
from collections.abc import Sequence
import json
from pathlib import Path
import sys
import tempfile
import time

import real_bench
import real_kinova
import real_lara8
from real_page import DOCS, document, NUMBERS, PAGE, page
import real_yucobot
from size import parser


def asked_for(words: Sequence[str]) -> Namespace:
    """Return where recordings are and where results go."""
    known = parser(__doc__)
    known.add_argument('data', type=Path, nargs='?', help='folder of the recordings')
    known.add_argument('--page', type=Path, default=PAGE)
    known.add_argument('--numbers', type=Path, default=NUMBERS)
    known.add_argument('--figures', type=Path, default=DOCS / 'figures')
    asked = known.parse_args(words)
    if asked.quick:
        return asked
    if asked.data is None:
        known.error('name the folder of the recordings, or take --quick')
    needed = (real_kinova.FOLDER, real_yucobot.FILE, real_lara8.FILE, real_bench.FOLDER)
    missing = [name for name in needed if not (asked.data / name).exists()]
    if missing:
        known.error(f'{asked.data} lacks {", ".join(missing)}; name the folder of the recordings '
                    '(make real DATA=DIR)')
    return asked


def measured(data: Path, figures: Path) -> dict[str, object]:
    """Return the numbers of all recordings, and draw the figures."""
    found: dict[str, object] = {}
    with tempfile.TemporaryDirectory() as folder:
        here = Path(folder)
        for name, numbers in (('kinova', lambda: real_kinova.numbers(data, here, figures)),
                              ('yucobot', lambda: real_yucobot.numbers(data, here)),
                              ('lara8', lambda: real_lara8.numbers(data, here)),
                              ('bench', lambda: real_bench.numbers(data, here))):
            begin = time.monotonic()
            found[name] = numbers()
            print(f'{name}: {time.monotonic() - begin:.0f} s', flush=True)
    return found


def main() -> int:
    """Measure and write, or compare the page that is there."""
    asked = asked_for(sys.argv[1:])
    if asked.quick:
        known = json.loads(asked.numbers.read_text(encoding='utf-8'))
        same = page(known) == asked.page.read_text(encoding='utf-8')
        print(f'{asked.page.name} is {"" if same else "NOT "}what its numbers make')
        return 0 if same else 1
    text = document(measured(asked.data, asked.figures))
    asked.numbers.write_text(text, encoding='utf-8')    # first: a sentence may not hold any more
    asked.page.write_text(page(json.loads(text)), encoding='utf-8')
    return 0


if __name__ == '__main__':
    sys.exit(main())
