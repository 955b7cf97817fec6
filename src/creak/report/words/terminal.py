"""What the terminal says of a run: figures as rows of text, and the answer in its last lines."""

from __future__ import annotations

import textwrap
from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import Any

from creak.errors import told_apart
from creak.report.words.answer import SHOWN, Answer, Place, answer, band_words, sones
from creak.report.words.text import number
from creak.studies.run.compared import main_of
from creak.verify.rubbing import SLIDING, STICK_SLIP
from creak.words import percent

MOST = 12
"""Places on the terminal."""
OF_STATE = {STICK_SLIP: ("slips", "slip_share", "friction_energy"), SLIDING: ("slip_share", "friction_energy")}
"""What a place does by friction -> figures of it that count for its bar."""
HEARD = (("N5, sone", "n5"), ("Nmax, sone", "n_max"), ("dB(A)", "level"))
WIDTH, LINES = 80, 8
"""Columns and lines of the terminal's answer."""


def run_rows(summary: dict[str, Any]) -> list[list[str]]:
    """Header and one row per figure, one column per run."""
    runs: dict[str, dict[str, Any]] = summary["runs"]
    figures: list[tuple[str, Callable[[dict[str, Any]], str]]] = [
        ("degrees of freedom", lambda r: f"{r['dof']:,}"),
        ("retained dofs + modes", lambda r: f"{r['retained']:,} + {r['modes']:,}" if r["retained"] else "-"),
        ("gap channels", lambda r: f"{r['channels']:,}"),
        ("simulated time, s", lambda r: f"{r['end']:.4g}"),
        ("steps (with contact)", lambda r: f"{r['steps']:,} ({r['contact_steps']:,})"),
        ("wall time, s", lambda r: f"{r['wall_s']:.2f}"),
        ("CPU time, s", lambda r: f"{r['cpu_s']:.2f}"),
        ("reduction CPU time, s", lambda r: f"{r['offline_cpu_s']:.2f}" if r["offline_cpu_s"] else "-"),
        ("peak memory, GB", lambda r: f"{r['peak_rss_gb']:.2f}"),
        ("channels closed from the start", lambda r: f"{r.get('rest_channels', 0) or '-'}"),
        ("contact events", lambda r: f"{len(r['events'])}"),
        ("stick-slip events", lambda r: f"{len(r['slip_events'])}" if r["energies"]["friction"] else "-"),
        ("hardest place: force", lambda r: _of_place(r, "force")),
        ("hardest place: impulse of its events", lambda r: _of_place(r, "impulse")),
        ("hardest place: closing speed", lambda r: _of_place(r, "closing_speed")),
        ("total impulse", lambda r: _figure(r["impulse_total"], ".4g")),
        ("energy created, % of work", lambda r: _percent(r["energy_created"], ".3f", 1e3)),
        ("energy created, % of what contact took up", lambda r: _percent(r["energy_created_of_contact"], ".3f", 1e3)),
        ("dissipated by the scheme, %", lambda r: _percent(r["scheme_dissipation"], ".2f", 1e3)),
        ("largest penetration", lambda r: _figure(r["penetration_max"], ".3g")),
    ]
    return [["", *runs], *([name, *(text(r) for r in runs.values())] for name, text in figures)]


def place_table(summary: dict[str, Any]) -> list[list[str]]:
    """Header and a row for each place of the main run, as it ranks them."""
    run = main_of(summary)
    places = run.get("places", [])
    columns: list[tuple[str, Callable[[dict[str, Any]], str]]] = [
        ("place", lambda p: p["name"]),
        ("events", lambda p: f"{p['events']}"),
        ("slips", lambda p: f"{p['slips']}"),
        ("force", lambda p: _figure(p["force"], ".3g")),
        ("impulse", lambda p: _figure(p["impulse"], ".3g")),
    ]
    if any(p["level"] is not None for p in places):
        columns += [(name, lambda p, key=key: _figure(p[key], ".3g")) for name, key in HEARD]  # type: ignore[misc]
    if any(p["n_max_added"] is not None for p in places):
        columns.append(("N5 added to background, sone", lambda p: _figure(p["n5_added"], ".3g")))
    if any(place_settled(p) is not None for p in places):
        columns.append(("within, %", lambda p: _percent(place_settled(p), ".2g", 100.0)))
    return [[name for name, _ in columns], *([text(p) for _, text in columns] for p in places[:MOST])]


def place_settled(place: dict[str, Any]) -> float | None:
    """Largest change of force, impulse, N5 and friction of a place over the repeated runs, a share; None: not known."""
    to = place.get("settled_to") or {}
    figures = [*(["impulse", "force"] if place["events"] else []), *(["n5"] if place["n5"] is not None else [])]
    figures += OF_STATE.get(place.get("friction") or "", ())
    figures += ["slip_rate"] if place.get("friction") == STICK_SLIP and place["slip_rate"] is not None else []
    known = [float(to[name]) for name in figures if to.get(name) is not None]
    return max(known) if known and len(known) == len(figures) else None


def cause_lines(summary: dict[str, Any]) -> list[str]:
    """What causes each place, and what would help."""
    run = main_of(summary)
    told = [p for p in run.get("places", [])[:MOST] if p["cause"] is not None]
    return [
        line
        for p in told
        for line in (
            f"{p['name']}: {p['cause']['words']}",
            *(f"{p['name']}: would help: {text}" for text in p["cause"].get("changes_words", [])),
        )
    ]


def verification_rows(summary: dict[str, Any]) -> list[list[str]]:
    """Figures that compare the two runs; empty when only one was made."""
    v, runs = summary["verification"], summary["runs"]
    rows = []
    if v.get("mac"):
        rows.append(["lowest diagonal MAC", f"{min(v['mac']):.4f} ({len(v['mac'])} modes)"])
    if v.get("nrmse"):
        rows.append(["NRMSE fit x, y, z", ", ".join(_figure(v["nrmse"][a], ".4f") for a in "xyz")])
        rows.append(["NRMSE fit, all", _figure(v["nrmse"]["all"], ".4f")])
    if v.get("spots"):
        rows.append(["single events against the unreduced model", _spots(v["spots"])])
    if v.get("events"):
        e = v["events"]
        rows.append(["events matched", f"{e['matched']} of {e['reference']} ({e['extra']} extra)"])
        for name, key in (("event force", "amplitude_ratio_mean"), ("event impulse", "impulse_ratio_mean")):
            if e[key] is not None:
                rows.append([f"mean {name}, reduced / reference", f"{e[key]:.4f}"])
        if e["matched"]:
            mean, most = (1e3 * e["time_error"][key] for key in ("mean", "percentile_95"))
            rows.append(["event time error, mean (95 %), ms", f"{mean:.2f} ({most:.2f})"])
            rows.append(["events with force within 5 %", f"{e['within_5_percent']} of {e['matched']}"])
    if v.get("events") and v["events"]["statistics"]["chaotic"]:
        rate = v["events"]["statistics"]["rate"]
        rows.append(["chaotic: events per second", f"{rate['reduced']:.1f}, reference {rate['reference']:.1f}"])
    if "reduced" in runs and "reference" in runs:
        seconds = runs["reduced"]["end"] / max(runs["reference"]["end"], 1e-9)
        ratio = seconds * runs["reference"]["wall_s"] / max(runs["reduced"]["wall_s"], 1e-9)
        rows.append(["reduced run is faster by", f"{ratio:.0f} x"])
    return rows


def _spots(spots: list[dict[str, Any]]) -> str:
    """How far the impulse of the checked events is off, in words."""
    known = [s["impulse"] for s in spots if not s["problem"]]
    off = [abs(x["reduced"] / x["unreduced"] - 1.0) for x in known if x["reduced"] is not None and x["unreduced"]]
    lost = len(known) - len(off)
    most = f"impulse within {percent(max(off))} in {len(off)}" if off else ""
    return ", ".join(text for text in (most, f"{lost} it does not have" if lost else "") if text) or "none to compare"


def _of_place(run: dict[str, Any], key: str) -> str:
    """A figure of the place that is hit hardest, the sum of its channels."""
    hardest = max(run.get("places", []), key=lambda p: p["force"], default=None)
    return "-" if hardest is None else _figure(hardest[key], ".4g")


def _figure(value: float | None, form: str) -> str:
    """A number, or "-" where there is none."""
    return "-" if value is None else f"{value:{form}}"


def _percent(value: float | None, form: str, most: float) -> str:
    """Per cent, with few digits beyond `most` of them."""
    per_cent = None if value is None else 100.0 * value
    return _figure(per_cent, form if per_cent is None or abs(per_cent) < most else ".3g")


def answer_lines(summary: Mapping[str, Any]) -> list[str]:
    """Lines of at most `WIDTH` columns for the end of the terminal: `LINES` at most, and one for each limit.

    Long texts go on in further lines as long as there are such left; what does not fit is left out from a clause on.
    """
    found = answer(summary)
    first = textwrap.wrap(f"{found.light.upper()}: {found.headline}", WIDTH, subsequent_indent="  ", max_lines=2)
    texts = list(_texts(found))
    lines = [*first, *_place_lines(found.places, found.beside)]
    spare = max(LINES - len(lines) - len(texts), 0)
    for text in texts:
        own = _fitting(text, 1 + spare)
        spare -= len(own) - 1
        lines += own
    return lines


def _fitting(text: str, most: int) -> list[str]:
    """The text up to a semicolon that fits, else up to a comma, and then dots, else up to a colon."""
    for mark, dots in (("; ", ""), (", ", ", ..."), (": ", "")):
        clauses = text.split(mark)
        for n in range(len(clauses), int(mark == ": "), -1):
            told = mark.join(clauses[:n]) + (dots if n < len(clauses) else "")
            lines = textwrap.wrap(told, WIDTH, subsequent_indent="  ")
            if len(lines) <= most:
                return lines
    return textwrap.wrap(text, WIDTH, subsequent_indent="  ", max_lines=most)


def _place_lines(places: Sequence[Place], beside: bool) -> list[str]:
    """A line for each of the first places, and one for the others; two for a single one that has a long name."""
    shown = places if len(places) <= SHOWN else places[: SHOWN - 1]
    n5, n_max = ("adds", "adds up to") if beside else ("N5", "Nmax")
    lines, texts = [], []
    for p in shown:
        heard = "" if p.n5 is None else f", {n_max} {sones(p.n_max)}" if p.is_rare else f", {n5} {sones(p.n5)}"
        often = f"{number(p.rate, 2)} a second" + (f" ({number(p.squeak, 2)} slips in a squeak)" if p.squeak else "")
        texts.append(f" {p.does}, {often}, {number(p.force, 3)} {p.unit}{heard}")
    names = [p.name for p in shown]
    if len(shown) > 1:
        names = told_apart(names, [WIDTH - 2 - len(told) for told in texts])
    for name, told in zip(names, texts, strict=True):
        lines += textwrap.wrap(name + told, WIDTH, initial_indent="  ", subsequent_indent="    ", max_lines=2)
    return lines if len(shown) == len(places) else [*lines, f"  and {len(places) - len(shown)} more places"]


def _texts(found: Answer) -> Iterator[str]:
    worst = next((p for p in found.places if p.cause), None)
    if worst is not None:
        yield f"cause: {worst.cause}"
        if worst.helps:
            yield f"would help: {worst.helps}"
    if found.places and found.before:
        yield found.before
    yield from found.limits
    own = [] if found.limits else [f"why {found.light.upper()}: {found.why}"]
    band = [] if found.band is None else [f"loudness {band_words(found)}"]
    if found.computed is None and own and band:
        yield f"{own[0]}; {band[0]}"
    else:
        yield from (*own, *band)
