"""Static start: gravity, forces, moved supports, press fits and stops against closed forms, and rest that stays rest."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from creak.errors import InputError
from creak.studies.file.reader import read_study
from creak.studies.prepare.setup import set_up
from creak.studies.run.job import StudyResult, run_study
from helpers_decks import write_study
from helpers_findings import summarised
from helpers_refusal import refusal

LENGTH, SIDE, MODULUS, DENSITY, GRAVITY, N = 200.0, 2.0, 210000.0, 7.85e-9, 9810.0, 8
EI, WEIGHT = MODULUS * SIDE**4 / 12.0, DENSITY * SIDE**2 * GRAVITY
"""N mm2, N/mm"""
GIVE = LENGTH**3 / (3.0 * EI)
"""mm/N at the tip."""
SAG = WEIGHT * LENGTH**4 / (8.0 * EI)
BEAM = (
    "*NODE\n"
    + "".join(f"{i + 1}, {LENGTH * i / N}, 0., 0.\n" for i in range(N + 1))
    + "*ELEMENT, TYPE=B31, ELSET=BEAM\n"
    + "".join(f"{i + 1}, {i + 1}, {i + 2}\n" for i in range(N))
    + f"*NSET, NSET=TIP\n{N + 1}\n*NSET, NSET=ROOT\n1\n*NSET, NSET=ALL, GENERATE\n1, {N + 1}\n"
    + f"*MATERIAL, NAME=STEEL\n*ELASTIC\n{MODULUS}, 0.3\n*DENSITY\n{DENSITY},\n*DAMPING, ALPHA=5., BETA=2.e-6\n"
    + f"*BEAM SECTION, SECTION=RECT, ELSET=BEAM, MATERIAL=STEEL\n{SIDE}, {SIDE}\n0., 1., 0.\n"
)
HELD = BEAM + "*BOUNDARY\nROOT, 1, 6\n"
LED = BEAM + "*BOUNDARY\nROOT, 1, 2\nROOT, 4, 6\n"
"""Its root is free to be moved along z."""
SPRING = 50.0
STOP = f'[[connector]]\ntype = "play"\nname = "stop"\nnodes = "TIP"\ndof = "z"\nstiffness = {SPRING}\n'
DOWN = f"[[static]]\ngravity = [0, 0, {-GRAVITY}]\n"
REST = '[reduction]\nf_max = 2000\n[time]\nend = 0.01\naccuracy = "quick"\n[output]\nnodes = "TIP"\ninterval = 1e-4\n'
FORCED = REST.replace('accuracy = "quick"', "step = 1e-4")
EXACT = 1e-3
"""Of all closed forms."""


def tip_force(value: float) -> str:
    return f'[[static]]\nforce = {value}\nnode_set = "TIP"\ndof = "z"\n'


def study(folder: Path, deck: str, tables: str, rest: str = REST) -> Path:
    return write_study(
        folder, f'[model]\ndeck = "beam.inp"\n[reference]\nrun = true\n{tables}{rest}', {"beam.inp": deck}
    )


def run(folder: Path, deck: str, tables: str, rest: str = REST) -> StudyResult:
    return run_study(set_up(read_study(study(folder, deck, tables, rest))), lambda *_: None)


def stays(result: StudyResult, tip: float, force: float) -> None:
    """Both models start at the closed form of the tip and of the stop's force, and stay there."""
    assert set(result.runs) == {"reduced", "reference"}
    for one in result.runs.values():
        h = one.history
        assert h.displacement[0, 2] == pytest.approx(tip, rel=EXACT)
        assert np.abs(h.displacement - h.displacement[0]).max() <= 1e-9 * abs(tip)
        pressed = h.force.sum(axis=1) if h.force.size else np.zeros(h.time.size)
        assert pressed[0] == pytest.approx(force, rel=EXACT, abs=1e-12)
        assert np.abs(pressed - pressed[0]).max() <= 1e-9 * max(force, 1.0)
        assert not one.events
    figures = summarised(result)
    assert figures["static"]["residual"] < 1e-9
    assert figures["static"]["energy_error"] < 1e-9
    assert figures["static"]["nodes"][str(N + 1)]["z"] == pytest.approx(tip, rel=EXACT)
    assert all(r["verdict"] != "unreliable" for r in figures["runs"].values() if "verdict" in r)


@pytest.mark.parametrize("rest", [REST, FORCED], ids=["exact", "hht"])
def test_gravity_sag_of_a_cantilever(tmp_path, rest):
    stays(run(tmp_path, HELD, DOWN, rest), -SAG, 0.0)


@pytest.mark.parametrize("rest", [REST, FORCED], ids=["exact", "hht"])
def test_a_beam_sags_onto_its_stop(tmp_path, rest):
    clear = 0.4 * SAG
    force = (SAG - clear) / (GIVE + 1.0 / SPRING)
    stays(run(tmp_path, HELD, DOWN + f"{STOP}lower = {-clear}\n", rest), -clear - force / SPRING, force)


def test_a_squeezed_clip_presses_the_beam_away(tmp_path):
    squeezed = 0.7
    force = squeezed / (GIVE + 1.0 / SPRING)
    result = run(tmp_path, HELD, f"[[static]]\npress_fit = true\n{STOP}lower = {squeezed}\n")
    stays(result, GIVE * force, force)
    stop = summarised(result)["static"]["contacts"]["stop"]
    assert stop["force"] == pytest.approx(force, rel=EXACT)


BLOCK, SOFT, OVERLAP, PER_AREA = 10.0, 2000.0, 0.02, 1e5
"""Edge and modulus of two cubes that overlap, and the stiffness of their contact."""


def overlapping_cubes() -> str:
    """Cubes without lateral strain between two walls, the lower of 2 x 2 elements across, the upper of 3 x 3."""
    nodes, elements, low, high = [], [], [], []
    for n, z, name in ((2, 0.0, "LOWER"), (3, BLOCK - OVERLAP, "UPPER")):
        at = np.arange((n + 1) ** 2 * 2).reshape(n + 1, n + 1, 2) + len(nodes) + 1
        step = BLOCK / n
        nodes += [f"{at[i, j, k]}, {i * step}, {j * step}, {z + k * BLOCK}\n" for i, j, k in np.ndindex(at.shape)]
        elements.append(f"*ELEMENT, TYPE=C3D8, ELSET={name}\n")
        for i, j in np.ndindex(n, n):
            square = at[[i, i + 1, i + 1, i], [j, j, j + 1, j + 1]].T
            elements.append(f"{100 * n + n * i + j}, {', '.join(map(str, square.ravel()))}\n")
        low, high = low or at[:, :, 0].ravel().tolist(), at[:, :, 1].ravel().tolist()
    return (
        "".join(["*NODE\n", *nodes, *elements])
        + "*NSET, NSET=WALLS\n"
        + "".join(f"{k},\n" for k in [*low, *high])
        + f"*NSET, NSET=ALL, GENERATE\n1, {len(nodes)}\n*SURFACE, NAME=TOP\nLOWER, S2\n*SURFACE, NAME=BOTTOM\nUPPER, S1\n"
        + f"*MATERIAL, NAME=M\n*ELASTIC\n{SOFT}, 0.\n*DENSITY\n1e-9,\n*DAMPING, ALPHA=5., BETA=2.e-6\n"
        + "*SOLID SECTION, ELSET=LOWER, MATERIAL=M\n*SOLID SECTION, ELSET=UPPER, MATERIAL=M\n"
        + "*BOUNDARY\nWALLS, 3, 3\nALL, 1, 2\n"
    )


@pytest.mark.parametrize("how", ["geometry", "clearance"])
def test_surfaces_that_overlap_are_pressed_apart(tmp_path, how):
    """p = overlap / (2 L / E + 1 / k_A) between cubes whose meshes do not match; an overlap of the deck or the study's."""
    deck, tables = overlapping_cubes(), f"[contact.fit]\nsecondary = 'BOTTOM'\nmain = 'TOP'\nstiffness = {PER_AREA}\n"
    if how == "clearance":
        tables += f"clearance = {-OVERLAP}\n"
    rest = REST.replace("2000", "200000").replace("0.01", "0.001").replace("1e-4", "1e-5").replace("TIP", "WALLS")
    result = run(tmp_path, deck, f"{tables}[[static]]\npress_fit = true\n", rest)
    wanted = OVERLAP / (2.0 * BLOCK / SOFT + 1.0 / PER_AREA) * BLOCK**2
    assert set(result.runs) == {"reduced", "reference"}
    for one in result.runs.values():
        force = one.history.force.sum(axis=1)
        assert force[0] == pytest.approx(wanted, rel=EXACT)
        assert np.abs(force - force[0]).max() <= 1e-9 * wanted
        assert not one.events


def test_a_clearance_below_zero_is_a_press_fit_or_a_mistake(tmp_path):
    """It was run as zero, which is neither; `set_up` of the one with press_fit is the test above."""
    tables = f"[contact.fit]\nsecondary = 'BOTTOM'\nmain = 'TOP'\nclearance = {-OVERLAP}\n"
    with pytest.raises(InputError, match=r"study\.toml:\d+ .*clearance = -0\.02; expected zero or more.*press_fit"):
        set_up(read_study(study(tmp_path, overlapping_cubes(), tables)))


def test_a_press_fit_of_nothing_is_warned_of(tmp_path):
    open_stop, squeezed = f"{STOP}lower = -1.0\n", f"{STOP}lower = 0.1\n"
    for tables, wrong in ((open_stop, True), (squeezed, False)):
        path = study(tmp_path, HELD, f"[[static]]\npress_fit = true\n{tables}")
        told = [n for n in set_up(read_study(path)).notes if "press_fit: no surfaces overlap" in n]
        assert bool(told) == wrong


def test_a_force_opens_a_clip_with_preload(tmp_path):
    """It carries its preload until the tip has moved by preload / stiffness; from there the beam is alone."""
    preload = 2.0
    clip = f"{STOP}upper = 0\npreload = {preload}\n"
    shut, opened = -1.0, -20.0
    stiffness = 1.0 / GIVE + SPRING
    folders = [tmp_path / name for name in ("shut", "open")]
    for folder in folders:
        folder.mkdir()
    stays(run(folders[0], HELD, tip_force(shut) + clip), shut / stiffness, preload + SPRING * shut / stiffness)
    stays(run(folders[1], HELD, tip_force(opened) + clip), GIVE * (opened + preload), 0.0)


def test_a_moved_support_bends_the_beam_against_its_stop(tmp_path):
    moved = 1.5
    force = moved / (GIVE + 1.0 / SPRING)
    root = f'[[static]]\ndisplacement = {moved}\nnode_set = "ROOT"\ndof = "z"\n'
    stays(run(tmp_path, LED, f"{root}{STOP}upper = 0\n"), force / SPRING, force)


def test_motion_goes_on_about_the_static_state(tmp_path):
    """Small motion of the excited root: the same as without gravity, about the sag; reduced and unreduced agree."""
    shake = (
        '[excitation.root]\nnode_set = "ROOT"\ndof = "z"\n'
        'signal = { type = "sine", frequency = 100, amplitude = 0.001 }\n'
    )
    plain, loaded = (
        run(tmp_path, LED, tables + shake).runs["reduced"].history.displacement[:, 2] for tables in ("", DOWN)
    )
    assert np.ptp(plain) > 1e-3
    assert loaded == pytest.approx(plain - SAG, rel=0.0, abs=EXACT * SAG)
    assert loaded - loaded[0] == pytest.approx(plain, rel=0.0, abs=1e-9)


def test_a_stop_that_carries_weight_lets_go_at_the_static_force(tmp_path):
    """A force pulse below what the stop carries leaves it closed, one above opens it; both models see the same."""
    clear = 0.4 * SAG
    carried = (SAG - clear) / (GIVE + 1.0 / SPRING)
    for factor, opens in ((0.5, False), (4.0, True)):
        pulse = (
            '[excitation.lift]\nnode_set = "TIP"\ndof = "z"\nkind = "force"\nsignal = { type = "smooth-step", '
            f"values = [[0.0, 0.0], [0.01, {factor * carried}]] }}\n"
        )
        tables = DOWN + pulse + f"{STOP}lower = {-clear}\n"
        runs = run(tmp_path, HELD, tables, REST.replace("end = 0.01", "end = 0.0125")).runs.values()
        assert [bool((one.history.force[-1] == 0.0).all()) for one in runs] == [opens, opens]


REFUSED = {
    "zero gravity": ("[[static]]\ngravity = [0, 0, 0]\n", "gravity is zero"),
    "two loads": ("[[static]]\ngravity = [0, 0, -1]\nforce = 2\n", "give one of gravity"),
    "nothing": ("[[static]]\n", "no load"),
    "unknown set": ('[[static]]\nforce = 1\nnode_set = "TOP"\ndof = "z"\n', "TOP"),
    "no set": ("[[static]]\nforce = 1\n", "force needs node_set and dof"),
    "set of gravity": ('[[static]]\ngravity = [0, 0, -1]\nnode_set = "TIP"\n', "acts on the whole model"),
    "force on a support": ('[[static]]\nforce = 1\nnode_set = "ROOT"\ndof = "z"\n', "it loads nothing"),
    "held node moved": (
        '[[static]]\ndisplacement = 1\nnode_set = "ROOT"\ndof = "z"\n',
        r'which the deck holds.*Free them: \[support.NAME\] with nodes = "ROOT" and free = \["z"\]',
    ),
    "not a number": ("[[static]]\ngravity = [0, 0, nan]\n", "gravity"),
    "one table": ("[static]\ngravity = [0, 0, -1]\n", "Write \\[\\[static\\]\\]"),
}


@pytest.mark.parametrize("case", REFUSED)
def test_what_cannot_be_meant_is_refused(tmp_path, case):
    tables, match = REFUSED[case]
    with pytest.raises(InputError, match=match):
        set_up(read_study(study(tmp_path, HELD, tables)))


def test_a_unit_that_can_hardly_be_meant_is_warned_of(tmp_path):
    notes = set_up(read_study(study(tmp_path, HELD, "[[static]]\ngravity = [0, 0, -9.81]\n"))).notes
    assert any("0.001 times the earth's, which is 9810 mm/s2" in note for note in notes)


def test_a_model_that_only_a_stop_holds_is_refused(tmp_path):
    """Nothing but the stop keeps it from falling."""
    setup = set_up(read_study(study(tmp_path, LED, DOWN + STOP.replace("TIP", "ROOT") + "lower = 0\n")))
    text = str(refusal(run_study, setup, lambda *_: None))
    assert "move freely" in text
    assert "springs" in text
