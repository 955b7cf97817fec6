"""Two results side by side, as rows for terminal and page, and as one HTML file."""

from __future__ import annotations

import io
from pathlib import Path

from markupsafe import Markup, escape

from creak.formats.complete_file import write_text
from creak.report.figures import palette
from creak.report.tables.comparison import Comparison, Figure
from creak.report.tables.run import Table
from creak.report.templates import page_templates
from creak.report.words.text import NONE, number, percent, plural, setting
from creak.report.words.verdict import span, verdict_line
from creak.version import version

FILES = Path(__file__).parent
NOTHING = "none"
WORDS = {
    "closing_speed": "closing speed",
    "n5": "N5",
    "slip_rate": "slip rate",
    "slip_path": "slip path",
    "friction_energy": "friction energy",
}
COUNTS = ("events", "slips", "slips there", "stick-slip events")
RUBBING = {"slip rate there": "slip rate", "slip path there": "slip path", "friction energy": "friction energy"}
"""Figures of friction that the sentence tells -> their names there."""


def write_comparison(found: Comparison, path: Path) -> None:
    """Write the page as one self-contained HTML file; it appears whole or not at all."""
    environment = page_templates("creak.report")
    text = environment.get_template("comparison.html.j2").render(
        version=version(),
        a=found.a,
        b=found.b,
        sentence=sentence(found),
        verdicts=verdicts(found),
        settings=settings_table(found),
        figures=figures_table(found),
        places=places_table(found),
        places_title=places_title(found),
        picture=Markup(_events_svg(found)),
        css=Markup((FILES / "report.css").read_text(encoding="utf-8")),
    )
    write_text(path, text)


def sentence(found: Comparison) -> str:
    """What changed, in one line."""
    a, b = len(found.a.events), len(found.b.events)
    impulse = next(f for f in found.figures if f.name == "impulse")
    force = next(f for f in found.figures if f.name == "largest force of a place")
    both = len(found.events.pairs)
    parts = [f"{plural(a, 'event')} before, {b or 'none'} after, {both} of them in both"]
    for figure in (impulse, force):
        if figure.change is not None:
            parts.append(f"{figure.name} {percent(1.0 + figure.change)}")
    return "; ".join([*parts, *_rubbing(found)]) + "."


def _rubbing(found: Comparison) -> list[str]:
    """What friction does at the hardest rub of both, how often and how far, and the heat of all; empty without it."""
    known = {f.name: f for f in found.figures}
    state = known.get("friction there")
    if state is None:
        return []
    a, b = (NOTHING if s is None else s for s in (state.a, state.b))
    said = [f"hardest rub {a} in both" if a == b else f"hardest rub {a} before, {b} after"]
    for name, word in RUBBING.items():
        change = known[name].change if name in known else None
        said += [] if change is None else [f"{word} {percent(1.0 + change)}"]
    return said


def verdicts(found: Comparison) -> list[str]:
    """How far each of the two can be trusted, where that is known."""
    said = []
    for side in (found.a, found.b):
        if line := verdict_line(side.run):
            said.append(f"{side.name}: {line}")
    return said


def settings_table(found: Comparison) -> Table:
    """Keys of the study that differ."""
    rows = [[s.key, setting(s.a), setting(s.b)] for s in found.settings]
    return Table(["setting", found.a.name, found.b.name], rows, text_columns=3)


def figures_table(found: Comparison) -> Table:
    """Of the whole run."""
    rows = [[_named(f), *_values(f)] for f in found.figures]
    return Table(["", found.a.name, found.b.name, "change"], rows)


def places_table(found: Comparison) -> Table:
    """Place by place, a row for each figure."""
    rows = []
    for place in found.places:
        for i, figure in enumerate(place.figures):
            rows.append([place.name if i == 0 else "", _named(figure), *_values(figure)])
    return Table(["place", "", found.a.name, found.b.name, "change"], rows, text_columns=2)


def places_title(found: Comparison) -> str:
    """Head of `places_table`: figures of places are not those of the whole run."""
    spans = {span(side.found) for side in (found.a, found.b)}
    return f"Places {spans.pop()}" if len(spans) == 1 else "Places, over the verification window of each"


def rows(table: Table) -> list[list[str]]:
    """Header and rows, for the terminal."""
    return [table.head, *table.rows]


def _named(f: Figure) -> str:
    name = WORDS.get(f.name, f.name)
    return f"{name}, {f.unit}" if f.unit else name


def _values(f: Figure) -> list[str]:
    whole = f.name in COUNTS
    shown = [v if isinstance(v, str) else number(int(v) if whole and v is not None else v) for v in (f.a, f.b)]
    return [*shown, NONE if f.change is None else percent(1.0 + f.change)]


def _events_svg(found: Comparison) -> str:
    """Force of the place of each event over time, the first result upward, the second downward."""
    from matplotlib.backends.backend_svg import FigureCanvasSVG
    from matplotlib.figure import Figure as Drawing

    drawing = Drawing(figsize=(11.0, 3.4))
    FigureCanvasSVG(drawing)
    axes = drawing.add_axes((0.07, 0.16, 0.91, 0.74))
    for side, sign, colour in ((found.a, 1.0, palette.REFERENCE), (found.b, -1.0, palette.REDUCED)):
        times, forces = [e.t_start for e in side.events], [sign * e.force_place for e in side.events]
        axes.vlines(times, 0.0, forces, color=colour, linewidth=1.4, label=side.name.replace("$", r"\$"))
        axes.plot(times, forces, ".", color=colour, markersize=4)
    axes.axhline(0.0, color=palette.MUTED, linewidth=0.8)
    axes.set_xlabel("time, s")
    axes.set_ylabel(f"force of the place, {found.units.force}")
    axes.yaxis.set_major_formatter(lambda value, _: f"{abs(value):g}")
    axes.legend(frameon=False, loc="lower right", bbox_to_anchor=(1.0, 1.0), borderaxespad=0.0, ncols=2)
    axes.spines[["top", "right"]].set_visible(False)
    text = io.StringIO()
    drawing.savefig(text, format="svg", metadata={"Date": None, "Title": str(escape(sentence(found)))})
    drawn = text.getvalue()
    return drawn[drawn.index("<svg") :]
