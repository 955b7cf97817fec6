"""Static loads of Nastran decks before a run, from subcases and by number in a study: sag, heat and moved supports."""

from __future__ import annotations

import numpy as np
import pytest

from creak.errors import InputError
from creak.studies.file.reader import read_study
from creak.studies.prepare.deck_step import set_up_deck
from creak.studies.prepare.setup import set_up
from creak.studies.run.job import run_study

LENGTH, SIDE, MODULUS, DENSITY, GRAVITY, N = 200.0, 2.0, 210000.0, 7.85e-9, 9810.0, 8
EI, WEIGHT = MODULUS * SIDE**4 / 12.0, DENSITY * SIDE**2 * GRAVITY
SAG, GIVE = WEIGHT * LENGTH**4 / (8.0 * EI), LENGTH**3 / (3.0 * EI)
ALPHA, WARM = 1.2e-5, 60.0
GROWTH = ALPHA * WARM * LENGTH
MAT = f"MAT1,1,{MODULUS},,.3,{DENSITY},{ALPHA},\n"
BEAM = (
    "".join(f"GRID,{i + 1},,{LENGTH * i / N},0.,0.\n" for i in range(N + 1))
    + "".join(f"CBAR,{i + 1},1,{i + 1},{i + 2},0.,1.,0.\n" for i in range(N))
    + f"PBAR,1,1,{SIDE**2},{SIDE**4 / 12},{SIDE**4 / 12},{SIDE**4 / 7.1}\n"
    + f"SPC1,1,123456,1\nPARAM,COUPMASS,1\nTSTEP,5,100,1.-4\nTSTEPNL,6,100,1.-4,1\nSPC1,2,3,{N + 1}\nSPCADD,3,1,2\n"
)
GRAV = f"GRAV,10,,{GRAVITY},0.,0.,-1.\n"
FORCE = f"FORCE,11,{N + 1},,.1,0.,0.,2.\n"
BOTH = "LOAD,12,2.,.5,10,1.,11\n"
MOVED = f"SPCD,13,{N + 1},3,.7\n"
HEAT = "TEMPD,20,80.,21,20.\n"
CARDS = GRAV + FORCE + BOTH + MOVED + HEAT + MAT
CONTROL = "DISPLACEMENT = 1\nSET 1 = 9\n"


def deck(folder, case: str, cards: str = CARDS, solution: str = "109"):
    path = folder / "beam.bdf"
    path.write_text(f"SOL {solution}\nCEND\n{CONTROL}{case}BEGIN BULK\n{BEAM}{cards}ENDDATA\n", encoding="utf-8")
    return path


def tip(setup, dof: int) -> list[np.ndarray]:
    """Motion of the tip in every run."""
    runs = run_study(setup, lambda *_: None).runs
    return [one.history.displacement[:, dof] for one in runs.values()]


def starts_and_stays(setup, dof: int, place: float) -> None:
    for u in tip(setup, dof):
        assert u[0] == pytest.approx(place, rel=1e-3)
        assert np.abs(u - u[0]).max() <= 1e-9 * abs(place)


BEFORE = "SPC = 1\nSUBCASE 1\nLOAD = 10\nSUBCASE 2\nTSTEP = 5\n"
CASES = {
    "gravity": (BEFORE, 2, -SAG),
    "force": (BEFORE.replace("LOAD = 10", "LOAD = 11"), 2, 0.2 * GIVE),
    "both": (BEFORE.replace("LOAD = 10", "LOAD = 12"), 2, 2.0 * (0.2 * GIVE - 0.5 * SAG)),
    "named": ("SPC = 1\nSUBCASE 7\nLOAD = 10\nSUBCASE 8\nLOAD = 11\nSUBCASE 9\nIC(STATSUB) = 7\nTSTEP = 5\n", 2, -SAG),
    "moved": (BEFORE.replace("SPC = 1", "SPC = 3").replace("LOAD = 10", "LOAD = 13"), 2, 0.7),
    "heat": (BEFORE.replace("LOAD = 10", "TEMPERATURE(LOAD) = 20\nTEMPERATURE(INITIAL) = 21"), 0, GROWTH),
    "from zero": (BEFORE.replace("LOAD = 10", "TEMP(LOAD) = 20"), 0, GROWTH * 80.0 / WARM),
}


@pytest.mark.parametrize("case", CASES)
def test_a_transient_starts_from_the_static_subcase(tmp_path, case):
    text, dof, place = CASES[case]
    starts_and_stays(set_up_deck(deck(tmp_path, text)), dof, place)


def test_heat_closes_a_gap_of_the_deck(tmp_path):
    """The bar presses with (alpha dT L - gap)/(L/EA + 1/k)."""
    gap, k = 0.05, 5000.0
    wall = f"GRID,20,,{LENGTH + 1.0},0.,0.,,123456\nCGAP,50,50,{N + 1},20\nPGAP,50,{gap},,{k}\n"
    force = (GROWTH - gap) / (LENGTH / (MODULUS * SIDE**2) + 1.0 / k)
    setup = set_up_deck(deck(tmp_path, CASES["heat"][0], CARDS + wall))
    starts_and_stays(setup, 0, gap + force / k)
    (run,) = run_study(setup, lambda *_: None).runs.values()
    assert run.history.force[:, 0] == pytest.approx(np.full(run.history.time.size, force), rel=1e-3)


def test_tref_goes_before_the_initial_temperature(tmp_path):
    path = deck(tmp_path, CASES["heat"][0], CARDS.replace(f"{ALPHA},\n", f"{ALPHA},50.\n"))
    starts_and_stays(set_up_deck(path), 0, GROWTH * 30.0 / WARM)


@pytest.mark.parametrize("solution", ["112", "129"])
def test_other_transients_start_so_too(tmp_path, solution):
    text = BEFORE if solution == "112" else BEFORE.replace("TSTEP = 5", "TSTEPNL = 6")
    starts_and_stays(set_up_deck(deck(tmp_path, text, solution=solution)), 2, -SAG)


REST = '[reduction]\nf_max = 2000\n[time]\nend = 0.01\n[output]\nnodes = "SET_1"\n'


def study(folder, tables: str, cards: str = CARDS, spc: int = 1):
    deck(folder, f"SPC = {spc}\n", cards, "103")
    path = folder / "study.toml"
    path.write_text(f'[model]\ndeck = "beam.bdf"\n[reference]\nrun = true\n{tables}{REST}', encoding="utf-8")
    return set_up(read_study(path))


def by_number(number: int) -> str:
    return f"[[static]]\ndeck_loads = {number}\n"


@pytest.mark.parametrize(
    ("number", "spc", "dof", "place"),
    [(10, 1, 2, -SAG), (12, 1, 2, 0.4 * GIVE - SAG), (13, 3, 2, 0.7), (20, 1, 0, GROWTH * 80.0 / WARM)],
)
def test_a_study_names_loads_of_the_deck(tmp_path, number, spc, dof, place):
    """Reduced and unreduced."""
    setup = study(tmp_path, by_number(number), spc=spc)
    starts_and_stays(setup, dof, place)


def test_gravity_of_deck_and_study_agree(tmp_path):
    (one, other), (plain, _) = (
        tip(study(tmp_path, t), 2) for t in (by_number(10), f"[[static]]\ngravity = [0, 0, {-GRAVITY}]\n")
    )
    assert one[0] == pytest.approx(plain[0], rel=1e-12)
    assert other[0] == pytest.approx(one[0], rel=1e-12)


def test_abaqus_and_nastran_sag_alike(tmp_path):
    lines = ["*NODE", *(f"{i + 1}, {LENGTH * i / N}, 0., 0." for i in range(N + 1)), "*ELEMENT, TYPE=B33, ELSET=BEAM"]
    lines += [f"{i + 1}, {i + 1}, {i + 2}" for i in range(N)]
    lines += ["*BEAM SECTION, SECTION=RECT, ELSET=BEAM, MATERIAL=S", f"{SIDE}, {SIDE}", "0., 1., 0.", "*NSET, NSET=TIP"]
    lines += [f"{N + 1}", "*MATERIAL, NAME=S", "*ELASTIC", f"{MODULUS}, .3", "*DENSITY", f"{DENSITY},"]
    lines += ["*BOUNDARY", "1, 1, 6", "*STEP", "*STATIC", "*DLOAD", f"BEAM, GRAV, {GRAVITY}, 0., 0., -1.", "*END STEP"]
    lines += ["*STEP", "*DYNAMIC, DIRECT", "1.E-4, 0.01", "*NODE OUTPUT, NSET=TIP", "U", "*END STEP"]
    path = tmp_path / "beam.inp"
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")
    (abaqus,), (nastran,) = tip(set_up_deck(path), 2), tip(set_up_deck(deck(tmp_path, BEFORE)), 2)
    assert abaqus[0] == pytest.approx(-SAG, rel=1e-3)
    assert nastran[0] == pytest.approx(abaqus[0], rel=1e-6)


REFUSED = {
    "line load": (BEFORE, CARDS + "PLOAD1,10,1,FZ,FR,0.,2.\n", "PLOAD1 of load set 10 is not read"),
    "gradient": (
        BEFORE.replace("LOAD = 10", "TEMP(LOAD) = 20"),
        CARDS + "TEMPRB,20,1,80.\n",
        "TEMPRB of temperature set",
    ),
    "not there": (BEFORE.replace("LOAD = 10", "LOAD = 99"), CARDS, "LOAD = 99 in the case control, but no card"),
    "no heat": (BEFORE.replace("LOAD = 10", "TEMP(LOAD) = 99"), CARDS, "TEMPERATURE = 99 in the case control"),
    "no subcase": (BEFORE.replace("TSTEP", "IC(STATSUB) = 5\nTSTEP"), CARDS, "no such subcase"),
    "other supports": (BEFORE.replace("LOAD", "SPC = 3\nLOAD"), CARDS, "takes SPC = 3, the transient one 1"),
    "gravity in time": (
        "SPC = 1\nTSTEP = 5\nDLOAD = 7\n",
        CARDS + "TLOAD1,7,10,,,8\nTABLED1,8\n,0.,1.,1.,1.,ENDT\n",
        "GRAV",
    ),
    "its stress too": (BEFORE.replace("TSTEP", "IC(STATSUB,DIFFK) = 1\nTSTEP"), CARDS, "STATSUB"),
    "its stress": (BEFORE.replace("TSTEP", "STATSUB = 1\nTSTEP"), CARDS, "STATSUB"),
    "heat in time": ("SPC = 1\nSUBCASE 1\nTSTEP = 5\nTEMP(LOAD) = 20\n", CARDS, "TEMPERATURE\\(LOAD\\)"),
}


@pytest.mark.parametrize("case", REFUSED)
def test_what_a_run_cannot_start_from_is_refused(tmp_path, case):
    text, cards, match = REFUSED[case]
    with pytest.raises(InputError, match=match):
        set_up_deck(deck(tmp_path, text, cards))


def test_a_study_is_refused_only_the_loads_that_it_names(tmp_path):
    cards = CARDS + "PLOAD1,30,1,FZ,FR,0.,2.\n"
    study(tmp_path, by_number(10), cards)
    with pytest.raises(InputError, match="PLOAD1 of load set 30 is not read"):
        study(tmp_path, by_number(30), cards)
    with pytest.raises(InputError, match="no static loads '99'"):
        study(tmp_path, by_number(99), cards)
    for more, match in (
        ("LOAD,30,1.,1.,77\n", "uses load set 77, which is not defined"),
        ("GRAV,30,,9.81\n", "no direction"),
    ):
        with pytest.raises(InputError, match=match):
            study(tmp_path, by_number(30), CARDS + more)


def test_a_later_table_replaces_temperatures_of_the_deck(tmp_path):
    tables = by_number(20) + "[[static]]\ntemperature = 40\nreference = 10\n"
    starts_and_stays(study(tmp_path, tables), 0, GROWTH * 30.0 / WARM)


def test_loads_of_the_transient_subcase_are_told(tmp_path):
    setup = set_up_deck(deck(tmp_path, "SPC = 1\nSUBCASE 1\nLOAD = 10\nTSTEP = 5\n"))
    assert any(u.keyword == "LOAD" and "static subcase" in u.why for u in setup.model.unread)
    assert setup.study.config.static == []
