"""Sections of docstrings (Parameters, Returns, Raises) as Markdown, for the Python page of the site."""

from __future__ import annotations

import re
from collections.abc import Iterator
from typing import Any

import griffe

SECTION = re.compile(r"^(Parameters|Returns|Raises|Keys|Method|Source)\n-{3,}\n", flags=re.MULTILINE)
ENTRY = re.compile(r"(?:^|(?<=\. ))(\*?[A-Za-z_]\w*(?:, \*?[A-Za-z_]\w*)*) : ")


def markdown(text: str) -> str:
    """The docstring with headings in bold and an item for each parameter or error."""
    head, *rest = SECTION.split(text)
    pieces = [head.rstrip()]
    for title, body in zip(rest[::2], rest[1::2], strict=True):
        section, _, after = body.partition("\n\n")
        pieces += [f"**{title}**", "\n".join(_items(section)), after.rstrip()]
    return "\n\n".join(p for p in pieces if p)


def _items(section: str) -> Iterator[str]:
    """Entries `name : text` as list items, other lines as they are."""
    joined = re.sub(r"\n\s+", " ", section)
    for line in joined.splitlines():
        parts = ENTRY.split(line.strip())
        if parts[0].strip():
            yield parts[0].strip()
        for names, text in zip(parts[1::2], parts[2::2], strict=True):
            yield f"- `{names}`: {text.strip()}"


class DocstringSections(griffe.Extension):
    """Rewrites docstrings as they are collected."""

    def on_object(self, *, obj: griffe.Object, **more: Any) -> None:
        """Called for every module, class, function and attribute."""
        if obj.docstring is not None:
            obj.docstring.value = markdown(obj.docstring.value)
