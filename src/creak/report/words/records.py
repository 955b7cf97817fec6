"""How far time histories of a test and of a run agree, in a sentence and as rows."""

from __future__ import annotations

from creak.report.words.text import NONE, fixed, number, plural
from creak.studies.findings.beside_records import RecordFits


def record_sentence(found: RecordFits) -> str:
    """The best and the worst channel."""
    order = sorted(found.pairs, key=lambda p: p.fit.fit)
    said = f"{plural(len(order), 'channel')} beside the run"
    if len(order) == 1:
        return f"{said}: {order[0].name} with a fit of {fixed(order[0].fit.fit, 2)} (1: the same)."
    ends = [f"{p.name} with a fit of {fixed(p.fit.fit, 2)}" for p in (order[-1], order[0])]
    return f"{said}: best {ends[0]}, worst {ends[1]} (1: the same, 0: no better than a constant)."


def record_rows(found: RecordFits) -> list[list[str]]:
    """Header, and a row for each channel."""
    rows = [["channel", "unit", "fit", "corr.", "rms test", "model", "events", "model"]]
    for p in found.pairs:
        counts = [NONE, NONE] if p.fit.events is None else [str(len(e)) for e in p.fit.events]
        figures = [fixed(p.fit.fit, 3), fixed(p.fit.correlation, 3), *(number(x) for x in p.fit.rms)]
        rows.append([p.name, p.unit, *figures, *counts])
    return rows
