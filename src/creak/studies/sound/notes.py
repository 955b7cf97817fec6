"""What is said of how a run is heard: where, how far up in frequency and by what, and what is left out."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from creak.model.mesh import Part
from creak.sound.third_octave import LOWER_EDGES, UPPER_EDGES
from creak.studies.sound.band import Band
from creak.studies.sound.beyond import Beyond
from creak.studies.sound.cabin import NOTHING
from creak.studies.sound.ear import Ear
from creak.studies.sound.loud import Heard
from creak.studies.sound.radiation import LARGE
from creak.studies.sound.statistics import Statistics
from creak.studies.sound.transfers import words_of
from creak.words import listed, percent

LEAST_ERROR = 1e-3
"""Of the unreduced model's answers that is told."""
ROUND_OFF = 1e-9
"""Share of the largest coordinate of a listener below which another is none."""
MOST_PARTS = 6
"""Of equivalent radiated power in the notes."""
WHAT = {
    "modes": "modes that the reduction kept",
    "unreduced": "share of the cost that the unreduced model may take",
    "mesh": "mesh",
    "step": "step in contact",
    "statistics": "statistical energy of plates",
    "rate": "sampling rate",
}
"""What may end the band."""


@dataclass(frozen=True)
class Reach:
    """How far up in frequency contact is heard, and by what."""

    band: Band
    further: Beyond | str = ""
    """What the unreduced model adds beyond the modes; why it does not, or "" where it need not."""
    more: Statistics | str = ""
    """The same of the statistical energy of plates, beyond what is computed."""

    def by_unreduced(self, further: Beyond | str) -> Reach:
        """The unreduced model goes on beyond the modes, or why not."""
        band = replace(self.band, beyond=further.high) if isinstance(further, Beyond) else self.band
        return replace(self, band=band, further=further)

    def by_plates(self, more: Statistics | str) -> Reach:
        """Statistical energy goes on beyond what is computed, or why not."""
        band = replace(self.band, statistics=more.span.high) if isinstance(more, Statistics) else self.band
        return replace(self, band=band, more=more)

    @property
    def beyond(self) -> Beyond | None:
        return self.further if isinstance(self.further, Beyond) else None

    @property
    def statistics(self) -> Statistics | None:
        return self.more if isinstance(self.more, Statistics) else None


def notes_of(
    ears: Sequence[Ear],
    heard: Sequence[Sequence[Heard]],
    reach: Reach,
    power: Mapping[str, float],
    compact: Mapping[str, float],
    parts: Sequence[Part],
) -> list[str]:
    """Notes on what the listeners hear.

    Parameters
    ----------
    ears : that which each listener is told of. heard : listener by listener, each place by itself, last all together.
    power : part -> dB of its equivalent radiated power, loudest first.
    compact : part that is heard as a compact body -> Hz up to which it is one.
    """
    return [
        *_places(ears),
        *_band(ears, reach),
        *_beyond(reach, heard[0][-1]),
        *_of_statistics(reach.band, heard[0], reach.more, parts),
        *_radiation(reach, power, compact),
        *_around(ears, heard, reach.band, parts),
        *_background(ears[0], heard[0][-1], reach.band),
        *_too_loud(heard),
    ]


def _places(ears: Sequence[Ear]) -> list[str]:
    """Where listeners are that the study does not name."""
    said = []
    for listener in (ear.listener for ear in ears):
        small = ROUND_OFF * float(np.abs(listener.position).max())
        at = ", ".join(f"{x if abs(x) > small else 0.0:.4g}" for x in listener.position)
        if not listener.given:
            said.append(
                f"sound: heard at ({at}), an ear 0.6 m off the loudest panel, as the study has no [listener]; "
                f"{', '.join(listener.parts)} radiate"
            )
    return said


def _band(ears: Sequence[Ear], reach: Reach) -> list[str]:
    band = reach.band
    return [
        f"sound: believed from {band.low:.0f} to {band.high:.0f} Hz, ended by the {WHAT[band.limit]}; "
        f"nothing outside is in it. Contact forces alone make it; panels {_walls(ears)}, none shadows another"
    ]


def _beyond(reach: Reach, all_of: Heard) -> list[str]:
    """What the unreduced model adds beyond the modes."""
    further = reach.further
    if isinstance(further, str):
        return [f"sound: the unreduced model takes the band no further than the modes: {further}"] if further else []
    n5 = "" if all_of.n5 is None else f" N5 of all is {all_of.n5_modes or 0.0:.3g} sone by the modes alone,"
    both = all_of.n5 if all_of.n5_computed is None else all_of.n5_computed
    n5 += "" if both is None or all_of.n5 is None else f" {both:.3g} with both."
    return [
        f"sound: to {reach.band.modes:.0f} Hz by the modes that the reduction kept, from there by the unreduced model "
        f"at {further.found.freq.size} frequencies, which cost {further.solves:.0f} back-substitutions and are right "
        f"within {percent(max(further.found.error, LEAST_ERROR))} between them; the forces are those of the run.{n5}"
    ]


def _radiation(reach: Reach, power: Mapping[str, float], compact: Mapping[str, float]) -> list[str]:
    """Which parts radiate, and how."""
    said, band = [], reach.band
    if power and (isinstance(reach.further, Beyond) or isinstance(reach.more, Statistics)):
        said.append(f"sound: the equivalent radiated power is that up to {min(band.modes, band.computed):.0f} Hz")
    if power:
        levels = ", ".join(f"{name} {level:.0f} dB" for name, level in [*power.items()][:MOST_PARTS])
        said.append(f"sound: equivalent radiated power of contact, re 1 pW: {levels}")
    if compact:
        names = ", ".join(f"{name} compact below {freq:.0f} Hz" for name, freq in compact.items())
        said.append(
            f"sound: {names}: acceleration noise of the sphere of the same volume, without a wall; from there "
            f"to {LARGE:g} times as much it becomes that of faces set in a wall"
        )
    return said


def _background(ear: Ear, all_of: Heard, band: Band) -> list[str]:
    """What [background] masks, at the first listener."""
    background = ear.background
    if background is None:
        return []
    if all_of.n5 is not None and all_of.n5_added is None:
        return [
            "sound: with the [background] it is too loud at low frequency for ISO 532-1 (120 dB): places are ranked by "
            "their own loudness"
        ]
    said = [
        "sound: places are ranked by the loudness that they add to the study's [background], N of both less N of "
        "the background alone"
    ]
    given = np.flatnonzero(background > NOTHING)
    low, high = (LOWER_EDGES[given[0]], UPPER_EDGES[given[-1]]) if given.size else (0.0, 0.0)
    if low > band.low or high < min(band.high, UPPER_EDGES[-1]):
        said.append(f"sound: the [background] has nothing outside {low:.0f} to {high:.0f} Hz; nothing is masked there")
    return said


def _too_loud(heard: Sequence[Sequence[Heard]]) -> list[str]:
    if any(h.n5 is None for of_one in heard for h in of_one):
        return ["sound: too loud at low frequency for ISO 532-1 (120 dB): no loudness of it"]
    return []


def _walls(ears: Sequence[Ear]) -> str:
    free = [ear.listener.name for ear in ears if ear.listener.rims]
    if not free:
        return "count as set in a wall"
    return "stand free" if len(free) == len(ears) else f"stand free for {listed(free)}, else count as set in a wall"


def _around(ears: Sequence[Ear], heard: Sequence[Sequence[Heard]], band: Band, parts: Sequence[Part]) -> list[str]:
    """What room, measured ways and heads do, and the road beside."""
    said, all_of = [], heard[0][-1]
    if (cabin := ears[0].cabin) is not None:
        room = cabin.room
        n5 = f"; N5 of all is {all_of.n5_direct:.3g} sone without it, {all_of.n5:.3g} with it" if all_of.n5 else ""
        low = f"below {room.schroeder:.0f} Hz" if np.isfinite(room.schroeder) else "at all frequencies"
        said.append(
            f"sound: the [room] of {room.volume:g} m^3 sends back a diffuse field, as noise{n5}; {low} its single "
            "resonances count (Schroeder), and its level is a mean"
        )
    for ear in ears:
        if ear.listener.transfers:
            names = [part.name for part in parts]
            said += words_of(ear.listener.transfers, names, ear.listener.name, (band.low, band.high))
        if ear.listener.side:
            own = f"as {ear.listener.hrtf} has them," if ear.listener.hrtf else "a rigid sphere"
            said.append(
                f"sound: {ear.listener.name} hears with two ears, {own} equalised for sound from the front; "
                f"figures are those of the {ear.listener.ear} one, which hears all contact louder"
            )
        if ear.road is not None:
            level = f"{ear.road:.0f} dB(A)" if ear.road > 0.0 else "nothing"
            said.append(
                f"sound: without contact the excitation alone sends {level} to {ear.listener.name}, up to "
                f"{ear.band:.0f} Hz; it is part of the [background]"
            )
    return said


def _of_statistics(band: Band, heard: Sequence[Heard], more: Statistics | str, parts: Sequence[Part]) -> list[str]:
    """What statistical energy adds, and what it leaves out."""
    if isinstance(more, str):
        return [f"sound: no statistical energy beyond {band.computed:.0f} Hz: {more}"] if more else []
    ties, all_of = [h.tie for h in heard if h.tie is not None], heard[-1]
    tied = [t.bands for t in ties if t.bands]
    n5 = ""
    if all_of.n5 is not None and all_of.n5_computed is not None and all_of.n5_bar:
        n5 = f" N5 of all is {all_of.n5_computed:.3g} sone below {band.computed:.0f} Hz and {all_of.n5:.3g} with both"
        n5 += f", {all_of.n5_bar[0]:.3g} to {all_of.n5_bar[1]:.3g} by their scatter."
    said = [
        f"sound: beyond {band.computed:.0f} Hz, where the {WHAT[band.computed_limit]} ends what is computed, by the "
        f"statistical energy of {listed([parts[k].name for k in more.plates])}, as noise, to {band.high:.0f} Hz; "
        f"{f'tied to the last {max(tied)} third octaves that were computed' if tied else 'tied to nothing computed'}"
        f".{n5}"
    ]
    if more.left_out:
        names = listed([parts[k].name for k in more.left_out])
        said.append(f"sound: contact also pushes {names}, no plate there: nothing of it beyond {band.computed:.0f} Hz")
    return said
