"""A formula of columns: sums and products of columns and numbers, and nothing else of Python."""

import ast
from collections.abc import Callable, Mapping
from dataclasses import dataclass
import operator
import re
from typing import Any

import numpy as np

from .column_map import ColumnMapError, Floats

LONGEST = 300
QUOTED = re.compile('`([^`]+)`')
PLACE = '_column_'
BINARY: dict[type[ast.operator], Callable[[Any, Any], Any]] = {
    ast.Add: operator.add, ast.Sub: operator.sub, ast.Mult: operator.mul,
    ast.Div: operator.truediv}
UNARY: dict[type[ast.unaryop], Callable[[Any], Any]] = {
    ast.UAdd: operator.pos, ast.USub: operator.neg}


@dataclass(frozen=True)
class Formula:
    """An expression, and the columns that its names stand for."""

    tree: ast.expr
    names: Mapping[str, str]

    def __call__(self, columns: Mapping[str, Floats]) -> Floats:
        """Return the value in every row (n,), NaN where there is no finite one."""
        with np.errstate(all='ignore'):
            found = np.asarray(self._value(self.tree, columns), np.float64)
        return np.where(np.isfinite(found), found, np.nan)

    def _value(self, node: ast.expr, columns: Mapping[str, Floats]) -> Any:
        if isinstance(node, ast.BinOp):
            return BINARY[type(node.op)](self._value(node.left, columns),
                                         self._value(node.right, columns))
        if isinstance(node, ast.UnaryOp):
            return UNARY[type(node.op)](self._value(node.operand, columns))
        if isinstance(node, ast.Name):
            return columns[self.names[node.id]]
        return np.float64(ast.literal_eval(node))       # a number: nothing else is let in


def read_formula(entry: str, text: object) -> Formula:
    """
    Return a formula of `+ - * /`, brackets, numbers and columns.

    A column whose name is no word stands in backticks. Raises ColumnMapError.
    """
    if not isinstance(text, str) or not text.strip() or len(text) > LONGEST:
        raise ColumnMapError(f'{entry}.formula must be a text of 1 to {LONGEST} characters')
    quoted = QUOTED.findall(text)
    places = iter(range(len(quoted)))
    plain = QUOTED.sub(lambda _: f'{PLACE}{next(places)}', text.strip())
    try:
        tree = ast.parse(plain, mode='eval').body
    except (SyntaxError, ValueError, MemoryError, RecursionError):
        raise ColumnMapError(f'{entry}.formula {text!r} cannot be read; columns whose names are '
                             'no words stand in `backticks`') from None
    for node in ast.walk(tree):
        if not _is_allowed(node):
            raise ColumnMapError(f'{entry}.formula {text!r} may hold columns, numbers, brackets '
                                 'and + - * / only')
    names = {f'{PLACE}{place}': name for place, name in enumerate(quoted)}
    words = dict.fromkeys(node.id for node in ast.walk(tree) if isinstance(node, ast.Name))
    if not words:
        raise ColumnMapError(f'{entry}.formula {text!r} names no column')
    return Formula(tree, {word: names.get(word, word) for word in words})


def _is_allowed(node: ast.AST) -> bool:
    if isinstance(node, ast.Constant):
        return type(node.value) in (int, float)
    return isinstance(node, (ast.BinOp, ast.UnaryOp, ast.Name, ast.Load, *BINARY, *UNARY))
