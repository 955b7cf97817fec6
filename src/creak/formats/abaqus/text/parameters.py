"""*PARAMETER: values by name, as `<name>` in the lines of the deck."""

from __future__ import annotations

import re
from collections.abc import Mapping

from creak.errors import InputError, suggest
from creak.formats.abaqus.text.lexer import Block
from creak.formats.deck.expressions import ERRORS, FUNCTIONS, Value, error_word, value_of

_USE = re.compile(r"<\s*([A-Za-z_]\w{0,79})\s*>")
_LINE = re.compile(r"\s*([A-Za-z_]\w{0,79})\s*=(?!=)\s*(.{1,500}?)\s*(#.*)?")


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
        values[found[1]] = value_of(found[2], values, FUNCTIONS)
    except ERRORS as error:
        raise InputError(
            f"*PARAMETER {found[1]} = {found[2][:60]}: {error_word(error)} error",
            expected="numbers, names of parameters, + - * / ** ( ) and functions such as sqrt",
            where=where,
            fix="Write the value as a number.",
        ) from None


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
