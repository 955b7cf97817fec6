"""The benchmarks of decks and modes at a tiny size, so that they cannot rot."""

from __future__ import annotations

import shutil
import time

import numpy as np
import pytest
import scipy.sparse as sp
from benchmarks import deck_size, modes_cost, modes_peers
from benchmarks.modes_peers_decks import calculix_deck, moving_bodies, mystran_deck

from creak.errors import InputError
from creak.formats.abaqus.reader import read_deck
from creak.formats.nastran.reader import read_nastran
from creak.linalg import ritz
from creak.studies.models.deck_modes import deck_modes
from creak_thesis.door import write_door

pytestmark = pytest.mark.once

N, COUNT = 900, 20


def chain():
    """Springs and masses in a row, both ends held: omega = 2 sin(k pi / 2 (N + 1))."""
    K = sp.diags_array([-np.ones(N - 1), 2.0 * np.ones(N), -np.ones(N - 1)], offsets=[-1, 0, 1], format="csr")
    return K, sp.identity(N, format="csr")


def strips(tmp_path, more=""):
    """Two cantilevers in line, clamped at their outer ends by a coupling, their inner ends joined by a rigid link; a grip holds a row of shells."""
    lines = ["*NODE"]
    for strip in range(2):
        lines += [
            f"{1 + 100 * strip + 3 * i + j}, {70.0 * strip + 10.0 * i}, {10.0 * j}, 0."
            for i in range(7)
            for j in range(3)
        ]
    lines += ["901, 0., 10., 0.", "902, 60., 10., 0.", "903, 70., 10., 0.", "904, 130., 10., 0."]
    for strip in range(2):
        lines.append(f"*ELEMENT, TYPE=S4, ELSET=STRIP{strip}")
        first = [1 + 100 * strip + 3 * i + j for i in range(6) for j in range(2)]
        lines += [f"{500 + n}, {n}, {n + 3}, {n + 4}, {n + 1}" for n in first]
    ends = {901: range(1, 7), 902: range(16, 22), 903: range(101, 107), 904: range(116, 122)}
    for ref, grip in ends.items():
        lines += [f"*NSET, NSET=N{ref}", *(f"{n}," for n in grip), f"*SURFACE, TYPE=NODE, NAME=S{ref}", f"N{ref},"]
        lines += [f"*COUPLING, CONSTRAINT NAME=C{ref}, REF NODE={ref}, SURFACE=S{ref}", "*KINEMATIC", "1, 6"]
    lines += ["*MPC", "BEAM, 903, 902", "*BOUNDARY", "901, 1, 6", "904, 1, 3", more]
    for strip in range(2):
        lines += [f"*SHELL SECTION, ELSET=STRIP{strip}, MATERIAL=STEEL", "1.5"]
    lines += ["*MATERIAL, NAME=STEEL", "*ELASTIC", "210000., 0.3", "*DENSITY", "7.85e-9", ""]
    path = tmp_path / "strips.inp"
    path.write_text("\n".join(line for line in lines if line), encoding="utf-8")
    return path


def test_cost_of_modes():
    """Every phase is met, the phases are the whole, and the modes are those of the chain."""
    started = time.perf_counter()
    measured = modes_cost.measure(*chain(), COUNT, False)
    assert 0.0 < measured.total < time.perf_counter() - started
    assert min(measured.seconds.values()) > 0.0
    exact = 2.0 * np.sin(0.5 * np.pi * np.arange(1, COUNT + 1) / (N + 1))
    np.testing.assert_allclose(np.sqrt(measured.modes.omega2), exact, rtol=1e-9)
    assert len(modes_cost.rows(measured)) == len(modes_cost.PHASES) + 3


def test_time_belongs_to_the_innermost_phase():
    ticks = iter([0.0, 1.0, 3.0, 7.0])  # rest begins, solves begin, solves end, rest ends
    clock = modes_cost.Clock(lambda: next(ticks))
    clock.timed(modes_cost.REST, clock.timed(modes_cost.SOLVES, lambda: None))()
    assert clock.seconds[modes_cost.SOLVES] == 2.0
    assert clock.seconds[modes_cost.REST] == 1.0 + 4.0


def test_a_timed_name_that_is_gone_stops_the_benchmark(monkeypatch):
    monkeypatch.delattr(ritz, "_eigen")
    with pytest.raises(AttributeError, match="_eigen"):
        modes_cost.measure(*chain(), COUNT, False)


def test_a_phase_that_is_never_met_stops_the_benchmark(monkeypatch):
    names = [timed for timed in modes_cost._timed_names() if timed[2] != modes_cost.VECTORS]
    monkeypatch.setattr(modes_cost, "_timed_names", lambda: names)
    with pytest.raises(RuntimeError, match="eigenvectors"):
        modes_cost.measure(*chain(), COUNT, False)


def test_size_of_a_deck(tmp_path):
    """In this process, at the coarsest mesh."""
    deck, study = write_door(40.0, tmp_path)
    set_up, assemble, sizes = deck_size.assembly_stage(study)
    stages = deck_size.Stages(deck_size.read_stage(study), set_up, assemble, *sizes)
    assert stages.nodes == read_deck(deck).nodes.count
    assert 0 < stages.free < 6 * stages.nodes < stages.entries
    table = {what: (measured, goal) for what, measured, goal in deck_size.rows(stages, 0.1)}
    assert table["set up and assemble"][1] == "< 60 s"
    whole = f"{set_up.wall_s + assemble.wall_s:.1f} s wall"
    assert table["set up and assemble"][0].startswith(whole)


def test_links_that_share_nodes_are_one_body(tmp_path):
    """The clamped end is held node by node, the pinned one leads its body, the middle has two grips and two nodes."""
    model = read_deck(strips(tmp_path))
    bodies, supports = moving_bodies(model)
    label = model.nodes.ids
    assert sorted(b.others.size for b in bodies) == [6, 13]
    pinned = min(bodies, key=lambda b: b.others.size)
    assert label[pinned.leader] == 904
    assert {int(label[n]) for n, dofs in supports.items() if len(dofs) == 6} == {*range(1, 7), 901}
    with pytest.raises(InputError, match="two nodes of a rigid body"):
        moving_bodies(read_deck(strips(tmp_path, more="119, 1, 1")))


def test_mystran_deck_is_the_same_model(tmp_path):
    """creak reads it back: coordinates with nine digits, the rest with the six or seven that eight characters hold."""
    model = read_deck(strips(tmp_path))
    (tmp_path / "m.bdf").write_text(mystran_deck(model, 6), encoding="utf-8")
    back = read_nastran(tmp_path / "m.bdf")
    np.testing.assert_allclose(back.nodes.coords, model.nodes.coords, rtol=1e-8)
    shells, expected = (np.concatenate([b.nodes_idx for b in m.blocks]) for m in (back, model))
    np.testing.assert_array_equal(shells, expected)
    section, of_strip = back.blocks[0].section, model.blocks[0].section
    assert section.thickness == of_strip.thickness
    assert section.material.youngs_modulus == pytest.approx(of_strip.material.youngs_modulus, rel=1e-6)
    assert section.material.density == pytest.approx(of_strip.material.density, rel=1e-6)
    assert sorted(c.nodes_idx.size for c in back.constraints) == [6, 13]
    held = {(int(n), dof) for f in back.fixed for n in f.nodes_idx for dof in f.dofs}
    assert held == {(n, dof) for n, dofs in moving_bodies(model)[1].items() for dof in dofs}


@pytest.mark.skipif(shutil.which("ccx") is None, reason="CalculiX is not installed")
def test_calculix_answers(tmp_path):
    """Its solids with incompatible modes bend as shells do, where grips hold whole shells; on so coarse a mesh
    to some 10 %."""
    path = strips(tmp_path)
    found = modes_peers.calculix_run(shutil.which("ccx"))(modes_peers.Task(path, 4, 1, tmp_path))
    assert found.failed == ""
    np.testing.assert_allclose(found.frequencies, deck_modes(path, count=4).frequencies, rtol=0.15)


def test_calculix_deck(tmp_path):
    text = calculix_deck(read_deck(strips(tmp_path)), 6)
    assert text.count("*RIGID BODY") == 2
    labels = [int(line.split(",")[0]) for line in text.split("*NODE\n")[1].split("*")[0].splitlines()]
    assert labels == list(range(1, 47))
    assert text.split("*FREQUENCY\n")[1].startswith("6\n")


def test_a_program_that_fails_says_why(tmp_path):
    task = modes_peers.Task(tmp_path, 1, 1, tmp_path)
    assert "not installed" in modes_peers.calculix_run(None)(task).failed
    found = modes_peers.run(task, ["sh", "-c", "echo no licence; exit 3"], "none.dat", lambda _: np.ones(1))
    assert found.failed == "status 3: no licence"
    assert modes_peers.row("x", 1, found, found)[-1] == found.failed


@pytest.mark.slow
@pytest.mark.parametrize("program", [modes_peers.creak_run, modes_peers.scipy_run])
def test_creak_and_scipy_run_as_peers(tmp_path, program):
    path = strips(tmp_path)
    found = program(modes_peers.Task(path, 3, 1, tmp_path))
    assert found.failed == ""
    np.testing.assert_allclose(found.frequencies, deck_modes(path, count=3).frequencies, rtol=1e-9)
    assert modes_peers.apart(found, found) == "+0.0 to +0.0 %"


def test_tables_of_peers_are_read():
    calculix = """
     E I G E N V A L U E   O U T P U T

      1   0.9420264E+03   0.3069245E+02   0.4884855E+01   0.0000000E+00
     P A R T I C I P A T I O N   F A C T O R S
      1  -0.4540463E-01  -0.2044180E+00   0.1161982E-01  -0.1365904E+02
"""
    assert modes_peers.calculix_frequencies(calculix).tolist() == [4.884855]
    mystran = (
        " R E A L   E I G E N V A L U E S\n 1 1 2.646276E+03 5.144197E+01 8.187244E+00 1.000000E+00 2.646276E+03\n"
    )
    assert modes_peers.mystran_frequencies(mystran).tolist() == [8.187244]


def test_requests_for_output_are_dropped():
    text = "DISP(PLOT)\n  DISPLACEMENT(PLOT) = ALL\nEIGRL,101,,,10\nPARAM*  POST  -1\n*\nGRID*  1\n*  2.\n"
    kept, dropped = modes_peers.without_output(text, 7)
    assert kept == "DISP(PLOT)\nEIGRL,101,,,7\nGRID*  1\n*  2.\n"
    assert dropped == ["  DISPLACEMENT(PLOT) = ALL", "PARAM*  POST  -1", "*"]
