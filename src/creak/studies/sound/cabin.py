"""The cabin around the listeners and the steady sound that contacts are heard beside, as the study gives them."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from creak.arrays import FloatArray, IntArray
from creak.errors import InputError
from creak.sound.carriers import Noise, along
from creak.sound.forced import without_lows
from creak.sound.head import RADIUS
from creak.sound.room import Room, diffuse_squares, ear_noise
from creak.sound.zwicker_tables import BANDS, RATE
from creak.studies.file.places import Places
from creak.studies.file.sound_tables import BackgroundTable, RoomTable
from creak.studies.file.tables import read_table
from creak.studies.sound.listeners import Listener

GOLDEN = 0.7548776662
"""Of the length of the noise by which the room of each place begins later than that of the one before."""


@dataclass(frozen=True)
class Cabin:
    """A room as one listener hears it."""

    room: Room
    spread: float
    """1/m^2, mean of 1 / r^2 over what radiates."""
    noise: Noise
    """Of what is heard of it, one for all listeners."""
    side: int = 0
    """1, -1: at the left or right ear; 0: at the middle of the head."""

    def adds(self, direct: FloatArray) -> FloatArray:
        """(n_group, n) Pa of the diffuse field that the sound of each group feeds, direct (n_group, n) at 48 kHz."""
        n, span, out = direct.shape[1], self.noise.span, np.zeros(direct.shape)
        bands = span.bands
        noise = ear_noise(self.noise.of(n), bands, RADIUS, self.side)
        for g, x in enumerate(direct):
            if x.any():
                squares = diffuse_squares(self.room, x, self.spread, bands)
                rows = along(noise, squares, int(GOLDEN * (g + 1) * n) % n)
                out[g] = without_lows(rows.sum(axis=0), RATE, span.only)
        return out


def cabin_of(
    room: Room,
    listener: Listener,
    levels: Mapping[int, float],
    metre: float,
    noise: Noise,
) -> Cabin:
    """The room as a listener hears it.

    Parameters
    ----------
    levels : part -> dB of its equivalent radiated power: by it parts count in the mean distance; all alike without.
    noise : of the band that is heard, which listeners share.
    """
    skin = listener.skin
    area = np.linalg.norm(skin.areas, axis=1)
    of_part = np.bincount(np.maximum(skin.part, 0), area)
    power = np.zeros(of_part.size)
    for part, level in levels.items():
        if part < power.size and of_part[part] > 0.0:
            power[part] = 10.0 ** (0.1 * level) / of_part[part]
    weight = area * power[np.maximum(skin.part, 0)] if power.any() else area
    r = metre * np.linalg.norm(skin.centres - listener.position, axis=1)
    return Cabin(room, float(weight @ r**-2 / weight.sum()), noise, listener.side)


def room_of(table: RoomTable | None, places: Places) -> Room | None:
    """The study's room; None: it gives none.

    Raises
    ------
    InputError : no such file, a wrong header, a time that is not above 0; so short a time that walls would have to
        absorb all.
    """
    if table is None:
        return None
    where, given = places.where("room", "reverberation"), table.reverberation
    if isinstance(given, str):
        where = str(path := places.sibling(given))
        freq, time = read_table(path, places.where("room", "reverberation"), ("frequency", "time"))
        if freq[0] <= 0.0 or time.min() <= 0.0:
            raise InputError(
                f"a reverberation time of {time.min():g} s, frequencies from {freq[0]:g} Hz",
                where=where,
                expected="numbers above 0",
                fix="Repair the row.",
            )
    else:
        freq, time = np.array(given if isinstance(given, list) else [(1000.0, given)]).T
    room = Room(table.volume, np.interp(np.log(BANDS), np.log(freq), time))
    worst = int(room.absorbed.argmax())
    if room.absorbed[worst] >= 1.0:
        raise InputError(
            f"a reverberation time of {room.reverberation[worst]:g} s in a room of {table.volume:g} m^3",
            where=where,
            expected=f"more than {room.reverberation[worst] * room.absorbed[worst]:.3g} s: with that the walls of a "
            "cube absorb all",
            fix="Check volume (m^3) and time (s), or leave out [room]: the direct sound is then all.",
        )
    return room


NOTHING = -100.0
"""dB of bands that are not given."""
NEAR = 0.02
"""Share by which a frequency may be off the middle of its band: nominal ones and those to base 2 are by up to 1.3 %."""
LOUDEST = 120.0
"""dB, of any band."""
NOMINAL = (1.0, 1.25, 1.6, 2.0, 2.5, 3.15, 4.0, 5.0, 6.3, 8.0)
"""Of the third octaves of a decade."""
OCTAVE = 3
"""Third octaves."""
LOWEST, HIGHEST, FIRST = -20, 13, -16
"""Third octaves from 1 kHz, of 10 Hz, of 20 kHz and of the first of `BANDS`."""


def background_of(table: BackgroundTable | None, places: Places) -> FloatArray | None:
    """(28,) dB re 20 uPa of the third octaves from 25 Hz to 12.5 kHz; None: the study gives no levels.

    The file has third octaves, or octaves, whose energy is shared equally by their third octaves. Bands that loudness
    does not know are read and left out.

    Raises
    ------
    InputError : no such file, a wrong header, a frequency that is no third octave, one twice, a band left out between
        others, a level above 120 dB.
    """
    if table is None or table.file is None:
        return None
    path = places.sibling(table.file)
    freq, level = read_table(path, places.where("background", "file"), ("frequency", "level"))
    band = np.rint(10.0 * np.log10(np.maximum(freq, 1e-3) / 1000.0)).astype(np.int64)
    off = (np.abs(freq / (1000.0 * 10.0 ** (0.1 * band)) - 1.0) > NEAR) | (band < LOWEST) | (band > HIGHEST)
    if off.any():
        raise InputError(
            f"{freq[off][0]:g} Hz is no third octave from {_name(LOWEST)} to {_name(HIGHEST)} Hz",
            where=path,
            expected="nominal frequencies: 25, 31.5, 40, 50, 63, 80, 100, ...; of octaves 31.5, 63, 125, ...",
            fix="Give third-octave or octave levels.",
        )
    if np.unique(band).size < band.size:
        raise InputError("two levels of one third octave", where=path, expected="one of each")
    if level.max() > LOUDEST:
        raise InputError(
            f"a level of {level.max():g} dB",
            where=path,
            expected=f"dB re 20 uPa, {LOUDEST:g} at most",
            fix="Check its unit.",
        )
    band, level = _thirds(band, level, path)
    known = (band >= FIRST) & (band < FIRST + BANDS.size)
    found = np.full(BANDS.size, NOTHING)
    found[band[known] - FIRST] = np.maximum(level[known], NOTHING)
    return found


def _thirds(band: IntArray, level: FloatArray, path: Path) -> tuple[IntArray, FloatArray]:
    """Third octaves, of bands in order that are third octaves or octaves without a hole.

    Raises
    ------
    InputError : they are neither.
    """
    apart = np.diff(band)
    if (apart == 1).all():
        return band, level
    if (apart == OCTAVE).all() and band[0] % OCTAVE == 0:
        each = band[:, None] + np.arange(-1, OCTAVE - 1)
        return each.ravel(), np.repeat(level - 10.0 * np.log10(OCTAVE), OCTAVE)
    hole = int(np.flatnonzero(apart != (OCTAVE if (band % OCTAVE == 0).all() else 1))[0])
    raise InputError(
        f"no level between {_name(int(band[hole]))} and {_name(int(band[hole + 1]))} Hz",
        where=path,
        expected="every third octave, or every octave, from the first to the last",
        fix=f"Give the others too; {NOTHING:g} dB is silence.",
    )


def _name(band: int) -> str:
    """Nominal frequency of a third octave, Hz."""
    digits = NOMINAL[band % len(NOMINAL)]
    return f"{digits * 10.0 ** (3 + band // len(NOMINAL)):g}"
