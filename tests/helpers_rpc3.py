"""A small file of the trade: RPC III."""

from __future__ import annotations

import numpy as np

POINTS, GROUP, STEP = 300, 128, 0.005
TIME = STEP * np.arange(POINTS)
COURSES = {"Acc_X": np.sin(40.0 * TIME), "Acc_Z": 3.0 * np.cos(25.0 * TIME)}


def rpc3(order: str = "<", kind: str = "SHORT_INTEGER", **changed: str) -> bytes:
    """Header of two blocks and three groups, the last filled up; 100 points a frame."""
    scales = [4.0 / 32752.0] * len(COURSES)
    head = {
        "FORMAT": {"<": "BINARY_IEEE_LITTLE_END", ">": "BINARY_IEEE_BIG_END"}[order],
        "NUM_HEADER_BLOCKS": "6",
        "NUM_PARAMS": "22",
        "FILE_TYPE": "TIME_HISTORY",
        "TIME_TYPE": "RESPONSE",
        "DELTA_T": f"{STEP}",
        "CHANNELS": "2",
        "PTS_PER_FRAME": "100",
        "PTS_PER_GROUP": f"{GROUP}",
        "FRAMES": "3",
        "HALF_FRAMES": "0",
        "INT_FULL_SCALE": "32752",
        "DATA_TYPE": kind,
    }
    for k, (name, scale) in enumerate(zip(COURSES, scales, strict=True), start=1):
        head |= {f"DESC.CHAN_{k}": name, f"UNITS.CHAN_{k}": "g", f"SCALE.CHAN_{k}": f"{scale!r}"}
    head |= changed
    records = b"".join(k.encode().ljust(32, b"\0") + v.encode().ljust(96, b"\0") for k, v in head.items())
    form = np.dtype(order + {"SHORT_INTEGER": "i2", "FLOATING_POINT": "f4"}[kind])
    data = b""
    for begin in range(0, POINTS, GROUP):
        for course, scale in zip(COURSES.values(), scales, strict=True):
            piece = np.zeros(GROUP)
            own = course[begin : begin + GROUP]
            piece[: own.size] = np.round(own / scale) if kind == "SHORT_INTEGER" else own
            data += piece.astype(form).tobytes()
    return records.ljust(6 * 512, b"\0") + data
