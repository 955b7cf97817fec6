"""LS-DYNA files -> keyword blocks, included files read where they stand.

*PARAMETER and *PARAMETER_EXPRESSION give values by name, as &name and -&name in the fields of cards."""

from __future__ import annotations

import math
import re
from collections import ChainMap
from collections.abc import Iterator
from dataclasses import dataclass, field, replace
from pathlib import Path

from creak.errors import InputError
from creak.formats.deck.expressions import ERRORS, FUNCTIONS, Functions, Value, error_word, value_of, whole
from creak.formats.deck.text import IncludeBudget, Line, read_bytes, read_lines, refuse_loop
from creak.formats.lsdyna.text.deck import KINDS, LONG, TENS, Block, Shift
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


PROGRAM, ENDINGS = "an LS-DYNA", ".k, .key or .dyn"
_LONG = re.compile(r"\bLONG\s*=\s*Y", re.I)
_WIDE = re.compile(r"\bI10\s*=\s*Y", re.I)
_PGP = "-----BEGIN PGP"
INCLUDES = ("INCLUDE", "INCLUDE_TRANSFORM")
PATHS = ("INCLUDE_PATH", "INCLUDE_PATH_RELATIVE")
_INCLUDED = re.compile(rb"(?im)^\*INCLUDE(?:_TRANSFORM)?[ \t]*\r?\n((?:(?!\*).*(?:\r?\n|\Z))*)")


def read_blocks(path: Path) -> list[Block]:
    """The keywords of a deck and of what it includes, up to *END.

    Raises
    ------
    InputError : a file is missing, encrypted or not text, a deck includes itself, data before the first keyword.
    """
    reader = _Reader(path)
    reader.read(path, "", (), Shift(), _Format())
    return reader.blocks


def lsdyna_files(path: Path) -> list[Path]:
    """A deck and what it includes, in reading order."""
    files, known = [path], {path}
    for file in files:  # grows on the way
        for data in _INCLUDED.findall(read_bytes(file)):
            for name in data.decode("latin-1").splitlines():
                included = file.parent / name.strip()
                if name.strip() and included.is_file() and included not in known:
                    known.add(included)
                    files.append(included)
    return files


@dataclass(frozen=True)
class _Format:
    """How wide the fields of a file are."""

    long: bool = False
    wide: bool = False


@dataclass
class _Reader:
    main: Path
    blocks: list[Block] = field(default_factory=list)
    folders: list[Path] = field(default_factory=list)
    """Of *INCLUDE_PATH."""
    budget: IncludeBudget = field(default_factory=IncludeBudget)
    values: dict[str, Value] = field(default_factory=dict)
    """Those of *PARAMETER, by name."""
    places: dict[str, str] = field(default_factory=dict)

    def read(
        self,
        path: Path,
        included_at: str,
        above: tuple[Path, ...],
        shift: Shift,
        form: _Format,
        known: ChainMap[str, Value] | None = None,
    ) -> None:
        """The blocks of a file, with the values that names have there: its own, those of the files above, and all."""
        here = (*above, path.absolute())
        local, local_places = dict[str, Value](), dict[str, str]()
        values = (ChainMap(self.values) if known is None else known).new_child(local)
        for plain in _split(path, read_lines(path, included_at, PROGRAM, ENDINGS, self.budget), form):
            block = replace(plain, values=values)
            if block.name in NAMES:
                own = LOCAL in block.name
                define(block, local if own else self.values, local_places if own else self.places)
            elif block.name in INCLUDES:
                self._include(block, path, here, shift, _Format(block.long, block.wide), values)
            elif block.name in PATHS:
                self.folders += [path.parent / line.text.strip() for line in block.lines]
            else:
                self.blocks.append(replace(block, shift=shift))

    def _include(
        self,
        block: Block,
        path: Path,
        above: tuple[Path, ...],
        shift: Shift,
        form: _Format,
        known: ChainMap[str, Value],
    ) -> None:
        names, rest = _file_names(block)
        if block.name == "INCLUDE_TRANSFORM":
            names, shift = names[:1], _shifted(replace(block, shift=shift), rest)
        for name in names:
            places = [folder / name.text for folder in (path.parent, self.main.parent, *self.folders)]
            target = next((p for p in places if p.exists() and not p.is_dir()), places[0])
            refuse_loop(target, above, name.where, f"*{block.name}")
            self.read(target, name.where, above, shift, form, known)


def _split(path: Path, lines: list[str], form: _Format) -> list[Block]:
    """The blocks of one file; what follows *END is left out."""
    found: list[tuple[str, str, list[Line]]] = []
    for i, text in enumerate(lines, start=1):
        where = f"{path}:{i}"
        if text.startswith("$"):
            continue
        if text.startswith("*"):
            if text[1:].strip().upper() == "END":
                break
            found.append((text[1:].strip(), where, []))
        elif text.startswith(_PGP):
            raise InputError(
                "a part of the deck is encrypted", where=where, fix="Ask its supplier for a deck in plain text."
            )
        elif found:
            found[-1][2].append(Line(text.rstrip(), where))
        elif text.strip():
            raise InputError(
                f"data before the first keyword: {text.strip()!r}",
                where=where,
                expected="*KEYWORD, comments that begin with $",
                fix="Is this an LS-DYNA keyword deck?",
            )
    blocks = []
    for head, where, data in found:
        name = head.split()[0].upper() if head else ""
        if name == "KEYWORD":
            form = _Format(bool(_LONG.search(head)), bool(_WIDE.search(head)))
        own = {"+": _Format(True), "-": _Format(), "%": _Format(wide=True)}.get(head[-1:], form)
        n = max((i for i, line in enumerate(data, start=1) if line.text), default=0)
        block = Block(name.rstrip("+-%"), where, tuple(data[:n]), own.long, own.wide, blank=tuple(data[n:]))
        blocks.append(block)
    return blocks


def _file_names(block: Block) -> tuple[list[Line], tuple[Line, ...]]:
    """Names of files, each on one line or on several that end in ` +`; and the lines after the first name."""
    names: list[Line] = []
    rest: tuple[Line, ...] = ()
    begun = ""
    for i, line in enumerate(block.lines):
        text = begun + line.text.strip()
        if text.endswith(" +"):
            begun = text[:-2].rstrip()
            continue
        begun = ""
        names.append(Line(text, line.where))
        if len(names) == 1:
            rest = block.lines[i + 1 :]
    named = [name for name in names if name.text]
    if not named:
        raise block.error(f"*{block.name} names no file", fix="Give the name of the file below it.")
    return named, rest


def _shifted(block: Block, lines: tuple[Line, ...]) -> Shift:
    """The shift of the included file, after the name: ids; IDROFF; factors; TRANID."""
    cards = [block.card(line) for line in lines[:4]]
    own = [0] * len(KINDS)
    for i in range(7):
        own[i] = cards[0].integer(i) if cards else 0
    own[7] = cards[1].integer(0) if len(cards) > 1 else 0
    for i in range(4) if len(cards) > 2 else ():
        text = cards[2].text(i)
        if text and (i == 3 or cards[2].real(i) not in (0.0, 1.0)):
            raise cards[2].wrong(i, "no factor on mass, time, length or temperature", "Convert the units of the file.")
    transforms = block.shift.transforms
    if len(cards) > 3 and cards[3].integer(0):
        transforms = ((cards[3].label(0, "d"), cards[3].where), *transforms)
    return Shift(tuple(a + b for a, b in zip(block.shift.offsets, own, strict=True)), transforms)
