"""Verified quantities: what a test found, what it should be and how far apart they may lie.

Tests hold and record them through the fixture `measured`; `pytest --measured=FILE` writes them down. docs/verification.md is made
from that file by `python -m tools.verification_page`.
"""

from __future__ import annotations

import copy
import json
import os
import re
from collections.abc import Sequence
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np

ROOT = Path(__file__).parents[1]
Row = dict[str, Any]


class Measured:
    """The fixture `measured`: a record of quantities and of curves to draw.

    A quantity that one test records several times (parameters, examples of a property) keeps the case that comes closest
    to its limit.
    """

    def __init__(self) -> None:
        self.quantities: dict[tuple[str, str], Row] = {}
        self.curves: dict[tuple[str, str], Row] = {}
        self.writing = False
        """Whether they will be written: a test may then compute more points for a curve."""
        self.section = self.source = ""
        """Of quantities that are given none."""

    def of(self, section: str = "", source: str = "") -> Measured:
        """The same record with a section and a source for those that are given none."""
        other = copy.copy(self)
        other.section, other.source = section, source
        return other

    def __call__(
        self,
        quantity: str,
        found: Any,
        expected: Any = None,
        *,
        rel: Any = 0.0,
        abs: Any = 0.0,
        between: tuple[float, float] | None = None,
        at_most: float | None = None,
        at_least: float | None = None,
        section: str | None = None,
        source: str | None = None,
        unit: str = "",
    ) -> None:
        """Assert that `found` is `expected` within the tolerance, and record both.

        Parameters
        ----------
        section, source : keys of `SECTIONS` and words for the reference of tools/verification_page.py; None: those of
            the record.
        quantity : its name. With `{}` in it each entry of an array has a row of its own, numbered from 1; without, the
            worst entry is kept.
        found, expected : number or array; `expected` may be left out with the limits below.
        rel, abs : tolerance as in `pytest.approx`, the larger of the two rules; number or one for each entry.
        between : lowest and highest value allowed. `expected` is the middle unless given.
        at_most : an error or a misfit, zero at best, and its bound. at_least : a count or a ratio and its lower bound.

        Raises
        ------
        AssertionError : a value lies outside, is no number, or there is none.
        TypeError : nothing to hold it to.
        """
        value = np.atleast_1d(np.asarray(found, dtype=float)).ravel()
        assert value.size, f"{quantity}: no value"
        if expected is None and between is None and at_most is None and at_least is None:
            raise TypeError(f"{quantity}: neither an expected value nor a limit")
        if at_most is not None:
            expected, between = 0.0, (-at_most, at_most)
        elif between is not None and expected is None:
            expected = 0.5 * (between[0] + between[1])
        wanted = (
            [None] * value.size
            if expected is None
            else np.broadcast_to(np.asarray(expected, float).ravel(), value.shape)
        )
        slack = np.broadcast_to(
            np.maximum(np.abs(0.0 if expected is None else expected) * np.asarray(rel), abs), value.shape
        )
        for i, (x, e, t) in enumerate(zip(value, wanted, slack, strict=True)):
            low, high = (at_least, None) if e is None else between or (e - t, e + t)
            name = quantity.replace("{}", str(i + 1))
            said = f"{name}: found {x!r}, expected {low} to {high}"
            assert low is None or low <= x, said
            assert high is None or x <= high, said
            self._keep(
                {
                    "section": self.section if section is None else section,
                    "quantity": name,
                    "source": self.source if source is None else source,
                    "unit": unit,
                    "expected": _short(e, 12),
                    "value": _short(x, 12),
                    "difference": None if e is None else _short(x - e, 3),
                    "low": _short(low, 12),
                    "high": _short(high, 12),
                    "tolerance": None if between or e is None else _short(t, 3),
                    "test": _test(),
                }
            )

    def curve(self, picture: str, label: str, x: Any, y: Any, exact: Any = None) -> None:
        """Record points y(x) for a picture of tools/verification_page.py; `exact` is the reference at the same points."""
        row = {"picture": picture, "label": label, "x": _list(x), "y": _list(y)}
        self.curves[picture, label] = row | {"exact": None if exact is None else _list(exact), "test": _test()}

    def _keep(self, row: Row) -> None:
        key = row["test"], row["quantity"]
        if key not in self.quantities or share(row) > share(self.quantities[key]):
            self.quantities[key] = row


def share(row: Row) -> float:
    """Part of the tolerance that is used: difference over the limit on its side; bound over value for a lower bound."""
    if row["difference"] is None:
        return row["low"] / row["value"] if row["value"] > 0.0 else np.inf
    limit = abs((row["high"] if row["difference"] > 0.0 else row["low"]) - row["expected"])
    return abs(row["difference"]) / limit if limit else float(row["difference"] != 0.0)


def merge(file: Path, found: Measured, ran: set[str]) -> None:
    """Put what `ran` recorded into the file; rows of other tests stay as long as their test is there."""
    old = json.loads(file.read_text(encoding="utf-8")) if file.exists() else {"quantities": [], "curves": []}
    new = {"quantities": found.quantities, "curves": found.curves}
    lines = []
    for kind, rows in new.items():
        kept = [r for r in old[kind] if r["test"] not in ran] + [r for r in rows.values() if r["test"] in ran]
        placed = sorted((r for r in kept if place(r["test"])[1] >= 0), key=lambda r: place(r["test"]))
        lines.append(f' "{kind}": [\n' + ",\n".join("  " + json.dumps(r) for r in placed) + "\n ]")
    file.write_text("{\n" + ",\n".join(lines) + "\n}\n", encoding="utf-8")


@cache
def place(test: str) -> tuple[str, int]:
    """File of `path::name` and where in it the test is; -1 if it is not."""
    path, _, name = test.partition("::")
    file = ROOT / path
    head = re.search(rf"^def {name}\(", file.read_text(encoding="utf-8"), re.MULTILINE) if file.exists() else None
    return path, head.start() if head else -1


def test_of(nodeid: str) -> str:
    """`path::name` of pytest's name for a test, without parameters."""
    return nodeid.split(" (")[0].split("[")[0]


def _test() -> str:
    return test_of(os.environ["PYTEST_CURRENT_TEST"])


def _short(x: float | None, digits: int) -> float | None:
    return None if x is None else float(f"{float(x):.{digits}g}")


def _list(x: Sequence[float]) -> list[float]:
    return [float(f"{v:.5g}") for v in np.asarray(x, dtype=float)]
