"""A directory that appears whole or not at all, and how figures are put into it."""

from collections.abc import Iterator, Mapping
from contextlib import contextmanager
import json
from pathlib import Path
import shutil
import tempfile
from typing import Any

from matplotlib.figure import Figure

from ..pages.drawing import inline_svg


@contextmanager
def whole_directory(out: Path, unwritable: type[ValueError]) -> Iterator[Path]:
    """
    Give a fresh directory beside `out`, which becomes `out` at the end and is gone on any error.

    What the disk refuses is raised as `unwritable`.
    """
    partial: Path | None = None
    try:
        out.parent.mkdir(parents=True, exist_ok=True)
        partial = Path(tempfile.mkdtemp(prefix=f'.{out.name}.', dir=out.parent))
        yield partial
        partial.chmod(0o755)
        partial.rename(out)
    except OSError as error:
        raise unwritable(f'{out} cannot be written: {error.strerror}') from None
    finally:
        if partial is not None:
            shutil.rmtree(partial, ignore_errors=True)


def write_json(path: Path, document: Mapping[str, Any]) -> None:
    """Write a report for machines; raises ValueError for numbers that JSON does not have."""
    path.write_text(json.dumps(document, indent=1, allow_nan=False) + '\n', encoding='utf-8')


def save_figures(figures: Mapping[str, Figure], out: Path, *,
                 vectors: bool = True) -> dict[str, str]:
    """Save figures as PNG, with `vectors` as SVG too, and return them as elements for a page."""
    inline = {}
    for name, figure in figures.items():
        figure.savefig(out / f'{name}.png', dpi=150)
        if vectors:
            figure.savefig(out / f'{name}.svg')
        inline[name] = inline_svg(figure, name)
    return inline
