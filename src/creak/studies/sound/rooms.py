"""The cabin around the listeners, as the study gives it, and what it adds to their sound."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from creak.arrays import FloatArray
from creak.errors import InputError
from creak.sound.carriers import Noise, along
from creak.sound.forced import without_lows
from creak.sound.head import RADIUS
from creak.sound.room import Room, diffuse_squares, ear_noise
from creak.sound.zwicker_tables import BANDS, RATE
from creak.studies.file.places import Places
from creak.studies.file.sound_tables import RoomTable
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
