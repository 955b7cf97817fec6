"""Causes as plain data for summary.json and as a sentence."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from creak.arrays import FloatArray
from creak.contact.gap_operator import GapOperator
from creak.dynamics.loads import Loads
from creak.studies.cause.changes import Change, Effect
from creak.studies.cause.decompose import CARRIED, CONTACT, EXCITATION, REST, Cause
from creak.studies.findings.spots import judged_by

MODES = 8
"""Modes told one by one."""
TOLD = 3
"""Modes in a sentence."""
COINCIDES = -20.0
"""dB of the excitation's spectrum at a mode from which they coincide."""
LINES = 1.5
"""Lines of the spectrum to both sides of a mode that count as at it, where its half bandwidth is less."""
BY = {EXCITATION: "excitation", CONTACT: "earlier contact"}
"""Kind of a source -> its word."""
ACCELERATION = 2
NOTHING = 1e-3
"""Share of the largest source's closing from which another one is told, and of the largest mode's from which that with
the supports is."""


def cause_dict(cause: Cause, loads: Loads, gaps: GapOperator, length: str) -> dict[str, Any]:
    """Closing displacements (positive towards contact) by source, mode and part.

    Those of the sources sum to gap0 - gap; those of the modes, and of the parts, do so with what the supports carry.
    """
    order = np.argsort(-np.abs(cause.modes))[:MODES]
    level = driven_level(loads, cause.frequencies[order], cause.damping[order])
    modes: list[dict[str, Any]] = [
        {
            "frequency": float(cause.frequencies[i]),
            "damping": float(cause.damping[i]),
            "closing": -float(cause.modes[i]),
            "of": {s.name: -float(s.modes[i]) for s in cause.sources},
            "excitation_db": float(db),
            "coincides": bool(db >= COINCIDES),
        }
        for i, db in zip(order.tolist(), level.tolist(), strict=True)
    ]
    direct = -sum(s.direct for s in cause.sources)
    found: dict[str, Any] = {
        "time": cause.time,
        "channel": gaps.names[cause.channel],
        "gap0": cause.gap0,
        "gap": cause.gap,
        "closing": cause.gap0 - cause.gap,
        "sources": [{"kind": s.kind, "name": s.name, "closing": -s.total} for s in cause.sources],
        "modes": modes,
        "other_modes": -float(cause.modes.sum()) - sum(m["closing"] for m in modes),
        "with_supports": direct,
        "parts": [{"name": name, "closing": 0.0 - moved} for name, moved in cause.parts if name != CARRIED],
    }
    return found | {"words": cause_words(found, length)}


def cause_words(cause: dict[str, Any], length: str) -> str:
    """The same as a sentence."""

    def moved(value: float) -> str:
        return f"{value:.3g} {length}"

    by = sorted((s for s in cause["sources"] if s["kind"] != REST), key=lambda s: -abs(s["closing"]))
    by = [s for s in by if abs(s["closing"]) >= NOTHING * abs(by[0]["closing"])]
    sources = ", ".join(f"{moved(s['closing'])} by {BY.get(s['kind'], s['kind'])} {s['name']}" for s in by[:4])
    modes = ", ".join(
        f"{m['frequency']:.4g} Hz ({moved(m['closing'])}{', excited' if m['coincides'] else ', not excited'})"
        for m in cause["modes"][:TOLD]
    )
    parts = ", ".join(f"{p['name']} {moved(p['closing'])}" for p in cause["parts"])
    carried, largest = cause["with_supports"], max(abs(m["closing"]) for m in cause["modes"])
    along = f"; {moved(carried)} is {CARRIED}, beyond which" if abs(carried) > NOTHING * largest else ";"
    return (
        f"at {cause['time']:.4g} s the gap of {moved(cause['gap0'])} had closed by {moved(cause['closing'])}: "
        f"{sources}; most through the modes at {modes}{along} parts move {parts}"
    )


def change_dict(change: Change, now: Effect, predicted: Effect, checked: Effect | str | None) -> dict[str, Any]:
    """One change with its effect on the reduced model and, where it was looked at, in a full run."""
    return {
        "change": change.kind,
        "words": change.words,
        "now": vars(now).copy(),
        "predicted": vars(predicted).copy(),
        "checked": checked if checked is None or isinstance(checked, str) else vars(checked).copy(),
    }


def change_words(changes: Sequence[dict[str, Any]], impulse: str) -> list[str]:
    """A sentence for each change."""
    return [f"{c['words']}: {_effect(c, impulse)}" for c in changes]


def _effect(change: dict[str, Any], impulse: str) -> str:
    key = judged_by(change)
    what, unit = ("N5", "sone") if key == "n5" else ("impulse", impulse)

    def shown(effect: dict[str, Any]) -> str:
        return "-" if effect[key] is None else f"{effect[key]:.3g}"

    text = f"{what} {shown(change['now'])} -> {shown(change['predicted'])} {unit}"
    total = f"total_{key}"
    text += f", of all places {_known(change['now'][total])} -> {_known(change['predicted'][total])}"
    checked = change["checked"]
    if isinstance(checked, str):
        return f"{text}; not checked: {checked}"
    return text if checked is None else f"{text}; full run {shown(checked)} ({_known(checked[total])})"


def _known(value: float | None) -> str:
    return "-" if value is None else f"{value:.3g}"


def driven_level(loads: Loads, frequencies: FloatArray, damping: FloatArray) -> FloatArray:
    """(n,) dB: the excitation's spectrum at each mode, within its half bandwidth, under its highest line.

    Accelerations of supports and forces, the whole record under a Hann window, the largest of all excitations; -inf
    where there is none.
    """
    columns = np.hstack([loads.support[ACCELERATION], loads.force])
    n = loads.time.size
    spectrum = np.abs(np.fft.rfft(columns * np.hanning(n)[:, None], axis=0)) ** 2
    highest = spectrum.max(axis=0, initial=0.0)
    share = (spectrum[:, highest > 0.0] / highest[highest > 0.0]).max(axis=1, initial=0.0)
    line = 1.0 / (n * loads.step)
    half = np.maximum(np.nan_to_num(damping) * frequencies, LINES * line)
    freq, found = np.arange(share.size) * line, np.zeros(frequencies.size)
    for i, (low, high) in enumerate(zip(frequencies - half, frequencies + half, strict=True)):
        found[i] = share[np.searchsorted(freq, low) : np.searchsorted(freq, high) + 1].max(initial=0.0)
    with np.errstate(divide="ignore"):
        return np.asarray(10.0 * np.log10(found))
