"""What would help at a place, beside what is known of the place itself."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any


def beside_bars(cause: dict[str, Any] | None, bars: Mapping[str, float | None]) -> dict[str, Any] | None:
    """The same with a word at each change that alters its place by no more than the place's own bar.

    Parameters
    ----------
    bars : of the place's N5 and impulse, as shares; None: not known, and nothing is said.
    """
    if cause is None or not cause.get("changes"):
        return cause
    words = []
    for change, text in zip(cause["changes"], cause["changes_words"], strict=True):
        key, (now, then) = judged_by(change), (change["now"], change["predicted"])
        bar = bars.get(key)
        small = bar is not None and then[key] is not None and abs(then[key] - now[key]) <= bar * now[key]
        words.append(f"{text}; within the uncertainty of the place, {100.0 * bar:.2g} %" if small and bar else text)
    return cause | {"changes_words": words}


def judged_by(change: dict[str, Any]) -> str:
    """The figure that tells what a change does: loudness where it is known."""
    return "n5" if change["now"]["n5"] is not None else "impulse"
