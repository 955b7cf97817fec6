"""Bulk data cards with all digits: small and large fields where the numbers fit, else free field."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from decimal import Decimal

Field = str | int | float | None
SMALL, LARGE = 8, 16
WIDTH = 72
"""Columns that every program reads of a line."""


def card(name: str, fields: Sequence[Field]) -> Iterator[str]:
    """Lines of a card; `fields` follow its name, None is blank.

    Eight fields of 8 columns to a line where every entry fits, else four of 16 (`NAME*`, reals with exponent D). A card
    of which a number needs more than 16 columns is in free field, where numbers keep all their digits as long as a line
    has no more than 72 columns: one or two long ones always, of four at least ten digits (four negative numbers with
    exponents). Programs that take 16 characters of a field round there as well.
    """
    last = max((k for k, f in enumerate(fields) if f is not None), default=0)
    fields = fields[: last + 1]
    for width in (SMALL, LARGE):
        texts = [_text(f, width) for f in fields]
        if all(t is not None for t in texts):
            yield from _lines(name, [t or "" for t in texts], width)
            return
    rows = [fields[k : k + 4] for k in range(0, len(fields), 4)]
    yield from (_free_line(f"{name}*" if k == 0 else "*", row) for k, row in enumerate(rows))
    if len(rows) % 2:
        yield "*"


def _lines(name: str, texts: Sequence[str], width: int) -> Iterator[str]:
    """In columns; cards of large field have an even number of lines."""
    per_line, large = 64 // width, width == LARGE
    for k in range(0, max(len(texts), 1), per_line):
        head = f"{name}{'*' * large}" if k == 0 else "*" if large else "+"
        yield (f"{head:<8}" + "".join(f"{t:>{width}}" for t in texts[k : k + per_line])).rstrip()
    if large and -(-len(texts) // per_line) % 2:
        yield "*"


def _free_line(head: str, fields: Sequence[Field]) -> str:
    """A line of free field, its reals with all their digits or as many as it has room for."""
    texts, digits = [_whole(f) for f in fields], [17] * len(fields)
    while len(head) + sum(1 + len(t) for t in texts) > WIDTH:
        k = max(range(len(texts)), key=lambda i: len(texts[i]))
        digits[k] -= 1
        field = fields[k]
        texts[k] = (
            min(_forms(float(f"{field:.{digits[k] - 1}e}")), key=len) if isinstance(field, float) else _whole(field)
        )
    return ",".join([head, *texts])


def _text(field: Field, width: int) -> str | None:
    """The field in at most `width` columns without loss, None where it does not fit."""
    if isinstance(field, float):
        return fitted(field, width)
    text = "" if field is None else str(field)
    return text if len(text) <= width else None


def _whole(field: Field) -> str:
    return _forms(field)[0] if isinstance(field, float) else "" if field is None else str(field)


def fitted(value: float, width: int) -> str | None:
    """A real that reads back as the same double, in at most `width` columns; None where there is none."""
    return next((text for text in _forms(value) if len(text) <= width), None)


def _forms(value: float) -> list[str]:
    """Plain decimal, with D exponent, with Nastran's exponent without a letter (1.5-9), the preferred first."""
    sign, digits, exponent = Decimal(repr(float(value))).normalize().as_tuple()
    assert isinstance(exponent, int)
    text, minus = "".join(map(str, digits)), "-" * sign
    point = len(text) + exponent
    if text == "0":
        return ["0."]
    power, mantissa = point - 1, f"{minus}{text[0]}.{text[1:]}"
    forms = [f"{mantissa}D{power:+d}", f"{mantissa}{power:+d}"]
    plain = minus + _plain(text, point) if -8 < point < 16 else ""
    if plain and (point > 0 or len(plain) <= len(forms[0])):
        forms.insert(0, plain)
    return forms


def _plain(text: str, point: int) -> str:
    if point <= 0:
        return f".{'0' * -point}{text}"
    return f"{text[:point]}.{text[point:]}" if point < len(text) else f"{text}{'0' * (point - len(text))}."
