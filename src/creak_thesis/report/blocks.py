"""What a section of the thesis page is made of."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any, Literal

from creak.report_tools import Table

Mark = Literal["same", "differs", "explained", "not run"]


@dataclass(frozen=True)
class Text:
    """A paragraph. `kind`: plain, `agree`, `found`, `differ` (each with its own label), small or absent."""

    words: str
    kind: str = "plain"


@dataclass(frozen=True)
class Heading:
    words: str


@dataclass(frozen=True)
class TableBlock:
    """A table with the number that it has in the thesis."""

    title: str
    table: Table
    style: str = ""


@dataclass(frozen=True)
class FigureBlock:
    """A plotly figure, or why there is none."""

    title: str
    spec: dict[str, Any] | None
    caption: str
    height: int = 0


@dataclass(frozen=True)
class PictureBlock:
    """A PNG as a data URI, or why there is none."""

    title: str
    uri: str
    caption: str


Block = Text | Heading | TableBlock | FigureBlock | PictureBlock


@dataclass
class Section:
    """A study: its title in the contents list, and its blocks, which are added one by one."""

    id: str
    title: str
    blocks: list[Block] = field(default_factory=list)


@dataclass(frozen=True)
class Finding:
    """A line of the summary: what the thesis found, what creak found."""

    section: str
    """Id of the section that shows it."""
    thesis: str
    creak: str
    mark: Mark
    rule: str
    """What the mark is computed from, in words."""


@dataclass(frozen=True)
class Answer:
    """A question, recommendation or open point, and what creak's runs say."""

    question: str
    thesis: str
    creak: str


def agree(words: str, so: bool = True) -> Text:
    """What creak finds, and whether it is what the thesis finds."""
    return Text(words, "agree" if so else "found")


def differ(words: str) -> Text:
    return Text(words, "differ")


def absent(words: str) -> Text:
    return Text(words, "absent")
