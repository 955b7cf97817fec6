"""The answer of a run, of its summary, for page and terminal: what rattles or squeaks, how audible, how sure."""

from __future__ import annotations

import math
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from creak.report.words.text import force_unit, number, plural
from creak.studies.converge.settled import SETTLED, STATISTICS
from creak.studies.findings.elines import YES
from creak.studies.findings.limits import limit_words
from creak.studies.run.compared import main_of
from creak.verify.intervals import overlap
from creak.verify.reliability import UNRELIABLE
from creak.verify.rubbing import SLIDING, STICK, STICK_SLIP
from creak.words import first_few, listed

GREEN, AMBER, RED = "green", "amber", "red"
FAINT, LOUD = 0.1, 4.0
"""sone (the first N, too): below it a place is no cause for amber; from it on it is one for red."""
HEARD = ((FAINT, "hardly audible"), (1.0, "faint"), (LOUD, "clearly audible"), (math.inf, "loud"))
"""N5 in sone below which creak's own word holds: 1 sone is a tone of 40 dB at 1 kHz, 4 sone one of 60 dB."""
PRESSED = ((FAINT, "soft"), (5.0, "moderate"), (math.inf, "hard"))
"""The same of the force of a place, N, where nothing is heard."""
LOUDER = 2.0
"""Times as hard as all that is counted, from which on a hit before it is told."""
SHOWN = 3
"""Places and lines that are named."""
ADDED = " added to the background"
OWN = "creak's own scale, as the study has no [limit]"
UNKNOWN = "not known"


@dataclass(frozen=True)
class Place:
    """What the first screen says of a place."""

    name: str
    does: str
    """"rattles", "squeaks", "slides", "slips" or "slides now and then" (it sticks most of the time), or two of them."""
    rate: float
    """Events and slips a second, in the mean over what is counted."""
    squeak: float | None
    """Slips a second from the first to the last one; None: it does not squeak, or has too few."""
    force: float
    unit: str
    """Of the force."""
    n5: float | None
    """sone; beside a background what it adds to that; infinite beyond ISO 532-1; None: it was not heard."""
    n_max: float
    """The same of its loudest instant; 0: it was not heard."""
    hit: str
    """Node and instant of its hardest event; empty: it has none."""
    cause: str
    helps: str

    @property
    def is_rare(self) -> bool:
        """Is it heard, in less than 5 % of the time?"""
        return self.n5 is not None and _is_rare(self.n5, self.n_max)


@dataclass(frozen=True)
class Answer:
    """What the first screen says."""

    light: str
    """GREEN, AMBER or RED."""
    headline: str
    why: str
    """What the light goes by."""
    limits: tuple[str, ...]
    """A sentence for each limit of the study."""
    places: tuple[Place, ...]
    rate: float
    """Events and slips a second; what hits at several places at once is one event."""
    n5: float | None
    """The same of all contact together."""
    n_max: float
    beside: bool
    """Whether there is a background."""
    listener: str
    """Who hears it; empty: nobody."""
    band: tuple[float, float] | None
    """Hz that the loudness comes from."""
    computed: float | None
    """Hz up to which it is computed, where it goes on by statistical energy; None: it does not."""
    still: str
    """What is said where there is no place: that nothing touches, or what rests."""
    before: str
    """What hit harder before the time that is counted; empty where nothing did."""
    reached: bool
    """Whether the run came to what is counted."""
    unheard: str
    """Why the loudness of what touches is not computed; empty: it is."""


def answer(summary: Mapping[str, Any]) -> Answer:
    """Of the main run of a summary."""
    sound, run = summary["sound"] or {}, main_of(summary) or {"places": [], "end": 0.0}
    beside = bool(sound.get("beside_background"))
    seconds = _seconds(summary, run)
    start = (summary["verification"].get("window") or (0.0,))[0]
    events = [e for e in run.get("events", ()) if e["t_end"] > start]
    places = tuple(_place(p, events, seconds, beside, force_unit(summary)) for p in run["places"] if _does(p))
    light, why = _light(summary, run, places)
    band = sound.get("band")
    return Answer(
        light=light,
        headline=_headline(summary, places, seconds, before := earlier(summary, run)),
        why=why,
        limits=tuple(limit_words(summary["limits"] or [])),
        places=places,
        rate=_rate(summary, run, places, seconds),
        n5=_n5(sound, beside),
        n_max=_n_max(sound, beside),
        beside=beside,
        listener=(sound["listener"] if sound.get("given") else "an ear off the loudest panel")
        if sound.get("listener")
        else "",
        band=None if band is None else (band["low"], band["high"]),
        computed=computed_to(band),
        still=_still(summary, run),
        before=before,
        reached=_reached(summary, run),
        unheard=str(sound.get("missing") or "").removeprefix("none: ") if places else "",
    )


def earlier(summary: Mapping[str, Any], run: Mapping[str, Any]) -> str:
    """What hit harder before the periods of the excitation that are counted; empty where nothing did.

    Harder: by more than the `LOUDER` times that the motion of a run from rest may differ from that of its end.
    """
    start = (summary["verification"].get("window") or (0.0, 0.0))[0]
    events = [e for e in run.get("events", ()) if e["t_end"] <= start]
    hardest = max((e["force_place"] for e in events), default=0.0)
    if hardest <= LOUDER * max((p["force"] for p in run["places"]), default=0.0):
        return ""
    return f"before that {plural(len(events), 'event')}, the hardest {number(hardest, 3)} {force_unit(summary)}"


def _lately(summary: Mapping[str, Any], run: Mapping[str, Any]) -> bool:
    """Whether something hit shortly before what is counted, not longer ago than that lasts."""
    start, end = summary["verification"].get("window") or (0.0, 0.0)
    return any(2.0 * start - end < e["t_end"] <= start for e in run.get("events", ()))


def _seconds(summary: Mapping[str, Any], run: Mapping[str, Any]) -> float:
    """Length of what is counted."""
    start, end = summary["verification"].get("window") or (0.0, run["end"])
    return float(end) - float(start)


def _rate(summary: Mapping[str, Any], run: Mapping[str, Any], places: Sequence[Place], seconds: float) -> float:
    every = sum(p.rate for p in places)
    window = summary["verification"].get("window")
    if window is None or not seconds > 0.0 or not run.get("events"):
        return every
    hits = sum(overlap(e["t_start"], e["t_end"], window) for e in run["events"])
    return min(every, (hits + sum(p["slips"] or 0 for p in run["places"] if _does(p))) / seconds)


def _does(p: Mapping[str, Any]) -> str:
    told = ["rattles"] if p["events"] else []
    seldom = [] if told else ["slips" if p["slips"] else "slides now and then"]
    told += {STICK: seldom, STICK_SLIP: ["squeaks"], SLIDING: ["slides"]}.get(p["friction"] or "", [])
    return " and ".join(told)


def _place(p: Mapping[str, Any], events: Sequence[Mapping[str, Any]], seconds: float, beside: bool, unit: str) -> Place:
    cause, own = p["cause"] or {}, [e for e in events if e.get("node") in p.get("nodes", ())]
    hit = max(own, key=lambda e: float(e["force_place"]), default=None)
    label = "" if hit is None else str(hit["node"])
    named = tail if hit and (tail := hit["channel"].rpartition(":")[2]).endswith(label) else label  # of an instance
    helps = cause.get("changes_words") or [""]
    return Place(
        name=p["name"],
        does=_does(p),
        rate=(p["events"] + (p["slips"] or 0)) / seconds if seconds > 0.0 else 0.0,
        squeak=p.get("slip_rate") if p["friction"] == STICK_SLIP else None,
        force=p["force"],
        unit=unit,
        n5=_n5(p, beside),
        n_max=_n_max(p, beside),
        hit="" if hit is None else f"node {named}, {number(hit['t_start'], 4)}\u00a0s",
        cause=cause.get("words", ""),
        helps=helps[0],
    )


def _n5(heard: Mapping[str, Any], beside: bool) -> float | None:
    """As `Heard.order` has it: what was heard and has no loudness is beyond the standard."""
    if heard.get("level") is None:
        return None
    n5 = heard["n5_added" if beside else "n5"]
    return math.inf if n5 is None else float(n5)


def _n_max(heard: Mapping[str, Any], beside: bool) -> float:
    if heard.get("level") is None:
        return 0.0
    n_max = heard["n_max_added" if beside else "n_max"]
    return math.inf if n_max is None else float(n_max)


def _is_rare(n5: float, n_max: float) -> bool:
    """Is it heard in less than 5 % of the time? N5 tells nothing of it then."""
    return n5 < FAINT <= n_max


def _how_loud(n5: float, n_max: float) -> str:
    if _is_rare(n5, n_max):
        return f"rare, up to {sones(n_max)}"
    return f"{word_of(n5, HEARD)}, {sones(n5)}"


def sones(n5: float) -> str:
    return f"{number(n5, 2)} sone" if math.isfinite(n5) else "beyond ISO 532-1"


def word_of(value: float, words: Sequence[tuple[float, str]]) -> str:
    """The word of a scale."""
    return next(word for most, word in words if value < most or most == math.inf)


def _headline(summary: Mapping[str, Any], places: Sequence[Place], seconds: float, before: str) -> str:
    odd, said = summary.get("other_units"), _said(summary, places, seconds, before)
    return f"{odd[:1].upper()}{odd[1:]}, so no figure is in the unit beside it. {said}" if odd else said


def _said(summary: Mapping[str, Any], places: Sequence[Place], seconds: float, before: str) -> str:
    if summary["stopped"]:
        return f"The run stopped early, and tells only of its beginning: {summary['stopped']}"
    if summary["unanswered"]:
        return f"No answer: {summary['unanswered'].partition(':')[0]}"
    if not places:
        but = _though_quiet(summary)
        still = f"The run is quiet in {number(seconds, 3)} s, but {listed(but)}" if but else ""
        still = still or f"Nothing rattles or squeaks in {number(seconds, 3)} s"
        return still + (f"; {before}" if before else "")
    worst = _worst(places)
    assert worst is not None
    kinds = [k for k in ("rattle", "squeak", "slide", "slip") if any(k in p.does for p in places)]
    heard = _how_loud(worst.n5, worst.n_max) if worst.n5 is not None else ""
    heard += ADDED * bool(heard and (summary["sound"] or {}).get("beside_background"))
    how = heard or f"{word_of(worst.force, PRESSED)}, {number(worst.force, 2)} {worst.unit}"
    what = f"{plural(len(places), 'place')} {_joined(kinds, len(places))}"
    last = "" if summary.get("other_units") else f": {how}"
    return f"{what[:1].upper()}{what[1:]}; worst is {worst.name}{last}"


def _though_quiet(summary: Mapping[str, Any]) -> list[str]:
    """What is wrong with a run in which nothing rattles or squeaks."""
    failed = [one["limit"] for one in summary["limits"] or [] if one["failed"]]
    run = main_of(summary)
    said = [f"{'limit' if len(failed) == 1 else 'limits'} {listed(failed)} {_verb('fail', failed)}"] if failed else []
    said += [text] if (text := _let_by_tolerances(summary)) else []
    return said + (["it cannot be relied on"] if run.get("verdict") == UNRELIABLE else [])


def _let_by_tolerances(summary: Mapping[str, Any]) -> str:
    """What tolerances let E-lines do that the run itself did not; empty: nothing."""
    lines = (summary.get("elines") or {"lines": ()})["lines"]
    told = {line["name"]: figures for line in lines if (figures := line["contact"] or line["linear"])}
    for does, names in (
        ("squeak", [name for name, f in told.items() if f["squeak"] == YES]),
        ("touch", [name for name, f in told.items() if f["risk"] and f["margin"] + f["tolerance"] > 0.0]),
    ):
        if names:
            word = "E-line" if len(names) == 1 else "E-lines"
            which = listed(names) if len(names) <= SHOWN else first_few(names, SHOWN)
            return f"tolerances let {word} {which} {does}"
    return ""


def _verb(verb: str, of: Sequence[str]) -> str:
    return f"{verb}s" if len(of) == 1 else verb


def _joined(kinds: Sequence[str], count: int) -> str:
    return " and ".join(f"{kind}s" if count == 1 else kind for kind in kinds)


def _light(summary: Mapping[str, Any], run: Mapping[str, Any], places: Sequence[Place]) -> tuple[str, str]:
    limits, verdict = summary["limits"] or [], run.get("verdict")
    good = GREEN if verdict in (SETTLED, STATISTICS) else AMBER
    if summary["unanswered"] or summary["stopped"] or verdict == UNRELIABLE:
        return RED, summary["unanswered"] or ("a run that stopped" if summary["stopped"] else "an unreliable run")
    said = limit_words(limits)
    for wrong, light in (("failed", RED), ("missing", AMBER)):
        if text := next((text for text, one in zip(said, limits, strict=True) if one[wrong]), ""):
            return light, text
    if odd := summary.get("other_units"):
        return AMBER, f"nothing in {force_unit(summary)} or sone: {odd}"
    if not places and good == GREEN and _lately(summary, run):
        return AMBER, "something hits shortly before what is counted: a longer run tells whether it comes back"
    if not places and (told := _let_by_tolerances(summary)):
        return AMBER, told
    if limits:
        return good, "; ".join(said)
    if not places:
        return good, _still(summary, run)
    worst = max(p.force if p.n5 is None else p.n_max if p.is_rare else p.n5 for p in places)
    loud = any(p.n5 is not None and p.n5 >= LOUD for p in places)
    return (RED if loud else AMBER if worst >= FAINT else good), OWN


def _reached(summary: Mapping[str, Any], run: Mapping[str, Any]) -> bool:
    """Whether the run came to what is counted: a run that stopped may not have."""
    return not summary["stopped"] or (summary["verification"].get("window") or (0.0,))[0] < run["end"]


def _still(summary: Mapping[str, Any], run: Mapping[str, Any]) -> str:
    if not _reached(summary, run):
        return "the run stopped before what is counted"
    resting = run.get("resting") or []
    if not resting:
        start = (summary["verification"].get("window") or (0.0,))[0]
        return f"nothing touches from {number(start, 3)} s on" if earlier(summary, run) else "nothing touches"
    forces = [p["force_mean"] for p in resting]
    force = "" if None in forces else f" with {number(sum(forces), 3)} {force_unit(summary)}"
    what = "1 patch rests" if len(resting) == 1 else f"{number(len(resting))} patches rest"
    return f"nothing hits or slips ({what}{force})"


@dataclass(frozen=True)
class Tile:
    """A figure of the page's first screen."""

    label: str
    value: str
    detail: str


def tiles(found: Answer, trust: str) -> list[Tile]:
    """Worst place, loudness, events a second, how sure.

    Parameters
    ----------
    trust : verdict and reasons of the run.
    """
    worst, first = _worst(found.places), re.split(r"[.:]", trust)[0]
    word = "" if found.n5 is None else word_of(found.n5, HEARD)
    if found.n5 is not None and _is_rare(found.n5, found.n_max):
        word = f"heard in less than 5 % of the time, up to {sones(found.n_max)}"
    loud = f"{word} to {found.listener}" if found.listener and word else word
    slips = "touches and slips " * any(p.squeak for p in found.places)
    of_all = " of all places" if len(found.places) > 1 else ""
    return [
        Tile(
            "worst place",
            worst.name if worst else "none" if found.reached else UNKNOWN,
            f"{worst.does}; {number(worst.force, 3)} {worst.unit}{f' at {worst.hit}' if worst.hit else ''}"
            if worst
            else found.still,
        ),
        Tile(
            f"loudness{of_all}{ADDED}" if found.beside else f"loudness{of_all}, N5",
            _loudness(found),
            found.unheard or "; ".join(text for text in (loud, band_words(found), found.why) if text),
        ),
        Tile("events a second", number(found.rate, 2), f"{slips}at {plural(len(found.places), 'place')}")
        if found.reached
        else Tile("events a second", UNKNOWN, found.still),
        Tile("how sure", first or "not checked", trust[len(first) + 1 :].strip() and "why stands below"),
    ]


def _loudness(found: Answer) -> str:
    if found.n5 is not None:
        return sones(found.n5)
    return "not computed" if found.unheard else "not heard" if found.reached else UNKNOWN


def _worst(places: Sequence[Place]) -> Place | None:
    """The loudest, as places are ranked (`Heard.rank`); of those that are not heard the hardest."""

    def rank(p: Place) -> tuple[float, float, float]:
        n5 = p.n5 or 0.0
        return n5 if n5 >= FAINT else 0.0, p.n_max, p.force

    return max(places, key=rank, default=None)


def computed_to(band: Mapping[str, Any] | None) -> float | None:
    """Hz from which on a sound's band, as summary.json has it, is statistical energy; None: nothing of it is."""
    end = None if band is None else band.get("computed")
    return None if band is None or end is None or end >= band["high"] else float(end)


def band_words(found: Answer) -> str:
    if found.band is None:
        return ""
    beyond = "" if found.computed is None else f", statistical above {number(found.computed, 2)} Hz"
    return f"from {number(found.band[0], 2)} to {number(found.band[1], 2)} Hz{beyond}"
