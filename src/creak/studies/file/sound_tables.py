"""Tables of the study for what is heard: listeners, the room around them, and what they hear besides."""

from __future__ import annotations

from itertools import pairwise
from typing import Annotated, Literal

from pydantic import Field, StrictBool, field_validator, model_validator

from creak.studies.file.table import Finite, Positive, Table

UNNAMED = "ear"
"""Name of the listener of a study that names none."""


class TransferTable(Table):
    """[listener.NAME.transfer.PART]: what was measured from a part to the listener, in place of the open air."""

    file: str
    """Transfer function from the middle of the part to the ear, Pa over a volume acceleration or velocity in m and s,
    relative to the study file. CSV with the header frequency,real,imag or frequency,amplitude,phase (degrees) or
    frequency,amplitude; a universal file with data set 58; or WAV, an impulse response."""
    function: int | str | None = None
    """Name, or number from 1, of the function in a universal file, or of the channel in a WAV file with several."""
    per: Literal["volume acceleration", "volume velocity"] | None = None
    """What the pressure is per; default: what the file says, else volume acceleration."""
    full_scale: Positive | None = None
    """Of a WAV file: Pa per m^3/s^2 (or per m^3/s) that a sample of 1 stands for; responses of all samples add up."""


class ListenerTable(Table):
    """[listener.NAME]: where the sound of the contacts is heard. Without one: an ear 0.6 m off the loudest panel."""

    position: tuple[Finite, Finite, Finite]
    """length, in the deck's axes."""
    parts: list[str] | str = []
    """Parts, surfaces or element sets that radiate to it; default: all parts with shells or solids."""
    wall: StrictBool = True
    """Whether panels count as set in a wall. `false`: they stand free, and what flows around their edges is not heard.
    """
    faces: tuple[Finite, Finite, Finite] | None = None
    """Direction in which its head looks, in the deck's axes: it hears with two ears, position is the middle between
    them. Default: a point in the air."""
    up: tuple[Finite, Finite, Finite] | None = None
    """Direction of the top of the head; default: z."""
    hrtf: str | None = None
    """SOFA file of its ears, head-related impulse responses as they were measured, relative to the study file. Default:
    a rigid sphere."""
    transfer: dict[str, TransferTable] = {}
    """[listener.NAME.transfer.PART]: what was measured from a part to the listener."""

    @property
    def part_names(self) -> tuple[str, ...]:
        return (self.parts,) if isinstance(self.parts, str) else tuple(self.parts)

    @field_validator("faces", "up")
    @classmethod
    def _points_somewhere(cls, value: tuple[float, ...] | None) -> tuple[float, ...] | None:
        if value is not None and not any(value):
            raise ValueError("is no direction, its length is 0")
        return value

    @model_validator(mode="after")
    def _has_a_head(self) -> ListenerTable:
        if self.up is not None and self.faces is None:
            raise ValueError("up is that of a head: give faces, where it looks, too")
        if self.hrtf is not None and self.faces is None:
            raise ValueError("hrtf is that of a head: give faces, where it looks, too")
        if self.transfer and self.faces is not None:
            raise ValueError("a transfer function is measured at one ear, its head is in it: leave faces out")
        return self


Reverberation = Positive | Annotated[list[tuple[Positive, Positive]], Field(min_length=1)] | str


class RoomTable(Table):
    """[room]: the cabin around all listeners, whose walls send back what radiates, as a diffuse field."""

    volume: Positive
    """m^3, whatever the units of the deck."""
    reverberation: Reverberation
    """s in which the sound falls by 60 dB: one number, [[Hz, s], ...] upwards in frequency, or a CSV file with the
    header frequency,time, relative to the study file. Between its frequencies it follows their logarithm, outside it is
    that of the nearest."""

    @field_validator("reverberation")
    @classmethod
    def _upwards(cls, value: Reverberation) -> Reverberation:
        if isinstance(value, list) and any(b[0] <= a[0] for a, b in pairwise(value)):
            raise ValueError("its frequencies do not increase")
        return value


class BackgroundTable(Table):
    """[background]: the steady sound that the contacts are heard beside, as the user measured or assumes it."""

    file: str | None = None
    """CSV file with the header frequency,level, relative to the study file: third octaves or octaves by their nominal
    frequency, upwards and without a hole, and levels in dB re 20 uPa. An octave is shared equally by its third octaves.
    Nothing is below the first band and above the last."""
    linear: StrictBool = False
    """What the excitation radiates to each listener without any contact counts as background, beside what file has."""

    @model_validator(mode="after")
    def _something(self) -> BackgroundTable:
        if self.file is None and not self.linear:
            raise ValueError("give file, levels that were measured, or linear = true, the sound of the excitation")
        return self
