"""Where what a study holds was written: what messages name."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

Keys = tuple[str | int, ...]


@dataclass(frozen=True)
class Places:
    """Of a study file, of the changes that were made to it, or of a deck that was made a study."""

    path: Path
    """The study file, or the deck."""
    text: str = ""
    """Of the study file, in which lines are counted."""
    changes: Mapping[str, Any] = field(default_factory=dict)
    """Dotted key -> value that it was changed to since the file was read."""
    of_deck: Mapping[Keys, str] | None = None
    """Beginning of a key -> file:line of the deck; None: the keys are those of a study file."""

    def where(self, *keys: str | int) -> str:
        """file:line of a key; the change that set it, where there is one."""
        if self.of_deck is not None:
            found = (self.of_deck.get(keys[:n]) for n in range(len(keys), 0, -1))
            return next((place for place in found if place), str(self.path))
        name = dotted(keys)
        if key := next((k for k in self.changes if overlap(k, name)), None):
            return f"the change {key} = {self.changes[key]!r} of {self.path}"
        return f"{self.path}:{line_of(self.text, keys)} [{name}]"

    def sibling(self, name: str) -> Path:
        """A path that the study names, relative to the folder that it lies in."""
        return (self.path.parent / name).resolve() if not Path(name).is_absolute() else Path(name)


def overlap(a: str, b: str) -> bool:
    """One dotted key is the other, or a table that holds it."""
    return a == b or a.startswith(f"{b}.") or b.startswith(f"{a}.")


def dotted(keys: Sequence[str | int]) -> str:
    """Keys as a change names them: `contact.flange.stiffness`."""
    return ".".join(str(k) for k in keys)


def line_of(text: str, keys: Sequence[str | int]) -> int:
    """Line of a key in the TOML text: its table's header, then the key below it (best effort)."""
    lines = text.splitlines()
    names = [str(k) for k in keys if not isinstance(k, int)]
    index = next((k for k in keys if isinstance(k, int)), 0)
    best, start = 1, 0
    for depth in range(len(names), 0, -1):
        found = _headers(lines, names[:depth], r"\]")
        if found:
            start = found[min(index, len(found) - 1)]
            best = start + 1
            names = names[depth:]
            break
    if best == 1 and len(names) == 1 and (below := _headers(lines, names, r"\.")):
        return below[0] + 1  # a table of tables: [excitation.root]
    for name in reversed(names):
        for i in range(start, len(lines)):
            if i > start and lines[i].lstrip().startswith("["):
                break
            if re.search(rf'(^|[\s,{{."]){re.escape(name)}"?\s*[.=]', lines[i].split("#")[0]):
                return i + 1
    return best


def _headers(lines: Sequence[str], names: Sequence[str], end: str) -> list[int]:
    """Lines of headers of a table; `end` is a pattern of what follows its names."""
    dots = r"\s*\.\s*".join(f'"?{re.escape(n)}"?' for n in names)
    header = re.compile(rf"^\s*\[\[?\s*{dots}\s*{end}")
    return [i for i, line in enumerate(lines) if header.match(line)]
