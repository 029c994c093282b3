"""
Compile laws to machine code, cached on disk and never stale.

numba decides by a function's own file whether its cached code is current. So an edit of a law
would leave the kernel that calls it out of date. Here the cache folder of a module carries a
digest of that module and of every module that it imports, directly or not. An edit of a law
opens a new folder for whoever can call it, and for nobody else.
"""

from collections.abc import Callable, Iterator
from functools import cache
import hashlib
from inspect import signature
import os
from pathlib import Path
import re
from types import FunctionType
from typing import Any, TypeAlias, TypeVar

import numba
from numba.core import cgutils, config, event
from numba.core.caching import FunctionCache
from numba.extending import intrinsic, overload

from .arrays import Array

Record: TypeAlias = Any          # a numpy record: the numbers of a joint, an effect ... by name
Number = TypeVar('Number', float, Array)        # of a law for scalars and arrays alike
Law = TypeVar('Law', bound=Callable[..., Any])

_PACKAGES = Path(__file__).resolve().parents[2]
_CONFIG: Any = config
_SOURCES = ('hda_arm_sim', 'hda_torque_estimator')
_IMPORT = re.compile(r'^[ ]*from +(\.*)([\w.]*) +import +(\([^)]*\)|[^\n]*)', re.MULTILINE)


@cache
def _path(module: str) -> Path | None:
    """Return the source file of a module of ours; None if it is not ours or no module."""
    if not module.startswith(_SOURCES):
        return None
    place = _PACKAGES.joinpath(*module.split('.'))
    return next((path for path in (place.with_suffix('.py'), place / '__init__.py')
                 if path.is_file()), None)


def _ours() -> list[str]:
    """Return the names of all modules of ours."""
    return ['.'.join(path.relative_to(_PACKAGES).with_suffix('').parts)
            for package in _SOURCES for path in (_PACKAGES / package).rglob('*.py')]


@cache              # others ask about the same module: unremembered it took a third of a start
def _imports(module: str, path: Path) -> tuple[str, ...]:
    """Return the modules of ours that a module imports from."""
    return tuple(name for name in _named(module, path) if _path(name))


def _named(module: str, path: Path) -> Iterator[str]:
    """Yield the names that a module imports from: modules, and what may be modules in them."""
    package = module if path.name == '__init__.py' else module.rpartition('.')[0]
    for dots, name, what in _IMPORT.findall(path.read_text()):
        above = package.split('.')[:1 - len(dots) or None] if dots else []
        origin = '.'.join([*above, *([name] if name else [])])
        yield origin
        yield from (f'{origin}.{part}' for part in re.findall(r'\w+', what))


def digested(module: str) -> dict[str, Path]:
    """
    Return the sources on which the compiled code of a module may depend, by module.

    For a module that is not ours these are all of ours: nobody asks what it imports.
    """
    found: dict[str, Path] = {}
    ahead = [module] if _path(module) else _ours()
    while ahead:
        name = ahead.pop()
        path = _path(name)
        if path and name not in found:
            found[name] = path
            ahead += _imports(name, path)
    return found


@cache
def source_digest(module: str) -> str:
    """Return a digest of all sources on which a module's code depends, 16 hex digits."""
    digest = hashlib.sha256(numba.__version__.encode())
    for _, path in sorted(digested(module).items()):
        digest.update(path.read_bytes())
    return digest.hexdigest()[:16]


def cache_folder(module: str) -> Path:
    """Return the folder of a module's compiled code (HDA_CACHE_DIR or the user's cache)."""
    root = os.environ.get('HDA_CACHE_DIR') or os.environ.get('XDG_CACHE_HOME')
    base = Path(root) if root else Path.home() / '.cache'
    return base / 'hda_torque_estimator' / source_digest(module)


_unwritten: list[str] = []         # why compiled code is not kept, as far as it was tried


@cache
def _can_be_written(folder: Path) -> bool:
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError:
        writable = False
    else:
        writable = os.access(folder, os.W_OK | os.X_OK)
    if not writable:
        _unwritten.append(f'{folder.parent} cannot be written')
    return writable


class _Cache(FunctionCache):
    """A cache that code does not depend on: a full disk costs time, nothing else."""

    def save_overload(self, signature: Any, code: Any) -> None:
        """Save compiled code if the disk takes it."""
        try:
            super().save_overload(signature, code)
        except OSError as error:
            _unwritten.append(f'{self.cache_path} cannot be written ({error.strerror})')


class _Listener(event.Listener):
    """Say once that something is compiled."""

    def __init__(self, say: Callable[[str], None]) -> None:
        self._say: Callable[[str], None] | None = say

    def on_start(self, event: Any) -> None:
        """Say it with the first that is compiled, not loaded."""
        say, self._say = self._say, None
        if say:
            say('compiling, once after an installation, for a minute or two' if not _unwritten else
                f'compiling, for a minute or two and at every start anew: {_unwritten[0]}; '
                'HDA_CACHE_DIR can name another folder')

    def on_end(self, event: Any) -> None:
        """Say nothing."""


def say_when_compiling(say: Callable[[str], None]) -> None:
    """Call `say`, once, if anything has to be compiled, which takes long."""
    event.register('numba:compile', _Listener(say))


def compiled(law: Law, *, inlined: bool = False) -> Law:
    """
    Return `law` compiled on first use; scalars and arrays alike where its formula allows.

    Its annotations are for who calls it: numba does not read them. `inlined` functions become
    part of their caller: handing over many arrays costs more than a short law itself. Other
    threads may run meanwhile.
    """
    made: Any = numba.njit(error_model='numpy', forceinline=inlined, nogil=True)(law)
    folder = cache_folder(law.__module__)
    if not _CONFIG.DISABLE_JIT and _can_be_written(folder):
        before = _CONFIG.CACHE_DIR
        _CONFIG.CACHE_DIR = str(folder)
        try:
            made._cache = _Cache(law)
        finally:
            _CONFIG.CACHE_DIR = before
    return made


def inlined(law: Law) -> Law:
    """Return `law` compiled into its callers."""
    return compiled(law, inlined=True)


def either(first: Law, second: Law, is_second: Callable[[Any], bool]) -> Law:
    """
    Return what compiled code calls for one of two laws, chosen when its caller is compiled.

    The second law is meant where `is_second` holds for the numba type of an argument. Both are
    compiled functions with the same names of arguments. The choice costs nothing at run time.
    """
    def chosen(*arguments: Any) -> Any:
        raise TypeError(f'{first.__name__} is chosen by compiled code alone')

    laws = _bare(first), _bare(second)

    def choose(*types: Any) -> Any:
        return laws[any(map(is_second, types))]

    choice: Any = choose
    choice.__signature__ = signature(laws[0])
    overload(chosen, jit_options={'error_model': 'numpy', 'forceinline': True,
                                  'nogil': True})(choice)
    made: Any = chosen
    return made


def _bare(law: Any) -> Any:
    """Return the function of a compiled law without annotations, which numba would compare."""
    made = law.py_func
    bare = FunctionType(made.__code__, made.__globals__, made.__name__, made.__defaults__,
                        made.__closure__)
    bare.__module__ = made.__module__
    return bare


def interpreted(law: Law) -> Law:
    """Return a compiled law as it stands in its source, for arrays of any shape."""
    made: Any = law
    return made.py_func


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
