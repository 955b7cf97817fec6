"""How results show themselves: events as a table, a line, a few rows of HTML, figures."""

from __future__ import annotations

from collections.abc import Iterable
from functools import cached_property
from html import escape
from typing import TYPE_CHECKING, Any, Literal

from creak.api.extras import HOW_PANDAS, need_report
from creak.errors import InputError
from creak.given import items_of, one_of, texts
from creak.model.units import UNITS
from creak.studies.run.compared import main_of
from creak.verify.events import Event
from creak.verify.matching import SOME_EVENTS

if TYPE_CHECKING:
    from creak.studies.findings.tree import Findings
    from creak.verify.matching import EventMatch

COLUMNS = {
    "contact": "",
    "channel": "",
    "node": "",
    "t_start": "s",
    "t_peak": "s",
    "t_end": "s",
    "force": "force",
    "node_force_raw": "force",
    "impulse": "impulse",
    "closing_speed": "speed",
    "touches": "",
}
"""Column of a table of events -> its unit, or the attribute of `report.words.text.Units` that names it."""
PLACES = {
    **dict.fromkeys(("name", "contact", "nodes", "events"), ""),
    **{"impulse": "impulse", "force": "force", "closing_speed": "speed", "share": "", "irregularity": ""},
    **{"friction": "", "slips": "", "slip_rate": "1/s", "slip_path": "length", "friction_energy": "energy"},
    **{"n5": "sone", "n10": "sone", "n_max": "sone", "level": "dB(A)", "sharpness": "acum", "sharp_time": "s"},
    **{"roughness": "asper", "prominence": "", "impulse_adjustment": "dB", "sound_share": ""},
}
"""The same of a table of places."""
OF_LINE = {"name": "", "contact_pair": "", "points": "", "tolerance": "length", "material": "", "outcome": ""}
OF_LINE_IN_RUN = {
    **dict.fromkeys(("margin", "margin_percentile", "gap", "closing", "across"), "length"),
    **dict.fromkeys(("in_plane", "in_plane_percentile", "in_plane_touching"), "length"),
    **dict.fromkeys(("node", "in_plane_node", "risk", "points_at_risk", "squeak"), ""),
}
ELINES = {**OF_LINE, "run": "", **OF_LINE_IN_RUN}
"""The same of a table of E-lines, a row for each line in each run: `linear` and `contact`."""
ROWS = 10
"""Events that a notebook shows."""


class Events(list[Event]):
    """Contact events by start time: a list of `Event` that also knows how to be a table."""

    def __init__(self, events: Iterable[Event], nodes: Iterable[str], units: str) -> None:
        super().__init__(items_of(events, Event, "events", SOME_EVENTS))
        one_of(units, [*UNITS], "units")
        self._nodes, self._units = list(texts(nodes, "nodes")), units
        if len(self._nodes) != len(self):
            raise InputError(f"{len(self._nodes)} nodes of {len(self)} events", expected="as many of both")

    def rows(self) -> list[dict[str, Any]]:
        """A dictionary for each event: contact, channel, node, times (s), force (of its place, low-passed), the raw
        peak of its hardest node, impulse (over all channels of the place), closing speed and number of touches, in the
        units of the deck."""
        found = []
        for e, node in zip(self, self._nodes, strict=True):
            values = (
                *(e.group, e.channel, node, e.t_start, e.t_peak, e.t_end),
                *(e.force_place, e.force_peak, e.impulse, e.closing_speed, e.contacts),
            )
            found.append(dict(zip(COLUMNS, values, strict=True)))
        return found

    def units(self) -> dict[str, str]:
        """Unit of each column of `rows`; empty: a name or a number."""
        return _units(COLUMNS, self._units)

    def to_frame(self) -> Any:
        """`rows` as a pandas DataFrame; its `attrs["units"]` are `units()`.

        Raises
        ------
        InputError : pandas is not installed.
        """
        return _frame(self.rows(), COLUMNS, self._units, "events.rows()")

    def __repr__(self) -> str:
        return f"<{_count(self)}>"

    def _repr_html_(self) -> str:
        """The first events as a table, for notebooks."""
        heads = "".join(f"<th>{escape(n)}{f', {u}' if u else ''}</th>" for n, u in self.units().items())
        lines = "".join("<tr>" + "".join(map(_cell, row.values())) + "</tr>" for row in self.rows()[:ROWS])
        more = f"<p>{len(self) - ROWS} more: events.to_frame()</p>" if len(self) > ROWS else ""
        return f"<table><thead><tr>{heads}</tr></thead><tbody>{lines}</tbody></table>{more}"


def _cell(value: Any) -> str:
    return f"<td>{value:.4g}</td>" if isinstance(value, float) else f"<td>{escape(str(value))}</td>"


def _line_rows(elines: dict[str, Any] | None) -> list[dict[str, Any]]:
    """A row for each line in each run that there is."""
    return [
        {**{name: line[name] for name in OF_LINE}, "run": run, **line[run]}
        for line in ([] if elines is None else elines["lines"])
        for run in ("linear", "contact")
        if line[run] is not None
    ]


def _frame(rows: list[dict[str, Any]], columns: dict[str, str], units: str, instead: str) -> Any:
    try:
        import pandas
    except ImportError as error:
        raise InputError("pandas is not installed here", fix=f"Install it: {HOW_PANDAS}, or use {instead}.") from error
    made = pandas.DataFrame(rows, columns=list(columns))
    made.attrs["units"] = _units(columns, units)
    return made


def _units(columns: dict[str, str], units: str) -> dict[str, str]:
    """The unit of each column, out of what names it."""
    return {name: getattr(UNITS[units], unit, unit) for name, unit in columns.items()}


def _count(events: Events) -> str:
    if not events:
        return "no contact events"
    hardest = max(events, key=lambda e: e.force_place)
    force = f"{hardest.force_place:.4g} {events.units()['force']}"
    what = f"{len(events)} contact event{'s' if len(events) > 1 else ''}"
    return f"{what}, the hardest at {hardest.t_start:.4g} s on {hardest.group}: {force}"


Kind = Literal["force", "gap", "spectra", "energy"]
TableKind = Literal["events", "places", "elines"]


class Shown:
    """A result that shows itself."""

    if TYPE_CHECKING:
        findings: Findings
        """Everything that the study found."""

        @cached_property
        def summary(self) -> dict[str, Any]:
            """The content of summary.json (docs/results.md)."""

    @property
    def events(self) -> Events:
        """Contact events of the main run, by start time; `events.to_frame()` is a table of them."""
        found, run = self.findings, self.findings.main
        events, label = [] if run is None else run.events, found.setup.model.nodes.label
        return Events(events, (label(e.node_idx) for e in events), self.summary["units"])

    @property
    def agreement(self) -> EventMatch | None:
        """Events of the reduced run against those of the reference; None where one of them is missing."""
        return self.findings.events

    def __repr__(self) -> str:
        """Title, events, verdict and agreement in a line."""
        told = self._facts()
        rest = "; ".join(f"{key}: {value}" for key, value in told.items() if key != "title")
        return f"<{type(self).__name__} {told['title']!r}: {rest}>"

    def _repr_html_(self) -> str:
        """The same, and the first events, for notebooks."""
        rows = ((escape(k), escape(v)) for k, v in self._facts().items())
        lines = "".join(f"<tr><th>{key}</th><td>{value}</td></tr>" for key, value in rows)
        return f"<table><tbody>{lines}</tbody></table>{self.events._repr_html_() if self.events else ''}"

    def _facts(self) -> dict[str, str]:
        """Title, runs, events, verdict, agreement."""
        summary = self.summary
        told = {"title": summary["title"] or "untitled study", "runs": ", ".join(summary["runs"]) or "none"}
        told["events"] = _count(self.events)
        main = main_of(self.summary)
        if said := [*filter(None, [main.get("verdict")]), *main.get("reasons", ())]:
            told["verdict"] = "; ".join(said)
        match = summary["verification"].get("events")
        if match:
            told["agreement"] = f"{match['matched']} of {match['reference']} events of the unreduced model found"
        if summary["stopped"]:
            told["stopped"] = summary["stopped"]
        return told

    def plot(self, kind: Kind = "force") -> Any:
        """A figure of the report, as a plotly Figure: `show()` it, or let a notebook do so.

        Parameters
        ----------
        kind : "force" (contact force over time, both runs), "gap" (smallest gap of each contact), "spectra" (of the
            verification pairs) or "energy".

        Raises
        ------
        InputError : a kind that there is not, nothing to draw (no contact), or a package of the extra `report` is not
            installed.
        """
        need_report()
        import plotly.graph_objects as go

        from creak.report.figures.gaps import gap_figure
        from creak.report.figures.run import energy_figure, force_figure, spectra_figure

        makers = {"force": force_figure, "gap": gap_figure, "spectra": spectra_figure, "energy": energy_figure}
        if kind not in makers:
            raise InputError(f"no figure {kind!r}", expected=" or ".join(map(repr, makers)))
        drawn = makers[kind](self.findings, UNITS[self.findings.setup.study.config.model.units])
        if drawn.spec is None:
            raise InputError(drawn.caption.rstrip("."))
        return go.Figure(drawn.spec)

    def to_frame(self, kind: TableKind = "events") -> Any:
        """A table as a pandas DataFrame, with the unit of each column in its `attrs["units"]`.

        Parameters
        ----------
        kind : "events" (contact events of the main run), "places" (where it rattles or squeaks) or "elines" (a row for
            each E-line in the run without contact, `linear`, and in that with it, `contact`); figures as in
            summary.json.

        Raises
        ------
        InputError : a table that there is not, or pandas (the extra `pandas`) is not installed.
        """
        summary = self.summary
        if kind == "events":
            return self.events.to_frame()
        if kind == "places":
            return _frame(main_of(self.summary).get("places", []), PLACES, summary["units"], 'summary["runs"]')
        if kind == "elines":
            return _frame(_line_rows(summary["elines"]), ELINES, summary["units"], 'summary["elines"]')
        raise InputError(f"no table {kind!r}", expected="'events', 'places' or 'elines'")
