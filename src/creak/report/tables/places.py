"""The ranked list of rattling places as words for the first screen."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from creak.model.units import Units
from creak.report.figures.scene import Animations
from creak.report.sound_parts import players
from creak.report.tables.checks import RUN_WORDS
from creak.report.words.answer import earlier
from creak.report.words.text import number, plural, share, with_minus
from creak.report.words.verdict import span
from creak.studies.findings.limits import limit_words
from creak.studies.findings.places import Place, near
from creak.studies.findings.tree import Findings
from creak.verify.rubbing import SLIDING, STICK
from creak.words import listed

MOST_PLACES = 12


@dataclass(frozen=True)
class PlaceRow:
    """A line of the list."""

    number: int
    where: str
    detail: str
    count: str
    force: str
    speed: str
    heard: tuple[str, str]
    """N5 and Nmax of its own sound, sone."""
    quality: str
    """Sharpness, roughness and prominence."""
    settled: tuple[str, str]
    """Within what force and N5 have settled."""
    bar: float
    """N5 over that of the loudest, %."""
    cause: list[str]
    """In words: sources, modes, parts; empty: none was told."""
    changes: list[str]
    """What would help."""
    audio: str
    """Data URI of a WAV file; empty: none."""
    motion: int | None
    """Animation that shows its hardest recorded event."""


def place_parts(result: Findings, summary: dict[str, Any], motions: Animations, units: Units) -> dict[str, Any]:
    """What the template needs of the places."""
    places, run = result.places, result.main
    told = [] if run is None else summary["runs"][run.name]["places"]
    heard = any(p["level"] is not None for p in told)
    audio = players(result)
    loudest = max((p["n5"] or 0.0 for p in told), default=0.0)
    rows = [
        _row(result, p, t, motions, units, loudest, audio[k] if k < len(audio) - 1 else "")
        for k, (p, t) in enumerate(zip(places[:MOST_PLACES], told, strict=False))
    ]
    cut = f"The first {MOST_PLACES} of {len(places)} places." if len(places) > MOST_PLACES else ""
    return {
        "places": rows,
        "places_heard": heard,
        "audio_all": audio[-1] if audio else "",
        "places_words": "Not known: the run says nothing of rattle."
        if summary.get("unanswered")
        else _words(result, places, units, summary, heard=heard),
        "places_cut": cut,
        "limits": limit_words(summary["limits"]),
    }


def _words(result: Findings, places: tuple[Place, ...], units: Units, summary: dict[str, Any], *, heard: bool) -> str:
    run = result.main
    if run is None or not result.gaps.m:
        return "Nowhere: nothing can touch under this load."
    if not places and result.stopped is not None and result.window[0] >= run.history.time[-1]:
        before = f": {plural(len(run.events), 'contact event')} until then" if run.events else ""
        return f"Not known: the run stopped before what is counted{before}."
    if not places and run.events:
        return f"Nowhere {span(result)}; over the whole run there are {plural(len(run.events), 'event')}."
    if not places:
        return "Nowhere: no contact event in the run."
    first = "loudest" if heard else "hardest hit"
    return (
        f"{plural(len(places), 'place')} of the {RUN_WORDS[run.name]} run {span(result)}, the {first} first. "
        f"Contact nodes that touch side by side, or within {number(near(result.setup.model), 2)} {units.length}, are "
        f"one place; forces are low-passed peaks of its nodes together.{_before(summary, run.name)}"
    )


def _before(summary: dict[str, Any], run: str) -> str:
    told = earlier(summary, summary["runs"][run])
    return f" {told[:1].upper()}{told[1:]}." if told else ""


def _row(
    result: Findings,
    place: Place,
    told: dict[str, Any],
    motions: Animations,
    units: Units,
    loudest: float,
    audio: str,
) -> PlaceRow:
    model = result.setup.model
    part = next((p.name for p in model.parts if p.has(place.node_idx)), "")
    xyz = ", ".join(number(float(x), 3) for x in model.nodes.coords[place.node_idx])
    detail = f"{plural(int(place.nodes_idx.size), 'node')}; x, y, z = {xyz} {units.length}"
    return PlaceRow(
        number=place.number,
        where=f"{place.contact}, node {model.nodes.label(place.node_idx)}{f' of {part}' if part else ''}",
        detail=detail,
        count=_count(place, told),
        force=number(place.force, 3) if place.events else "–",
        speed=number(place.speed, 3) if place.events else "–",
        heard=(number(told["n5"], 3), number(told["n_max"], 3)),
        quality="; ".join(number(told.get(key), 2) for key in ("sharpness", "roughness", "prominence")),
        settled=(
            _settled(told, "force"),
            ", ".join(x for x in (_added(told), _of_ways(told), _settled(told, "n5"), _ties(told)) if x),
        ),
        bar=100.0 * (told["n5"] or 0.0) / loudest if loudest else 0.0,
        cause=[] if told["cause"] is None else with_minus(told["cause"]["words"]).split("; "),
        changes=[] if told["cause"] is None else [with_minus(text) for text in told["cause"].get("changes_words", [])],
        audio=audio,
        motion=_motion(place, motions),
    )


def _settled(told: dict[str, Any], figure: str) -> str:
    to = (told.get("settled_to") or {}).get(figure)
    if to is None or not told[figure]:
        return ""
    said = share(to)
    return "not settled" if to >= 1.0 else said if said.startswith("below") else f"within {said}"


def _added(told: dict[str, Any]) -> str:
    """What places are ranked by, beside a background."""
    return "" if told.get("n5_added") is None else f"adds {number(told['n5_added'], 3)} to the background"


def _of_ways(told: dict[str, Any]) -> str:
    """What of N5 is computed, and between what it lies by the scatter of the statistical rest."""
    bar, computed = told.get("n5_bar"), told.get("n5_computed")
    if not bar or computed is None:
        return ""
    return f"{number(computed, 3)} of it computed, {number(bar[0], 3)} to {number(bar[1], 3)} with the rest statistical"


def _ties(told: dict[str, Any]) -> str:
    """Places that may be as loud."""
    ties = told.get("ties") or []
    return f"tied with {listed([str(k) for k in ties])}" if ties else ""


def _count(place: Place, told: dict[str, Any]) -> str:
    """Events, and what friction does there where it slips or slides for most of the time or by turns."""
    friction, said = place.rub.friction, []
    if friction is not None and (place.slip_count or friction.state != STICK):
        said = [friction.state, *([plural(place.slip_count, "slip")] if place.slip_count else [])]
        said += [f"{number(friction.rate, 3)} a second while it squeaks"] if friction.rate else []
        said += [text] if (text := _settled(told, "friction_energy")) and friction.state == SLIDING else []
        said += [text] if (text := _settled(told, "slip_rate")) else []
    return ", ".join([*([number(len(place.events))] if place.events or not said else []), *said])


def _motion(place: Place, motions: Animations) -> int | None:
    """The animation that shows the hardest event of a place that any of them shows."""
    for event in sorted(place.events, key=lambda e: -e.force_place):
        for k, (start, end) in enumerate(motions.spans):
            if start <= event.t_start and event.t_end <= end:
                return k
    return None
