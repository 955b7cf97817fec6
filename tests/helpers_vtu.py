"""VTU files read back, by what they say of themselves."""

from __future__ import annotations

import base64
import xml.etree.ElementTree as ET
from pathlib import Path

import numpy as np


def arrays(path: Path) -> dict[str, np.ndarray]:
    """Name -> values, by the type that the file states; each begins with its length in bytes."""
    found = {}
    for element in ET.parse(path).iter("DataArray"):
        raw = base64.b64decode(element.text.strip(), validate=True)
        assert int.from_bytes(raw[:8], "little") == len(raw) - 8
        kind = {"Float32": "<f4", "Float64": "<f8", "Int64": "<i8", "UInt8": "u1"}[element.get("type")]
        values = np.frombuffer(raw[8:], dtype=kind)
        found[element.get("Name")] = values.reshape(-1, int(element.get("NumberOfComponents", "1"))).squeeze()
    return found
