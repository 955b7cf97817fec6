"""docs/tutorial.md followed: its commands are run, and the figures that the page prints are those that come out.

Times are those of a machine, and are not compared.
"""

from __future__ import annotations

import json
import re
import shlex
from pathlib import Path
from typing import Any

import pytest

from helpers_cli import say
from helpers_docs import ROOT

PAGE = (ROOT / "docs" / "tutorial.md").read_text(encoding="utf-8")
TIMES = ("wall time", "reduced run is faster")
"""Rows of a machine."""
FOLLOWED = ("example", "info", "modes", "run")


def commands() -> list[list[str]]:
    """The commands of sections 2 to 4, in order."""
    part = PAGE[PAGE.index("## 2.") : PAGE.index("## 5.")]
    return [shlex.split(line)[1:] for line in re.findall(r"^ {4}(creak .*)$", part, flags=re.MULTILINE)]


@pytest.fixture(scope="module")
def said(tmp_path_factory) -> tuple[Path, dict[str, str]]:
    """The folder, and what each command printed, by its first word."""
    pytest.importorskip("plotly", reason="plotly is not installed: pip install 'creak[report]'")
    folder, out = tmp_path_factory.mktemp("tutorial"), {}
    for words in commands():
        words = [*words, "--verbose"] if words[0] == "run" else words  # the page shows tables as well
        with pytest.MonkeyPatch.context() as patch:
            patch.chdir(folder)
            patch.setenv("COLUMNS", "160")
            ran = say(*words)
        assert ran.status == 0, ran.words
        out[words[0]] = ran.out + ran.err
    return folder, out


@pytest.fixture(scope="module")
def summary(said) -> dict[str, Any]:
    return json.loads((said[0] / "door" / "results" / "summary.json").read_text(encoding="utf-8"))


def told() -> str:
    """The page with its line ends made blanks."""
    return " ".join(PAGE.split())


def rows(text: str) -> dict[str, list[str]]:
    """Cells of the tables of a page or of the terminal, by the first one."""
    found = {}
    for line in text.splitlines():
        cells = [c.strip() for c in re.split(r"[|│┃]", line.strip().strip("|│┃"))]
        if len(cells) > 1 and cells[0]:
            found[cells[0]] = cells[1:]
    return found


def test_all_commands_were_run(said):
    assert [words[0] for words in commands()] == list(FOLLOWED)


def test_the_tables_of_the_page_are_those_of_the_terminal(said):
    part = PAGE[PAGE.index("## 4.") : PAGE.index("The last line is the verdict")]
    page, terminal = rows(part), rows(said[1]["run"])
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


def test_the_answer_of_the_page_is_that_of_the_terminal(said):
    (block,) = re.findall(r"^    (RED: .*?)\n\n", PAGE, flags=re.MULTILINE | re.DOTALL)
    shown = [line.removeprefix("    ") for line in block.splitlines()]
    assert len(shown) == 5
    assert "\n".join(shown) in said[1]["run"]


def test_sizes_and_modes_are_those_printed(said, summary):
    model, run = summary["model"], summary["runs"]["reduced"]
    assert f"{model['dof']:,} degrees of freedom" in told()
    (first,) = re.findall(r"^ *1 +([\d.]+) ", said[1]["modes"], flags=re.MULTILINE)[:1]
    assert f"The first mode that `creak modes` prints is at {float(first):.2f} Hz" in told()
    frequencies = summary["verification"]["frequencies"]
    worst = max(abs(b / a - 1.0) for a, b in frequencies)
    assert (
        f"({frequencies[0][0]:.3f} Hz first, {frequencies[-1][0]:.2f} Hz last, {100 * worst:.1g} % off at most)"
        in told()
    )
    kept = re.search(r"pre-check: (\d+) of (\d+) channels kept", said[1]["run"])
    assert kept is not None
    assert f"How close each of the {kept[2]} channels came in the linear run: {kept[1]} were kept" in told()
    assert run["channels"] == int(kept[1])


def test_the_verdict_is_the_one_of_the_page(said, summary):
    run, window = summary["runs"]["reduced"], summary["verification"]["window"]
    assert f"The last line is the verdict: `{run['verdict']}`" in told()
    late = [e for e in run["events"] if e["t_start"] >= window[0]]
    assert f"{len(late)} rattle events in the last second" in told()
    spots = summary["verification"]["spots"]
    assert len(spots) == 8
    assert "marches through eight of the events" in told()


def test_show_motion_leads_to_the_motion_and_does_not_play_it(said):
    """What the button of the report does, from its code: choose the event, scroll; nothing starts."""
    assert (
        'jumps to "Motion around an event" with the hardest event of that place chosen; "Play" there plays it' in told()
    )
    page = (said[0] / "door" / "results" / "report.html").read_text(encoding="utf-8")
    assert re.search(r'data-animate="\d+">show motion</button>', page)
    start = page.index('all("[data-animate]")')
    handler = page[start : page.index("}));", start)]
    assert 'getElementById("motion").scrollIntoView()' in handler
    assert "pick.value = b.dataset.animate" in handler
    assert "run(true)" not in handler
    assert "play" not in handler.lower()
