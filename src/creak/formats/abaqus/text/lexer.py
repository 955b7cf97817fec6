"""Abaqus text -> keyword blocks: parameters, data lines, and the file and line of each of them.

*PARAMETER gives values by name, as `<name>` in the lines of the deck."""

from __future__ import annotations

import os
import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path

from creak.errors import InputError, suggest
from creak.formats.deck.expressions import ERRORS, FUNCTIONS, Value, error_word, value_of
from creak.formats.deck.refusals import Placed
from creak.formats.deck.text import IncludeBudget, read_bytes, read_lines, refuse_loop

_FILE_SHIFT = 32
_LINE_MASK = (1 << _FILE_SHIFT) - 1


def squeeze(name: str) -> str:
    """Upper case without blanks: Abaqus ignores both on keyword lines."""
    return "".join(name.split()).upper()


@dataclass
class Block(Placed):
    """One keyword line with its data lines.

    `code` and `codes` hold the place of the keyword line and of each data line: file number and line
    number in one integer, decoded by `where`.
    """

    name: str
    """The keyword as written, upper case, without the star."""
    params: dict[str, str]
    """Parameter name without blanks, upper case -> value without quotes ("" for a flag)."""
    code: int
    files: list[str]
    lines: list[str] = field(default_factory=list)
    """Data lines without outer blanks; blank lines inside the block are kept as ""."""
    codes: list[int] = field(default_factory=list)
    options: list[Block] = field(default_factory=list)
    """Keywords that belong to this one (*ELASTIC to *MATERIAL, *KINEMATIC to *COUPLING)."""

    @property
    def where(self) -> str:
        """file:line of the keyword line."""
        return self.place(self.code)

    def place(self, code: int) -> str:
        """file:line of a code."""
        return f"{self.files[code >> _FILE_SHIFT]}:{code & _LINE_MASK}"

    def has(self, param: str) -> bool:
        return squeeze(param) in self.params

    def get(self, param: str, default: str = "") -> str:
        """Value of a parameter as written, or the default."""
        return self.params.get(squeeze(param), default)

    def option(self, param: str, default: str = "") -> str:
        """Value of a parameter that is one word of a list: upper case, single blanks."""
        return " ".join(self.get(param, default).upper().split())

    def need(self, param: str) -> str:
        """Value of a parameter that must be there.

        Raises
        ------
        InputError : it is missing or empty.
        """
        value = self.get(param)
        if not value:
            raise InputError(
                f"*{self.name} has no {param}=",
                expected=f"*{self.name}, {param}=...",
                where=self.where,
                fix=f"Give {param}= on this keyword line.",
            )
        return value

    def rows(self, *, blanks: bool = False) -> Iterator[tuple[list[str], str]]:
        """Data lines as (fields, file:line); trailing empty fields are dropped."""
        for line, code in zip(self.lines, self.codes, strict=True):
            fields = split_fields(line)
            while fields and not fields[-1]:
                fields.pop()
            if fields or blanks:
                yield fields, self.place(code)


def split_fields(line: str) -> list[str]:
    """Comma-separated fields without outer blanks; a comma inside double quotes does not split.

    Each part of a name may have quotes of its own, as Abaqus/CAE writes it ("Plate 1-1".TOP, "Plate 1-1"."left, top").
    The quotes go, and of several blanks in such a field one stays; case counts no more inside quotes than outside.
    """
    if '"' not in line:
        return [f.strip() for f in line.split(",")]
    fields, start, quoted = [], 0, False
    for k, char in enumerate(line):
        if char == '"':
            quoted = not quoted
        elif char == "," and not quoted:
            fields.append(line[start:k])
            start = k + 1
    fields.append(line[start:])
    return [" ".join(f.replace('"', "").split()) for f in fields]


def lex(path: str | Path) -> list[Block]:
    """Split a deck and everything it includes into keyword blocks.

    Raises
    ------
    InputError : a file is missing or not text, a deck includes itself, data precede the first keyword.
    """
    lexer = _Lexer()
    lexer.read_file(Path(path), included_at="")
    return lexer.finished()


def abaqus_files(path: Path) -> list[Path]:
    """A deck and what it includes, in reading order."""
    if not re.search(rb"(?i)input", read_bytes(path)):  # the word that names a file, wherever its line is broken
        return [path]
    blocks = lex(path)
    return [Path(name) for name in blocks[0].files] if blocks else [path]


class _Lexer:
    def __init__(self) -> None:
        self.blocks: list[Block] = []
        self.files: list[str] = []
        self.open_files: list[Path] = []
        self.budget = IncludeBudget()

    def finished(self) -> list[Block]:
        for block in self.blocks:
            while block.lines and not block.lines[-1]:
                block.lines.pop()
                block.codes.pop()
        return self.blocks

    def read_file(self, path: Path, included_at: str) -> None:
        refuse_loop(path, self.open_files, included_at, "*INCLUDE")
        lines = read_lines(path, included_at, "an Abaqus", ".inp", self.budget)
        self.open_files.append(path.absolute())
        base = len(self.files) << _FILE_SHIFT
        self.files.append(str(path))
        self._read_lines(lines, base, path)
        self.open_files.pop()

    def _read_lines(self, lines: list[str], base: int, path: Path) -> None:
        k = 0
        while k < len(lines):
            line = lines[k].strip()
            k += 1
            if not line.startswith("*"):
                self._data(line, base | k)
            elif not line.startswith("**"):
                code = base | k
                while line.endswith(",") and k < len(lines):
                    following = lines[k].strip()
                    if following.startswith("**"):
                        k += 1
                        continue
                    if following.startswith("*") or not following:
                        break
                    line += following
                    k += 1
                self._keyword(line, code, path)

    def _data(self, line: str, code: int) -> None:
        if self.blocks:
            self.blocks[-1].lines.append(line)
            self.blocks[-1].codes.append(code)
        elif line:
            raise InputError(
                f"data before the first keyword: {line[:60]!r}",
                expected="a line that starts with * such as *HEADING or *NODE",
                where=Block("", {}, code, self.files).where,
                fix="Is this an Abaqus deck? Delete the line or start it with ** to make it a comment.",
            )

    def _keyword(self, line: str, code: int, path: Path) -> None:
        name, *params = split_fields(line[1:])
        block = Block(" ".join(name.upper().split()), {}, code, self.files)
        if not name:
            raise block.error(
                "a keyword line without a keyword",
                expected="*KEYWORD",
                fix="Name the keyword, or start the line with ** to make it a comment.",
            )
        for param in params:
            key, _, value = param.partition("=")
            if key.strip():
                block.params[squeeze(key)] = " ".join(value.split())
        if squeeze(name) == "INCLUDE":
            self.read_file(self._beside(path, block), block.where)
            return
        self.blocks.append(block)
        if block.has("INPUT"):
            self.read_file(self._beside(path, block), block.where)

    def _beside(self, path: Path, block: Block) -> Path:
        """The file that INPUT names: beside the one that includes it, or else beside the deck itself, as in Abaqus."""
        name = block.need("INPUT").replace("\\", "/")
        found, at_deck = path.parent / name, self.open_files[0].parent / name
        return at_deck if os.path.exists(at_deck) and not os.path.exists(found) else found


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
