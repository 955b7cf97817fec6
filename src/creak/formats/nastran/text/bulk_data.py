"""Cards of Nastran bulk data in small, large and free field."""

from __future__ import annotations

import itertools
import re
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, ClassVar

from creak.errors import InputError
from creak.formats.deck.refusals import Placed
from creak.formats.deck.text import Line
from creak.formats.matrices.checks import field_value, number, read_text

_INTEGER = re.compile(r"[+-]?[0-9]+")
MAX_DIGITS = 15
"""Of an integer."""
MAX_LIST = 1_000_000
"""Ids of one card, where each of them is taken for itself."""
_BEGIN_BULK = re.compile(r"\s*BEGIN\s+BULK\b", re.I)


@dataclass(frozen=True)
class Card(Placed):
    """One bulk data entry with its continuations."""

    kind: ClassVar[str] = " card"

    name: str
    fields: tuple[str, ...]
    """Data fields from the second on, eight per small and four per large line, blank where not given."""
    where: str
    """File and line, for messages."""
    continued: tuple[tuple[int, str], ...] = ()
    """First data field and place of each continuation line."""
    tail: str = ""
    """Field 10 of its last line, where that asks for a line which does not follow."""

    def text(self, i: int) -> str:
        return self.fields[i] if i < len(self.fields) else ""

    @property
    def title(self) -> str:
        """Name and id, for messages."""
        return f"{self.name} {self.text(0)}"

    def place(self, i: int) -> str:
        """File and line of field i."""
        return next((where for first, where in reversed(self.continued) if i >= first), self.where)

    def wrong(self, i: int, expected: str, fix: str = "") -> InputError:
        """The error for field i; fields are counted as Nastran does, ten to a line with name and continuation."""
        return InputError(
            f"field {2 + i + 2 * (i // 8)} of {self.name} is {self.text(i)!r}",
            where=self.place(i),
            expected=expected,
            fix=fix,
        )

    def integer(self, i: int, default: int | None = None) -> int:
        """Field i (from 0) as an integer; the default where it is blank."""
        text = self.text(i)
        if not text and default is not None:
            return default
        if not _INTEGER.fullmatch(text):
            raise self.wrong(i, "an integer")
        if len(text) > MAX_DIGITS:
            raise self.wrong(i, f"an integer of at most {MAX_DIGITS} digits")
        return int(text)

    def real(self, i: int, default: float | None = None) -> float:
        """Field i (from 0) as a real number, also in Nastran's short form 1.-3; the default where it is blank."""
        text = self.text(i)
        if not text and default is not None:
            return default
        value = field_value(text)
        if value is None:
            raise self.wrong(i, "a real number")
        return value

    def is_integer(self, i: int) -> bool:
        """Does field i hold an integer (a real number has a point)?"""
        return _INTEGER.fullmatch(self.text(i)) is not None

    def components(self, i: int, default: str | None = None) -> tuple[int, ...]:
        """Field i as dofs: digits 1 to 6, each once, with blanks between them or none; a blank or 0 is none."""
        text = "".join((self.text(i) or default or "").split())
        if text.strip("0") and not re.fullmatch("[1-6]+", text):
            raise self.wrong(i, "dofs, digits 1 to 6")
        return tuple(sorted({int(c) for c in text} - {0}))


def read_cards(path: Path) -> list[Card]:
    """All cards of a bulk data file (.asm, .pch, .bdf); what stands before BEGIN BULK is skipped.

    INCLUDE files are not followed.
    """
    lines = read_text(path).splitlines()
    begin = next((i for i, line in enumerate(lines, start=1) if _BEGIN_BULK.match(line)), 0)
    return cards_of(Line(text, f"{path}:{i}") for i, text in enumerate(lines[begin:], start=begin + 1))


def cards_of(lines: Iterable[Line]) -> list[Card]:
    """The cards of bulk data lines; comments ($) and blank lines are skipped.

    Replicated fields are written out: = is the field of the card before, == all that follow, *x or *(x) that field and
    x more; =n or =(n) on a line of its own repeats the last replication n times. A named continuation belongs to the
    line that asks for it in field 10, wherever that stands; one without a name to the line before it.

    Raises
    ------
    InputError : a free-field line with too many fields, continuations that no line asks for.
    """
    found: list[_Open] = []
    early: list[_Early] = []
    asking: dict[str, _Open] = {}
    rule: list[str] = []
    last: _Open | None = None
    for line in lines:
        text = line.text.split("$")[0].expandtabs(8).rstrip()
        if not text:
            continue
        if prose := _PROSE.match(text):
            last = _Open(prose.group(1).upper(), [], line.where, [], "")
            found.append(last)
            continue
        if last is not None and _goes_on_in_prose(text, last, asking):
            continue
        head, fields, tail = _split(text, line.where)
        if head.startswith("=") and found:
            count = re.fullmatch(r"=\(?([0-9]{1,6})\)?", head)
            rule = rule if count else fields
            for _ in range(int(count.group(1)) if count else 1):
                found.append(
                    _Open(found[-1].name, _replicated(rule, found[-1].fields, line.where), line.where, [], tail)
                )
        elif head and head[0] not in "+*":
            name = head.rstrip("*").strip().upper()
            if found and any(f.startswith(("=", "*")) for f in fields):
                rule, fields = fields, _replicated(fields, found[-1].fields, line.where)
            found.append(_Open(name, fields, line.where, [], tail))
        elif last is not None or _own_name(head):
            owner = _owner(head, last, asking)
            if owner is None:
                owner = _Early("", [], line.where, [], "", _own_name(head), _before(last))
                early.append(owner)
            last = owner
            last.extend(fields, tail, line.where)
            _ask(last, asking)
            continue
        if found:
            last = found[-1]
            _ask(last, asking)
    _place(early, asking)
    return [Card(o.name, tuple(o.fields), o.where, tuple(o.continued), o.tail) for o in found]


_PROSE = re.compile(r"(DEQATN|DESC|MONPNT[123]|MONDSP[12]|MONSUM[1T]?|MONCNCM)\b", re.I)
"""Cards that hold a formula or a sentence, commas and all; none of them bears on the structure."""


def _goes_on_in_prose(text: str, last: _Open, asking: Mapping[str, _Open]) -> bool:
    """Whether a line goes on with the card of prose before it."""
    asked = _own_name(text[:8].split(",")[0]) in asking
    return text[0] in " +*," and _PROSE.fullmatch(last.name) is not None and not asked


def _replicated(rule: list[str], before: list[str], where: str) -> list[str]:
    """The fields of a card from those of the card before it."""
    out: list[str] = []
    for i, text in enumerate(rule):
        old = before[i] if i < len(before) else ""
        step = re.fullmatch(r"\*\(?([^()]+)\)?", text)
        if text == "==":
            return [*out, *before[i : len(rule)]]
        if text == "=":
            out.append(old)
        elif step:
            out.append(_more(old, step.group(1), where))
        else:
            out.append(text)
    return out


def _more(old: str, step: str, where: str) -> str:
    try:
        if _INTEGER.fullmatch(old) and _INTEGER.fullmatch(step):
            return str(int(old) + int(step))
        return repr(float(number(old)) + float(number(step)))
    except ValueError:
        raise InputError(
            f"a replicated field adds {step!r} to {old!r}",
            where=where,
            expected="two numbers",
            fix="Write the card out.",
        ) from None


@dataclass
class _Open:
    """A card that may go on."""

    name: str
    fields: list[str]
    where: str
    continued: list[tuple[int, str]]
    tail: str
    """Field 10 of the last line: the name of the line that follows."""

    def extend(self, fields: list[str], tail: str, where: str) -> None:
        self.continued.append((len(self.fields), where))
        self.fields.extend(fields)
        self.tail = tail


@dataclass
class _Early(_Open):
    """Lines that stand before the one that asks for them."""

    own: str
    """The name by which the first of them answers."""
    after: str
    """What stands before them, for the message that no line asks for them."""


def _names(tail: str) -> set[str]:
    """Names by which a continuation may answer: the first character of field 10 is free."""
    return {tail.lstrip("+*").strip().upper(), tail[1:].strip().upper()} - {""}


def _ask(card: _Open, asking: dict[str, _Open]) -> None:
    for name in _names(card.tail) if card.tail else ():
        asking[name] = card


def _own_name(head: str) -> str:
    """Name by which a continuation answers; empty: it has none."""
    return head.lstrip("+*").strip().upper()


def _owner(head: str, last: _Open | None, asking: dict[str, _Open]) -> _Open | None:
    """What a continuation goes on with: the line before it, unless names say otherwise; None: nobody asked yet."""
    own = _own_name(head)
    owner = last if last is not None and (not own or own in _names(last.tail)) else asking.get(own)
    if owner is not None:
        _answer(owner, asking)
    return owner


def _before(last: _Open | None) -> str:
    """Of a continuation that nobody asked for yet: the line before it, and what that asks for."""
    if last is None or not last.name:
        return ""
    asks = f" that asks for {last.tail.lstrip('+*').strip()!r}" if _names(last.tail) else ""
    return f", which follows a line of {last.name}{asks}"


def _answer(owner: _Open, asking: dict[str, _Open]) -> None:
    for name in _names(owner.tail):
        asking.pop(name, None)


def _place(early: list[_Early], asking: dict[str, _Open]) -> None:
    """Put continuations that stand before the line that asks for them where they belong.

    Raises
    ------
    InputError : no line asks for their name.
    """
    for lines in early:
        owner = asking.get(lines.own)
        if owner is None or owner is lines:
            raise InputError(
                f"no line asks for continuation {lines.own!r}{lines.after}",
                where=lines.where,
                expected=f"a line with {lines.own!r} in field 10",
                fix="Correct the name, or leave it out where the line before it is the one that goes on.",
            )
        _answer(owner, asking)
        start = len(owner.fields)
        owner.continued.extend((start + first, where) for first, where in lines.continued)
        owner.fields.extend(lines.fields)
        owner.tail = lines.tail
        _ask(owner, asking)


def _split(line: str, where: str) -> tuple[str, list[str], str]:
    """First field, the data fields and the continuation field of one line."""
    if "," in line:
        head, *items = (item.strip() for item in line.split(","))
        count = 4 if "*" in head else 8
        tail = items[count] if len(items) > count else ""
        if any(items[count + 1 :]):
            raise InputError(
                f"the line has {len(items) + 1} fields",
                where=where,
                expected=f"at most {count + 2}",
                fix="Go on in a continuation line.",
            )
    else:
        head = line[:8].strip()
        width = 16 if "*" in head else 8
        count = 64 // width
        items = [line[i : i + width].strip() for i in range(8, 72, width)]
        tail = line[72:80].strip()
    return head, (items[:count] + [""] * count)[:count], tail


def id_list(card: Card, start: int = 0) -> Iterator[int]:
    """Ids of a list with THRU (and BY), from field `start` on.

    Raises
    ------
    InputError : more than `MAX_LIST` ids.
    """
    ranges = list(id_ranges(card, start))
    if (count := sum(map(len, ranges))) > MAX_LIST:
        raise card.error(
            f"{card.name} lists {count:,} ids", expected=f"at most {MAX_LIST:,}", fix="Give the last id that there is."
        )
    return itertools.chain.from_iterable(ranges)


def id_ranges(card: Card, start: int = 0) -> Iterator[range]:
    """The same as ranges, of any length."""
    fields = [text.upper() for text in card.fields[start:]]
    i = 0
    while i < len(fields):
        if not fields[i]:
            i += 1
        elif i + 2 < len(fields) and fields[i + 1] == "THRU":
            by = i + 4 < len(fields) and fields[i + 3] == "BY"
            step = card.integer(start + i + 4) if by else 1
            yield range(card.integer(start + i), card.integer(start + i + 2) + 1, max(step, 1))
            i += 5 if by else 3
        else:
            first = card.integer(start + i)
            yield range(first, first + 1)
            i += 1


def ids_among(ranges: Iterable[range], known: Mapping[int, Any]) -> list[int]:
    """The ids of ranges that there are, each once: what a wide THRU spans besides costs nothing."""
    found: dict[int, None] = {}
    for ids in ranges:
        few = len(ids) <= len(known)
        found.update(dict.fromkeys((i for i in ids if i in known) if few else sorted(i for i in known if i in ids)))
    return list(found)


def free_card(name: str, fields: Iterable[object], per_line: int = 8) -> str:
    """A free-field card; with per_line = 4 in large field, whose numbers keep their digits."""
    items = ["" if f is None else str(f) for f in fields]
    star = "*" if per_line == 4 else ""
    lines = [",".join([star if i else name + star, *items[i : i + per_line]]) for i in range(0, len(items), per_line)]
    return "\n".join(lines) + "\n"


def real(value: float) -> str:
    """Shortest decimal that reads back exactly, with Nastran's double precision exponent."""
    text = repr(float(value)).upper().replace("E", "D")
    return text if "." in text or "D" in text else f"{text}."
