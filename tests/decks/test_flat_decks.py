"""Flat parts in their plane: rotations about the normal are an aid of the shells, held or free they stiffen nothing."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest

from creak.assembly.coupling import Driven
from creak.assembly.rigid import unheld_parts
from creak.formats.decks import read_model
from helpers_flat_decks import SHELLS, THICKNESS, frequencies, mesh, strip, timoshenko

SAME = 1e-9
"""Held and free are the same matrices but for the order of the dofs: round-off of the solver, relative to 1e3 times the
frequency looked at, squared."""
TILTED = np.linalg.qr(np.array([[0.9, 0.3, -0.2], [0.1, 0.7, 0.6], [0.4, -0.5, 0.8]]).T)[0].T
TILTED[2] = np.cross(TILTED[0], TILTED[1])


SLOPES = 4.648
"""L^2 times the integral of w'^2 over that of w^2 in the first mode of a cantilever (Blevins 1979, table 8-1)."""


@pytest.mark.parametrize("kind", SHELLS)
def test_held_drilling_rotations_stiffen_no_strip(tmp_path, kind):
    """All shells within .5 % of the beam and so of each other, on the mesh of twenty by two."""
    free, held = (frequencies(tmp_path, strip(kind, 20, 2, held=held), 1)[0] for held in (False, True))
    assert held == pytest.approx(free, rel=SAME)
    assert held == pytest.approx(timoshenko(), rel=5e-3)


@pytest.mark.parametrize("kind", ["S3", "CTRIA3", "S4", "CQUAD4"])
def test_held_strips_converge(tmp_path, kind):
    """To within .3 %: a beam leaves out .13 % of a plate in plane stress, which is shear at the root."""
    assert frequencies(tmp_path, strip(kind, 40, 4, held=True), 1)[0] == pytest.approx(timoshenko(), rel=3e-3)


@pytest.mark.parametrize("kind", ["S3", "S4R", "CTRIA3", "CQUAD4", "CQUAD8"])
def test_a_plate_in_no_global_plane_is_held_in_a_frame_of_its_own(tmp_path, kind):
    plain = frequencies(tmp_path, strip(kind, 20, 2, held=False), 2)
    for held in (False, True):
        assert frequencies(tmp_path, strip(kind, 20, 2, held=held, axes=TILTED), 2) == pytest.approx(plain, rel=1e-6)


def test_single_nodes_that_are_held_stiffen_nothing(tmp_path):
    free = frequencies(tmp_path, strip("S3", 20, 2, held=False))
    some = strip("S3", 20, 2, held=False) + "17, 6, 6\n31, 6, 6\n50, 4, 6\n"
    assert frequencies(tmp_path, some) == pytest.approx(free, rel=SAME)


@pytest.mark.parametrize("kind", ["S3", "CTRIA3", "CQUAD4"])
def test_a_held_side_is_the_same_with_and_without_its_drilling_rotations(tmp_path, kind):
    held = strip(kind, 20, 2, held=False)
    free = held.replace("ROOT, 6, 6\n", "").replace("SPC1,1,126,", "SPC1,1,12,")
    assert free != held
    rel = SAME if kind != "CQUAD4" else 1e-5  # a share of the drilling penalty of quads, 1e-3 G t
    assert frequencies(tmp_path, free) == pytest.approx(frequencies(tmp_path, held), rel=rel)


def test_grids_held_in_a_frame_of_their_own_about_the_normal_alone(tmp_path):
    free = strip("CTRIA3", 20, 2, held=False, axes=TILTED).replace(",5,345\n", ",5,\n")
    held = free.replace(",5,\n", ",5,6\n")
    assert frequencies(tmp_path, held, 6)[3:] == pytest.approx(frequencies(tmp_path, free, 6)[3:], rel=1e-6)


def test_the_only_clamped_node_still_holds_its_plate(tmp_path):
    """By its drilling rotation alone; a second pin takes that over, and the hold is nothing."""
    plate = strip("S3", 20, 2, held=False).split("*BOUNDARY")[0] + "*BOUNDARY\n1, 1, 6\n"
    assert frequencies(tmp_path, plate, 1)[0] > 0.0
    assert unheld_parts(read_model(tmp_path / "flat.inp"), Driven({})) == []


def test_rotations_about_the_normal_hold_no_plate(tmp_path):
    """Supports across the plate and no more: it moves in its plane, and turns there, whatever holds drilling."""
    plate = strip("S3", 20, 2, held=False).split("*BOUNDARY")[0] + "*BOUNDARY\nALL, 3, 6\n1, 1, 1\n61, 1, 1\n"
    found = frequencies(tmp_path, plate, 3)
    assert [f == 0.0 for f in found] == [True, True, False]
    assert unheld_parts(read_model(tmp_path / "flat.inp"), Driven({})) == ["ALL"]


def test_a_pin_at_one_corner_turns_though_its_rotation_is_held(tmp_path):
    """A link and a pin at the ends of the lower side: the strip turns about the pin, held or not."""
    deck = strip("S3", 20, 2, held=False).split("ROOT, 1, 2")[0]
    free, held = (frequencies(tmp_path, deck + f"1, 1, 2\n61, 2, 2\n{more}") for more in ("", "ALL, 6, 6\n"))
    assert held == pytest.approx(free, rel=SAME)


def test_beams_meet_the_support_and_the_shell_does_not(tmp_path):
    """A bar along the lower side: its rotations are held, so each piece bends as 12 EI/h^3, as by itself."""
    side = 1e-3
    bars = "\n".join(f"CBAR,{900 + i},9,{a},{b},0.,0.,1." for i, (a, b) in enumerate(_lower_side()))
    card = f"PBAR,9,1,{side**2},{side**4 / 12},{side**4 / 12},{side**4 / 6}\n{bars}"
    free, held = (frequencies(tmp_path, strip("CTRIA3", 20, 2, held=h, more=card), 1)[0] for h in (False, True))
    shear = 12.0 * 210e9 * side**4 / 12.0 / 0.05**2  # stiffness against shear that the held bar adds, 12 EI/h^2
    inertia = 7850.0 * 0.1 * THICKNESS * (2.0 * np.pi * free) ** 2
    assert held / free - 1.0 == pytest.approx(0.5 * SLOPES * shear / inertia, rel=0.1)


def _lower_side() -> list[tuple[int, int]]:
    xy, _ = mesh("CTRIA3", 20, 2)
    row = sorted((x, k) for k, (x, y) in enumerate(xy.tolist(), 1) if y < 1e-9)
    return [(a[1], b[1]) for a, b in pairwise(row)]


def _angle(kind: str, *held: str) -> str:
    """Two plates that meet at right angles along x, fixed at x = 0."""
    lines, elements = ["*NODE"], []
    for j in range(-2, 3):
        y, z = (0.05 * j, 0.0) if j >= 0 else (0.0, -0.05 * j)
        lines += [f"{21 * (j + 2) + i + 1}, {0.05 * i}, {y}, {z}" for i in range(21)]
    for j in range(4):
        for i in range(20):
            a = 21 * j + i + 1
            quad = (a, a + 1, a + 22, a + 21)
            elements += [quad] if kind == "S4" else [quad[:3], (quad[0], *quad[2:])]
    lines += [f"*ELEMENT, TYPE={kind}, ELSET=ALL", *(", ".join(map(str, [k, *e])) for k, e in enumerate(elements, 1))]
    for name, first in (("WEB", 1), ("FOLD", 43), ("FLAT", 64)):
        lines += [f"*NSET, NSET={name}, GENERATE", f"{first}, {first + (20 if name == 'FOLD' else 41)}"]
    lines += ["*NSET, NSET=ROOT", *(str(21 * j + 1) for j in range(5)), "*MATERIAL, NAME=M", "*ELASTIC", "210e9, .3"]
    lines += ["*DENSITY", "7850.", "*SHELL SECTION, ELSET=ALL, MATERIAL=M", f"{THICKNESS}"]
    return "\n".join([*lines, "*BOUNDARY", "ROOT, 1, 6", *held, ""])


@pytest.mark.parametrize("kind", ["S3", "S4"])
def test_along_a_fold_the_rotation_is_real(tmp_path, kind):
    """About the normal of one plate the other bends: held there it is stiffer, whatever else of the first is held."""
    free, flat, fold, both = (
        frequencies(tmp_path, _angle(kind, *held))
        for held in ((), ("FLAT, 6, 6", "WEB, 5, 5"), ("FOLD, 6, 6",), ("FOLD, 6, 6", "FLAT, 6, 6"))
    )
    assert flat == pytest.approx(free, rel=SAME)
    assert both == pytest.approx(fold, rel=SAME)
    assert fold[0] > 1.1 * free[0]


@pytest.mark.parametrize("kind", ["M3D3", "M3D4"])
@pytest.mark.parametrize("held", [True, False])
def test_membranes_have_no_modes_of_what_nothing_holds(tmp_path, kind, held):
    """The strip of membranes is the strip of shells in its plane: rotations and the normal add nothing below it."""
    deck = strip(kind, 20, 2, held=True)
    loose = deck if held else deck.replace("ALL, 3, 6\n", "")
    as_shell = frequencies(tmp_path, strip(kind.replace("M3D", "S"), 20, 2, held=True))
    assert frequencies(tmp_path, loose) == pytest.approx(as_shell, rel=2e-3)  # Abaqus's shells have drilling inertia


def test_a_tilted_membrane_has_none_either(tmp_path):
    deck = strip("M3D4", 20, 2, held=True)
    tilted = strip("M3D4", 20, 2, held=False, axes=TILTED).replace("ALL, 3, 5\n", "")
    assert frequencies(tmp_path, tilted) == pytest.approx(frequencies(tmp_path, deck), rel=1e-6)


def test_a_nastran_shell_of_mid1_alone_is_a_membrane(tmp_path):
    deck = strip("CQUAD4", 20, 2, held=True)
    alone = deck.replace(f"PSHELL,1,1,{THICKNESS},1,,1", f"PSHELL,1,1,{THICKNESS}").replace(",3456\n", "\n")
    assert frequencies(tmp_path, alone) == pytest.approx(frequencies(tmp_path, deck), rel=1e-4)


def test_a_skin_on_a_block_leaves_its_modes_alone(tmp_path):
    """A skin of 1e-4 on a block of .1 x .1: stiffness and mass change by a thousandth, and so do the modes."""

    def number(i, j, k):
        return 1 + i + 9 * (j + 3 * k)

    lines = ["*NODE"]
    lines += [f"{number(i, j, k)}, {i / 8}, {j / 20}, {k / 20}" for k in range(3) for j in range(3) for i in range(9)]
    cells = [(i, j, k) for k in range(2) for j in range(2) for i in range(8)]
    around = ((0, 0), (1, 0), (1, 1), (0, 1))
    lines.append("*ELEMENT, TYPE=C3D8I, ELSET=BLOCK")
    for e, (i, j, k) in enumerate(cells, 1):
        lines.append(", ".join(map(str, [e, *(number(i + a, j + b, k + c) for c in (0, 1) for a, b in around)])))
    skin = ["*ELEMENT, TYPE=M3D4, ELSET=SKIN"]
    skin += [
        ", ".join(map(str, [100 + e, *(number(i + a, j + b, 2) for a, b in around)]))
        for e, (i, j, k) in enumerate(cells)
        if k == 1
    ]
    data = ["*MATERIAL, NAME=M", "*ELASTIC", "210e9, .3", "*DENSITY", "7850."]
    data += ["*SOLID SECTION, ELSET=BLOCK, MATERIAL=M"]
    held = ["*BOUNDARY", *(f"{number(0, j, k)}, 1, 3" for j in range(3) for k in range(3)), ""]
    bare = frequencies(tmp_path, "\n".join([*lines, *data, *held]))
    section = ["*MEMBRANE SECTION, ELSET=SKIN, MATERIAL=M", "1e-4"]
    assert frequencies(tmp_path, "\n".join([*lines, *skin, *data, *section, *held])) == pytest.approx(bare, rel=3e-3)
