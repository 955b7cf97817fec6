"""*PARAMETER and *PARAMETER_EXPRESSION: values by name, as &name and -&name in the fields of cards."""

from __future__ import annotations

import math
import re
from collections.abc import Iterator

from creak.errors import InputError
from creak.formats.deck.expressions import ERRORS, FUNCTIONS, Functions, Value, error_word, value_of, whole
from creak.formats.lsdyna.text.cards import LONG, TENS, Block
from creak.formats.matrices.checks import field_value

NAMES = frozenset(
    "_".join(("PARAMETER", *expression, *local)) for expression in ((), ("EXPRESSION",)) for local in ((), ("LOCAL",))
)
"""Keywords that are read here."""
LOCAL = "LOCAL"
_NAME = re.compile(r"([RIC])\s*([A-Z_]\w{0,28})", re.IGNORECASE)


def _nearest_integer(x: float) -> int:
    return math.floor(abs(x) + 0.5) * (1 if x >= 0.0 else -1)


_FUNCTIONS: Functions = {
    **FUNCTIONS,
    **{name: getattr(math, name) for name in ("sinh", "cosh", "tanh", "asinh", "acosh", "atanh")},
    **{
        "aint": lambda x: float(math.trunc(x)),
        "nint": _nearest_integer,
        "mod": lambda a, b: whole(math.fmod(a, b), a, b),
    },
    "sign": lambda a, b: whole(math.copysign(a, b), a, b),
}


def define(block: Block, into: dict[str, Value], places: dict[str, str]) -> None:
    """Put the values of a block into a table by name, in small letters; it may use those that its cards know.

    Parameters
    ----------
    places : where the names of the table have their values from.

    Raises
    ------
    InputError : no name with its type, no value, a value of another type, a name that has another value already.
    """
    pairs = _expressions(block) if "EXPRESSION" in block.name else _pairs(block)
    for head, text, where in pairs:
        named = _NAME.fullmatch(head)
        if named is None:
            raise InputError(
                f"*{block.name} has {head!r} for the name of a parameter",
                where=where,
                expected="R, I or C, and a name: R thick",
                fix="Say of which type it is.",
            )
        name = named[2].lower()
        value = _value(block, named[1].upper(), named[2], text, where)
        if name in into and into[name] != value:
            raise InputError(
                f"&{named[2]} has two values, {into[name]} and {value}",
                where=where,
                expected=f"one value of each name; the other is {places[name]}",
                fix="Remove one of them.",
            )
        into[name] = value
        places.setdefault(name, where)


def _pairs(block: Block) -> Iterator[tuple[str, str, str]]:
    """Name and value of each pair of fields, and where they stand."""
    for line in block.lines:
        card = block.card(line, TENS)
        for i in range(0, len(card.fields), 2):
            if card.text(i) or card.text(i + 1):
                yield card.text(i), card.text(i + 1), card.where


def _expressions(block: Block) -> Iterator[tuple[str, str, str]]:
    """Name and expression of each; a line without a name goes on with the one before."""
    begun: tuple[str, str, str] | None = None
    for line in block.lines:
        text = line.text.expandtabs(8)
        width = LONG if block.long else TENS[0]
        head, rest = text.split(",", 1) if "," in text[: width + 1] else (text[:width], text[width:])
        if head.strip() and begun is not None:
            yield begun
        if head.strip() or begun is None:
            begun = head.strip(), rest.strip(), line.where
        else:
            begun = begun[0], begun[1] + rest.strip(), begun[2]
    if begun is not None:
        yield begun


def _value(block: Block, kind: str, name: str, text: str, where: str) -> Value:
    if kind == "C":
        return text
    if "EXPRESSION" not in block.name and (plain := field_value(text)) is not None:
        value: Value = plain
    else:
        bare = text.replace("&", "").lower()
        try:
            value = value_of(bare, block.values, _FUNCTIONS, _quotient)
        except ERRORS as error:
            raise InputError(
                f"*{block.name} &{name} = {text[:60]!r}: {error_word(error)} error",
                expected="numbers, names of parameters above, + - * / ** ( ) and functions such as sqrt",
                where=where,
                fix="Write the value as a number.",
            ) from None
    if isinstance(value, str):
        raise InputError(f"&{name} is a text", where=where, expected="a number", fix="Write C before its name.")
    if kind == "R":
        return float(value)
    if value != int(value):
        raise InputError(
            f"&{name} = {text[:60]} is {value:g}",
            where=where,
            expected="a whole number, as I before its name says",
            fix="Write R before the name, or round it: nint(...).",
        )
    return int(value)


def _quotient(a: float, b: float) -> float:
    """Of two integers an integer, as LS-DYNA has it."""
    return math.trunc(a / b) if isinstance(a, int) and isinstance(b, int) else a / b
