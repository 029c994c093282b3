"""
Compile laws to machine code, cached on disk and never stale.

numba decides by a function's own file whether its cached code is current, so an edit of a law
would leave the kernel that calls it out of date. Here the cache folder carries a digest of every
pure source file: any edit opens a new folder.
"""

from collections.abc import Callable
import hashlib
import os
from pathlib import Path
from typing import Any

import numba
from numba.core import config

_PACKAGES = Path(__file__).resolve().parents[2]
_SOURCES = ('hda_arm_sim', 'hda_torque_estimator')


def source_digest() -> str:
    """Return a digest of the sources from which compiled code is made, 16 hex digits."""
    digest = hashlib.sha256(numba.__version__.encode())
    for package in _SOURCES:
        for path in sorted((_PACKAGES / package).rglob('*.py')):
            digest.update(path.read_bytes())
    return digest.hexdigest()[:16]


def cache_folder() -> Path:
    """Return the folder of this source's compiled code (HDA_CACHE_DIR or the user's cache)."""
    root = os.environ.get('HDA_CACHE_DIR') or os.environ.get('XDG_CACHE_HOME')
    base = Path(root) if root else Path.home() / '.cache'
    return base / 'hda_torque_estimator' / _DIGEST


def compiled(law: Callable[..., Any], *, inlined: bool = False) -> Any:
    """
    Return `law` compiled on first use; scalars and arrays alike where its formula allows.

    `inlined` functions become part of their caller: handing over many arrays costs more than
    a short law itself.
    """
    before = config.CACHE_DIR
    config.CACHE_DIR = str(cache_folder())
    try:
        return numba.njit(cache=True, error_model='numpy', forceinline=inlined)(law)
    finally:
        config.CACHE_DIR = before


def inlined(law: Callable[..., Any]) -> Any:
    """Return `law` compiled into its callers."""
    return compiled(law, inlined=True)


_DIGEST = source_digest()
