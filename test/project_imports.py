"""List what every module of the project imports."""

import ast
from collections.abc import Iterator
from pathlib import Path

from project_files import files, PACKAGES, ROOT


def module_name(path: Path) -> str:
    """Return the dotted name under which a file is imported."""
    return '.'.join(path.relative_to(ROOT).with_suffix('').parts).removesuffix('.__init__')


PATHS = {module_name(path): path for package in PACKAGES
         for path in files('*.py', within=ROOT / package)}


def imported(name: str) -> Iterator[str]:
    """Yield the full name of everything that a module of the project imports, wherever it does."""
    package = name if PATHS[name].stem == '__init__' else name.rpartition('.')[0]
    for node in ast.walk(ast.parse(PATHS[name].read_text())):
        if isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            source = origin(node, package)
            yield from (inside if (inside := f'{source}.{alias.name}') in PATHS else source
                        for alias in node.names)


def origin(node: ast.ImportFrom, package: str) -> str:
    """Return the full name of what a `from` statement in `package` imports from."""
    if not node.level:
        return node.module or ''
    parts = package.split('.')
    return '.'.join([*parts[:len(parts) + 1 - node.level], *filter(None, [node.module])])


IMPORTS = {name: set(imported(name)) for name in PATHS}
