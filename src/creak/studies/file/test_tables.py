"""[test.NAME]: measurements beside which a run is put."""

from __future__ import annotations

from pydantic import model_validator

from creak.studies.file.table import Positive, Table


class MeasuredTable(Table):
    """A file of a test: modes, frequency response functions or time histories."""

    file: str
    """Universal file (.unv, .uff), CSV, RPC III (.rsp, .drv) or WAV, relative to the study file."""
    sensors: str | None = None
    """CSV file with the header sensor,node. Default: sensors are at the nodes with their labels, else the nearest."""
    channels: dict[str, str] = {}
    """Name of a time history in the file -> what the run calls it, as "1017 Z", "flange gap", "flange force"."""
    full_scale: Positive | None = None
    """Of a WAV file that does not tell it: what full scale is, in `unit`."""
    unit: str | None = None
    """Of a WAV file: unit of its samples, as "m/s^2"."""

    @model_validator(mode="after")
    def _of_a_wav_file(self) -> MeasuredTable:
        if (self.full_scale is None) != (self.unit is None):
            raise ValueError("give both full_scale and unit, or neither")
        if self.unit is not None and not self.file.lower().endswith(".wav"):
            raise ValueError("full_scale and unit belong to WAV files; other files tell their units themselves")
        return self
