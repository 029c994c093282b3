"""The size of a benchmark: all take `--quick`, a tiny case of which nothing is judged."""

from argparse import ArgumentParser


def parser(text: str | None) -> ArgumentParser:
    """Return a parser of a benchmark with this docstring, which knows `--quick`."""
    first = (text or '').strip().partition('\n')[0]
    made = ArgumentParser(description=first)
    made.add_argument('--quick', action='store_true',
                      help='a tiny case that ends in seconds; its numbers say nothing')
    return made


def verdict(bar: str, kept: bool, *, quick: bool, words: tuple[str, str] = ('yes', 'NO')) -> int:
    """Print whether a bar was kept, and return the exit code; a tiny case has no bar."""
    print(f'{bar}: {"a tiny case, not judged" if quick else words[not kept]}')
    return 0 if kept or quick else 1
