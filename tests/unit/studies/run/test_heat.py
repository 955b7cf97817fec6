"""Heat before a run: expansion, clamped forces, bimetal and gaps that close against closed forms, and rest after it."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from creak.errors import InputError
from creak.studies.file.reader import read_study
from creak.studies.prepare.deck_step import set_up_deck
from creak.studies.prepare.setup import Setup, set_up
from creak.studies.run.job import StudyResult, run_study

RECORDED = {"section": "contact"}

LENGTH, SIDE, MODULUS, ALPHA, COLD, WARM, N = 200.0, 2.0, 210000.0, 1.2e-5, 20.0, 80.0, 4
AREA, GROWTH = SIDE**2, ALPHA * (WARM - COLD) * LENGTH
STIFF, GAP = 5000.0, 0.05
PRESSED = (GROWTH - GAP) / (LENGTH / (MODULUS * AREA) + 1.0 / STIFF)
"""N of the stop, which lies GAP before the end of the bar."""
EXACT = 1e-3
STEEL = f"*MATERIAL, NAME=STEEL\n*ELASTIC\n{MODULUS}, 0.3\n*DENSITY\n7.85e-9,\n*DAMPING, ALPHA=5., BETA=2.e-6\n"
EXPANDS = f"*EXPANSION, ZERO=5.\n{ALPHA},\n"
BAR = (
    "*NODE\n"
    + "".join(f"{i + 1}, {LENGTH * i / N}, 0., 0.\n" for i in range(N + 1))
    + f"{N + 2}, {LENGTH}, 0., 0.\n*ELEMENT, TYPE=B31, ELSET=BEAM\n"
    + "".join(f"{i + 1}, {i + 1}, {i + 2}\n" for i in range(N))
    + f"*NSET, NSET=TIP\n{N + 1}\n*NSET, NSET=ROOT\n1\n*NSET, NSET=ALL, GENERATE\n1, {N + 1}\n"
    + f"*BEAM SECTION, SECTION=RECT, ELSET=BEAM, MATERIAL=STEEL\n{SIDE}, {SIDE}\n0., 1., 0.\n*BOUNDARY\nROOT, 1, 6\n"
)
REST = '[reduction]\nf_max = 20000\n[time]\nend = 0.002\n[output]\nnodes = "TIP"\n'
HEAT = f"[[static]]\ntemperature = {WARM}\nreference = {COLD}\n"
STOP = (
    f'[[connector]]\ntype = "play"\nname = "stop"\nnodes = "TIP"\ndof = "x"\nupper = {GAP}\nlower = -1.0\n'
    f"stiffness = {STIFF}\n"
)


def study(folder: Path, tables: str, deck: str = BAR + STEEL + EXPANDS) -> Setup:
    (folder / "bar.inp").write_text(deck, encoding="utf-8")
    path = folder / "study.toml"
    whole = "" if "[reference]" in tables else "[reference]\nrun = true\n"
    path.write_text(f'[model]\ndeck = "bar.inp"\n{whole}{tables}{REST}', encoding="utf-8")
    return set_up(read_study(path))


def run(setup: Setup) -> StudyResult:
    return run_study(setup, lambda *_: None)


def stays(result: StudyResult, dof: int, tip: float, force: float = 0.0) -> None:
    """Every model starts at the closed form of the tip and of the stop's force, and stays there."""
    for one in result.runs.values():
        h = one.history
        assert h.displacement[0, dof] == pytest.approx(tip, rel=EXACT)
        assert np.abs(h.displacement - h.displacement[0]).max() <= 1e-9 * abs(tip)
        pressed = h.force.sum(axis=1) if h.force.size else np.zeros(h.time.size)
        assert pressed[0] == pytest.approx(force, rel=EXACT, abs=1e-12)
        assert np.abs(pressed - pressed[0]).max() <= 1e-9 * max(force, 1.0)


def test_a_free_bar_grows(tmp_path):
    result = run(study(tmp_path, HEAT))
    assert set(result.runs) == {"reduced", "reference"}
    stays(result, 0, GROWTH)
    assert any("60 to 60 degrees above" in note for note in result.setup.notes)


def test_a_gap_closes_in_heat_and_the_stop_presses(tmp_path, measured):
    result = run(study(tmp_path, HEAT + STOP))
    stays(result, 0, GAP + PRESSED / STIFF, PRESSED)
    assert result.setup.static is not None
    source = "(alpha dT L - gap)/(L/EA + 1/k)"
    found = result.setup.static.state.force.sum()
    measured("bar that heat drives against a stop: force", found, PRESSED, rel=EXACT, unit="N", source=source)


def test_a_clamped_bar_presses_with_e_a_alpha_dt(tmp_path, measured):
    wall = STOP.replace(str(GAP), "0.0").replace(str(STIFF), "1e10")
    found = run(study(tmp_path, HEAT + wall)).setup.static.state.force.sum()
    wanted = MODULUS * AREA * ALPHA * (WARM - COLD)
    measured("clamped bar in heat: force", found, wanted, rel=EXACT, unit="N", source="E A alpha dT")


HOW = {
    "part": (f'[[static]]\ntemperature = {WARM}\nreference = {COLD}\npart = "BEAM"\n', 1.0),
    "later table": (HEAT + f'[[static]]\ntemperature = {COLD}\nreference = {COLD}\nnode_set = "ALL"\n' + HEAT, 1.0),
    "root only": (HEAT + 'node_set = "ROOT"\n', 0.5 / N),
    "file": ('[[static]]\ntemperature = "warm.csv"\nreference = 20\n', 0.5),
    "deck's reference": (f"[[static]]\ntemperature = {WARM}\n", 1.0),
}


@pytest.mark.parametrize("how", HOW)
def test_places_of_a_temperature(tmp_path, how):
    """A file that rises from the reference at the root to WARM at the tip heats by half on average."""
    tables, share = HOW[how]
    rows = "".join(f"{i + 1},{COLD + (WARM - COLD) * i / N}\n" for i in range(N + 1))
    (tmp_path / "warm.csv").write_text("node,temperature\n" + rows, encoding="utf-8")
    deck = BAR + STEEL + EXPANDS
    deck += f"*INITIAL CONDITIONS, TYPE=TEMPERATURE\nALL, {COLD}\n" if how == "deck's reference" else ""
    stays(run(study(tmp_path, tables + "[reference]\nrun = true\n", deck)), 0, share * GROWTH)


HEATED = f"*INITIAL CONDITIONS, TYPE=TEMPERATURE\nALL, {COLD}\n*STEP\n*STATIC\n*TEMPERATURE\nALL, {WARM}\n*END STEP\n"
DYNAMIC = "*STEP\n*DYNAMIC, DIRECT, ALPHA=-0.05\n1.E-4, 0.002\n*NODE OUTPUT, NSET=TIP\nU\n*END STEP\n"


def deck_run(folder: Path, steps: str, material: str = STEEL + EXPANDS) -> StudyResult:
    path = folder / "bar.inp"
    path.write_text(BAR + material + steps + DYNAMIC, encoding="utf-8")
    return run(set_up_deck(path))


@pytest.mark.parametrize(
    ("steps", "share"),
    [
        (HEATED, 1.0),
        (HEATED + "*STEP\n*STATIC\n*TEMPERATURE\nALL, 50.\n*END STEP\n", 0.5),
        (HEATED + "*STEP\n*STATIC\n*TEMPERATURE, OP=NEW\nROOT, 80.\n*END STEP\n", 0.5 / N),
        (HEATED.replace("*INITIAL CONDITIONS, TYPE=TEMPERATURE\nALL, 20.0\n", ""), WARM / (WARM - COLD)),
    ],
)
def test_temperatures_of_static_steps(tmp_path, steps, share):
    stays(deck_run(tmp_path, steps), 0, share * GROWTH)


STRIP, WIDTH, LOW, HIGH = 40.0, 2.0, 0.8, 0.5
E_LOW, E_HIGH, A_LOW, A_HIGH = 2.1e5, 7e4, 1.2e-5, 2.4e-5


def bimetal() -> float:
    """Tip deflection of a strip clamped at its root (Timoshenko, J. Opt. Soc. Am. 11 (1925) 233)."""
    h, m, n = LOW + HIGH, LOW / HIGH, E_LOW / E_HIGH
    bent = 6.0 * (A_HIGH - A_LOW) * (WARM - COLD) * (1 + m) ** 2
    return -bent / (h * (3 * (1 + m) ** 2 + (1 + m * n) * (m * m + 1 / (m * n)))) * STRIP**2 / 2.0


def metals() -> str:
    """Without Poisson's ratio, as in a beam."""
    pairs = (("LOW", E_LOW, A_LOW), ("HIGH", E_HIGH, A_HIGH))
    return "".join(f"*MATERIAL, NAME={n}\n*ELASTIC\n{e}, 0.\n*DENSITY\n5.e-9,\n*EXPANSION\n{a},\n" for n, e, a in pairs)


def strip(kind: str) -> str:
    count = 8
    heights = (-LOW, 0.0, HIGH) if kind == "solids" else (0.0,)
    points = [(x, y, z) for z in heights for x in np.linspace(0.0, STRIP, count + 1) for y in (0.0, WIDTH)]
    lines = ["*NODE", *(f"{k + 1}, {x}, {y}, {z}" for k, (x, y, z) in enumerate(points))]
    quads = [(2 * i + 1, 2 * i + 3, 2 * i + 4, 2 * i + 2) for i in range(count)]
    layer = 2 * (count + 1)
    if kind == "solids":
        lines += ["*ELEMENT, TYPE=C3D8I, ELSET=A"]
        lines += [f"{k + 1}, {', '.join(str(n) for n in (*q, *(n + layer for n in q)))}" for k, q in enumerate(quads)]
        lines += ["*ELEMENT, TYPE=C3D8I, ELSET=B"]
        for k, q in enumerate(quads):
            lines += [f"{k + 101}, {', '.join(str(n + layer) for n in (*q, *(n + layer for n in q)))}"]
        lines += ["*SOLID SECTION, ELSET=A, MATERIAL=LOW", "*SOLID SECTION, ELSET=B, MATERIAL=HIGH"]
    else:
        lines += [
            "*ELEMENT, TYPE=S4, ELSET=A",
            *(f"{k + 1}, {a}, {b}, {c}, {d}" for k, (a, b, c, d) in enumerate(quads)),
        ]
    if kind == "laminate":
        lines += ["*SHELL SECTION, ELSET=A, COMPOSITE", f"{LOW}, 3, LOW, 0.", f"{HIGH}, 3, HIGH, 0."]
    if kind == "offsets":
        lines += ["*SHELL SECTION, ELSET=A, MATERIAL=LOW, OFFSET=SPOS", f"{LOW}"]
        lines += ["*ELEMENT, TYPE=S4, ELSET=B"]
        lines += [f"{101 + k}, {a}, {b}, {c}, {d}" for k, (a, b, c, d) in enumerate(quads)]
        lines += ["*SHELL SECTION, ELSET=B, MATERIAL=HIGH, OFFSET=SNEG", f"{HIGH}"]
    tip = [k + 1 for k, p in enumerate(points) if p[0] == STRIP]
    root = [k + 1 for k, p in enumerate(points) if p[0] == 0.0]
    lines += ["*NSET, NSET=TIP", f"{tip[0]}", "*NSET, NSET=ROOT", ", ".join(map(str, root)), "*BOUNDARY"]
    lines += ["ROOT, 1, 1", f"{root[0]}, 2, 3", f"{root[1]}, 3, 3"]
    lines += [] if kind == "solids" else ["ROOT, 5, 5"]
    return "\n".join(lines) + "\n" + metals()


@pytest.mark.parametrize("kind", ["laminate", "offsets", "solids"])
def test_bimetal_strip(tmp_path, kind, measured):
    result = run(study(tmp_path, HEAT, strip(kind)))
    stays(result, 2, bimetal())
    found = result.runs["reference"].history.displacement[0, 2]
    measured(
        f"bimetal strip of {kind}: tip",
        found,
        bimetal(),
        rel=EXACT,
        unit="mm",
        source="Timoshenko 1925",
        section="beams and solids",
    )


REFUSED = {
    "no reference": (
        f"[[static]]\ntemperature = {WARM}\n",
        "",
        "no temperature without strain is known of material STEEL",
    ),
    "no expansion": (HEAT, EXPANDS, "strains nothing"),
    "not warmer": (HEAT.replace("80.0", "20.0"), "", "strains nothing"),
    "by temperature": (HEAT, ("\n1.2e-05,\n", "\n1.2e-05, 0.\n1.3e-05, 100.\n"), "depends on temperature"),
    "too few": (HEAT, ("*EXPANSION,", "*EXPANSION, TYPE=ORTHO,"), "fewer than 3 coefficients"),
    "by subroutine": (HEAT, ("*EXPANSION,", "*EXPANSION, USER,"), "is none by constants"),
    "unknown part": (HEAT + 'part = "DOOR"\n', "", "unknown part 'DOOR'"),
    "unknown node": ('[[static]]\ntemperature = "warm.csv"\nreference = 20\n', "", "unknown node 77"),
    "dof": (HEAT + 'dof = "x"\n', "", "a temperature has no dof"),
    "reference of gravity": ("[[static]]\ngravity = [0, 0, -9810]\nreference = 20\n", "", "knows neither reference"),
    "unknown loads": ('[[static]]\ndeck_loads = "10"\n', "", "no static loads '10'"),
}


@pytest.mark.parametrize("case", REFUSED)
def test_what_cannot_be_heated_is_refused(tmp_path, case):
    tables, taken, match = REFUSED[case]
    old, new = taken if isinstance(taken, tuple) else (taken, "")
    (tmp_path / "warm.csv").write_text("node,temperature\n1,80\n77,80\n", encoding="utf-8")
    with pytest.raises(InputError, match=match):
        study(tmp_path, tables, (BAR + STEEL + EXPANDS).replace(old, new) if old else BAR + STEEL + EXPANDS)


def test_the_table_without_a_reference_is_named(tmp_path):
    """The first of two has one."""
    tables = HEAT + f'[[static]]\ntemperature = {WARM}\nnode_set = "TIP"\n'
    with pytest.raises(InputError, match=r":8 \[static\.1\]: no temperature without strain"):
        study(tmp_path, tables, BAR + STEEL + EXPANDS)


def test_refused_in_decks(tmp_path):
    for steps, match in (
        (HEATED.replace(f"ALL, {WARM}", "ALL, 80., 2."), "vary through the section"),
        (HEATED.replace("*TEMPERATURE\n", "*TEMPERATURE, FILE=job\n"), "\\*TEMPERATURE, FILE"),
        (HEATED.replace("*TEMPERATURE\n", "*TEMPERATURE, AMPLITUDE=RISE\n"), "has an AMPLITUDE"),
        (HEATED.replace(f"ALL, {WARM}", "NONE, 80."), "unknown node set 'NONE'"),
    ):
        with pytest.raises(InputError, match=match):
            deck_run(tmp_path, steps)


def test_what_is_heated_and_does_not_expand_is_told(tmp_path):
    """A rigid coupling at the tip keeps its length; a deck with temperatures that nothing uses runs as before."""
    coupled = BAR + STEEL + EXPANDS + f"*SURFACE, TYPE=NODE, NAME=END\nTIP\n*COUPLING, REF NODE={N + 2}, "
    coupled += "CONSTRAINT NAME=C, SURFACE=END\n*KINEMATIC\n"
    assert any("do not expand: they keep their length" in n for n in study(tmp_path, HEAT, coupled).notes)
    plain = study(tmp_path, "[[static]]\ngravity = [0, 0, -9810]\n", BAR + STEEL + EXPANDS + HEATED)
    assert any(u.keyword.startswith("*INITIAL CONDITIONS") and not u.changes_answer for u in plain.model.unread)
    assert not any("heat" in note for note in plain.notes)
