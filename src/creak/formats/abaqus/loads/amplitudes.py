"""*AMPLITUDE."""

from __future__ import annotations

import math
from collections.abc import Iterable

import numpy as np

from creak.arrays import FloatArray
from creak.errors import InputError, suggest
from creak.formats.abaqus.text.fields import positive, to_float, to_int
from creak.formats.abaqus.text.lexer import Block
from creak.formats.abaqus.text.outline import Outline, list_params
from creak.model.steps import Amplitude

KINDS = ("TABULAR", "EQUALLY SPACED", "SMOOTH STEP", "PERIODIC")
_PARAMS = "NAME, DEFINITION, TIME, VALUE, SMOOTH, FIXED INTERVAL, BEGIN, INPUT"


def read_amplitudes(deck: Outline, blocks: Iterable[Block]) -> dict[str, Amplitude]:
    """Amplitudes by name, upper case.

    Raises
    ------
    InputError : a name used twice; a DEFINITION that creak does not read; a wrong table.
    """
    result: dict[str, Amplitude] = {}
    for block in blocks:
        name = block.need("NAME").upper()
        if name in result:
            raise block.error(f"amplitude {name!r} is defined twice", fix="Rename one of them.")
        list_params(deck, block, _PARAMS)
        result[name] = _amplitude(block, name)
    return result


def find_amplitude(amplitudes: Iterable[str], name: str, where: str) -> str:
    """The name as the table of amplitudes has it; empty for none.

    Raises
    ------
    InputError : there is no such amplitude.
    """
    if name and name.upper() not in amplitudes:
        raise InputError(f"unknown amplitude {name!r}", where=where, fix=suggest(name, amplitudes))
    return name.upper()


def _amplitude(block: Block, name: str) -> Amplitude:
    kind = block.option("DEFINITION", "TABULAR")
    if kind not in KINDS:
        raise block.error(
            f"amplitude {name!r} has DEFINITION={kind}", expected=", ".join(KINDS), fix=suggest(kind, KINDS)
        )
    if block.option("TIME", "STEP TIME") not in ("STEP TIME", "TOTAL TIME"):
        raise block.error(
            f"amplitude {name!r} has TIME={block.get('TIME')}", expected="STEP TIME or TOTAL TIME", fix="Correct it."
        )
    value = block.option("VALUE", "RELATIVE")
    if value not in ("RELATIVE", "ABSOLUTE"):
        raise block.error(f"amplitude {name!r} has VALUE={value}", expected="RELATIVE or ABSOLUTE", fix="Correct it.")
    absolute = value == "ABSOLUTE"
    if kind == "PERIODIC":
        return _periodic(block, name, absolute)
    points = _equally_spaced(block, name) if kind == "EQUALLY SPACED" else _points(block, name)
    smooth = kind == "SMOOTH STEP"
    if smooth and points.shape[0] < 2:
        raise block.error(f"amplitude {name!r} has one point", expected="two or more", fix="Add one.")
    label = "smooth step" if smooth else "tabular"
    return Amplitude(name, label, points, _rounding(block, name), absolute, where=block.where)


def _rounding(block: Block, name: str) -> float:
    if not block.has("SMOOTH"):
        return 0.25
    share = to_float(block.get("SMOOTH"), block.where, "SMOOTH")
    if not 0.0 <= share <= 0.5:
        raise block.error(f"amplitude {name!r} has SMOOTH={share:g}", expected="0 to 0.5", fix="Correct it.")
    return share


def _points(block: Block, name: str) -> FloatArray:
    """(k, 2) time and value: pairs, four on a line."""
    numbers, last, point = [], block.where, -math.inf
    for fields, where in block.rows():
        if len(fields) % 2:
            raise InputError(
                f"amplitude {name!r}: a line with {len(fields)} numbers",
                expected="pairs of time and value",
                where=where,
                fix="Complete the line.",
            )
        row = [to_float(f, where, f"amplitude {name!r}: number") for f in fields]
        for time in row[::2]:
            if time <= point:
                raise InputError(
                    f"amplitude {name!r}: time {time:g} follows {point:g}",
                    expected="times that increase",
                    where=where,
                    fix="Sort the points, drop doubles.",
                )
            point = time
        numbers += row
        last = where
    if not numbers:
        raise InputError(f"amplitude {name!r} has no points", where=last, fix="Give pairs of time and value.")
    return np.array(numbers, dtype=np.float64).reshape(-1, 2)


def _equally_spaced(block: Block, name: str) -> FloatArray:
    interval = positive(block.need("FIXED INTERVAL"), block.where, "FIXED INTERVAL")
    begin = to_float(block.get("BEGIN"), block.where, "BEGIN")
    values = [to_float(f, where, f"amplitude {name!r}: value") for fields, where in block.rows() for f in fields]
    if not values:
        raise block.error(f"amplitude {name!r} has no values", fix="Give them.")
    return np.column_stack([begin + interval * np.arange(len(values)), values])


def _periodic(block: Block, name: str, absolute: bool) -> Amplitude:
    """First line: N, circular frequency, t_0, A_0; then A_1, B_1, A_2, B_2, ..."""
    rows = list(block.rows())
    if not rows:
        raise block.error(
            f"amplitude {name!r} has no data",
            expected="N, circular frequency, start, A0",
            fix="Add the line, and the coefficients A1, B1, A2, B2, ... after it.",
        )
    fields, where = rows[0]
    padded = [*fields, "", "", "", ""][:4]
    count = to_int(padded[0], where, "number of terms")
    omega = positive(padded[1], where, "circular frequency")
    start, mean = (to_float(f, where, f"amplitude {name!r}: number") for f in padded[2:])
    numbers = [to_float(f, w, f"amplitude {name!r}: coefficient") for fields, w in rows[1:] for f in fields]
    if count < 1 or len(numbers) not in (2 * count, 2 * count - 1):
        raise InputError(
            f"amplitude {name!r} has {len(numbers)} coefficients for {count} term(s)",
            expected=f"{2 * max(count, 1)}: A1, B1, A2, B2, ...",
            where=where,
            fix="Complete them.",
        )
    numbers = [*numbers, 0.0][: 2 * count]
    return Amplitude(
        name,
        "periodic",
        absolute=absolute,
        frequency=omega / (2.0 * math.pi),
        start=start,
        mean=mean,
        cosine=tuple(numbers[::2]),
        sine=tuple(numbers[1::2]),
        where=block.where,
    )
