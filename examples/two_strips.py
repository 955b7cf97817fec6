"""# Two strips that rattle

A plastic strip is clamped 0.3 mm above a steel one on a common base, which shakes with 5 to 100 Hz.
The strips bend differently, so that the gap at their tips closes: fifty impacts a second.
Craig-Bampton keeps the contact's dofs and the modes below 6 kHz of each strip, a ninth of the unknowns.
Both models run through the same steps; their contact events are compared by time, force and impulse.
Impacts amplify small differences, so that agreement is a test of the reduction where it matters.
"""

import sys
import tempfile
from pathlib import Path

import creak

LENGTH, WIDTH, ELEMENTS, ROWS, GAP = 120.0, 20.0, 24, 4, 0.3
"""mm."""
STRIPS = {"STEEL": (1, 0.0, 1.0), "PLASTIC": (1001, GAP + 0.5 * (1.0 + 2.5), 2.5)}
"""Name -> first label, height and thickness, mm."""
STUDY = {
    "title": "Two strips",
    "model": {"deck": "strips.inp", "units": "mm-t-s"},
    "damping": {"rayleigh": {"alpha": 6.0, "beta": 1e-4}},
    "contact": {"tips": {"secondary": "UNDER", "main": "OVER", "method": "surface-to-surface"}},
    "excitation": {
        "base": {
            "node_set": "BASE",
            "dof": "z",
            "kind": "displacement",
            "signal": {"type": "multisine", "f_min": 5, "f_max": 100, "amplitude": 0.02, "period": 0.2, "seed": 2},
        }
    },
    "reduction": {"f_max": 6000},
    "time": {"step": 1e-4, "periods": 3},
    "verification": {"f_max": 1000, "mac_f_max": 300, "merge": 0.002, "event_tolerance": 0.002},
}


def strip(name: str) -> list[str]:
    """One strip of the deck, clamped in x, y and rotation at its root."""
    first, z, thickness = STRIPS[name]
    n = ELEMENTS + 1
    nodes = [
        f"{first + j * n + i}, {LENGTH * i / ELEMENTS:.6f}, {WIDTH * j / ROWS:.6f}, {z:.6f}"
        for j in range(ROWS + 1)
        for i in range(n)
    ]
    starts = [first + j * n + i for j in range(ROWS) for i in range(ELEMENTS)]
    shells = [f"{first + k}, {a}, {a + 1}, {a + n + 1}, {a + n}" for k, a in enumerate(starts)]
    root = [f"{first + j * n}," for j in range(ROWS + 1)]
    tip = [f"{first + k}," for k, _ in enumerate(starts) if k % ELEMENTS >= ELEMENTS - 4]
    return [
        "*NODE",
        *nodes,
        f"*ELEMENT, TYPE=S4, ELSET={name}",
        *shells,
        "*NSET, NSET=BASE",
        *root,
        f"*ELSET, ELSET={name}_TIP",
        *tip,
        f"*SHELL SECTION, ELSET={name}, MATERIAL={name}",
        f"{thickness},",
    ]


def deck() -> str:
    """Both strips, materials and contact surfaces as an Abaqus deck in mm, t, s."""
    return "\n".join(
        [
            *strip("STEEL"),
            *strip("PLASTIC"),
            "*MATERIAL, NAME=STEEL",
            "*ELASTIC",
            "210000., 0.3",
            "*DENSITY",
            "7.85e-9,",
            "*MATERIAL, NAME=PLASTIC",
            "*ELASTIC",
            "2500., 0.35",
            "*DENSITY",
            "1.1e-9,",
            "*SURFACE, NAME=UNDER",
            "PLASTIC_TIP, SNEG",
            "*SURFACE, NAME=OVER",
            "STEEL_TIP, SPOS",
            "*BOUNDARY",
            "BASE, 1, 2",
            "BASE, 4, 6",
            "",
        ]
    )


def main(picture: str | None = None) -> dict[str, float]:
    """Events of both runs and how well they agree."""
    with tempfile.TemporaryDirectory() as folder:
        (Path(folder) / "strips.inp").write_text(deck())
        result = creak.run(creak.make_study(STUDY, folder))
    reference, reduced = result.runs["reference"], result.runs["reduced"]
    match = result.agreement
    assert match is not None
    if picture:
        draw(result, picture)
    return {
        "unknowns": float(reduced.system.n),
        "unknowns_reference": float(reference.system.n),
        "events": float(len(reduced.events)),
        "matched": float(len(match.pairs)),
        "missed": float(len(match.missed)),
        "extra": float(len(match.extra)),
        "impulse_ratio": sum(e.impulse for e in reduced.events) / sum(e.impulse for e in reference.events),
        "energy_created": max(r.history.energy_created for r in result.runs.values()),
    }


def draw(result: creak.Result, picture: str) -> None:
    """Smallest gap and total force over the last period, and the impulse of each event in both runs."""
    import matplotlib.pyplot as plt

    figure, (top, low, last) = plt.subplots(3, 1, figsize=(8.0, 7.6), layout="constrained", sharex=True)
    begin, end = result.found.window
    for name, color, style in (("reference", "0.2", "-"), ("reduced", "C1", "--")):
        h = result.runs[name].history
        top.plot(1e3 * h.time, h.gap.min(axis=1), style, color=color, linewidth=1.2, label=name)
        low.plot(1e3 * h.time, h.force.sum(axis=1), style, color=color, linewidth=1.2, label=name)
        events = result.runs[name].events
        marker = "o" if name == "reference" else "x"
        t, impulse = zip(*((1e3 * e.t_start, 1e3 * e.impulse) for e in events), strict=True)
        last.plot(t, impulse, marker, color=color, markersize=8, label=name)
    top.set(ylabel="smallest gap, mm", title="Two strips on a shaking base: unreduced and reduced model")
    low.set(ylabel="contact force, N")
    last.set(ylabel="impulse of the event, N ms", xlabel="time (of events: their start), ms")
    last.set_ylim(bottom=0.0)
    for axis in (top, low, last):
        axis.set_xlim(1e3 * begin, 1e3 * end)
        axis.grid(color="0.9")
        axis.set_ylim(top=1.25 * axis.get_ylim()[1])
        axis.legend(loc="upper right", ncols=2)
    figure.savefig(picture, dpi=150)


if __name__ == "__main__":
    print(main(sys.argv[1] if len(sys.argv) > 1 else "two_strips.png"))
