"""The word, the mark and the meaning of each result, the same on all pages."""

from typing import NamedTuple


class Badge(NamedTuple):
    """A result at a glance; `kind` is the class by which colour and shape are chosen."""

    kind: str
    word: str
    meaning: str


BADGES = {
    'no_discrepancy': Badge('healthy', 'Healthy', 'the model is right within its tolerances'),
    'explained': Badge('explained', 'Explained', 'causes are named, the rest is noise'),
    'ambiguous': Badge('ambiguous', 'Ambiguous', 'several causes explain it equally well'),
    'unknown': Badge('unknown', 'Unknown', 'something that no effect explains'),
    'insufficient_excitation': Badge('silent', 'Cannot tell', 'the recording cannot show it'),
}
FAILED = Badge('failed', 'Not diagnosed', 'the recording could not be read or used')
DONE = Badge('done', 'Done', 'there is no verdict')


def badge_of(verdict: str | None) -> Badge:
    """Return the badge of a verdict; None could not be diagnosed."""
    return FAILED if verdict is None else BADGES.get(verdict, DONE)
