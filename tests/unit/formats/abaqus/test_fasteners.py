"""*FASTENER: layers joined at reference nodes, rigidly or by springs."""

from __future__ import annotations

import numpy as np
import pytest

from creak.assembly.elimination import linear_equations
from creak.elements.block_matrices import block_matrices
from creak.errors import InputError
from creak.formats.decks import read_model
from creak.studies.models.deck_modes import deck_modes
from fuzz_more_samples import FASTENED

N = 6


def sheet(first: int, name: str, z: float) -> str:
    nodes = [f"{first + 7 * j + i}, {10 * i}, {10 * j}, {z}" for j in range(3) for i in range(N + 1)]
    cells = [
        f"{first + N * j + i}, "
        + ", ".join(str(first + 7 * (j + b) + i + a) for a, b in ((0, 0), (1, 0), (1, 1), (0, 1)))
        for j in range(2)
        for i in range(N)
    ]
    return (
        "*NODE\n"
        + "\n".join(nodes)
        + f"\n*ELEMENT, TYPE=S4, ELSET={name}\n"
        + "\n".join(cells)
        + f"\n*SHELL SECTION, ELSET={name}, MATERIAL=M\n1.,\n*SURFACE, NAME=S_{name}\n{name},\n"
    )


DECK = (
    sheet(1, "A", 0.0)
    + sheet(101, "B", 1.0)
    + "*MATERIAL, NAME=M\n*ELASTIC\n2.1e5, 0.3\n*DENSITY\n7.85e-9\n"
    + "*NODE, NSET=SPOTS\n901, 14, 10, 0.5\n902, 44, 9, 0.5\n"
)
FASTENER = (
    "*FASTENER, INTERACTION NAME=F, PROPERTY=P, REFERENCE NODE SET=SPOTS\n\nS_A, S_B\n*FASTENER PROPERTY, NAME=P\n3.,\n"
)
BEAMS = "*CONNECTOR SECTION, ELSET=FE\nBEAM,\n"


def read(folder, text):
    (folder / "a.inp").write_text(DECK + text)
    return read_model(folder / "a.inp")


@pytest.mark.parametrize("text", [FASTENER, FASTENER.replace("SPOTS\n\n", "SPOTS, ELSET=FE\n0., 0., 1.\n") + BEAMS])
def test_layers_move_as_one_body_round_each_spot(tmp_path, text):
    """Rigid motion breaks no equation; a layer that slides, lifts or turns against the other does."""
    model = read(tmp_path, text)
    coords = model.nodes.coords
    equations = [e for c in model.constraints for e in linear_equations(c, coords)]
    assert len(equations) == 2 * 2 * 6

    def broken(u):
        return max(abs(u.ravel()[list(e.labels)] @ e.coefficients) for e in equations)

    u = np.zeros((model.nodes.count, 6))
    turn = np.array([0.4, -0.1, 0.3])
    u[:, :3], u[:, 3:] = np.cross(turn, coords) + [1.0, 2.0, 3.0], turn
    assert broken(u) < 1e-10
    for dof in range(3):
        apart = np.zeros_like(u)
        apart[coords[:, 2] == 1.0, dof] = 1.0
        assert broken(apart) > 0.4
    assert not any(x.changes_answer for x in model.unread)


def test_two_sheets_with_fasteners_float_as_one(tmp_path):
    (tmp_path / "a.inp").write_text(DECK + FASTENER)
    assert deck_modes(tmp_path / "a.inp", count=8).rigid == 6


SPRUNG = FASTENER.replace("SPOTS\n\n", "SPOTS, ELSET=FE\n\n") + (
    "*CONNECTOR SECTION, ELSET=FE, BEHAVIOR=SOFT\nBUSHING,\n*CONNECTOR BEHAVIOR, NAME=SOFT\n"
    + "".join(f"*CONNECTOR ELASTICITY, COMPONENT={k}\n{100.0 * k},\n" for k in range(1, 7))
)


def test_springs_between_the_layers(tmp_path):
    """A node on each layer, hung on it; six springs between them, the third along the normal."""
    model = read(tmp_path, SPRUNG)
    (block,) = [b for b in model.blocks if b.kind == "bush2"]
    assert (block.ids.size, block.part) == (2, -1)
    x = model.nodes.coords[block.nodes_idx]
    assert x[:, 0] == pytest.approx(np.array([[14.0, 10.0, 0.0], [44.0, 9.0, 0.0]]))
    assert x[:, 1] == pytest.approx(np.array([[14.0, 10.0, 1.0], [44.0, 9.0, 1.0]]))
    assert len(set(model.nodes.ids.tolist())) == model.nodes.count == 2 * 21 + 2 + 4
    K = block_matrices(block, slice(None), model.nodes.coords)[0]
    for dof in range(3):
        apart = np.zeros(12)
        apart[6 + dof] = 1.0
        assert apart @ K[0] @ apart == pytest.approx(100.0 * (dof + 1))
    u = np.zeros((model.nodes.count, 6))
    turn = np.array([0.4, -0.1, 0.3])
    u[:, :3], u[:, 3:] = np.cross(turn, model.nodes.coords), turn
    equations = [e for c in model.constraints for e in linear_equations(c, model.nodes.coords)]
    assert max(abs(u.ravel()[list(e.labels)] @ e.coefficients) for e in equations) < 1e-10
    assert np.abs(K @ u[block.nodes_idx[0]].ravel()).max() < 1e-9
    assert not any(x.changes_answer for x in model.unread)


def test_sprung_sheets_float_as_one(tmp_path):
    (tmp_path / "a.inp").write_text(DECK + SPRUNG)
    found = deck_modes(tmp_path / "a.inp", count=8)
    assert found.rigid == 6
    assert found.frequencies[6] < deck_modes_of_rigid(tmp_path), "springs are softer than a rigid joint"


def deck_modes_of_rigid(folder) -> float:
    (folder / "b.inp").write_text(DECK + FASTENER)
    return deck_modes(folder / "b.inp", count=7).frequencies[6]


def test_the_radius_of_influence_takes_more_nodes(tmp_path):
    near = read(tmp_path, FASTENER).constraints
    far = read(tmp_path, FASTENER.replace("PROPERTY=P,", "PROPERTY=P, RADIUS OF INFLUENCE=15,")).constraints
    assert [c.nodes_idx.size for c in near] == [4, 4, 4, 4]
    assert all(c.nodes_idx.size > 6 for c in far)


@pytest.mark.parametrize(
    ("old", "new", "told"),
    [
        ("S_A, S_B", "S_A", "names 1 surface"),
        ("S_A, S_B", "S_A, S_C", "on surface 'S_C'.*Did you mean"),
        ("PROPERTY=P,", "PROPERTY=Q,", "unknown .FASTENER PROPERTY 'Q'"),
        ("3.,", "-3.,", "radius of the fastener"),
        ("PROPERTY=P,", "PROPERTY=P, SEARCH RADIUS=0.1,", "farther than 0.1 from surface 'S_A'"),
        ("SPOTS\n\n", "SPOTS, ELSET=FE\n\n", "connection type 'SPRUNG' is not supported"),
    ],
)
def test_mistakes(tmp_path, old, new, told):
    assert old in FASTENER
    with pytest.raises(InputError, match=told):
        read(tmp_path, FASTENER.replace(old, new) + BEAMS.replace("BEAM", "SPRUNG") * ("ELSET" in new))


@pytest.mark.parametrize("text", [FASTENER, SPRUNG])
def test_mass_at_the_reference_nodes(tmp_path, text):
    model = read(tmp_path, text.replace("NAME=P\n", "NAME=P, MASS=1e-6\n"))
    (block,) = [b for b in model.blocks if b.kind == "mass"]
    assert model.nodes.ids[block.nodes_idx[:, 0]].tolist() == [901, 902]
    assert block.section.mass == 1e-6
    assert block.part == 0
    ids = np.concatenate([b.ids for b in model.blocks])
    assert len(set(ids.tolist())) == ids.size
    with pytest.raises(InputError, match="MASS of the fastener is -1"):
        read(tmp_path, text.replace("NAME=P\n", "NAME=P, MASS=-1\n"))


def test_what_is_left_out_is_listed(tmp_path):
    model = read(tmp_path, FASTENER.replace("PROPERTY=P,", "PROPERTY=P, COUPLING=STRUCTURAL,"))
    assert [(u.keyword, u.changes_answer) for u in model.unread] == [("*FASTENER, COUPLING=STRUCTURAL", True)]


def test_a_facet_without_area_has_no_direction(tmp_path):
    """A node of the only facet of the first layer lies on the one across."""
    (tmp_path / "a.inp").write_text(FASTENED.replace(" 4, 0., 10., 0.", " 4, 10., 0., 0."))
    with pytest.raises(InputError, match=r"surface 'SA' nearest to a reference node of \*FASTENER has no area"):
        read_model(tmp_path / "a.inp")
