"""ALPHA1, ALPHA2, G with W3 and GE with W4 act on the whole structure: springs, bushings, masses and added matrices."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from creak.arrays import to_dense
from creak.assembly.coupling import Driven, couple
from creak.assembly.damping import is_damped
from creak.assembly.part import Rayleigh, common_rayleigh, damps_by_itself, loose_system, part_system
from creak.errors import InputError
from creak.formats.abaqus.reader import read_deck
from creak.formats.abaqus.writer import write_deck
from creak.formats.nastran.reader import read_nastran
from creak.formats.nastran.writer import write_nastran
from creak.model.mesh import Model
from creak.studies.file.reader import read_study
from creak.studies.prepare.setup import set_up
from helpers_nastran import read

CHAIN = """GRID,1,,0.,0.,0.
GRID,2,,10.,0.,0.
GRID,3,,20.,0.,0.
GRID,4,,30.,0.,0.
GRID,5,,40.,0.,0.
CELAS2,1,300.,1,1,2,1,.05
PELAS,7,200.,.08
CELAS1,2,7,2,1,3,1
PBUSH,8,K,150.,10.,10.,10.,10.,10.
,GE,.12
CBUSH,3,8,3,4,,,,0
MAT1,1,1000.,,.3,1.-9,,,.2
PROD,9,1,2.0
CROD,4,9,4,5
CMASS2,11,.01,2,1
CONM2,12,3,,.03
CONM1,13,4,,.04
CONM2,14,5,,.02
CDAMP2,15,.02,2,1,5,1
SPC1,1,123456,1
SPC1,1,23456,2,THRU,5
"""
"""Grid 1 is held, grids 2 to 5 move along x."""
ADDED = "DMIG,KX,0,6,1,0\nDMIG,KX,3,1,,3,1,80.\nDMIG,MX,0,6,1,0\nDMIG,MX,2,1,,2,1,.005\n"
CASE = "SPC = 1\nK2GG = KX\nM2GG = MX\n"
PARAMS = {
    "ALPHA1": {"ALPHA1": 5.0},
    "ALPHA2": {"ALPHA2": 1e-3},
    "G": {"G": 0.03, "W3": 120.0},
    "G without W3": {"G": 0.03},
    "GE": {"W4": 90.0},
    "GE without W4": {},
    "all": {"ALPHA1": 5.0, "ALPHA2": 1e-3, "G": 0.03, "W3": 120.0, "W4": 90.0},
}


def chain(tmp_path: Path, given: dict[str, float], added: bool = True, more: str = "") -> Model:
    params = "".join(f"PARAM,{name},{value}\n" for name, value in given.items())
    return read(tmp_path, CHAIN + (ADDED if added else "") + params + more, CASE if added else "SPC = 1\n")


def own(given: dict[str, float], added: bool = True) -> list[np.ndarray]:
    """K, M, C (4, 4) by hand: B1 + ALPHA1 M + (ALPHA2 + G/W3) K + sum of GE/W4 K_e; a rod has EA/L and half its mass."""
    K, K4 = np.zeros((5, 5)), np.zeros((5, 5))
    for i, (k, loss) in enumerate([(300.0, 0.05), (200.0, 0.08), (150.0, 0.12), (200.0, 0.2)]):
        K[i : i + 2, i : i + 2] += k * np.array([[1.0, -1.0], [-1.0, 1.0]])
        K4[i : i + 2, i : i + 2] += loss * k * np.array([[1.0, -1.0], [-1.0, 1.0]])
    M = np.diag([0.0, 0.01, 0.03, 0.04 + 1e-8, 0.02 + 1e-8])
    if added:
        K[2, 2] += 80.0
        M[1, 1] += 0.005
    B1 = 0.02 * np.outer(*2 * [np.array([0.0, 1.0, 0.0, 0.0, -1.0])])
    beta = given.get("ALPHA2", 0.0) + (given["G"] / given["W3"] if "W3" in given else 0.0)
    C = B1 + given.get("ALPHA1", 0.0) * M + beta * K + (K4 / given["W4"] if "W4" in given else 0.0)
    return [A[1:, 1:] for A in (K, M, C)]


def computed(model: Model, common: Rayleigh | None = None, override: bool = False) -> list[np.ndarray]:
    """K, M, C of what is not held, along x; by default damped as the deck says."""
    common = common or common_rayleigh(model)
    parts = [part_system(model, i, common, override=override) for i in range(len(model.parts))]
    loose = loose_system(model, common)
    system = couple([*parts, loose] if loose else parts, model, Driven({}), common, override=override)
    wanted = [6 * model.nodes.ids.tolist().index(i) for i in (2, 3, 4, 5)]
    rows = to_dense(system.rows(np.array(wanted))[0])
    at = np.array([int(np.flatnonzero(row)[0]) for row in rows])
    d, K, M = system.damping, to_dense(system.K), to_dense(system.M)
    C = d.alpha * M + d.beta * K + (0.0 if d.extra is None else to_dense(d.extra))
    return [A[np.ix_(at, at)] for A in (K, M, C)]


def assert_same(one: list[np.ndarray], other: list[np.ndarray]) -> None:
    for a, b in zip(one, other, strict=True):
        np.testing.assert_allclose(a, b, rtol=0.0, atol=1e-12 * max(np.abs(b).max(), 1e-300))


@pytest.mark.parametrize("name", PARAMS)
def test_the_whole_structure_is_damped(tmp_path, name):
    model = chain(tmp_path, PARAMS[name])
    assert_same(computed(model), own(PARAMS[name]))
    lost = {u.keyword: u.changes_answer for u in model.unread if u.keyword.endswith("GE")}
    given = ("CELAS2, GE", "PELAS, GE", "PBUSH, GE", "MAT1, GE")
    assert lost == ({} if "W4" in PARAMS[name] else dict.fromkeys(given, False))


def test_structural_damping_that_does_not_act_in_time_is_told(tmp_path):
    """PARAM,G without W3 as GE without W4, with the modal damping that does the same at resonance."""
    found = {u.keyword: u for u in chain(tmp_path, {"G": 0.06}).unread if u.damps}
    assert "PARAM,W3" in found["PARAM,G"].why
    assert "modal = 0.03 " in found["PARAM,G"].why
    assert not found["PARAM,G"].changes_answer
    assert "PARAM,W4" in found["MAT1, GE"].why
    assert not [u for u in chain(tmp_path, {"G": 0.06, "W3": 9.0}).unread if u.keyword == "PARAM,G"]


def test_damping_of_a_bushing_is_no_share_for_all_modes(tmp_path):
    """That of a material is: `creak new` gives it to all modes where all materials have it."""
    found = {u.keyword: u for u in chain(tmp_path, {}).unread if u.damps}
    assert (found["MAT1, GE"].share, found["MAT1, GE"].share_of) == (pytest.approx(0.1), "MAT1 1")
    assert "modal = 0.1 " in found["MAT1, GE"].why
    assert found["PBUSH, GE"].share == 0.0
    assert "modal" not in found["PBUSH, GE"].why


def test_springs_alone_are_damped_by_one_number(tmp_path):
    """Without materials: C is beta K, with no matrix of its own, and the model counts as damped."""
    springs = "GRID,1\nGRID,2,,10.\nCELAS2,1,300.,1,1,2,1\nCELAS2,2,500.,2,1\nCONM2,3,1,,.1\nCONM2,4,2,,.1\n"
    model = read(tmp_path, springs + "PARAM,G,.1\nPARAM,W3,120.\n")
    common = common_rayleigh(model)
    assert (common.alpha, common.beta) == (0.0, pytest.approx(0.1 / 120.0, rel=1e-15))
    assert not damps_by_itself(model, common, override=False)
    assert is_damped(model)
    assert not is_damped(read(tmp_path, springs + "PARAM,G,.1\n"))


def blocks_c(model: Model, kinds: str) -> list[tuple[np.ndarray, float]]:
    """Stiffness and beta of the springs whose kind begins so."""
    return [(b.section.stiffness, b.section.beta) for b in model.blocks if b.kind.startswith(kinds)]


def test_springs_along_turned_axes(tmp_path):
    bulk = "CORD2R,5,,0.,0.,0.,0.,0.,1.\n,.6,.8,0.\nGRID,1,,1.,,,5\nGRID,2,,2.\nCONM2,9,1,,1.\nCONM2,10,2,,1.\n"
    bulk += "CELAS2,1,70.,1,1,,,.3\nCBUSH1D,2,2,1,2,5\nPBUSH1D,2,40.,1.,.2\nPARAM,W4,10.\nPARAM,G,.1\nPARAM,W3,20.\n"
    found = blocks_c(read(tmp_path, bulk), "nodal")
    assert sorted((float(np.trace(K)), beta) for K, beta in found) == [
        (pytest.approx(70.0), pytest.approx(0.3 / 10.0 + 0.1 / 20.0)),
        (pytest.approx(2.0 * 40.0), pytest.approx(0.1 / 20.0)),
    ]


@pytest.mark.parametrize(
    ("line", "losses"),
    [(",GE,.2", [0.2] * 6), (",GE,.2,.1,,.1,.2,.3", [0.2, 0.1, 0.0, 0.1, 0.2, 0.3]), ("", [0.0] * 6)],
    ids=["GE1 alone", "six", "none"],
)
def test_each_direction_of_a_bushing_has_its_own_ge(tmp_path, line, losses):
    """C = diag(B + GE K / W4); GE1 alone holds for all. What damps otherwise is a bushing beside the first."""
    k, b = np.array([1.0, 2.0, 3.0, 4.0, 5.0, 6.0]), np.array([0.5, 0.0, 0.7, 0.0, 0.0, 0.0])
    bulk = "GRID,1\nGRID,2\nCBUSH,3,5,1,2,,,,0\nPBUSH,5,K,1.,2.,3.,4.,5.,6.\n,B,.5,,.7\n" + line + "\nPARAM,W4,7.\n"
    model = read(tmp_path, bulk + "CONM2,20,1,,1.\nCONM2,21,2,,1.\n")
    bushings = [blk.section for blk in model.blocks if blk.kind == "bush2"]
    assert len(bushings) == len(set(losses))
    np.testing.assert_array_equal(sum(s.stiffness for s in bushings), np.diag(k))
    C = sum(s.damping + s.beta * s.stiffness for s in bushings)
    np.testing.assert_allclose(C, np.diag(b + k * losses / 7.0), rtol=1e-15)
    assert len(model.element_sets["PID_5"]) == len(bushings)


def test_ge_of_a_laminate_stands_for_that_of_its_plies(tmp_path):
    shell = "GRID,1\nGRID,2,,1.\nGRID,3,,1.,1.\nCTRIA3,1,7,1,2,3\nPCOMP,7,,,,,,{}\n,1,.2\nMAT1,1,1.+4,,.3,,,,.1\n"
    for ge, expected in ((".4", 0.4), ("", 0.1)):
        model = read(tmp_path, shell.format(ge) + "PARAM,W4,10.\n")
        assert model.blocks[0].section.beta == pytest.approx(expected / 10.0)
        write_nastran(model, tmp_path / "copy.bdf")
        assert read_nastran(tmp_path / "copy.bdf").blocks[0].section.beta == pytest.approx(expected / 10.0)


STUDY = """[model]
deck = "deck.bdf"
{}
[nodes.e]
labels = [5]
[excitation.f]
node_set = "e"
dof = "x"
kind = "force"
signal = {{ type = "half-sine", duration = 0.05, amplitude = 10.0 }}
[time]
end = 0.1
[output]
nodes = ["e"]
"""


@pytest.mark.parametrize(
    ("table", "alpha", "beta"),
    [("rayleigh = { alpha = 3.0, beta = 0.01 }", 3.0, 0.01), ("modal = 0.02", 0.0, 0.0)],
    ids=["rayleigh", "modal"],
)
def test_damping_of_a_study_replaces_all_but_dashpots(tmp_path, table, alpha, beta):
    """C = alpha M + beta K + B1 of a study with its own damping, whatever the deck's parameters say."""
    chain(tmp_path, PARAMS["all"])
    (tmp_path / "study.toml").write_text(STUDY.format("[damping]\n" + table), encoding="utf-8")
    setup = set_up(read_study(tmp_path / "study.toml"))
    K, M, B1 = own({})
    found = computed(setup.model, setup.structure.rayleigh, override=setup.structure.override_damping)
    assert_same(found, [K, M, alpha * M + beta * K + B1])


@pytest.mark.parametrize("name", PARAMS)
def test_a_nastran_deck_written_again_keeps_it(tmp_path, name):
    write_nastran(chain(tmp_path, PARAMS[name]), tmp_path / "copy.bdf")
    assert_same(computed(read_nastran(tmp_path / "copy.bdf")), own(PARAMS[name]))


@pytest.mark.parametrize("name", [n for n, given in PARAMS.items() if "ALPHA1" not in given])
def test_an_abaqus_deck_gets_dashpots(tmp_path, name):
    """Abaqus's springs have no damping of their own; connectors and dashpots have, and it is said which became some."""
    model = replace(chain(tmp_path, PARAMS[name]), mass_form="consistent")
    notes = write_deck(model, tmp_path / "copy.inp")
    copy = read_deck(tmp_path / "copy.inp")
    K, M, C = own(PARAMS[name])
    assert_same([A for k, A in enumerate(computed(copy)) if k != 1], [K, C])
    told = [n for n in notes if "is a dashpot in the deck" in n]
    assert len(told) == (4 if set(PARAMS[name]) & {"ALPHA2", "W3", "W4"} else 0) - (name == "GE")
    assert M.shape == (4, 4)


def test_what_an_abaqus_deck_cannot_say_of_masses_is_refused(tmp_path):
    model = replace(chain(tmp_path, PARAMS["ALPHA1"]), mass_form="consistent")
    with pytest.raises(InputError, match="times their mass"):
        write_deck(model, tmp_path / "copy.inp")


def test_masses_damped_unlike_the_materials_are_refused(tmp_path):
    """ALPHA1 acts on point masses as well: materials alone cannot have it."""
    model = chain(tmp_path, PARAMS["ALPHA1"], added=False)
    blocks = [replace(b, section=replace(b.section, alpha=0.0)) if b.kind == "mass" else b for b in model.blocks]
    with pytest.raises(InputError, match="mass-proportional"):
        write_nastran(replace(model, blocks=tuple(blocks)), tmp_path / "copy.bdf")
