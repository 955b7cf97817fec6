"""Nastran files -> executive control, case control and bulk data, INCLUDE files read where they stand."""

from __future__ import annotations

import re
from dataclasses import dataclass, field
from pathlib import Path

from creak.errors import InputError
from creak.formats.deck.text import IncludeBudget, Line, read_bytes, read_lines, refuse_loop
from creak.formats.nastran.text.bulk_data import Card, cards_of

_BULK = re.compile(r"\s*BEGIN(\s+BULK)?\b", re.I)
_SUPER = re.compile(r"\s*BEGIN\s+(BULK\s+)?(SUPER|AUXMODEL|MODULE|ARBMODEL|FLXBDY|TRMC|UDS|CMODEXT)\b", re.I)
_END = re.compile(r"\s*ENDDATA\b", re.I)
_INCLUDE = re.compile(r"\s*INCLUDE\b[\s=]*(.*)", re.I)
_EXECUTIVE = re.compile(r"\s*(SOL|ID|APP|TIME|DIAG|NASTRAN|ASSIGN|COMPILE|ALTER|MALTER|INIT)\b", re.I)
_PARAM = re.compile(r"\s*PARAM\b", re.I)
"""PARAM cards may stand in the case control as well."""
_NAMES = (
    re.compile(r"\$\s*Femap Property (\d{1,15})\s*:(.+)", re.I),
    re.compile(r'\$HMNAME PROP\s+(\d{1,15})\s*"([^"]+)"', re.I),
    re.compile(r"\$ANSA_NAME_COMMENT;(\d{1,15});P[A-Z]+;([^;]+);", re.I),
)
"""Comments in which pre-processors keep the names of properties."""
_SET_NAME = re.compile(r'\$HMSET\s+(\d{1,15})\s+\d+\s*"([^"]+)"', re.I)
"""The same of sets."""
_LOADCOL = re.compile(r'\$HMNAME LOADCOL\s+(\d{1,15})\s*"([^"]+)"', re.I)
"""The same of sets of loads and supports."""


@dataclass(frozen=True)
class DeckFile:
    """The sections of a deck."""

    executive: list[Line]
    case: list[Line]
    cards: list[Card]
    property_names: dict[int, str]
    set_names: dict[int, str]
    support_names: dict[int, str]
    others: list[Line]
    """BEGIN lines of sections that were skipped (superelements)."""
    not_found: list[Line]
    """INCLUDE lines of the executive control (DMAP) whose file is missing."""
    unended: str = ""
    """What the deck ends with, and where, if not with ENDDATA; empty for bulk data alone."""
    last: str = ""
    """File and line of its last line."""


def read_deck_file(path: Path) -> DeckFile:
    """Read a deck and what it includes; a file without CEND and BEGIN BULK is bulk data alone.

    Raises
    ------
    InputError : a file is missing or not text, a deck includes itself, the deck is cut off.
    """
    budget = IncludeBudget()
    lines = _lines(path, "", budget)
    whole = any(_BULK.match(t) or t.strip().upper().startswith("CEND") for t in lines)
    reader = _Reader(path, "executive" if whole else "bulk", budget)
    reader.read(path, lines, ())
    if whole and not reader.begun:
        raise InputError(
            "the deck has CEND but no BEGIN BULK",
            where=path,
            expected="CEND, BEGIN BULK and ENDDATA",
            fix="Add BEGIN BULK before the first bulk data card.",
        )
    if not reader.controlled:
        reader.without_cend()
    case = reader.lines["case"]
    params = [_in_fields(line) for line in case if _PARAM.match(line.text)]
    cards = cards_of([*params, *reader.lines["bulk"]])
    commands = [line for line in case if not _PARAM.match(line.text)]
    names = (reader.names, reader.set_names, reader.support_names)
    unended = last = ""
    if (whole or reader.begun) and reader.section != "end" and cards:
        refuse_cut(cards, reader.lines["bulk"][-1])
        unended, last = f"{cards[-1].name} {cards[-1].text(0)}".strip(), reader.lines["bulk"][-1].where
    return DeckFile(reader.lines["executive"], commands, cards, *names, reader.others, reader.not_found, unended, last)


def refuse_cut(cards: list[Card], last: Line) -> None:
    """Refuse a deck without ENDDATA whose last card goes on in a line that is not there, or whose last line has no end
    and leaves its card shorter than all others of its name.

    Raises
    ------
    InputError : it is so.
    """
    card, file = cards[-1], Path(last.where.rpartition(":")[0])
    others = [_filled(c) for c in cards[:-1] if c.name == card.name]
    if card.tail:
        why = f"{card.title} goes on in a line that is not there"
    elif read_bytes(file)[-1:] not in (b"\n", b"\r") and others and _filled(card) < min(others):
        why = f"its last line has no end, and {card.title} has fewer fields than all others of its name"
    else:
        return
    raise InputError(
        f"the deck is cut off: it ends without ENDDATA, and {why}",
        where=last.where,
        expected="a deck that ends with ENDDATA",
        fix="Get the whole file, or complete its last card and add ENDDATA.",
    )


def _filled(card: Card) -> int:
    return max((i for i, text in enumerate(card.fields, start=1) if text), default=0)


def _in_fields(line: Line) -> Line:
    """A PARAM of the case control, whose words may stand anywhere, as a card."""
    words = line.text.split("$")[0].split()
    return Line(",".join(words), line.where) if len(words) == 3 and "," not in line.text else line


def nastran_files(path: Path) -> list[Path]:
    """A deck and what it includes, in reading order."""
    files, known = [path], {path}
    for file in files:  # grows on the way
        for name in re.findall(rb"(?im)^[ \t]*INCLUDE\s+['\"]?([^'\"\r\n$]+)", read_bytes(file)):
            included = file.parent / name.decode("latin-1").strip()
            if included.is_file() and included not in known:
                known.add(included)
                files.append(included)
    return files


@dataclass
class _Reader:
    main: Path
    section: str
    budget: IncludeBudget
    begun: bool = False
    """Whether BEGIN BULK was met."""
    controlled: bool = False
    """Whether CEND was met."""
    lines: dict[str, list[Line]] = field(
        default_factory=lambda: {"executive": [], "case": [], "bulk": [], "skipped": []}
    )
    names: dict[int, str] = field(default_factory=dict)
    set_names: dict[int, str] = field(default_factory=dict)
    support_names: dict[int, str] = field(default_factory=dict)
    others: list[Line] = field(default_factory=list)
    not_found: list[Line] = field(default_factory=list)

    def read(self, path: Path, lines: list[str], above: tuple[Path, ...]) -> None:
        k = 0
        while k < len(lines) and self.section != "end":
            text, where = lines[k], f"{path}:{k + 1}"
            k += 1
            if text.startswith("$"):
                self._comment(text)
                continue
            found = _INCLUDE.match(text)
            if found:
                name, k = _file_name(found.group(1), lines, k)
                self._include(name, path, Line(text.strip(), where), (*above, path.absolute()))
            else:
                self._line(Line(text, where))

    def _line(self, line: Line) -> None:
        if _END.match(line.text):
            self.section = "end"
        elif _SUPER.match(line.text):
            self.section = "skipped"
            self.others.append(Line(line.text.split("$")[0].strip(), line.where))
        elif _BULK.match(line.text) and not self.begun:
            self._turn_to("bulk", "case")
            self.begun = True
        elif not self.begun and line.text.strip().upper().startswith("CEND"):
            self._turn_to("case", "executive")
            self.controlled = True
        else:
            self.lines[self.section].append(line)

    def without_cend(self) -> None:
        """OptiStruct's decks have no CEND: what is not executive control is case control."""
        lines = self.lines["executive"]
        self.lines["case"] += [line for line in lines if not _EXECUTIVE.match(line.text)]
        self.lines["executive"] = [line for line in lines if _EXECUTIVE.match(line.text)]

    def _turn_to(self, section: str, before: str) -> None:
        """Go on in another section; what was taken for bulk data until here belongs to the one before."""
        if self.section == "bulk":
            self.lines[before], self.lines["bulk"] = self.lines["bulk"], []
        self.section = section

    def _comment(self, text: str) -> None:
        for pattern in _NAMES:
            found = pattern.match(text)
            if found and found.group(2).strip():
                self.names[int(found.group(1))] = found.group(2).strip()
        named = _SET_NAME.match(text)
        if named:
            self.set_names[int(named.group(1))] = named.group(2).strip()
        held = _LOADCOL.match(text)
        if held:
            self.support_names[int(held.group(1))] = held.group(2).strip()

    def _include(self, name: str, path: Path, line: Line, above: tuple[Path, ...]) -> None:
        choices = [path.parent / name, self.main.parent / name]
        target = next((c for c in choices if c.exists() and not c.is_dir()), None)
        if self.section == "skipped":
            return
        if target is None:
            if self.section == "executive":
                self.not_found.append(line)
                return
            raise InputError(
                f"there is no included file {name}",
                where=line.where,
                fix="Give the path relative to the including file.",
            )
        refuse_loop(target, above, line.where, "INCLUDE")
        self.read(target, _lines(target, line.where, self.budget), above)


def _file_name(rest: str, lines: list[str], k: int) -> tuple[str, int]:
    """Name of the file and the next line; a quoted name may go on over lines."""
    rest = rest.strip()
    if rest[:1] in ("'", '"'):
        quote, text = rest[0], rest[1:]
        while quote not in text and k < len(lines):
            text += lines[k].strip()
            k += 1
        return text.split(quote)[0].replace("\\", "/"), k
    return rest.split("$")[0].strip().replace("\\", "/"), k


def _lines(path: Path, included_at: str, budget: IncludeBudget) -> list[str]:
    return read_lines(path, included_at, "a Nastran", ".bdf, .dat, .nas or .fem", budget)
