"""*PARAMETER: values by name, as `<name>` in the lines of the deck."""

from __future__ import annotations

import ast
import math
import operator
import re
from collections.abc import Callable, Mapping

from creak.errors import InputError, suggest
from creak.formats.abaqus.text.lexer import Block

Value = float | int | str
_USE = re.compile(r"<\s*([A-Za-z_]\w{0,79})\s*>")
_LINE = re.compile(r"\s*([A-Za-z_]\w{0,79})\s*=(?!=)\s*(.{1,500}?)\s*(#.*)?")
_BINARY: Mapping[type, Callable[[float, float], float]] = {
    ast.Add: operator.add,
    ast.Sub: operator.sub,
    ast.Mult: operator.mul,
    ast.Div: operator.truediv,
    ast.FloorDiv: operator.floordiv,
    ast.Mod: operator.mod,
    ast.Pow: lambda a, b: math.pow(a, b),
}
_UNARY: Mapping[type, Callable[[float], float]] = {ast.UAdd: operator.pos, ast.USub: operator.neg}
_FUNCTIONS: Mapping[str, Callable[..., float]] = {
    **{name: getattr(math, name) for name in ("sin", "cos", "tan", "asin", "acos", "atan", "atan2", "sqrt", "exp")},
    **{name: getattr(math, name) for name in ("log", "log10", "radians", "degrees")},
    **{"abs": abs, "min": min, "max": max, "int": int, "float": float, "round": round},
}
LARGEST = 1e300


def with_parameters(blocks: list[Block]) -> list[Block]:
    """Blocks with the values of *PARAMETER in their lines and keyword parameters; a deck without any is as it is.

    Raises
    ------
    InputError : a line that is no assignment, an expression that is not of numbers, a name that has no value.
    """
    values: dict[str, Value] = {}
    for block in blocks:
        if block.name == "PARAMETER":
            for line, code in zip(block.lines, block.codes, strict=True):
                if line.split("#")[0].strip():
                    _assign(values, line, block.place(code))
    if not values:
        return blocks
    for block in blocks:
        if block.name != "PARAMETER":
            _fill_in(block, values)
    return blocks


def _assign(values: dict[str, Value], line: str, where: str) -> None:
    found = _LINE.fullmatch(line)
    if found is None:
        raise InputError(
            f"{line[:60]!r} in *PARAMETER",
            expected="name = expression",
            where=where,
            fix="Write one assignment a line.",
        )
    try:
        values[found[1]] = _value(ast.parse(found[2], mode="eval").body, values)
    except (SyntaxError, ValueError, TypeError, ArithmeticError, KeyError, RecursionError, MemoryError) as error:
        raise InputError(
            f"*PARAMETER {found[1]} = {found[2][:60]}: {type(error).__name__.removesuffix('Error').lower()} error",
            expected="numbers, names of parameters, + - * / ** ( ) and functions such as sqrt",
            where=where,
            fix="Write the value as a number.",
        ) from None


def _value(node: ast.expr, values: Mapping[str, Value]) -> Value:
    """The value of an expression of numbers, names and functions; a text in quotes alone."""
    if isinstance(node, ast.Constant) and isinstance(node.value, int | float | str):
        return node.value
    if isinstance(node, ast.Name):
        return values[node.id]
    if isinstance(node, ast.BinOp) and type(node.op) in _BINARY:
        return _checked(_BINARY[type(node.op)](_number(node.left, values), _number(node.right, values)))
    if isinstance(node, ast.UnaryOp) and type(node.op) in _UNARY:
        return _UNARY[type(node.op)](_number(node.operand, values))
    if isinstance(node, ast.Call) and isinstance(node.func, ast.Name) and not node.keywords:
        return _checked(_FUNCTIONS[node.func.id](*(_number(a, values) for a in node.args)))
    raise ValueError


def _number(node: ast.expr, values: Mapping[str, Value]) -> float:
    value = _value(node, values)
    if isinstance(value, str):
        raise TypeError
    return value


def _checked(value: float) -> float:
    if not abs(value) < LARGEST:
        raise OverflowError
    return value


def _fill_in(block: Block, values: Mapping[str, Value]) -> None:
    for k, line in enumerate(block.lines):
        if "<" in line:
            block.lines[k] = _filled(line, values, block.place(block.codes[k]))
    for key, value in block.params.items():
        if "<" in value:
            block.params[key] = _filled(value, values, block.where)


def _filled(text: str, values: Mapping[str, Value], where: str) -> str:
    def of(found: re.Match[str]) -> str:
        if found[1] not in values:
            raise InputError(f"<{found[1]}> is no *PARAMETER", where=where, fix=suggest(found[1], values))
        value = values[found[1]]
        return repr(value) if isinstance(value, float) else str(value)

    return _USE.sub(of, text)
