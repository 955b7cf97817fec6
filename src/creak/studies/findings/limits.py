"""What a run holds against the limits that the user set; creak has none of its own."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import Any

from creak.model.units import UNITS
from creak.sound.quality import BEYOND, FIGURES, NOTHING_THERE
from creak.sound.third_octave import LOWER_EDGES
from creak.sound.zwicker_tables import NAMES
from creak.studies.file.eline_tables import LimitTable
from creak.studies.file.quantities import in_base, length_in
from creak.studies.file.scatter_tables import table_of
from creak.studies.run.compared import main_of

OF_PLACES = {
    **{"n5": "sone", "n_max": "sone", "n10": "sone", "level": "dB(A)", "sharpness": "acum", "sharp_time": "s"},
    **{"roughness": "asper", "prominence": "", "impulse_adjustment": "dB", "force": ""},
}
"""Limit of each place -> unit; a force has that of the study."""
Named = Mapping[str, str]
"""What exceeds a limit, as `failed` names it."""
ADDED = {"n5": "n5_added", "n_max": "n_max_added"}
"""What counts beside a background."""


def judged(limit: LimitTable, summary: Mapping[str, Any]) -> list[dict[str, Any]]:
    """Each limit that the study sets: `limit`, `allowed` (number in `unit`), `failed` ({name, value} of places or lines
    of the main run that exceed it, worst first; of sound at every listener, with its name as `listener` where there
    are several), `missing` (why it was not looked at; null: it was); of tolerances from a table `table`, its name, and
    the largest is `allowed`."""
    return [*_of_places(limit, summary), *_of_octaves(limit, summary), *_of_lines(limit, summary)]


def limit_words(limits: list[dict[str, Any]]) -> list[str]:
    """A sentence for each limit: what fails it, that nothing does, or why it was not looked at."""
    said = []
    for one in limits:
        most = f"{one['allowed']:.4g} {one['unit']}".rstrip()
        what = f"limit {one['limit']} = " + (f"{one['table']} (at most {most})" if "table" in one else most)
        if one["missing"]:
            said.append(f"{what} was not looked at: {one['missing']}")
        elif one["failed"]:
            margin = "margin " if one["limit"] == "tolerance" else ""
            each = ", ".join(f"{f['name']} ({margin}{_shown(f, one['unit'])})" for f in one["failed"])
            said.append(f"{what} fails at {each}")
        else:
            said.append(f"{what} holds everywhere")
    return said


def _shown(failed: Mapping[str, Any], unit: str) -> str:
    value = "beyond ISO 532-1" if failed["value"] is None else f"{failed['value']:.3g} {unit}".rstrip()
    return f"{value} to {failed['listener']}" if "listener" in failed else value


def _heard(sound: Mapping[str, Any] | None) -> tuple[list[tuple[Named, Mapping[str, Any]]], str | None]:
    """Each place as each listener hears it, by its name in `failed`; why there are none."""
    if sound is None or sound.get("missing"):
        return [], "the run was not heard" if sound is None else sound["missing"]
    listeners = sound["listeners"]
    several = len(listeners) > 1
    return [
        ({"name": p["name"]} | ({"listener": x["listener"]} if several else {}), p)
        for x in listeners
        for p in x["places"]
    ], None


def _of_places(limit: LimitTable, summary: Mapping[str, Any]) -> Iterator[dict[str, Any]]:
    places, units = main_of(summary).get("places", []), UNITS[summary["units"]]
    sound = summary["sound"]
    heard, unheard = _heard(sound)
    for name, unit in OF_PLACES.items():
        text = getattr(limit, name)
        if text is None:
            continue
        key, why, every, allowed = name, unheard, heard, in_base(text) if isinstance(text, str) else float(text)
        if name == "force":
            why, every = None, [({"name": p["name"]}, p) for p in places]
            unit, allowed = units.force, allowed / units.newton
        elif sound is not None and sound.get("beside_background") and name in ADDED:
            key = ADDED[name]
        over, unknown = [], ""
        for named, p in every:
            reason = p["figures_missing"].get(name) if name in FIGURES and p[key] is None else None
            if reason is None or reason == BEYOND:
                over += [(named, p[key])] if p[key] is None or p[key] > allowed else []
            elif reason not in NOTHING_THERE:
                unknown = unknown or f"{p['name']} has none, {reason}"
        yield _judged(name, allowed, unit, over, why or (None if over or not unknown else unknown))


def _of_octaves(limit: LimitTable, summary: Mapping[str, Any]) -> Iterator[dict[str, Any]]:
    """Those that the run's band does not hold are not looked at."""
    sound = summary["sound"]
    heard, why = _heard(sound)
    for name, text in limit.third_octaves.items():
        band, allowed = NAMES.index(name), in_base(text)
        over, unheard = [], why
        if not why and LOWER_EDGES[band] >= sound["band"]["high"]:
            unheard = f"the band of the run ends at {sound['band']['high']:.0f} Hz"
        elif not why:
            every = ((named, p["third_octaves"][band]) for named, p in heard)
            over = [(named, level) for named, level in every if level > allowed]
        yield _judged(f"third_octaves.{name}", allowed, "dB", over, unheard)


def _of_lines(limit: LimitTable, summary: Mapping[str, Any]) -> Iterator[dict[str, Any]]:
    found, units = summary["elines"], summary["units"]
    lines = [] if found is None else found["lines"]
    length = UNITS[units].length
    for name, key in (("tolerance", "margin"), ("in_plane", "in_plane_touching")):
        text = getattr(limit, name)
        if text is None:
            continue
        table, over = table_of(text), []
        most = max((line["tolerance"] for line in lines), default=0.0)
        allowed = length_in(text, units) if table is None else most
        for line in lines:
            figures = line["contact"] or line["linear"]
            if figures is None or (name == "in_plane" and line["material"] is not None):
                continue
            if figures["risk"] if name == "tolerance" else figures[key] > allowed:
                over.append(({"name": line["name"]}, figures[key]))
        found = _judged(name, allowed, length, over, None if lines else "there is no E-line")
        yield found if table is None else found | {"table": table.file}


def _judged(
    name: str, allowed: float, unit: str, over: Sequence[tuple[Named, float | None]], missing: str | None
) -> dict[str, Any]:
    worst = sorted(over, key=lambda f: -float("inf") if f[1] is None else f[1] if name == "tolerance" else -f[1])
    failed = [{**named, "value": value} for named, value in worst]
    return {"limit": name, "allowed": allowed, "unit": unit, "failed": failed, "missing": missing}
