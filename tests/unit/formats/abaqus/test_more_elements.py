"""Membranes, rigid elements, continuum shells, cohesive layers, pyramids and display bodies in Abaqus decks."""

from __future__ import annotations

import numpy as np
import pytest

from creak.elements.block_matrices import block_matrices
from creak.errors import InputError
from creak.formats.decks import read_model
from creak.model.materials import GeneralShell
from creak.studies.models.deck_modes import deck_modes

SQUARE = "*NODE\n1, 0, 0, 0\n2, 10, 0, 0\n3, 10, 10, 0\n4, 0, 10, 0\n"
TOP = "5, 0, 0, 2\n6, 10, 0, 2\n7, 10, 10, 2\n8, 0, 10, 2\n"
STEEL = "*MATERIAL, NAME=M\n*ELASTIC\n7e4, 0.3\n*DENSITY\n2.7e-9\n"
GLUE = "*MATERIAL, NAME=G\n*ELASTIC, TYPE=TRACTION\n{}\n*DENSITY\n1e-9\n"


@pytest.fixture
def read(tmp_path):
    def one(text):
        (tmp_path / "a.inp").write_text(text)
        return read_model(tmp_path / "a.inp")

    return one


def matrices(model, k=0):
    return block_matrices(model.blocks[k], slice(None), model.nodes.coords)


@pytest.mark.parametrize(("kind", "nodes", "share"), [("M3D4", "1,2,3,4", 1.0), ("M3D3", "1,2,3", 0.5)])
def test_membranes_stretch_and_hardly_bend(read, kind, nodes, share):
    text = f"{SQUARE}*ELEMENT, TYPE={kind}, ELSET=P\n1, {nodes}\n*MEMBRANE SECTION, ELSET=P, MATERIAL=M\n0.5,\n{STEEL}"
    model = read(text)
    K, M, _ = matrices(model)
    n = model.blocks[0].nodes_idx.shape[1]
    x = model.nodes.coords[:n]
    stretch, bend = np.zeros((n, 6)), np.zeros((n, 6))
    stretch[:, 0], stretch[:, 1] = 1e-3 * x[:, 0], -0.3e-3 * x[:, 1]
    bend[:, 2], bend[:, 4] = -0.5e-3 * x[:, 0] ** 2, 1e-3 * x[:, 0]
    energy = [float(u.ravel() @ K[0] @ u.ravel()) for u in (stretch, bend)]
    assert energy[0] == pytest.approx(7e4 * 1e-6 * 0.5 * 100 * share, rel=1e-9), "E e^2 t A in uniaxial stress"
    assert 0.0 < energy[1] < 1e-5 * 7e4 / 0.91 * 0.5**3 / 12 * 1e-6 * 100
    u = np.zeros((n, 6))
    u[:, 0] = 1.0
    assert u.ravel() @ M[0] @ u.ravel() == pytest.approx(2.7e-9 * 0.5 * 100 * share)
    assert not any(u.changes_answer for u in model.unread)


RIGID = (
    f"{SQUARE}9, 5, 5, 5\n10, 5, 5, 0.4\n*ELEMENT, TYPE=R3D4, ELSET=R\n1, 1,2,3,4\n*RIGID BODY, ELSET=R, REF NODE=9\n"
    "*ELEMENT, TYPE=MASS, ELSET=HEAVY\n2, 9\n*MASS, ELSET=HEAVY\n0.001\n*ELEMENT, TYPE=ROTARYI, ELSET=TURN\n3, 9\n"
    "*ROTARY INERTIA, ELSET=TURN\n0.1, 0.1, 0.1\n*SURFACE, NAME=WALL\nR, SPOS\n" + STEEL
)


def test_rigid_elements_are_rigid_and_weigh_nothing(tmp_path):
    """Six rigid motions of the mass at the reference node, and nothing else."""
    (tmp_path / "a.inp").write_text(RIGID)
    found = deck_modes(tmp_path / "a.inp", count=6)
    assert len(found.frequencies) == 6
    assert found.rigid == 6
    model = read_model(tmp_path / "a.inp")
    assert model.surfaces["WALL"].facets.shape == (1, 2)
    section = model.blocks[0].section
    assert isinstance(section, GeneralShell)
    assert section.mass == 0.0
    assert 0.0 < section.thickness < 1e-4, "contact sees the surface where it lies"


def test_rigid_elements_need_their_body(read):
    with pytest.raises(InputError, match=r"type R3D4 has no section: 1; expected \*RIGID BODY"):
        read(RIGID.replace("*RIGID BODY, ELSET=R, REF NODE=9\n", "").replace("1, 1,2,3,4\n", "1, 1,2,3,4\n"))


@pytest.mark.parametrize("kind", ["C3D8I", "SC8R"])
def test_continuum_shells_bend_as_plates(read, kind, tmp_path):
    """First frequency of a clamped strip, one element through 2 mm: 1.8751^2 / (2 pi L^2) sqrt(E h^2 / 12 rho)."""
    n, length, width, h = 20, 100.0, 10.0, 2.0
    nodes = [
        f"{1 + 4 * i + j}, {length * i / n}, {width * (j % 2)}, {h * (j // 2)}" for i in range(n + 1) for j in range(4)
    ]
    cells = [
        f"{i + 1}, {4 * i + 1}, {4 * i + 5}, {4 * i + 6}, {4 * i + 2}, {4 * i + 3}, {4 * i + 7}, {4 * i + 8}, {4 * i + 4}"
        for i in range(n)
    ]
    section = "SOLID SECTION" if kind == "C3D8I" else "SHELL SECTION"
    text = (
        "*NODE\n"
        + "\n".join(nodes)
        + f"\n*ELEMENT, TYPE={kind}, ELSET=P\n"
        + "\n".join(cells)
        + f"\n*{section}, ELSET=P, MATERIAL=M\n2.,\n"
        + STEEL.replace("0.3", "0.0")
        + "*BOUNDARY\n1, 1, 3\n2, 1, 3\n3, 1, 3\n4, 1, 3\n"
    )
    (tmp_path / "a.inp").write_text(text)
    exact = 1.875104**2 / (2 * np.pi * length**2) * np.sqrt(7e4 * h**2 / (12 * 2.7e-9))
    assert deck_modes(tmp_path / "a.inp", count=1).frequencies[0] == pytest.approx(exact, rel=0.005)


def test_plies_of_continuum_shells_are_refused(read):
    text = (
        SQUARE + TOP + "*ELEMENT, TYPE=SC8R, ELSET=P\n1, 1,2,3,4,5,6,7,8\n*SHELL SECTION, ELSET=P, COMPOSITE\n1,3,M,0\n"
    )
    with pytest.raises(InputError, match="COMPOSITE of continuum shells"):
        read(text + STEEL)


def glued(data: str, thickness: str) -> str:
    return (
        SQUARE + TOP + "*ELEMENT, TYPE=COH3D8, ELSET=G\n1, 1,2,3,4,5,6,7,8\n"
        f"*COHESIVE SECTION, ELSET=G, MATERIAL=G, RESPONSE=TRACTION SEPARATION\n{thickness}\n" + GLUE.format(data)
    )


@pytest.mark.parametrize(("thickness", "T0"), [("", 1.0), ("0.25,", 0.25)])
def test_cohesive_layers(read, thickness, T0):
    """K = E / T0 per area, whatever the distance of the faces in the mesh; mass rho T0 per area."""
    model = read(glued("100., 40., 30.", thickness))
    K, M, _ = matrices(model)
    for dof, modulus in ((0, 40.0), (1, 30.0), (2, 100.0)):
        u = np.zeros((8, 6))
        u[4:, dof] = 1.0
        assert u.ravel() @ K[0] @ u.ravel() == pytest.approx(modulus / T0 * 100.0)
    u = np.zeros((8, 6))
    u[:, 1] = 1.0
    assert u.ravel() @ M[0] @ u.ravel() == pytest.approx(1e-9 * T0 * 100.0)


@pytest.mark.parametrize(
    ("old", "new", "text"),
    [
        ("RESPONSE=TRACTION SEPARATION", "RESPONSE=CONTINUUM", "RESPONSE=CONTINUUM"),
        ("TYPE=TRACTION\n100., 40., 30.", "TYPE=ISO\n100., .3", "no .ELASTIC, TYPE=TRACTION"),
        ("100., 40., 30.", "100., -40., 30.", "constant 2 of material 'G'"),
    ],
)
def test_cohesive_mistakes(read, old, new, text):
    with pytest.raises(InputError, match=text):
        read(glued("100., 40., 30.", "").replace(old, new))


def test_traction_is_for_cohesive_sections_alone(read):
    shell = SQUARE + "*ELEMENT, TYPE=S4, ELSET=P\n1, 1,2,3,4\n*SHELL SECTION, ELSET=P, MATERIAL=G\n1.\n"
    with pytest.raises(InputError, match="which cohesive elements alone have"):
        read(shell + GLUE.format("1., 1., 1."))


def test_a_pyramid(read):
    text = SQUARE + "5, 5, 5, 6\n*ELEMENT, TYPE=C3D5, ELSET=P\n1, 1,2,3,4,5\n*SOLID SECTION, ELSET=P, MATERIAL=M\n"
    model = read(text + STEEL + "*SURFACE, NAME=ALL\nP,\n*SURFACE, NAME=BASE\nP, S1\n")
    u = np.zeros((5, 6))
    u[:, 0] = 1.0
    assert u.ravel() @ matrices(model)[1][0] @ u.ravel() == pytest.approx(2.7e-9 * 200.0), "a third of base and height"
    assert (len(model.surfaces["ALL"].facets), len(model.surfaces["BASE"].facets)) == (5, 1)
    assert sorted(model.surfaces["BASE"].nodes_idx.tolist()) == [0, 1, 2, 3]


def test_display_bodies_are_left_out(read):
    part = SQUARE + "*ELEMENT, TYPE=S4, ELSET=P\n1, 1,2,3,4\n*SHELL SECTION, ELSET=P, MATERIAL=M\n1.\n"
    drawn = SQUARE + "*ELEMENT, TYPE=R3D4, ELSET=P\n1, 1,2,3,4\n"
    text = (
        f"*PART, NAME=A\n{part}*END PART\n*PART, NAME=B\n{drawn}*END PART\n*ASSEMBLY, NAME=X\n"
        "*INSTANCE, NAME=A-1, PART=A\n*END INSTANCE\n*INSTANCE, NAME=B-1, PART=B\n*END INSTANCE\n"
        "*ELSET, ELSET=SHOWN, INSTANCE=B-1\n1,\n*DISPLAY BODY, INSTANCE=B-1\n*END ASSEMBLY\n" + STEEL
    )
    model = read(text)
    assert [p.name for p in model.parts] == ["A-1"]
    assert "SHOWN" not in model.element_sets
    assert [u.keyword for u in model.unread] == ["*DISPLAY BODY"]
    assert not model.unread[0].changes_answer


@pytest.mark.parametrize("kind", ["S4", "S4T", "S4RS", "S4RSW"])
def test_names_of_the_same_shell(read, kind):
    text = SQUARE + f"*ELEMENT, TYPE={kind}, ELSET=P\n1, 1,2,3,4\n*SHELL SECTION, ELSET=P, MATERIAL=M\n1.\n" + STEEL
    model = read(text)
    assert [b.kind for b in model.blocks] == ["quad4"]
    assert [u.keyword for u in model.unread] == (["*ELEMENT, TYPE=S4T"] if kind == "S4T" else [])
    assert not any(u.changes_answer for u in model.unread)
