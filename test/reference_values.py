"""Find the reference values that other programs computed; they are not part of the project."""

from pathlib import Path

from project_files import ROOT
import pytest

FOLDER = ROOT.parent / 'shared' / 'reference'


def reference(name: str) -> Path:
    """Return a file of reference values, or skip the test that asks for it."""
    path = FOLDER / name
    if not path.exists():
        pytest.skip(f'reference values {name} are not at ../shared/reference')
    return path
