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
from numba.core import cgutils, config
from numba.extending import intrinsic

_PACKAGES = Path(__file__).resolve().parents[2]
_CONFIG: Any = config
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
    a short law itself. Other threads may run meanwhile.
    """
    before = _CONFIG.CACHE_DIR
    _CONFIG.CACHE_DIR = str(cache_folder())
    try:
        return numba.njit(cache=True, error_model='numpy', forceinline=inlined,
                          nogil=True)(law)
    finally:
        _CONFIG.CACHE_DIR = before


def inlined(law: Callable[..., Any]) -> Any:
    """Return `law` compiled into its callers."""
    return compiled(law, inlined=True)


def _borrowed(typing: Any, array: Any) -> Any:
    """
    Return an array that compiled code hands on without counting who holds it.

    The count is an atomic operation at every call and costs more than a short law. Only for the
    arguments of a function: its caller keeps them alive meanwhile.
    """
    def generate(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        view = context.make_array(signature.args[0])(context, builder, arguments[0])
        view.meminfo = cgutils.get_null_value(view.meminfo.type)
        view.parent = cgutils.get_null_value(view.parent.type)
        return view._getvalue()

    return array(array), generate


borrowed: Any = intrinsic(_borrowed)

_DIGEST = source_digest()
