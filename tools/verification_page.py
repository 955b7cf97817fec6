"""docs/verification.md, its chapters and pictures from what the tests record: `python -m tools.verification_page`.

`make verification` runs the tests that record (the fixture `measured`) into docs/verification.json first.
"""

from __future__ import annotations

import json
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib import colormaps
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

DOCS = Path(__file__).parents[1] / "docs"
PAGE, RECORD = DOCS / "verification.md", DOCS / "verification.json"
HEAD = """\
# What is verified

Every number that creak computes is held by a test to a closed form, a converged reference, another program or a
conservation law. These pages are made by `make verification`: it runs the tests that record what they find, and writes
what they found. `make test` runs all tests.

How to read the tables:

- Tolerances are those of the tests. A test that runs many cases shows the one that comes closest to its tolerance.
- Difference and tolerance are relative to the expected value where they are in per cent or a bare power of ten. With a
  unit they are absolute.
- Differences near round-off (1e-10 and less) change from machine to machine.

There are {count} quantities of {tests} tests. Half of them use less than {median} of their tolerance. Each chapter has
a page:

{chapters}

![Difference over tolerance of every quantity, by section](verification_margins.png)

Each dot is a row of a table: its difference from the reference, as a share of what the test allows. Shares below
1e-6, exact agreement among them, are drawn at the left edge. Lower bounds without an expected value are left out.
"""
TAIL = """\
## Your own model

A test of creak is no test of your model. `creak run` checks each study against its unreduced model, books the energy
and tells what has settled ([how far to trust an answer](trust.md)). `creak info` names what was not read.
"""
SECTIONS = {
    "shell statics": (
        "Shells, static",
        """\
`quad` is the 4-node shell, `tri` the 3-node one. More on shells, with the convergence of every case:
[their page](verification_shells.md).""",
    ),
    "shell modes": (
        "Shells, modes",
        """\
Square plates 10 x 10 m and a tapered membrane, all of steel. The targets that NAFEMS prints for thin plates are .1 to
1.3 % high, so the tests hold to converged Ritz values. lambda is omega a^2 sqrt(rho h / D) of plates a thousand times
as wide as thick. F, C and S are free, clamped and supported edges.""",
    ),
    "beams and solids": ("Beams, solids, laminates", ""),
    "models": ("Whole models", ""),
    "decks": (
        "Decks",
        """\
No run was compared with Abaqus. The decks of NX and MSC Nastran are in `shared/` beside the source. Without them their
tests are skipped, and the rows keep the last values.""",
    ),
    "measured": (
        "Measured structures",
        """\
Models made of published dimensions beside tests. Rows of softened corners have one stiffness fitted, those of
colliding cantilevers the damping; three factors are the authors' own. What the models leave open is told with
[the frame](correlation.md#a-bolted-frame) and [the cantilevers](correlation.md#two-cantilevers-that-collide).""",
    ),
    "reduction": (
        "Reduction",
        """\
The picture shows the error of the first frequencies of a uniform cantilever of 80 elements, cut at mid-span, against
the unreduced model. Lines are the references, dots are creak.""",
    ),
    "contact": (
        "Contact",
        """\
The picture is the bar on a rigid wall (E = 900, rho = A = 1, L = 10, speed 10): dots are creak, the line is the closed
form, rho c A v = 300 over 2 L / c. The rows on penalties say what a penalty does to the same bar with and without
numerical damping. Where it chatters, the test is that creak shows it.""",
    ),
    "contact, exact flow": (
        "Contact, by exact flow",
        "The same closed forms with nothing chosen: no step, penalty or scheme.",
    ),
    "friction": ("Friction", ""),
    "friction, exact flow": ("Friction, by exact flow", ""),
    "time": (
        "Time integration",
        """\
The picture is a free oscillator: dots are creak, lines the leading terms, period error
Omega^2 (1/12 - alpha/4 - 3 alpha^2/8) and damping ratio -alpha (1 + alpha)^2 Omega^3 / 8, Omega = 2 pi h / T.""",
    ),
    "energy": ("Energy", ""),
    "signals": ("Signals", ""),
    "sound": (
        "Sound and loudness",
        """\
The standard's signals 6 to 13 lie in `shared/` beside the source; without them their tests are skipped, and the rows
keep the last values.""",
    ),
    "verdicts": ("Verdicts and findings", ""),
    "examples": ("Examples", ""),
}
"""Section of a record -> heading and words."""
CHAPTERS = {
    "structures": ("Shells, beams and solids", ("shell statics", "shell modes", "beams and solids")),
    "decks": ("Models and decks", ("models", "decks")),
    "measured": ("Measured structures", ("measured",)),
    "reduction": ("Reduction", ("reduction",)),
    "contact": ("Contact and friction", ("contact", "contact, exact flow", "friction", "friction, exact flow")),
    "time": ("Time, energy, signals", ("time", "energy", "signals")),
    "results": ("Sound, verdicts, examples", ("sound", "verdicts", "examples")),
}
"""Name of a chapter's page -> heading and its sections."""
PICTURES = {
    "reduction": ("verification_reduction.png", "Frequency error against the modes kept"),
    "contact": ("verification_bar.png", "Contact force over time and the closed form"),
    "time": ("verification_hht.png", "Period error and damping ratio over the step, and their formulas"),
}
FLOOR = 1e-6
"""Left edge of the picture of margins."""
Row = dict[str, Any]


def read() -> dict[str, list[Row]]:
    """The record: `quantities` and `curves`."""
    found: dict[str, list[Row]] = json.loads(RECORD.read_text(encoding="utf-8"))
    return found


def pages(record: dict[str, list[Row]]) -> dict[str, str]:
    """File name -> text: the overview, and a page for each chapter."""
    rows = record["quantities"]
    shares = [s for r in rows if (s := share(r)) is not None]
    table = "\n".join(
        ["| chapter | quantities | tests |", "|---|---|---|", *(_chapter_line(k, rows) for k in CHAPTERS)]
    )
    tests = len({r["test"] for r in rows})
    head = HEAD.format(count=len(rows), tests=tests, median=_percent(float(np.median(shares))), chapters=table)
    return {PAGE.name: "\n".join([head, TAIL]), **{chapter_file(name): _chapter(name, rows) for name in CHAPTERS}}


def chapter_file(name: str) -> str:
    """Name of a chapter's page."""
    return f"verification_{name}.md"


def _of_chapter(name: str, rows: list[Row]) -> list[Row]:
    return [r for r in rows if r["section"] in CHAPTERS[name][1]]


def _chapter_line(name: str, rows: list[Row]) -> str:
    mine = _of_chapter(name, rows)
    return f"| [{CHAPTERS[name][0]}]({chapter_file(name)}) | {len(mine)} | {len({r['test'] for r in mine})} |"


def _chapter(name: str, rows: list[Row]) -> str:
    title, sections = CHAPTERS[name]
    head = f"# Verified: {title[0].lower()}{title[1:]}\n\nHow to read it: [what is verified](verification.md).\n"
    return "\n".join([head, *(line for key in sections for line in _section(key, rows))])


def share(row: Row) -> float | None:
    """Difference over the tolerance on its side; nothing for a lower bound without an expected value."""
    if row["expected"] is None:
        return None
    limit = abs((row["high"] if row["difference"] > 0.0 else row["low"]) - row["expected"])
    return float(abs(row["difference"]) / limit) if limit else float(row["difference"] != 0.0)


def passes(row: Row) -> bool:
    """Whether the value lies within the limits; round-off of the stored digits is let through."""
    used = share(row)
    return bool(row["value"] >= row["low"]) if used is None else used <= 1.0 + 1e-6


def _section(key: str, rows: list[Row]) -> Iterator[str]:
    title, words = SECTIONS[key]
    yield from (f"## {title}", "")
    if words:
        yield from (words, "")
    if key in PICTURES:
        file, told = PICTURES[key]
        yield from (f"![{told}]({file})", "")
    yield from ("| quantity | source | expected | creak | difference | tolerance | test |", "|" + 7 * "---|")
    yield from (_row(r) for r in rows if r["section"] == key)
    yield ""


def _row(row: Row) -> str:
    path, _, name = row["test"].partition("::")
    cells = [_cell(row["quantity"]), _cell(row["source"]), *_numbers(row), f"`{path}` `{name}`"]
    return f"| {' | '.join(cells)} |"


def _numbers(row: Row) -> tuple[str, str, str, str]:
    """Expected, creak, difference, tolerance: with as many digits as the tolerance asks for."""
    expected, value, low, high = row["expected"], row["value"], row["low"], row["high"]
    unit = f" {row['unit']}" if row["unit"] else ""
    if expected is None:
        return f"at least {low:g}{unit}", f"{value:.3g}{unit}", "–", "–"
    slack = max(high - expected, expected - low)
    digits = _digits(expected, slack)
    told = f"{expected:.{digits}g}{unit}", f"{value:.{digits}g}{unit}"
    relative = row["difference"] / abs(expected) if expected else 0.0
    if not slack:
        return *told, f"{row['difference']:.2g}", "none"
    if abs((high - expected) - (expected - low)) > 1e-6 * slack:
        return *told, f"{row['difference']:+.2g}{unit}", f"{low:.3g} to {high:.3g}{unit}"
    if expected and abs(float(f"{slack / abs(expected):.2g}") - slack / abs(expected)) < 1e-4 * slack / abs(expected):
        return *told, _percent(relative, "+"), _percent(slack / abs(expected))
    return *told, f"{row['difference']:+.2g}{unit}", f"{slack:.2g}{unit}"


def _digits(expected: float, slack: float) -> int:
    if not (expected and slack):
        return 3
    return int(np.clip(np.ceil(np.log10(abs(expected) / slack)) + 2, 3, 10))


def _percent(x: float, sign: str = "") -> str:
    """Per cent from 1e-4 on, a power of ten below."""
    return f"{100.0 * x:{sign}.2g} %" if abs(x) >= 1e-4 or x == 0.0 else f"{x:{sign}.1e}".replace("e-0", "e-")


def _cell(text: str) -> str:
    return text.replace("|", "\\|").replace("*", "\\*") or "–"


def draw(record: dict[str, list[Row]], folder: Path) -> None:
    """All pictures of the page."""
    _save(_margins(record["quantities"]), folder / "verification_margins.png")
    curves: dict[str, list[Row]] = {}
    for curve in record["curves"]:
        curves.setdefault(curve["picture"], []).append(curve)
    figure, (axis,) = _figure(1)
    _curves(axis, curves["craig-bampton"], "fixed-interface modes of each half", "error, %")
    axis.set_yscale("log")
    axis.set_xticks(range(5))
    _save(figure, folder / PICTURES["reduction"][0])
    figure, (axis,) = _figure(1)
    _curves(axis, curves["bar"], "time, s", "contact force, N", dots=".")
    _save(figure, folder / PICTURES["contact"][0])
    figure, axes = _figure(2)
    for axis, name, words in zip(axes, ("period", "damping"), ("period error", "damping ratio"), strict=True):
        _curves(axis, curves[f"hht {name}"], "h / T", words)
        axis.set_xscale("log")
        axis.set_yscale("log")
    _save(figure, folder / PICTURES["time"][0])


def _figure(panels: int) -> tuple[Figure, list[Axes]]:
    figure = Figure(figsize=(6.0 * panels, 4.2), layout="constrained")
    FigureCanvasAgg(figure)
    return figure, list(figure.subplots(1, panels, squeeze=False)[0])


def _save(figure: Figure, path: Path) -> None:
    """Without the version of matplotlib in the file, so that the same record gives the same bytes."""
    figure.savefig(path, dpi=110, metadata={"Software": None})


def _curves(axis: Axes, curves: list[Row], x_label: str, y_label: str, dots: str = "o") -> None:
    """Dots for what creak found, a line of the same colour for the reference."""
    colours = colormaps["tab10"]
    for k, curve in enumerate(curves):
        axis.plot(curve["x"], curve["y"], dots, ms=5, color=colours(k), label=curve["label"])
        if curve["exact"] is not None:
            axis.plot(curve["x"], curve["exact"], "-", lw=1.2, color="black" if dots == "." else colours(k), zorder=1)
    axis.set_xlabel(x_label)
    axis.set_ylabel(y_label)
    axis.grid(color="#e4e4e4", lw=0.6)
    axis.legend(frameon=False, fontsize=9)
    axis.spines[["top", "right"]].set_visible(False)


def _margins(rows: list[Row]) -> Figure:
    """Share of the tolerance that each quantity uses, a line of dots for each section."""
    figure = Figure(figsize=(9.0, 4.6), layout="constrained")
    FigureCanvasAgg(figure)
    axis = figure.subplots()
    for k, key in enumerate(SECTIONS):
        shares = sorted(max(s, FLOOR) for r in rows if r["section"] == key and (s := share(r)) is not None)
        # Dots of one section are spread over its stripe in a fixed pattern, so that none hides another.
        height = k + 0.6 * ((np.arange(len(shares)) * 0.618034) % 1.0 - 0.5)
        axis.semilogx(shares, height, "o", ms=4, alpha=0.7, mew=0, color=colormaps["tab20"](k))
    axis.axvline(1.0, color="#c00000", lw=1.4)
    axis.text(1.0, -0.9, " tolerance", color="#c00000", fontsize=9, va="center")
    axis.set_yticks(range(len(SECTIONS)), [title for title, _ in SECTIONS.values()])
    axis.set_ylim(len(SECTIONS) - 0.4, -1.4)
    axis.set_xlim(0.6 * FLOOR, 6.0)
    axis.set_xlabel("difference / tolerance")
    axis.grid(color="#e4e4e4", lw=0.6, axis="x")
    axis.spines[["top", "right", "left"]].set_visible(False)
    return figure


if __name__ == "__main__":
    made = read()
    for file, text in pages(made).items():
        (DOCS / file).write_text(text, encoding="utf-8")
    draw(made, DOCS)
    sys.stdout.write(f"wrote {PAGE}, {len(CHAPTERS)} chapters and {len(PICTURES) + 1} pictures\n")
