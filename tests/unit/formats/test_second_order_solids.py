"""Hexahedra of 20 and wedges of 15 nodes in decks: the same model from both formats, faces, contact, written decks, shapes."""

from __future__ import annotations

import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from creak.assembly.rigid import STRUCTURAL
from creak.contact.facets import facets_of
from creak.errors import InputError
from creak.formats.abaqus.reader import read_deck
from creak.formats.abaqus.writer import write_deck
from creak.formats.measured.uff import write_uff
from creak.formats.nastran.reader import read_nastran
from creak.formats.nastran.writer import write_nastran
from creak.formats.vtu import write_vtu
from creak.model.comparison import difference
from creak.model.faces import MIDDLES, face_numbers
from creak.model.mesh import Model
from creak.reduction.interface.spacing import EDGES
from helpers_nastran import NO_DAMPING, assembled, part_system, rigid_mass, to_dense

CORNERS = [(x, y, z) for z in (0.0, 3.0) for y in (0.0, 2.0) for x in (0.0, 2.0, 4.0)]
HEXES, WEDGES = [(0, 1, 4, 3, 6, 7, 10, 9)], [(1, 2, 5, 7, 8, 11), (1, 5, 4, 7, 11, 10)]
"""A block of 4 x 2 x 3: one hexahedron, and two wedges beside it."""
STEEL = "*MATERIAL, NAME=STEEL\n*ELASTIC\n 210000., .3\n*DENSITY\n 7.85e-9\n"
WOOD = (
    "*MATERIAL, NAME=STEEL\n*ELASTIC, TYPE=ORTHOTROPIC\n 30., 1., 20., 2., 3., 10., 4., 5.,\n 6.\n*DENSITY\n 7.85e-9\n"
)
MAT1 = "MAT1,1,210000.,,.3,7.85-9\n"
MAT9 = "MAT9,1,30.,1.,2.,,,,20.\n,3.,,,,10.,,,\n,4.,,,6.,,5.,7.85-9\n"
"""The two axes differ in the order of the shear strains: 12, 13, 23 and 12, 23, 31."""
NETWORK = {"C3D20": ",3,,1", "C3D20R": ",TWO,,FULL"}


def quadratic(bow: float) -> tuple[np.ndarray, list[list[int]], list[list[int]]]:
    """Nodes, and rows of the elements; the middle nodes are off the middle by up to `bow`."""
    coords, at = [np.array(c) for c in CORNERS], dict[frozenset[int], int]()
    shift = np.random.default_rng(6)

    def completed(corners: tuple[int, ...], kind: str) -> list[int]:
        row = list(corners)
        for i, j in MIDDLES[kind]:
            pair = frozenset((corners[i], corners[j]))
            if pair not in at:
                at[pair] = len(coords)
                middle = 0.5 * (coords[corners[i]] + coords[corners[j]])
                coords.append(middle + bow * shift.uniform(-1.0, 1.0, 3))
            row.append(at[pair])
        return row

    hexes = [completed(c, "hex20") for c in HEXES]
    wedges = [completed(c, "wedge15") for c in WEDGES]
    return np.array(coords), hexes, wedges


def abaqus(kind: str = "C3D20", bow: float = 0.15, material: str = STEEL, more: str = "") -> str:
    coords, hexes, wedges = quadratic(bow)
    lines = ["*NODE", *(f"{k + 1}, {x!r}, {y!r}, {z!r}" for k, (x, y, z) in enumerate(coords.tolist()))]
    lines += [f"*ELEMENT, TYPE={kind}, ELSET=H"]
    for k, row in enumerate(hexes):
        labels = [str(i + 1) for i in row]
        lines += [f"{k + 1}, " + ", ".join(labels[:15]) + ",", ", ".join(labels[15:])]
    lines += ["*ELEMENT, TYPE=C3D15, ELSET=W"]
    lines += [f"{k + 11}, " + ", ".join(str(i + 1) for i in row) for k, row in enumerate(wedges)]
    axes = "*ORIENTATION, NAME=O\n 0., 0., 1., 1., 0., 0.\n 3, 0.\n" if material == WOOD else ""
    name = ", ORIENTATION=O" if axes else ""
    sections = "".join(f"*SOLID SECTION, ELSET={s}, MATERIAL=STEEL{name}\n" for s in "HW")
    return "\n".join(lines) + "\n" + axes + sections + material + more


def nastran(network: str = ",3,,1", bow: float = 0.15, material: str = MAT1) -> str:
    """Nastran has the middle nodes between the faces before those of the second face."""
    coords, hexes, wedges = quadratic(bow)
    cards = [f"GRID,{k + 1},,{x:.15g},{y:.15g},{z:.15g}" for k, (x, y, z) in enumerate(coords.round(9).tolist())]
    for k, row in enumerate(hexes):
        cards += free("CHEXA", k + 1, 1, [*row[:12], *row[16:], *row[12:16]])
    for k, row in enumerate(wedges):
        cards += free("CPENTA", k + 11, 2, [*row[:9], *row[12:], *row[9:12]])
    cord = 5 if material == MAT9 else 0
    cards += ["CORD2R,5,,0.,0.,0.,0.,1.,0.", ",0.,0.,1."] if cord else []
    return "\n".join([*cards, f"PSOLID,1,1,{cord}{network}", f"PSOLID,2,1,{cord}"]) + "\n" + material


def free(name: str, label: int, pid: int, rows: list[int]) -> list[str]:
    fields = [str(label), str(pid), *(str(i + 1) for i in rows)]
    lines = [",".join(fields[k : k + 8]) for k in range(0, len(fields), 8)]
    return [f"{name},{lines[0]}", *("," + line for line in lines[1:])]


def read(folder: Path, text: str) -> Model:
    if "BEGIN BULK" in text or text.startswith("GRID"):
        (folder / "d.bdf").write_text(
            text if "BEGIN" in text else f"SOL 103\nCEND\nBEGIN BULK\nPARAM,COUPMASS,1\n{text}ENDDATA\n"
        )
        return read_nastran(folder / "d.bdf")
    (folder / "d.inp").write_text(text)
    return read_deck(folder / "d.inp")


def matrices(model: Model) -> list[np.ndarray]:
    system = part_system(model, 0, NO_DAMPING)
    order = np.lexsort([system.coordinates % 6, model.nodes.ids[system.coordinates // 6]])
    return [to_dense(A)[np.ix_(order, order)] for A in (system.K, system.M)]


@pytest.mark.parametrize("kind", NETWORK)
@pytest.mark.parametrize(("material", "mat"), [(STEEL, MAT1), (WOOD, MAT9)], ids=["isotropic", "orthotropic"])
def test_the_same_model_from_both_formats_has_the_same_matrices(tmp_path, kind, material, mat):
    """Middle nodes off the middle, so that any other order of nodes has another volume."""
    one, other = read(tmp_path, abaqus(kind, material=material)), read(tmp_path, nastran(NETWORK[kind], material=mat))
    assert [b.kind for b in one.blocks] == [b.kind for b in other.blocks]
    assert not one.unread
    assert not [u for u in other.unread if u.changes_answer]
    for a, b in zip(matrices(one), matrices(other), strict=True):
        # Coordinates in the Nastran deck have nine decimals.
        np.testing.assert_allclose(a, b, atol=1e-7 * np.abs(a).max())


@pytest.mark.parametrize(
    ("network", "kind"),
    [
        ("", "hex20s"),
        (",3", "hex20s"),
        (",,,REDUCED", "hex20s"),
        (",TWO", "hex20r"),
        (",,,FULL", "hex20"),
        (",3,GAUSS,1", "hex20"),
    ],
)
def test_psolid_says_how_a_hexahedron_is_integrated(tmp_path, network, kind):
    model = read(tmp_path, nastran(network))
    assert [b.kind for b in model.blocks] == [kind, "wedge15"]
    assert kind in STRUCTURAL


def test_mass_of_a_straight_block_is_exact(tmp_path):
    for model in (read(tmp_path, abaqus(bow=0.0)), read(tmp_path, nastran("", bow=0.0).replace("7.85-9", "1."))):
        density = model.blocks[0].section.material.density
        mass = rigid_mass(model)
        assert mass[0, 0] == pytest.approx(24.0 * density, rel=1e-12)
        assert mass[5, 5] == pytest.approx(24.0 * density * (4.0**2 + 2.0**2) / 3.0, rel=1e-12)


def test_lumped_mass_has_a_share_for_every_node(tmp_path):
    """Nastran's own: without COUPMASS the mass is on the translations of the nodes."""
    text = f"SOL 103\nCEND\nBEGIN BULK\n{nastran('', bow=0.0)}ENDDATA\n"
    system = part_system(read(tmp_path, text), 0, NO_DAMPING)
    diagonal = to_dense(system.M).diagonal()[system.coordinates % 6 < 3]
    assert diagonal.min() > 0.0
    assert diagonal.sum() == pytest.approx(3 * 24.0 * 7.85e-9, rel=1e-12)


SURFACES = (
    "".join(f"*SURFACE, NAME=H{k}\n H, S{k}\n" for k in range(1, 7))
    + "".join(f"*SURFACE, NAME=W{k}\n 11, S{k}\n" for k in range(1, 6))
    + "*SURFACE, NAME=ALL\n H,\n W,\n*SURFACE, NAME=TOP\n H, S2\n W, S2\n"
)


def area(model: Model, name: str) -> np.ndarray:
    """Area times outward direction."""
    return facets_of(model, name, where="").area_normals.sum(axis=0)


def test_faces_by_number_and_free_faces(tmp_path):
    """Of Abaqus: S1 below, S2 above, then round the sides from edge 1-2; what two elements share is not free."""
    model = read(tmp_path, abaqus(bow=0.0, more=SURFACES))
    expected = {
        "H1": (0, 0, -4),
        "H2": (0, 0, 4),
        "H3": (0, -6, 0),
        "H4": (6, 0, 0),
        "H5": (0, 6, 0),
        "H6": (-6, 0, 0),
        "W1": (0, 0, -2),
        "W2": (0, 0, 2),
        "W3": (0, -6, 0),
        "W4": (6, 0, 0),
        "W5": (-6, 6, 0),
        "TOP": (0, 0, 8),
    }
    for name, value in expected.items():
        np.testing.assert_allclose(area(model, name), value, atol=1e-12, err_msg=name)
    free = facets_of(model, "ALL", where="").area_normals
    assert np.linalg.norm(free, axis=1).sum() == pytest.approx(2 * (8 + 6 + 12), rel=1e-12)
    assert model.surfaces["H2"].nodes_idx.size == 8
    assert model.surfaces["W2"].nodes_idx.size == 6
    with pytest.raises(InputError, match=r"element 11 \(C3D15\) has no face S6"):
        read(tmp_path, abaqus(more="*SURFACE, NAME=F\n W, S6\n"))


def test_contact_reaches_the_middle_nodes_and_every_facet_knows_its_depth(tmp_path):
    """Half the height of the block, 1.5, whatever the facet; the normal stiffness of a face is E_c A/h."""
    model = read(tmp_path, abaqus(bow=0.0, more=SURFACES))
    facets = facets_of(model, "TOP", where="")
    np.testing.assert_allclose(facets.depth, 1.5, rtol=1e-12)
    confined = 210000.0 * 0.7 / (1.3 * 0.4)
    assert facets.normal_stiffness.sum() == pytest.approx(confined * 8.0 / 3.0, rel=1e-12)
    assert facets.node_rows.size == 8 + 6 + 6 - 3 - 3


def test_faces_have_numbers():
    assert face_numbers("hex8").tolist() == [1, 2, 3, 4, 5, 6]
    assert face_numbers("tet10").tolist() == [1] * 4 + [2] * 4 + [3] * 4 + [4] * 4
    assert np.bincount(face_numbers("hex20r")).tolist() == [0, 5, 5, 5, 5, 5, 5]
    assert np.bincount(face_numbers("wedge15")).tolist() == [0, 4, 4, 5, 5, 5]


def test_edges_of_the_interface_graph_are_halves():
    for kind in ("hex20", "hex20r", "hex20s", "wedge15"):
        corners = 8 if kind.startswith("hex") else 6
        assert all(low < corners <= high for low, high in (sorted(e) for e in EDGES[kind]))
        assert np.bincount(np.ravel(EDGES[kind]))[corners:].tolist() == [2] * (len(EDGES[kind]) // 2)


@pytest.mark.parametrize("kind", NETWORK)
def test_abaqus_deck_written_and_read_is_the_same(tmp_path, kind):
    """At most 16 fields to a line, as Abaqus reads them."""
    model = read(tmp_path, abaqus(kind, more=SURFACES))
    write_deck(model, tmp_path / "copy.inp")
    assert difference(model, read_deck(tmp_path / "copy.inp"), names=False) == ""
    text = (tmp_path / "copy.inp").read_text()
    assert max(len([f for f in line.split(",") if f.strip()]) for line in text.splitlines() if line[0] != "*") <= 16
    assert re.findall(r"TYPE=(\w+)", text) == [kind, "C3D15"]
    surfaces = [line.split(",")[-1].strip() for line in text.split("*SURFACE, NAME=H4")[1].splitlines()[1:2]]
    assert surfaces == ["S4"]


@pytest.mark.parametrize("network", ["", ",2,,1", ",3,,1"])
def test_nastran_deck_written_and_read_is_the_same(tmp_path, network):
    model = read(tmp_path, nastran(network))
    write_nastran(model, tmp_path / "copy.bdf")
    copy = read_nastran(tmp_path / "copy.bdf")
    assert difference(model, copy, names=False, tolerance=1e-12) == ""
    for a, b in zip(matrices(model), matrices(copy), strict=True):
        np.testing.assert_allclose(a, b, atol=1e-12 * np.abs(a).max())


@pytest.mark.parametrize("kind", NETWORK)
def test_from_format_to_format_and_back(tmp_path, kind):
    model = replace(read(tmp_path, abaqus(kind)), mass_form="linear")
    write_nastran(model, tmp_path / "there.bdf")
    there = read_nastran(tmp_path / "there.bdf")
    assert [b.kind for b in there.blocks] == [b.kind for b in model.blocks]
    write_deck(replace(there, mass_form="consistent"), tmp_path / "back.inp")
    for a, b, c in zip(*(matrices(m) for m in (model, there, read_deck(tmp_path / "back.inp"))), strict=True):
        np.testing.assert_allclose(a, b, atol=1e-12 * np.abs(a).max())
        np.testing.assert_allclose(a, c, atol=1e-12 * np.abs(a).max())


def test_two_integrations_under_one_section_become_two_properties(tmp_path):
    text = abaqus(bow=0.0).replace(
        "*SOLID SECTION, ELSET=H, MATERIAL=STEEL\n*SOLID SECTION, ELSET=W",
        "*ELSET, ELSET=A\n H, W\n*SOLID SECTION, ELSET=A",
    )
    model = replace(read(tmp_path, text), mass_form="linear")
    write_nastran(model, tmp_path / "there.bdf")
    assert [b.kind for b in read_nastran(tmp_path / "there.bdf").blocks] == ["hex20", "wedge15"]
    assert (tmp_path / "there.bdf").read_text().count("PSOLID") == 2


def test_reduced_shear_is_no_element_of_abaqus(tmp_path):
    with pytest.raises(InputError, match=r"hexahedron with reduced shear; IN = 2 and ISOP = 1 of PSOLID"):
        write_deck(replace(read(tmp_path, nastran("")), mass_form="consistent"), tmp_path / "copy.inp")
    assert not (tmp_path / "copy.inp").exists()


def test_vtu_and_universal_file_know_the_elements(tmp_path):
    """Middle nodes stand where the format wants them: half way between the nodes beside them."""
    model = read(tmp_path, abaqus(bow=0.0))
    shape = np.zeros((model.nodes.count, 3))
    write_vtu(tmp_path / "m.vtu", model, [1.0], iter([shape]))
    write_uff(tmp_path / "m.unv", model, [1.0], iter([shape]))
    lines = (tmp_path / "m.unv").read_text().splitlines()
    start = lines.index("  2412") + 1
    found = {}
    while lines[start] != "    -1":
        head = [int(v) for v in lines[start].split()]
        rows = -(-head[5] // 8)
        found[head[0]] = (head[1], [int(v) for line in lines[start + 1 : start + 1 + rows] for v in line.split()])
        start += 1 + rows
    assert [found[k][0] for k in (1, 11, 12)] == [116, 113, 113]
    x = dict(zip(model.nodes.ids.tolist(), model.nodes.coords, strict=True))
    for label, side in ((1, 4), (11, 3), (12, 3)):
        nodes = [x[n] for n in found[label][1]]
        low, between, high = nodes[: 2 * side], nodes[2 * side : 3 * side], nodes[3 * side :]
        for ring in (low, high):
            for k in range(1, 2 * side, 2):
                np.testing.assert_allclose(ring[k], 0.5 * (ring[k - 1] + ring[(k + 1) % (2 * side)]))
        for k, middle in enumerate(between):
            np.testing.assert_allclose(middle, 0.5 * (low[2 * k] + high[2 * k]))


def test_hexahedron_and_wedges_hang_together(tmp_path):
    """Hexahedron and wedges share the middle nodes of their common face: six rigid motions and no more."""
    system = assembled(read(tmp_path, nastran("")))
    keep = system.coordinates % 6 < 3
    energy = np.linalg.eigvalsh(to_dense(system.K)[np.ix_(keep, keep)])
    assert np.count_nonzero(energy < 1e-9 * energy[-1]) == 6
