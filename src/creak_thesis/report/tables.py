"""Tables of the thesis page: the thesis's column beside creak's, always."""

from __future__ import annotations

from collections.abc import Sequence

from creak.report_tools import NONE, Table, fixed, number, percent, tidy
from creak_thesis.doors import DoorFacts
from creak_thesis.plan import FINE_ETAS, RATTLING
from creak_thesis.report.facts import PARTS, Facts, against, flange_events, thesis, thesis_cpu
from creak_thesis.report.words import against_reference, bias, fit, seconds

RANGES = {300: "F300", 500: "F500", 700: "F700", 900: "F900", 1100: "F1100", 1300: "F1300", 1500: "D8", 2000: "F2000"}
"""Case for each range of fixed-interface modes; D8 keeps those up to 1500 Hz."""
BOTH = ("thesis", "creak")
NEWTON_NOTE = (
    "Plain Newton: every iteration of every step factorises the model's matrices anew, as a general implicit code "
    "does; steps with and without contact are timed on creak's own matrices and scaled to the steps of the A4 run. "
    "creak measured: CPU time of the whole A4 run as creak makes it, after the reduction. Ratios are to the unreduced "
    "model, counted the same way."
)


def material_table(door: DoorFacts | None) -> Table:
    """Table 3.1."""
    t = thesis()["materials"]
    rows = []
    for part in PARTS:
        found = None if door is None else door.sheets[part]
        cells = [
            [tidy(a), NONE if found is None else tidy(round(b, 6))]
            for a, b in zip(t[part], found or t[part], strict=True)
        ]
        rows.append([part.lower(), *(c for pair in cells for c in pair)])
    names = ("E, GPa", "ν", "ρ, kg/m³", "thickness, mm")
    return Table(["part", *(BOTH * 4)], rows, groups=[("", 1), *((n, 2) for n in names)])


def size_table(door: DoorFacts | None) -> Table:
    """Table 3.2 and the other figures of 3.1.2."""
    t = thesis()["model"]
    found = (
        [NONE] * 4
        if door is None
        else [fixed(door.mass, 2), number(door.n_dof), fixed(door.gap, 2), number(door.links)]
    )
    names = ("mass, kg", "dofs", "initial gap, mm", "rigid links")
    told = [fixed(t["mass"], 2), number(t["dof"]), fixed(t["gap"], 1), number(t["links"])]
    return Table(
        ["", *BOTH],
        [list(r) for r in zip(names, told, found, strict=True)],
        note="The thesis's full door, before its simplification, had 28.11 kg and 2,589,830 dofs.",
    )


def support_table(door: DoorFacts | None) -> Table:
    """Table 3.3."""
    t = thesis()["supports"]
    rows = [[p, words, NONE if door is None else door.supports[p]] for p, words in t.items()]
    return Table(["point", *BOTH], rows, text_columns=3)


def load_table(facts: Facts, amplitudes: dict[str, float]) -> Table:
    """Table 3.4."""
    t, rows = thesis()["loads"], []
    for load, told in t.items():
        low, high = told["events"]
        run = facts.load("Ref StS", load)
        rows.append(
            [
                load,
                tidy(told["amplitude"]),
                tidy(amplitudes[load]) if load in amplitudes else NONE,
                str(low) if low == high else f"{low}–{high}",
                NONE if run is None else str(len(flange_events(run))),
                NONE if run is None else seconds_share(run.contact_steps, run.steps),
            ]
        )
    return Table(
        ["load", *BOTH, *BOTH, "creak"],
        rows,
        groups=[("", 1), ("amplitude of each sine, mm", 2), ("events per second", 2), ("steps in contact", 1)],
        note="creak: events of the unreduced model (surface to surface) in the last second.",
    )


def seconds_share(part: int, whole: int) -> str:
    return f"{number(100.0 * part / whole, 3)} %" if whole else NONE


def spacing_table(facts: Facts) -> Table:
    """Table 3.5."""
    t = thesis()["spacing"]

    def both(name: str) -> list[str]:
        costs = [(facts.usual_cpu(name, kind), facts.usual_cpu("Ref C", kind)) for kind in ("", "condensed_")]
        return [text for cpu, of in costs for text in (seconds(cpu), against_reference(cpu, of))]

    rows = [
        [
            "Ref",
            NONE,
            NONE,
            NONE,
            fixed(t["reference_cpu"], 2),
            "1",
            *both("Ref C"),
        ]
    ]
    for k, spacing in enumerate(t["spacing"]):
        name = f"C{k + 1}"
        rows.append(
            [
                name,
                str(spacing),
                number(t["retained"][k]),
                count(facts.retained(name, "FRAME")),
                fixed(t["cpu"][k], 2),
                against_reference(t["cpu"][k], t["reference_cpu"]),
                *both(name),
            ]
        )
    groups = [("", 2), ("retained dofs, frame", 2), ("thesis", 2), ("creak, plain Newton", 2), ("creak, condensed", 2)]
    head = ["", "every n-th node", *BOTH, "CPU, 1000 s", "ratio", *("CPU, s", "ratio") * 2]
    note = "Plain Newton as in the thesis's solver, timed on creak's matrices (see the section on computational time); "
    note += "condensed: creak's step on the same full matrices, factorised once. "
    run = facts.load("Ref StS", "A4")
    if run is not None:
        note += (
            f"These cases have no runs of their own: their steps are counted as those of the unreduced A4 run "
            f"({number(run.steps)} steps, {number(run.contact_steps)} in contact)."
        )
    return Table(head, rows, note=note, groups=groups)


def count(value: int | None) -> str:
    return NONE if value is None else number(value)


def modes_table(facts: Facts) -> Table:
    """Table 3.6."""
    t = thesis()["range"]
    rows = []
    for k, f in enumerate(t["f_max"]):
        found = facts.case(RANGES[f])
        cells = [[number(t[p][k]), count(None if found is None else found.modes.get(p))] for p in PARTS]
        rows.append([number(f), *(c for pair in cells for c in pair)])
    return Table(["up to, Hz", *(BOTH * 3)], rows, groups=[("", 1), *((p.lower(), 2) for p in PARTS)])


def range_table(facts: Facts) -> Table:
    """Table 4.1."""
    names = [RANGES[f] for f in thesis()["range"]["f_max"]]
    table = cost_table(facts, names, "Ref StS")
    rows = [[number(f), *row[1:]] for f, row in zip(thesis()["range"]["f_max"], table.rows[1:], strict=True)]
    return Table(["up to, Hz", *table.head[1:]], [table.rows[0], *rows], groups=table.groups, note=table.note)


def cost_table(facts: Facts, names: Sequence[str], reference: str) -> Table:
    """CPU times of some cases against that of an unreduced one, each way of counting with its ratio."""
    kinds = [("creak, plain Newton", "")]
    if any(facts.usual_cpu(n, "condensed_") is not None for n in (reference, *names)):
        kinds.append(("creak, condensed step on the same matrices", "condensed_"))
    told = thesis_cpu(reference)
    rows = []
    for name in (reference, *names):
        theirs = thesis_cpu(name)
        row = [name, NONE if theirs is None else fixed(theirs, 2), against_reference(theirs, told)]
        for _, kind in kinds:
            cpu = facts.usual_cpu(name, kind)
            row += [seconds(cpu), against_reference(cpu, facts.usual_cpu(reference, kind))]
        own = facts.own_cpu(name)
        rows.append([*row, seconds(own), against_reference(own, facts.own_cpu(reference))])
    groups = [("", 1), ("thesis", 2), *((title, 2) for title, _ in kinds), ("creak, measured", 2)]
    head = ["", "CPU, 1000 s", "ratio", *(["CPU, s", "ratio"] * (len(kinds) + 1))]
    return Table(head, rows, groups=groups, note=NEWTON_NOTE)


def distance_table(facts: Facts) -> Table:
    """Table 3.7."""
    t, rows = thesis()["distance"], []
    for k, d in enumerate(t["distance"]):
        name = f"D{d}"
        found = facts.case(name)
        rows.append(
            [
                name,
                str(d),
                number(t["retained"][k]),
                count(facts.retained(name, "PANEL")),
                count(facts.retained(name, "FRAME")),
                number(t["total"][k]),
                count(None if found is None else found.n),
                count(None if found is None else found.unreduced),
            ]
        )
    return Table(
        ["", "distance, mm", "thesis", "creak", "creak", "thesis", "creak", "creak"],
        rows,
        groups=[("", 2), ("retained dofs, panel", 2), ("frame", 1), ("dofs in all", 2), ("unreduced", 1)],
    )


def axis_table(facts: Facts, name: str, told: dict[str, list[float]], loads: Sequence[str]) -> Table:
    """Tables 4.2 and 4.6: fit by axis."""
    rows = []
    for load in loads:
        cells = [[fit(told[load][k]), fit(facts.fit(name, load, a))] for k, a in enumerate("xyz")]
        rows.append([load, *(c for pair in cells for c in pair), fit(facts.fit(name, load))])
    return Table(["load", *(BOTH * 3), "creak"], rows, groups=[("", 1), *((a.upper(), 2) for a in "xyz"), ("all", 1)])


def grade_table(facts: Facts, name: str) -> Table:
    """Table 4.3, with missed and extra events and the mean force."""
    t = thesis()
    found = {load: facts.agreement(name, load) for load in RATTLING}
    names = ("force within 5 %", "force too low", "force too high")
    rows = []
    for k, (label, key) in enumerate(zip(names, ("perfect", "low", "high"), strict=True)):
        cells = [
            [str(t["predictions"][key][j]), NONE if a is None else str(a.graded[k])]
            for j, a in enumerate(found.values())
        ]
        rows.append([label, *(c for pair in cells for c in pair)])
    for label in ("missed", "extra"):
        cells = [
            [str(t["events"]["D8"][label][j]), NONE if a is None else str(getattr(a, label))]
            for j, a in enumerate(found.values())
        ]
        rows.append([f"events {label}", *(c for pair in cells for c in pair)])
    told = t["force"]["D8"]
    cells = [[percent(1.0 + told[j] / 100.0), bias(a)] for j, a in enumerate(found.values())]
    rows.append(["mean force of common events", *(c for pair in cells for c in pair)])
    return Table(["", *(BOTH * 3)], rows, groups=[("", 1), *((load, 2) for load in RATTLING)])


def force_table(facts: Facts, names: Sequence[str]) -> Table:
    """Mean force of the common events of some cases against their references."""
    t, rows = thesis()["force"], []
    for name in names:
        told = t.get(name, [None] * 3)
        row = [name]
        for j, load in enumerate(RATTLING):
            row += [percent(None if told[j] is None else 1.0 + told[j] / 100.0), bias(facts.agreement(name, load))]
        rows.append(row)
    return Table(["", *(BOTH * 3)], rows, groups=[("", 1), *((f"mean force, {x}", 2) for x in RATTLING)])


def participation_table(facts: Facts) -> Table:
    """Tables 3.8 and 4.5."""
    t, rows = thesis()["participation"], []
    base = facts.all_retained("D8")
    for eta in (*FINE_ETAS, *t["eta"]):
        name, k = f"P{eta}", t["eta"].index(eta) if eta in t["eta"] else None
        total, lowest = facts.all_retained(name), facts.lowest_mac(name)
        saved = None if total is None or not base else 100.0 * (1.0 - total / base)
        rows.append(
            [
                name,
                NONE if k is None else number(t["frame"][k]),
                count(facts.retained(name, "FRAME")),
                NONE if k is None else number(t["panel"][k]),
                count(facts.retained(name, "PANEL")),
                NONE if k is None else fixed(t["reduction"][k], 2),
                fixed(saved, 2),
                NONE if k is None else f"{fixed(t['mac'][k], 4)} ({t['mode'][k]})",
                NONE if lowest is None else f"{fit(lowest[0])} ({lowest[1]})",
            ]
        )
    groups = [("", 1), ("retained, frame", 2), ("retained, panel", 2), ("reduction, %", 2), ("lowest MAC (mode)", 2)]
    return Table(["", *(BOTH * 4)], rows, groups=groups)


def coarse_table(facts: Facts) -> Table:
    """Table 3.9."""
    t, rows = thesis()["coarse"], []
    base = facts.all_retained("D8")
    for k, merged in enumerate(t["merged"]):
        name = f"M{k + 1}"
        total = facts.all_retained(name)
        saved = None if total is None or not base else 100.0 * (1.0 - total / base)
        rows.append(
            [
                name,
                str(merged),
                number(t["retained"][k]),
                count(facts.retained(name, "FRAME")),
                fixed(t["reduction"][k], 2),
                fixed(saved, 2),
            ]
        )
    return Table(
        ["", "merged elements", *BOTH, *BOTH], rows, groups=[("", 2), ("retained dofs, frame", 2), ("reduction, %", 2)]
    )


def agreement_table(facts: Facts, names: Sequence[str]) -> Table:
    """Events and fits of some cases under each load, creak's only."""
    rows = []
    for name in names:
        row = [name]
        for load in RATTLING:
            a = facts.agreement(name, load)
            row += [NONE] * 3 if a is None else [f"{len(a.common)}/{a.reference}", str(a.extra), percent(a.force_ratio)]
            row.append(fit(facts.fit(name, load)))
        rows.append(row)
    return Table(
        ["", *(["found", "extra", "mean force", "NRMSE"] * 3)],
        rows,
        groups=[("creak", 1), *((x, 4) for x in RATTLING)],
        note="Found: events of the case's own unreduced model that the reduced one has within 10 ms.",
    )


def summary_table(facts: Facts) -> Table:
    """Table 4.7: size and CPU time of the configurations."""
    t, rows = thesis()["summary"], []
    for k, name in enumerate(t["names"]):
        found = facts.case(name)
        base = against(name)
        cpu, own = facts.usual_cpu(name), facts.own_cpu(name)
        rows.append(
            [
                name,
                number(t["panel"][k]) if t["panel"][k] else NONE,
                count(facts.retained(name, "PANEL")),
                number(t["frame"][k]) if t["frame"][k] else NONE,
                count(facts.retained(name, "FRAME")),
                number(t["total"][k]),
                count(None if found is None else found.n),
                fixed(t["cpu"][k], 2),
                against_reference(t["cpu"][k], thesis_cpu(base)),
                seconds(cpu),
                against_reference(cpu, facts.usual_cpu(base)),
                seconds(own),
                against_reference(own, facts.own_cpu(base)),
            ]
        )
    groups = [
        ("", 1),
        ("retained, panel", 2),
        ("retained, frame", 2),
        ("dofs in all", 2),
        ("thesis", 2),
        ("plain Newton", 2),
        ("creak, measured", 2),
    ]
    head = ["", *(BOTH * 3), "CPU, 1000 s", "ratio", "CPU, s", "ratio", "CPU, s", "ratio"]
    return Table(head, rows, groups=groups, note=NEWTON_NOTE)
