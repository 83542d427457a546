"""Read a formula of the case file, such as ``0.1 + 0.2*(r < 0.1 mm)``, without evaluating text as Python.

The text is parsed by Python's own parser; each node of the tree must be listed here. A number followed by
a unit of length stands for that length in mm. Comparisons are 1 where they hold and 0 elsewhere.
"""

from __future__ import annotations

import ast
import math
import operator
import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

from fretsolve.case.dimensions import LENGTH
from fretsolve.case.quantities import QuantityError, shown, to_internal

LONGEST = 300
"""Characters of a formula."""

_LENGTH = re.compile(r"(?<![\w.])((?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?)\s*(?![eE][+-]?\d)([A-Za-zµμ]+)")
_OPERATORS: Mapping[type[ast.operator], Callable[[Any, Any], Any]] = {
    ast.Add: operator.add,
    ast.Sub: operator.sub,
    ast.Mult: operator.mul,
    ast.Div: operator.truediv,
    ast.Pow: operator.pow,
}
_SIGNS: Mapping[type[ast.unaryop], Callable[[Any], Any]] = {ast.UAdd: operator.pos, ast.USub: operator.neg}
_COMPARISONS: Mapping[type[ast.cmpop], Callable[[Any, Any], Any]] = {
    ast.Lt: operator.lt,
    ast.LtE: operator.le,
    ast.Gt: operator.gt,
    ast.GtE: operator.ge,
}
FUNCTIONS = {"abs": 1, "sqrt": 1, "exp": 1, "log": 1, "sin": 1, "cos": 1, "tan": 1, "tanh": 1, "min": 2, "max": 2}
"""Functions with their number of arguments."""

CONSTANTS = {"pi": math.pi}


@dataclass(frozen=True)
class Expression:
    """A formula in the variables `names`. Raises QuantityError, whose text is for the user, if it cannot be used."""

    text: str
    names: tuple[str, ...] = ("x", "y", "r")

    def __post_init__(self) -> None:
        self._require_known(self._tree())

    def __call__(self, **values: Any) -> Any:
        """Return the value, an array like `values` or a number; it may be infinite or NaN."""
        import numpy as np

        with np.errstate(all="ignore"):
            return self._value(self._tree(), values, np)

    @property
    def varies(self) -> bool:
        """True if a variable stands in it."""
        return any(map(self.uses, self.names))

    def uses(self, name: str) -> bool:
        """Return whether the variable `name` stands in it."""
        return any(isinstance(node, ast.Name) and node.id == name for node in ast.walk(self._tree()))

    def _tree(self) -> ast.expr:
        if len(self.text) > LONGEST:
            raise QuantityError(f"{shown(self.text)} is too long; a formula has at most {LONGEST} characters")
        try:
            return ast.parse(_LENGTH.sub(self._in_mm, self.text.strip()), mode="eval").body
        except QuantityError:
            raise
        except (SyntaxError, ValueError, RecursionError, MemoryError):
            example = "one such as '0.1 + 0.2*(r < 0.1 mm)'"
            raise QuantityError(f"{shown(self.text)} is not a formula; {example} is needed") from None

    def _in_mm(self, match: re.Match[str]) -> str:
        try:
            return f"({to_internal(f'{match[1]} {match[2]}', LENGTH)!r})"
        except QuantityError as error:
            raise QuantityError(f"{shown(self.text)}: {error}") from None

    def _require_known(self, node: ast.expr) -> None:
        """Raise QuantityError for the first node that a formula cannot have."""
        allowed = ", ".join([*self.names, *CONSTANTS, *(f"{name}()" for name in FUNCTIONS)])
        match node:
            case ast.Constant(value=int() | float() as value) if not isinstance(value, bool):
                return
            case ast.Name(id=name) if name in self.names or name in CONSTANTS:
                return
            case ast.BinOp(left=left, op=op, right=right) if type(op) in _OPERATORS:
                parts = [left, right]
            case ast.UnaryOp(op=sign, operand=operand) if type(sign) in _SIGNS:
                parts = [operand]
            case ast.Compare(left=left, ops=ops, comparators=others) if all(type(op) in _COMPARISONS for op in ops):
                parts = [left, *others]
            case ast.Call(func=ast.Name(id=name), args=args, keywords=[]) if name in FUNCTIONS:
                if len(args) != FUNCTIONS[name]:
                    raise QuantityError(f"{shown(self.text)}: {name} takes {FUNCTIONS[name]} value(s), not {len(args)}")
                parts = args
            case _:
                what = shown(ast.unparse(node))
                needed = f"numbers, + - * / ** < > and {allowed} are"
                raise QuantityError(f"{shown(self.text)}: {what} is not allowed; {needed}")
        for part in parts:
            self._require_known(part)

    def _value(self, node: ast.expr, values: Mapping[str, Any], np: Any) -> Any:
        match node:
            case ast.Constant(value=value):
                return np.float64(value)
            case ast.Name(id=name):
                return values[name] if name in values else CONSTANTS[name]
            case ast.BinOp(left=left, op=op, right=right):
                return _OPERATORS[type(op)](self._value(left, values, np), self._value(right, values, np))
            case ast.UnaryOp(op=sign, operand=operand):
                return _SIGNS[type(sign)](self._value(operand, values, np))
            case ast.Compare(left=left, ops=ops, comparators=others):
                sides = [self._value(one, values, np) for one in (left, *others)]
                held = [_COMPARISONS[type(op)](*pair) for op, pair in zip(ops, pairwise(sides), strict=True)]
                return np.logical_and.reduce(held) * np.float64(1.0)
            case ast.Call(func=ast.Name(id=name), args=args):
                function: Any = {"min": np.minimum, "max": np.maximum}.get(name) or getattr(np, name)
                return function(*(self._value(one, values, np) for one in args))
        raise AssertionError(node)
