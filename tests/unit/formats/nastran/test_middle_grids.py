"""Elements that leave out some grids at the middles of their sides: patch tests, bending, mass, supports, heat."""

from __future__ import annotations

import numpy as np
import pytest

from creak.formats.nastran.mesh.solids import ORDER
from creak.model.mesh import Model
from helpers_nastran import assembled, read, rigid_mass, to_dense, unread
from helpers_solids import EDGES, solid_mesh

CARD = {"hex20s": "CHEXA", "wedge15": "CPENTA", "tet10": "CTETRA"}
YOUNG, NU = 2.0e5, 0.3


def solids(kind: str, n: tuple[int, int, int], size: tuple[float, float, float], keep, nu: float = NU) -> str:
    """A distorted block of which middle grids are there where `keep(ends)` says so, in all elements that share them."""
    coords, elements = solid_mesh(n, size, kind, 0.2 if nu else 0.0)
    lines = [f"GRID,{k + 1},,{x!r},{y!r},{z!r}" for k, (x, y, z) in enumerate(coords.tolist())]
    corners = elements.shape[1] - len(EDGES[kind])
    for e, row in enumerate(elements.tolist()):
        fields = [str(i + 1) for i in row]
        for k, (i, j) in enumerate(EDGES[kind]):
            if not keep(coords[[row[i], row[j]]]):
                fields[corners + k] = ""
        ordered = [str(e + 1), "1", *(fields[k] for k in ORDER.get(kind, range(len(fields))))]
        pieces = [",".join(ordered[k : k + 8]) for k in range(0, len(ordered), 8)]
        lines += [f"{CARD[kind]},{pieces[0]}", *(f",{piece}" for piece in pieces[1:])]
    return "\n".join([*lines, f"MAT1,1,{YOUNG},,{nu},1.", "PSOLID,1,1", ""])


def some(ends: np.ndarray) -> bool:
    """Some half of the sides, whichever element asks."""
    return int(1e6 * abs(ends.sum(axis=0) @ [1.0, np.sqrt(2.0), np.sqrt(3.0)])) % 2 == 0


def forces(model: Model, u: np.ndarray, dofs: slice) -> tuple[float, np.ndarray]:
    """Energy of a motion u (n_node, 6) of the nodes of elements, and the forces on the free dofs."""
    system, R = assembled(model), reach(model)
    used = np.unique(np.concatenate([b.nodes_idx.ravel() for b in model.blocks]))
    A, b = R[used, dofs].reshape(-1, R.shape[2]), u[used, dofs].ravel()
    q = np.linalg.lstsq(A, b, rcond=None)[0]
    np.testing.assert_allclose(A @ q, b, atol=1e-9 * np.abs(b).max())
    f = to_dense(system.K) @ q
    return 0.5 * float(q @ f), f


def reach(model: Model) -> np.ndarray:
    """(n_node, 6, n_free): motion of the nodes from the free dofs."""
    return to_dense(assembled(model).rows(np.arange(6 * model.nodes.count))[0]).reshape(model.nodes.count, 6, -1)


@pytest.mark.parametrize("kind", CARD)
def test_constant_strain_of_solids_is_exact(tmp_path, kind):
    """Of distorted blocks: energy V e'De/2, and no force inside."""
    size = (3.0, 2.0, 2.5)
    model = read(tmp_path, solids(kind, (2, 2, 2), size, some))
    assert model.blocks[0].kind == kind
    told = {"CTETRA of 10 grids, lumped mass": False} if kind == "tet10" else {}
    assert unread(model) == {f"{CARD[kind]} without some middle grids": False, **told}
    slope = np.random.default_rng(3).normal(size=(3, 3))
    u = np.pad(model.nodes.coords @ slope.T, ((0, 0), (0, 3)))
    energy, f = forces(model, u, slice(0, 3))
    e, lame, shear = 0.5 * (slope + slope.T), YOUNG * NU / (1 + NU) / (1 - 2 * NU), YOUNG / (2 + 2 * NU)
    exact = np.prod(size) * (0.5 * lame * np.trace(e) ** 2 + shear * (e * e).sum())
    assert energy == pytest.approx(exact, rel=1e-10)
    x = model.nodes.coords
    inner = ((x > 1e-9) & (x < np.array(size) - 1e-9)).all(axis=1)
    inside = np.abs(reach(model)[~inner]).sum(axis=(0, 1)) == 0.0
    assert inside.any()
    assert np.abs(f[inside]).max() < 1e-9 * np.abs(f).max()


def test_middle_grids_along_a_beam_alone_bend_it_exactly(tmp_path):
    """nu = 0, u = -k x y, v = k x^2/2: linear across, a parabola along; energy E I k^2 L/2."""
    length, height, width, k = 6.0, 1.0, 0.5, 0.01
    deck = solids("hex20s", (3, 1, 1), (length, height, width), lambda ends: np.ptp(ends[:, 0]) > 1.0, nu=0.0)
    model = read(tmp_path, deck)
    x, y, _ = (model.nodes.coords - [0.0, 0.5 * height, 0.0]).T
    u = np.zeros((model.nodes.count, 6))
    u[:, 0], u[:, 1] = -k * x * y, 0.5 * k * x * x
    followers = [c.nodes_idx for c in model.constraints]
    for row, a, b in followers:
        u[row] = 0.5 * (u[a] + u[b])
    energy, _ = forces(model, u, slice(0, 3))
    assert energy == pytest.approx(0.5 * YOUNG * width * height**3 / 12.0 * k**2 * length, rel=1e-10)


SHELLS = (
    "GRID,1,,0.,0.\nGRID,2,,4.,0.\nGRID,3,,4.,2.\nGRID,4,,0.,2.\nGRID,5,,2.,0.\nGRID,7,,2.,2.\n"
    f"MAT1,1,{YOUNG},,0.,1.\nPSHELL,1,1,.1,1,,1\n"
)
CQUAD8 = SHELLS + "CQUAD8,1,1,1,2,3,4,5,\n,7,\n"


@pytest.mark.parametrize("across", [False, True])
def test_a_quadrilateral_with_two_middle_grids_bends_exactly_along_them(tmp_path, across):
    """In its plane and out of it: energies E t b^3/12 and E b t^3/12 times k^2 L/2."""
    model, k = read(tmp_path, CQUAD8), 0.01
    assert [b.kind for b in model.blocks] == ["quad8"]
    x, y = model.nodes.coords[:, 0], model.nodes.coords[:, 1] - 1.0
    u = np.zeros((model.nodes.count, 6))
    if across:
        u[:, 2], u[:, 4] = 0.5 * k * x * x, -k * x
    else:
        u[:, 0], u[:, 1], u[:, 5] = -k * x * y, 0.5 * k * x * x, k * x
    energy, _ = forces(model, u, slice(0, 6))
    inertia = 2.0 * 0.1**3 / 12.0 if across else 0.1 * 2.0**3 / 12.0
    assert energy == pytest.approx(0.5 * YOUNG * inertia * k**2 * 4.0, rel=2e-8)


@pytest.mark.parametrize(
    ("card", "grids"), [("CQUAD8,1,1,1,2,3,4,5,\n,7,", 8), ("CTRIA6,1,1,1,2,3,5", 6), ("CTRIA6,1,1,1,2,3,,,0", 3)]
)
def test_constant_membrane_strain_of_shells_is_exact(tmp_path, card, grids):
    model = read(tmp_path, SHELLS + card + "\n")
    assert model.blocks[0].nodes_idx.shape == (1, grids)
    area = 8.0 if "QUAD" in card else 4.0
    slope = np.array([[1e-3, 4e-4], [4e-4, -2e-3]])
    u = np.zeros((model.nodes.count, 6))
    u[:, :2] = model.nodes.coords[:, :2] @ slope.T
    energy, _ = forces(model, u, slice(0, 6))
    assert energy == pytest.approx(0.5 * 0.1 * area * YOUNG * (slope * slope).sum(), rel=1e-8)


@pytest.mark.parametrize("coupled", ["", "PARAM,COUPMASS,1\n"])
def test_mass_is_kept_and_a_wide_thru_holds_no_added_node(tmp_path, coupled):
    """The node that stands for a grid left out has an id above all others, which no card finds."""
    model = read(tmp_path, coupled + CQUAD8 + "SPC1,1,123456,1,THRU,99\n")
    assert model.nodes.ids.tolist() == [1, 2, 3, 4, 5, 7, 8, 9]
    assert {i for f in model.fixed for i in f.nodes_idx.tolist()} == set(range(6))
    assert len(model.constraints) == 12
    assert rigid_mass(model)[0, 0] == pytest.approx(0.8, rel=1e-12)


def test_temperature_of_a_side_without_a_grid_is_the_mean_of_its_ends(tmp_path):
    heat = "TEMP,3,1,10.,2,20.\nTEMP,3,3,40.,4,30.\nTEMP,3,5,15.,7,35.\n"
    model = read(tmp_path, CQUAD8 + heat, "TEMPERATURE(INITIAL) = 3\n")
    warm = model.initial_temperature
    assert warm is not None
    found = dict(zip(model.nodes.ids[warm.nodes_idx].tolist(), warm.value.tolist(), strict=True))
    assert (found[8], found[9]) == (30.0, 20.0)
