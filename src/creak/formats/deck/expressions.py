"""Expressions of numbers, names and functions, as decks have them for values by name."""

from __future__ import annotations

import ast
import math
import operator
from collections.abc import Callable, Mapping

Value = float | int | str


def whole(x: float, *of: float) -> float:
    """The same as an integer where it is made of integers and is one."""
    return int(x) if all(isinstance(a, int) for a in of) and abs(x) < EXACT and x == int(x) else x


Functions = Mapping[str, Callable[..., float]]
_BINARY: Mapping[type, Callable[[float, float], float]] = {
    ast.Add: operator.add,
    ast.Sub: operator.sub,
    ast.Mult: operator.mul,
    ast.Div: operator.truediv,
    ast.FloorDiv: operator.floordiv,
    ast.Mod: operator.mod,
    ast.Pow: lambda a, b: whole(math.pow(a, b), a, b),
}
_UNARY: Mapping[type, Callable[[float], float]] = {ast.UAdd: operator.pos, ast.USub: operator.neg}
FUNCTIONS: Functions = {
    **{name: getattr(math, name) for name in ("sin", "cos", "tan", "asin", "acos", "atan", "atan2", "sqrt", "exp")},
    **{name: getattr(math, name) for name in ("log", "log10", "radians", "degrees")},
    **{"abs": abs, "min": min, "max": max, "int": int, "float": float, "round": round},
}
"""What most decks know."""
LARGEST, EXACT = 1e300, 2.0**53
ERRORS = (SyntaxError, ValueError, TypeError, ArithmeticError, KeyError, RecursionError, MemoryError)
"""What `value_of` raises where a text is no such expression."""


def value_of(
    text: str, values: Mapping[str, Value], functions: Functions, divide: Callable[[float, float], float] | None = None
) -> Value:
    """The value of an expression of numbers, names and functions, or of a text in quotes alone.

    Parameters
    ----------
    divide : of two numbers; default: as real numbers.

    Raises
    ------
    One of `ERRORS`.
    """
    binary = _BINARY if divide is None else {**_BINARY, ast.Div: divide}

    def of(node: ast.expr) -> Value:
        if isinstance(node, ast.Constant) and isinstance(node.value, int | float | str):
            return node.value
        if isinstance(node, ast.Name):
            return values[node.id]
        if isinstance(node, ast.BinOp) and type(node.op) in binary:
            return _checked(binary[type(node.op)](number(node.left), number(node.right)))
        if isinstance(node, ast.UnaryOp) and type(node.op) in _UNARY:
            return _UNARY[type(node.op)](number(node.operand))
        if isinstance(node, ast.Call) and isinstance(node.func, ast.Name) and not node.keywords:
            return _checked(functions[node.func.id](*(number(a) for a in node.args)))
        raise ValueError

    def number(node: ast.expr) -> float:
        value = of(node)
        if isinstance(value, str):
            raise TypeError
        return value

    return of(ast.parse(text, mode="eval").body)


def error_word(error: BaseException) -> str:
    """What kind of error it is, in a word."""
    return type(error).__name__.removesuffix("Error").lower()


def _checked(value: float) -> float:
    if not abs(value) < LARGEST:
        raise OverflowError
    return value
