"""Rows of the report's tables, as text ready to show."""

from __future__ import annotations

from dataclasses import asdict, dataclass, field
from typing import Any

import numpy as np

from creak.arrays import FloatArray
from creak.dynamics.history import ENERGIES
from creak.model.units import Units
from creak.reduction.health import health_rows
from creak.report.tables.checks import ROUND_OFF, RUN_WORDS
from creak.report.words.text import NONE, fixed, four, number, percent, plural, ratio, share, tidy
from creak.report.words.verdict import penetration
from creak.studies.findings.tree import Findings, FoundPart, FoundRun, FoundSetup

BALANCE = {
    "external": "work from outside",
    "kinetic": "kinetic energy at the end",
    "strain": "strain energy at the end",
    "contact": "energy of the contact springs at the end",
    "damping": "structural damping",
    "contact_damping": "dampers of the contacts",
    "friction": "friction",
    "scheme": "time integration (algorithmic)",
}
"""Terms of `ENERGIES` in the order of the report's balance."""


@dataclass(frozen=True)
class Table:
    """A table; the first `text_columns` columns are words, the others numbers."""

    head: list[str]
    rows: list[list[str]]
    text_columns: int = 1
    note: str = ""
    flags: list[str] = field(default_factory=list)
    """Style of each row: `missed`, `extra` or nothing; empty for no styles."""
    groups: list[tuple[str, int]] = field(default_factory=list)
    """Headings over so many columns each; empty for none."""


def frequency_table(result: Findings) -> Table | None:
    """Frequencies of the paired modes and their MAC."""
    modes = result.modes
    if modes is None or modes.freq_reference.size == 0:
        return None
    rows = []
    for i, (f, j) in enumerate(zip(modes.freq_reference.tolist(), modes.pairs.partner.tolist(), strict=True)):
        other = float(modes.freq_reduced[j]) if j >= 0 else None
        error = percent(ratio(other, f), 3) if f > 0.01 else NONE
        rows.append([str(i + 1), fixed(f, 3), fixed(other, 3), error, four(float(modes.pairs.mac[i]))])
    return Table(["mode", "unreduced, Hz", "reduced, Hz", "error", "MAC"], rows)


def fit_table(result: Findings) -> Table | None:
    """NRMSE fit of the relative motion by axis; None where nothing was compared."""
    fit = result.spectra.nrmse if result.spectra is not None else {}
    if not fit:
        return None
    rows = [
        [axis, four(fit[axis]), "" if fit[axis] is not None else "no motion along this axis (round-off only)"]
        for axis in ("x", "y", "z")
    ]
    rows.append(["all together", four(fit["all"]), ""])
    note = "1: the spectra of both runs are equal, phase included; 0: no better than no motion at all."
    return Table(["axis", "NRMSE fit", ""], rows, note=note, flags=["", "", "", "total"])


def gap_table(result: Findings, units: Units) -> Table | None:
    """Candidates and kept channels of each contact, and how far its gap closed."""
    setup = result.setup
    every = [*dict.fromkeys(setup.contacts.group), *dict.fromkeys(setup.connectors.group)]
    if not every:
        return None
    rows = []
    for group in every:
        source = setup.contacts if group in setup.contacts.group else setup.connectors
        all_of = [j for j, g in enumerate(source.group) if g == group]
        kept = [j for j, g in enumerate(result.gaps.group) if g == group]
        low, high = (float(f(source.gap0[all_of])) for f in (np.min, np.max))
        run = result.main
        p = None if run is None else penetration(result, run, group)
        rows.append(
            [
                group,
                number(len(all_of)),
                number(len(kept)),
                number(low),
                number(high),
                *([NONE] * 3 if p is None else [number(p.smallest), number(p.depth, 3), share(p.of_clearance)]),
                _stiffness(result.gaps.stiffness[kept]),
            ]
        )
    head = [
        "contact or connector",
        "candidates",
        "kept",
        "from",
        "to",
        f"smallest gap, {units.length}",
        f"penetration, {units.length}",
        "of clearance",
        f"mean stiffness, {units.stiffness}",
    ]
    groups = [("", 1), ("channels", 2), (f"clearance, {units.length}", 2), ("in the run with contact", 4)]
    return Table(head, rows, groups=groups)


def _stiffness(values: FloatArray) -> str:
    """Mean of the channels; those that cannot give way at all have none."""
    if values.size and np.isinf(values).all():
        return "hard"
    return number(_mean(values[np.isfinite(values)]), 3)


def _mean(values: Any) -> float | None:
    return float(np.mean(values)) if len(values) else None


def part_table(setup: FoundSetup, units: Units) -> Table:
    """Nodes, elements and mass of each part, and of the whole."""
    every = [*setup.parts, FoundPart("whole model", setup.model.nodes.count, setup.model.n_elements, setup.mass)]
    rows = [[p.name, number(p.nodes), number(p.elements), _mass(p.mass, units)] for p in every]
    note = f"{number(setup.dof)} degrees of freedom, {number(setup.free_dof)} of them free."
    return Table(["part", "nodes", "elements", "mass, kg"], rows, note=note, flags=[""] * (len(rows) - 1) + ["total"])


def _mass(mass: float | None, units: Units) -> str:
    return number(None if mass is None else mass * units.to_kg)


def cost_table(result: Findings) -> Table:
    """What the runs cost, and reduced against reference."""
    names: list[str] = [n for n in ("reference", "reduced") if n in result.runs]
    simulated = {n: float(result.runs[n].time[-1] - result.runs[n].time[0]) for n in names}
    runs = [_costs(result.runs[n], result.gaps.m, simulated[n]) for n in names]
    rows = [_cost_row(label, key, runs, compare) for label, key, compare in _COSTS]
    head = ["", *(RUN_WORDS[n] for n in names)]
    if len(runs) == 2:
        head.append("reduced / unreduced")
    return Table(head, rows, note=_real_time(names, runs, simulated))


def health_tables(result: Findings, units: Units) -> list[tuple[str, Table]]:
    """One table of checks for each superelement, under its name and how many warnings it got; the verdict first."""
    out = []
    for name, rows in ((name, health_rows(h)) for name, h in result.health.items()):
        verdicts = [row for row in rows if row[0] == "verdict"]
        others = [row for row in rows if row[0] not in ("verdict", "part")]
        warned = sum(value == "warning" for _, value, _ in verdicts)
        shown = [[_with_unit(label, units), value, remark] for label, value, remark in verdicts + others]
        out.append((f"{name}: {plural(warned, 'warning')}", Table(["", "value", "remark"], shown, 3)))
    return out


def _with_unit(label: str, units: Units) -> str:
    """The label of a figure of a superelement, with the unit of its value."""
    if label.startswith("inertia"):
        return f"{label}, {units.mass} {units.length}\N{SUPERSCRIPT TWO}"
    unit = {"mass": units.mass, "centre of gravity": units.length}.get(label)
    return label if unit is None else f"{label}, {unit}"


_COSTS = (
    ("unknowns in the time integration", "dof", True),
    ("retained degrees of freedom", "retained", False),
    ("fixed-interface modes", "modes", False),
    ("gap channels", "channels", False),
    ("steps", "steps", False),
    ("steps with contact", "contact_steps", False),
    ("time integration, wall, s", "wall_s", True),
    ("time integration, CPU, s", "cpu_s", True),
    ("before the first step, wall, s", "setup_s", True),
    ("one step, wall, ms", "step_ms", True),
    ("reduction, wall, s", "offline_wall_s", False),
    ("reduction, CPU, s", "offline_cpu_s", False),
    ("peak memory, GB", "peak_rss_gb", True),
    ("simulated time / wall time", "real_time", False),
)


def _costs(run: FoundRun, channels: int, simulated: float) -> dict[str, Any]:
    """Figure -> number, of `_COSTS`."""
    steps = run.time.size - 1
    return {
        **asdict(run.cost),
        **{name: getattr(run, name) for name in ("dof", "retained", "modes", "contact_steps", "setup_s")},
        "offline_wall_s": run.offline_wall_s,
        "offline_cpu_s": run.offline_cpu_s,
        "channels": channels,
        "steps": steps,
        "step_ms": 1000.0 * (ratio(run.cost.wall_s, steps) or 0.0),
        "real_time": ratio(simulated, run.cost.wall_s),
    }


def _cost_row(label: str, key: str, runs: list[dict[str, Any]], compare: bool) -> list[str]:
    absent = ("retained", "modes", "offline_wall_s", "offline_cpu_s")
    cells = [NONE if key in absent and not run[key] else number(run[key], 3) for run in runs]
    if len(runs) == 2:
        cells.append(number(ratio(runs[1][key], runs[0][key]), 3) if compare else "")
    return [label, *cells]


def _real_time(names: list[str], runs: list[dict[str, Any]], simulated: dict[str, float]) -> str:
    words = []
    for name, run in zip(names, runs, strict=True):
        if run["real_time"]:
            pace = "faster" if run["real_time"] >= 1.0 else "slower"
            who = RUN_WORDS[name]
            took = f"The {who} run of {tidy(simulated[name])} s took {number(run['wall_s'], 3)} s"
            words.append(f"{took}: {pace} than real time.")
    return " ".join(words)


def balance_table(result: Findings, units: Units) -> Table | None:
    """Where the energy of each run went by its end, as a share of the largest work or initial energy."""
    runs = {name: run.history for name, run in sorted(result.runs.items(), reverse=True) if run.history.energy.any()}
    if not runs:
        return None
    rows = []
    for term, label in BALANCE.items():
        row = [label]
        for h in runs.values():
            value = float(h.energy[-1, ENERGIES.index(term)])
            row += [number(value, 3), share(value / h.energy_scale)]
        rows.append(row)
    created = ["energy created at the worst moment"]
    for h in runs.values():
        made = h.energy_created if h.energy_created > ROUND_OFF else 0.0
        created += [number(made * h.energy_scale, 3), share(made)]
    head = ["", *(text for name in runs for text in (f"{RUN_WORDS[name]}, {units.energy}", "share"))]
    note = "Shares are of the largest work from outside during the run, or of the energy at its start."
    return Table(head, [*rows, created], note=note)


def energy_sentence(result: Findings) -> str:
    """What the balance leaves over, in words."""
    words = []
    for name, run in sorted(result.runs.items(), reverse=True):
        h = run.history
        who = RUN_WORDS[name]
        if not h.energy.any():
            continue
        made = h.energy_created
        left = share(max(h.energy_dissipated_by_scheme, 0.0))
        worst = f"at worst {share(made)} was created on the way"
        created = worst if made > ROUND_OFF else "none was created at any time"
        words.append(
            f"At the end of the {who} run {left} of the energy put in is left over, dissipated by the integration "
            f"scheme; {created}."
        )
        if h.residual > 0.0:
            words.append(f"Its equations of motion held to {number(h.residual, 2)} of the forces in them.")
    return " ".join(words)


def unread_rows(result: Findings) -> list[tuple[str, str, str, bool]]:
    """Keywords of the deck that were not used: keyword, where, what it means, whether the answer changes."""
    return [(u.keyword, u.where, u.why, u.changes_answer) for u in result.setup.unread]
