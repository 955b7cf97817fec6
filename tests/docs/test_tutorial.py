"""docs/tutorial.md: its figures are those that came out when its commands were run, on the files that they write today."""

from __future__ import annotations

import json
import re
from typing import Any

import pytest

from helpers_cli import say
from helpers_docs import ROOT, of_the_source

PAGE = (ROOT / "docs" / "tutorial.md").read_text(encoding="utf-8")
TIMES = ("wall time", "reduced run is faster")
"""Rows of a machine."""


@pytest.fixture(scope="module")
def record() -> dict[str, Any]:
    return json.loads((ROOT / "docs" / "tutorial.json").read_text(encoding="utf-8"))


@pytest.fixture(scope="module")
def told() -> str:
    """The page with its line ends made blanks."""
    return " ".join(PAGE.split())


def rows(lines: list[str]) -> dict[str, list[str]]:
    """Cells of the tables of a page or of the terminal, by the first one."""
    found = {}
    for line in lines:
        cells = [c.strip() for c in re.split(r"[|│┃]", line.strip().strip("|│┃"))]
        if len(cells) > 1 and cells[0]:
            found[cells[0]] = cells[1:]
    return found


def test_the_record_is_of_what_the_example_writes_today(record, tmp_path, monkeypatch):
    from benchmarks.tutorial import commands, written

    monkeypatch.chdir(tmp_path)
    example, *others = commands()
    assert [words[0] for words in others] == ["info", "modes", "run"]
    assert say(*example).status == 0
    assert written(tmp_path / "door") == record["files"], "python -m benchmarks.tutorial"
    assert say(*others[0]).status == 0


def test_the_tables_of_the_page_are_those_of_the_terminal(record):
    part = PAGE[PAGE.index("## 4.") : PAGE.index("The last line is the verdict")]
    page, terminal = rows(part.splitlines()), rows(record["printed"]["run"])
    compared = 0
    for name, cells in page.items():
        if (
            not name.startswith(TIMES)
            and set(name) != {"-"}
            and "value" not in cells
            and name != "reduced against reference"
        ):
            assert terminal[name] == cells, name
            compared += 1
    assert compared >= 9


def test_the_answer_of_the_page_is_that_of_the_terminal(record):
    (block,) = re.findall(r"^    (RED: .*?)\n\n", PAGE, flags=re.MULTILINE | re.DOTALL)
    shown = [line.removeprefix("    ") for line in block.splitlines()]
    assert len(shown) == 8
    assert "\n".join(shown) in "\n".join(record["printed"]["run"])


def test_sizes_and_modes_are_those_printed(record, told):
    assert f"{record['dof']:,} degrees of freedom" in told
    (first,) = re.findall(r"^ *1 +([\d.]+) ", "\n".join(record["printed"]["modes"]), flags=re.MULTILINE)[:1]
    assert f"The first mode that `creak modes` prints is at {float(first):.2f} Hz" in told
    frequencies = record["frequencies"]
    worst = max(abs(b / a - 1.0) for a, b in frequencies)
    assert (
        f"({frequencies[0][0]:.3f} Hz first, {frequencies[-1][0]:.2f} Hz last, {100 * worst:.1g} % off at most)" in told
    )
    kept = re.search(r"pre-check: (\d+) of (\d+) channels kept", " ".join(record["printed"]["run"]))
    assert kept is not None
    assert f"How close each of the {kept[2]} channels came in the linear run: {kept[1]} were kept" in told
    assert record["channels"] == int(kept[1])


def test_the_verdict_is_the_one_of_the_page(record, told):
    assert f"The last line is the verdict: `{record['verdict']}`" in told
    late = [t for t in record["t_start"] if t >= record["window"][0]]
    assert f"{len(late)} rattle events in the last second" in told
    assert record["spots"] == 8
    assert "marches through eight of the events" in told


def test_show_motion_leads_to_the_motion_and_does_not_play_it(told):
    """What the button of the report does, from its code: choose the event, scroll; nothing starts."""
    assert (
        'jumps to "Motion around an event" with the hardest event of that place chosen; "Play" there plays it' in told
    )
    report = of_the_source("src/creak/report")
    assert 'data-animate="{{ p.motion }}">show motion</button>' in (report / "report.html.j2").read_text()
    code = (report / "report.js").read_text(encoding="utf-8")
    start = code.index('all("[data-animate]")')
    handler = code[start : code.index("}));", start)]
    assert 'getElementById("motion").scrollIntoView()' in handler
    assert "pick.value = b.dataset.animate" in handler
    assert "run(true)" not in handler
    assert "play" not in handler.lower()
