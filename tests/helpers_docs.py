"""The pages of README.md and docs/, and what is in them: links, headings, blocks of code, commands."""

from __future__ import annotations

import importlib.util
import re
import shlex
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from types import ModuleType

import pytest

ROOT = Path(__file__).parents[1]
PAGES = sorted([ROOT / "README.md", *(ROOT / "docs").glob("*.md")])
MADE = {"changes.md", "architecture.md", "python.md", "gallery"}
"""Pages that the site makes when it is built."""
FENCE = re.compile(
    r"(?:<!-- (?P<mark>\w+) -->\n)?^ *```(?P<language>\w*)\n(?P<text>.*?)^ *```$", re.MULTILINE | re.DOTALL
)


@dataclass(frozen=True)
class Block:
    """A fenced block; `mark` is the word of a comment right before it."""

    language: str
    mark: str
    text: str


def of_the_source(name: str) -> Path:
    """A file or folder that is not in the wheel; without it the test is skipped."""
    if not (ROOT / name).exists():
        pytest.skip(f"{name} belongs to the source tree")
    return ROOT / name


def text_of(page: Path) -> str:
    return page.read_text(encoding="utf-8")


def name_of(page: Path) -> str:
    return page.name


def fences(page: Path) -> list[Block]:
    return [Block(m["language"], m["mark"] or "", m["text"]) for m in FENCE.finditer(text_of(page))]


def prose(page: Path) -> str:
    """The page without fenced blocks."""
    return FENCE.sub("", text_of(page))


def links(page: Path) -> list[str]:
    """Targets of links and pictures, code spans left out."""
    return re.findall(r"\]\(([^)\s]+)\)", re.sub(r"`[^`\n]*`", "code", prose(page)))


def anchors(page: Path) -> set[str]:
    """Anchors of the headings, as GitHub and the site make them."""
    heads = re.findall(r"^#{1,6} +(.+)$", prose(page), flags=re.MULTILINE)
    plain = (re.sub(r"[`*]|\]\([^)]*\)|\[", "", head).strip().lower() for head in heads)
    return {re.sub(r"[^\w\- ]", "", head).replace(" ", "-") for head in plain}


def commands(page: Path) -> list[list[str]]:
    """Words of every `creak ...` in the page, without `creak`."""
    return [words[1:] for words in shell_words(page, r"creak [a-z-]")]


def shell_words(page: Path, begin: str) -> list[list[str]]:
    """Words of every line that begins so: of indented blocks, of fences that are no program, and of code spans."""
    shell = "\n".join(b.text for b in fences(page) if b.language in ("", "text", "sh", "bash"))
    lines = [*shell.splitlines(), *re.findall(r"^(?:    |\t)+(.*)$", prose(page), flags=re.MULTILINE)]
    spans = [" ".join(s.split()) for s in re.findall(r"`([^`]+)`", prose(page))]
    single = [part for line in [*_joined(lines), *spans] for part in line.split(" && ")]
    return [words for line in single if (words := _words(line, begin))]


def _joined(lines: list[str]) -> Iterator[str]:
    """Lines, with those that go on (`[--option`) put behind the line before."""
    held = ""
    for line in map(str.strip, lines):
        if held and line.startswith(("[-", "| -")):
            held += " " + line
        else:
            yield held
            held = line
    yield held


def _words(line: str, begin: str) -> list[str]:
    """The words; empty where the line is no such command."""
    line = re.sub(r"\\\|", "|", line).removeprefix("$ ").removeprefix(".venv/bin/")
    return shlex.split(line, comments=True) if re.match(begin, line) else []


def tool(name: str) -> ModuleType:
    """A module of tools/, under its own name."""
    path = ROOT / "tools" / f"{name}.py"
    if not path.exists():
        pytest.skip("tools/ belongs to the source tree")
    spec = importlib.util.spec_from_file_location(f"docs_{name}", path)
    assert spec is not None
    assert spec.loader is not None
    made = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(made)
    return made
