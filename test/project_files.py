"""List the files of the project, as the tests of its style, layers and packaging see them."""

from collections.abc import Iterator
from fnmatch import fnmatch
import os
from pathlib import Path
import shutil

ROOT = Path(__file__).parents[1]
PACKAGES = ('hda_msgs_json', 'hda_arm_sim', 'hda_torque_estimator')

# What tools leave in a checkout; hidden files are settings and caches.
MADE_BY_TOOLS = ('.*', '__pycache__', 'build', 'dist', 'install', 'log', 'out', '*.egg-info')


def files(pattern: str = '*', within: Path = ROOT) -> Iterator[Path]:
    """Yield the files below `within` whose names match `pattern`, in order, links not followed."""
    for directory, names, found in os.walk(within):
        names[:] = sorted(name for name in names if not made_by_tools(name))
        yield from (Path(directory, name) for name in sorted(found)
                    if fnmatch(name, pattern) and not made_by_tools(name))


def python_roots() -> list[str]:
    """Return the files and directories of the top level that hold Python, relative to it."""
    return sorted({path.relative_to(ROOT).parts[0] for path in files('*.py')})


def copy_project(to: Path) -> Path:
    """Copy the project without what tools have made, and return where it is now."""
    shutil.copytree(ROOT, to, symlinks=True, ignore=shutil.ignore_patterns(*MADE_BY_TOOLS))
    return to


def made_by_tools(name: str) -> bool:
    """Return whether a file or directory of this name was made by a tool."""
    return any(fnmatch(name, pattern) for pattern in MADE_BY_TOOLS)
