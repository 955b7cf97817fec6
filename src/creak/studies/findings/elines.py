"""E-lines as lines of a table: margins, risks, and where the linear answer and contact part."""

from __future__ import annotations

import csv
import io
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np

from creak.arrays import BoolArray, FloatArray
from creak.model.plain_mesh import Mesh
from creak.model.units import METRES
from creak.studies.file.eline_tables import LimitTable, MaterialPairTable
from creak.studies.file.quantities import LENGTHS, length_in
from creak.studies.prepare.elines import Eline
from creak.studies.run.elines import LineFindings
from creak.verify.elines import DEFINITION, PointMeasures

BOTH, FALSE_ALARM, MISS, NEITHER = "both", "false alarm", "miss", "neither"
"""Who says that the parts can touch: linear run and run with contact, the first alone, the second alone, none."""
YES, POSSIBLE, NO = "yes", "possible", "no"
"""Is the in-plane motion of points that can touch longer than the travel of one stick-slip impulse: for the fewest, for
the most measured."""
EXACT = 1e-12
"""Of the largest coordinate, to which a gap that is 0 is known."""
RISK = "margin = gap - tolerance - largest closing displacement; risk where it is 0 or less, or where the point pressed"


@dataclass(frozen=True)
class Figures:
    """Of one line in one run, length; each the worst of its points."""

    margin: float
    """Smallest gap - tolerance - closing displacement."""
    margin_percentile: float
    """The same with the percentile of the peaks instead of the largest."""
    node_idx: int
    """Row of the node with the smallest margin."""
    gap: float
    """At rest, there."""
    tolerance: float
    """What scatter may take of it, there."""
    closing: float
    """Largest closing displacement, there."""
    across: float
    """Peak-to-peak along z, there."""
    in_plane: float
    """Largest principal peak-to-peak in the plane of any point."""
    in_plane_percentile: float
    in_plane_node_idx: int
    in_plane_touching: float
    """The same of the points that can touch; 0: none can."""
    risk: bool
    points_at_risk: int
    squeak: str | None
    """`YES`, `POSSIBLE` or `NO`; None: neither a material pair nor a limit says."""


@dataclass(frozen=True)
class LineRow:
    """A line of the table."""

    line: Eline
    points: int
    tolerance: tuple[float, float]
    """Least and largest that scatter may take of the gap at a point, length."""
    squeak_travel: tuple[float, float] | None
    """Travel of one impulse, length: with the most and the fewest impulses per mm that were measured; or the limit."""
    linear: Figures | None
    contact: Figures | None
    outcome: str | None
    """`BOTH`, `FALSE_ALARM`, `MISS` or `NEITHER`; None where a run is missing."""


def margins(found: LineFindings, closing: FloatArray) -> FloatArray:
    """(p,) gap - tolerance - closing displacement."""
    return np.asarray(found.gap0 - found.tolerance - closing)


def risks(found: LineFindings) -> tuple[BoolArray | None, BoolArray | None]:
    """(p,) points at which the parts can touch, in the linear run and in the one with contact."""
    near = EXACT * float(np.abs(found.position).max(initial=0.0))
    linear = None if found.linear is None else margins(found, found.linear.closing) <= near
    if found.contact is None or found.touched is None:
        return linear, None
    return linear, (margins(found, found.contact.closing) <= near) | found.touched


def line_rows(found: LineFindings, limit: LimitTable, units: str) -> list[LineRow]:
    """A row for each line, that with the smallest margin first (of the linear run where there is one)."""
    rows = [_row(found, k, limit, units) for k in range(len(found.lines))]
    return sorted(rows, key=_rank)


def _rank(row: LineRow) -> float:
    figures = row.linear or row.contact
    return np.inf if figures is None else figures.margin


def _row(found: LineFindings, k: int, limit: LimitTable, units: str) -> LineRow:
    line, mine = found.lines[k], np.flatnonzero(found.line_of == k)
    travel = squeak_travel(line, limit, units)

    def of(measures: PointMeasures | None, risk: BoolArray | None) -> Figures | None:
        if measures is None or risk is None:
            return None
        margin = margins(found, measures.closing)
        i, j = (int(mine[f(a[mine])]) for f, a in ((np.argmin, margin), (np.argmax, measures.in_plane)))
        percentile = margins(found, measures.closing_percentile)[mine]
        rubbing = float(measures.in_plane[mine[risk[mine]]].max(initial=0.0))
        return Figures(
            margin=float(margin[i]),
            margin_percentile=float(percentile.min()),
            node_idx=int(found.nodes_idx[i]),
            gap=float(found.gap0[i]),
            tolerance=float(found.tolerance[i]),
            closing=float(measures.closing[i]),
            across=float(measures.across[i]),
            in_plane=float(measures.in_plane[j]),
            in_plane_percentile=float(measures.in_plane_percentile[mine].max()),
            in_plane_node_idx=int(found.nodes_idx[j]),
            in_plane_touching=rubbing,
            risk=bool(risk[mine].any()),
            points_at_risk=int(np.count_nonzero(risk[mine])),
            squeak=None if travel is None else YES if rubbing > travel[1] else POSSIBLE if rubbing > travel[0] else NO,
        )

    linear, contact = (of(m, r) for m, r in zip((found.linear, found.contact), risks(found), strict=True))
    spread = float(found.tolerance[mine].min()), float(found.tolerance[mine].max())
    return LineRow(line, int(mine.size), spread, travel, linear, contact, _outcome(linear, contact))


def _outcome(linear: Figures | None, contact: Figures | None) -> str | None:
    if linear is None or contact is None:
        return None
    if linear.risk:
        return BOTH if contact.risk else FALSE_ALARM
    return MISS if contact.risk else NEITHER


def squeak_travel(line: Eline, limit: LimitTable, units: str) -> tuple[float, float] | None:
    """Travel of one stick-slip impulse, shortest and longest, length; None: nothing says."""
    if line.pair is not None:
        mm = LENGTHS["mm"] / METRES[units]
        return mm / line.pair.impulse_rate_max, mm / line.pair.impulse_rate_min
    if limit.in_plane is None:
        return None
    allowed = length_in(limit.in_plane, units)
    return allowed, allowed


def measured_rates(line: Eline | None, units: str) -> tuple[float, float] | None:
    """Fewest and most impulses per length of travel that were measured of a line's materials; None: nobody did."""
    if line is None or line.pair is None:
        return None
    mm = LENGTHS["mm"] / METRES[units]
    return line.pair.impulse_rate_min / mm, line.pair.impulse_rate_max / mm


def against_measured(per_length: float | None, measured: tuple[float, float] | None) -> str | None:
    """Impulses per length of travel in a run: `below`, `within` or `above` those measured; None: nothing to compare."""
    if per_length is None or measured is None:
        return None
    return "below" if per_length < measured[0] else "above" if per_length > measured[1] else "within"


def counted(rows: list[LineRow]) -> dict[str, int]:
    """Lines by outcome."""
    return {word: sum(r.outcome == word for r in rows) for word in (BOTH, FALSE_ALARM, MISS, NEITHER)}


def as_dict(found: LineFindings, limit: LimitTable, units: str, model: Mesh) -> dict[str, Any]:
    """The E-lines of a summary."""
    rows = line_rows(found, limit, units)
    linear, contact = risks(found)
    false = missed = None
    if linear is not None and contact is not None:
        false, missed = int(np.count_nonzero(linear & ~contact)), int(np.count_nonzero(contact & ~linear))
    counts = counted(rows)
    return {
        "risk": RISK,
        "percentile": found.percentile,
        "definition": DEFINITION,
        "linear_run": found.without,
        "why": found.why,
        "false_alarms": None if false is None else counts[FALSE_ALARM],
        "misses": None if missed is None else counts[MISS],
        "points_false_alarms": false,
        "points_misses": missed,
        "lines": [_line_dict(r, model) for r in rows],
        "material_pairs": {name: pair.model_dump(mode="json") for name, pair in pairs_of_lines(found).items()},
    }


def pairs_of_lines(found: LineFindings) -> dict[str, MaterialPairTable]:
    """Name -> what was measured, of the material pairs that lines have."""
    return {line.material: line.pair for line in found.lines if line.material and line.pair is not None}


def _line_dict(row: LineRow, model: Mesh) -> dict[str, Any]:
    def figures(f: Figures | None) -> dict[str, Any] | None:
        if f is None:
            return None
        plain = asdict(f)
        nodes = {"node": plain.pop("node_idx"), "in_plane_node": plain.pop("in_plane_node_idx")}
        return plain | {name: int(model.nodes.ids[idx]) for name, idx in nodes.items()}

    return {
        "name": row.line.name,
        "contact_pair": row.line.contact,
        "points": row.points,
        "tolerance": row.tolerance[1],
        "tolerance_from": row.line.tolerance or None,
        "material": row.line.material,
        "squeak_travel": None if row.squeak_travel is None else list(row.squeak_travel),
        "linear": figures(row.linear),
        "contact": figures(row.contact),
        "outcome": row.outcome,
    }


def point_columns(found: LineFindings) -> dict[str, FloatArray]:
    """Figures (p,) of the points in each run that there is, lengths of the study: `linear_margin`, ..."""
    measures = {"linear": found.linear, "contact": found.contact}
    columns: dict[str, FloatArray] = {}
    for name, m in measures.items():
        if m is None:
            continue
        columns |= {
            f"{name}_margin": margins(found, m.closing),
            f"{name}_closing": m.closing,
            f"{name}_closing_percentile": m.closing_percentile,
            f"{name}_across": m.across,
            f"{name}_along_x": m.along[:, 0],
            f"{name}_along_y": m.along[:, 1],
            f"{name}_in_plane": m.in_plane,
            f"{name}_in_plane_percentile": m.in_plane_percentile,
        }
    return columns


def point_csv(found: LineFindings, model: Mesh, length: str) -> str:
    """A line for each point: where it is, its frame, and its figures in both runs; lengths in `length`."""
    out, columns = io.StringIO(), point_columns(found)
    writer = csv.writer(out, lineterminator="\n")
    head = ["line", "node", "x", "y", "z", *(f"frame_{a}{b}" for a in "xyz" for b in "xyz"), "gap", "tolerance"]
    head += list(columns)
    writer.writerow([f"{h}_{length}" if k > 13 or 2 <= k < 5 else h for k, h in enumerate(head)])
    flat = np.column_stack(list(columns.values()))
    for i, k in enumerate(found.line_of.tolist()):
        figures = [*found.position[i], *found.frames[i].ravel(), found.gap0[i], found.tolerance[i], *flat[i]]
        name = found.lines[k].name
        writer.writerow([name, model.nodes.label(int(found.nodes_idx[i])), *(f"{float(x):.9g}" for x in figures)])
    return out.getvalue()
