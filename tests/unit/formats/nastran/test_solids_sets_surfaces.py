"""Solids, and what a study can name: sets, properties, surfaces, parts."""

from __future__ import annotations

import numpy as np
import pytest

from creak.elements.block_matrices import block_matrices
from helpers_nastran import motion, read, rigid_mass, row, unread
from helpers_refusal import refusal

CUBE = "".join(
    f"GRID,{i},,{x}.,{y}.,{z}.\n"
    for i, (x, y, z) in enumerate(
        [(0, 0, 0), (2, 0, 0), (2, 2, 0), (0, 2, 0), (0, 0, 2), (2, 0, 2), (2, 2, 2), (0, 2, 2)], start=1
    )
)
MAT1 = "MAT1,1,1000.,,.25,3.-3\n"
HELD = "SPC1,1,3,1,2,3,4\nSPC1,1,2,1,2\nSPC1,1,1,1\n"
ELEMENTS = {
    "hex8": "CHEXA,1,1,1,2,3,4,5,6\n,7,8\n",
    "wedge6": "CPENTA,1,1,1,2,3,5,6,7\nCPENTA,2,1,1,3,4,5,7,8\n",
    "tet4": "CTETRA,1,1,1,2,3,7\nCTETRA,2,1,1,3,4,7\nCTETRA,3,1,4,8,1,7\nCTETRA,4,1,8,5,1,7\nCTETRA,5,1,5,6,1,7\nCTETRA,6,1,6,2,1,7\n",
}


def stretched(model, dof=3):
    """Motion of grid 7 under a pull of 4 on the top, shared as constant stress asks."""
    shares = {5: 0.0, 6: 0.0, 7: 0.0, 8: 0.0}
    for block in model.blocks:
        for nodes in block.nodes_idx:
            top = [int(model.nodes.ids[i]) for i in nodes if model.nodes.ids[i] >= 5]
            if len(top) > 2:
                area = 4.0 if len(top) == 4 else 2.0
                for grid in top:
                    shares[grid] += area / len(top)
    return motion(model, {(g, dof): f for g, f in shares.items()})[row(model, 7)]


@pytest.mark.parametrize("kind", ELEMENTS)
def test_solids(tmp_path, kind):
    """A cube of side 2 under stress 1: strain 1/E along it, -nu/E across; mass rho V."""
    model = read(tmp_path, CUBE + ELEMENTS[kind] + "PSOLID,1,1\n" + MAT1 + HELD)
    assert model.blocks[0].kind == kind
    np.testing.assert_allclose(stretched(model)[:3], [-0.5e-3, -0.5e-3, 2e-3], atol=1e-12)
    assert rigid_mass(model)[0, 0] == pytest.approx(8 * 3e-3)


def test_quadratic_tetrahedron(tmp_path):
    """Mid-side grids in Nastran's order: 1-2, 2-3, 3-1, 1-4, 2-4, 3-4; mass and volume come out right."""
    corners = np.array([[0, 0, 0], [3, 0, 0], [0, 3, 0], [0, 0, 3]], dtype=float)
    middles = [0.5 * (corners[a] + corners[b]) for a, b in ((0, 1), (1, 2), (2, 0), (0, 3), (1, 3), (2, 3))]
    grids = "".join(f"GRID,{i},,{x},{y},{z}\n" for i, (x, y, z) in enumerate([*corners, *middles], start=1))
    model = read(tmp_path, grids + "CTETRA,1,1,1,2,3,4,5,6\n,7,8,9,10\nPSOLID,1,1\n" + MAT1)
    assert model.blocks[0].kind == "tet10"
    assert rigid_mass(model)[0, 0] == pytest.approx(4.5 * 3e-3)


def test_anisotropic_solid(tmp_path):
    """MAT9 whose axis 1 is the basic z (CORDM): stress 1 along it strains by 1/E1."""
    E1, E2, nu, G = 5000.0, 1000.0, 0.0, 400.0
    upper = [E1, nu, 0, 0, 0, 0, E2, 0, 0, 0, 0, E2, 0, 0, 0, G, 0, 0, G, 0, G]
    f = [f"{float(v)}" for v in upper]
    card = "MAT9,1," + ",".join(f[:7]) + "\n," + ",".join(f[7:15]) + "\n," + ",".join(f[15:]) + ",3.-3\n"
    frame = "CORD2R,5,,0.,0.,0.,1.,0.,0.\n,0.,0.,1.\n"
    model = read(tmp_path, frame + CUBE + ELEMENTS["hex8"] + "PSOLID,1,1,5\n" + card + HELD)
    # x of system 5 is the basic z, its z the basic x.
    np.testing.assert_allclose(stretched(model)[2], 2.0 / E1, rtol=1e-9)
    assert rigid_mass(model)[0, 0] == pytest.approx(8 * 3e-3)


def test_pyramids_of_thirteen_grids_are_refused(tmp_path):
    error = refusal(read, tmp_path, CUBE + "GRID,9\nCPYRAM,1,1,1,2,3,4,5,9\nPSOLID,1,1\n" + MAT1)
    assert (error.what, error.expected) == ("CPYRAM 1 has 6 grids", "5 grids")


def test_coupmass_gives_tetrahedra_of_ten_grids_their_consistent_mass(tmp_path):
    """u = x^2 along x, which the element holds: u'Mu = rho integral of x^4 = 24 rho V/840. Lumped, that is told."""
    grids = "".join(f"GRID,{k},,{x}\n" for k, x in enumerate(("0.", "1.", "0.,1.", "0.,0.,1."), start=1))
    grids += "GRID,5,,.5\nGRID,6,,.5,.5\nGRID,7,,0.,.5\nGRID,8,,0.,0.,.5\nGRID,9,,.5,0.,.5\nGRID,10,,0.,.5,.5\n"
    deck = grids + "CTETRA,1,1,1,2,3,4,5,6\n,7,8,9,10\nPSOLID,1,1\nMAT1,1,2.+5,,.3,6.\n"
    energy = []
    for param in ("PARAM,COUPMASS,1\n", ""):
        model = read(tmp_path, param + deck)
        assert unread(model) == ({} if param else {"CTETRA of 10 grids, lumped mass": False})
        (block,) = model.blocks
        M = block_matrices(block, slice(None), model.nodes.coords, form=model.mass_form)[1][0, ::6, ::6]
        u = model.nodes.coords[:, 0] ** 2
        assert M.sum() == pytest.approx(1.0, rel=1e-12)
        energy.append(u @ M @ u)
    assert energy[0] == pytest.approx(24.0 / 840.0, rel=1e-12)
    assert energy[1] > 1.5 * energy[0]


PLATES = (
    '$HMNAME PROP       1"Upper skin"\nGRID,1\nGRID,2,,1.\nGRID,3,,1.,1.\nGRID,4,,,1.\nGRID,11,,,,5.\nGRID,12,,1.,,5.\nGRID,13,,1.,1.,5.\n'
    "CQUAD4,1,1,1,2,3,4\nCTRIA3,2,2,11,12,13\nPSHELL,1,1,.1,1,,1\nPSHELL,2,1,.1,1,,1\n" + MAT1
)


def test_parts_and_sets(tmp_path):
    """A part of one property is called after it; properties are element sets, with their names from comments."""
    sets = "SET1,7,1,2,11\nSET3,8,ELEM,2\nASET1,123,1,THRU,3\nSUPORT,4,123456\nBSET,11,3,12,3\n"
    model = read(tmp_path, PLATES + sets, "SET 9 = 1, 3 THRU 12 EXCEPT 12\n")
    assert [p.name for p in model.parts] == ["PID_1", "PID_2"]
    assert {k: v.tolist() for k, v in model.element_sets.items()} == {
        "PID_1": [[0, 0]],
        "PID_2": [[1, 0]],
        "UPPER_SKIN": [[0, 0]],
        "SET_7": [[0, 0], [1, 0]],
        "SET_8": [[1, 0]],
        "SET_9": [[0, 0]],
    }
    ids = {k: model.nodes.ids[v].tolist() for k, v in model.node_sets.items()}
    assert ids == {"ASET": [1, 2, 3], "SUPORT": [4], "BSET": [11, 12], "SET_7": [1, 2, 11], "SET_9": [1, 3, 4, 11]}
    assert [name for name, changes in unread(model).items() if changes] == ["ASET1", "BSET"]


def test_two_properties_in_one_part(tmp_path):
    model = read(tmp_path, PLATES.replace("11,12,13", "1,2,13"))
    assert [p.name for p in model.parts] == ["PART-1"]


def test_surfaces(tmp_path):
    """Shells: both sides, positive, negative. Solids: the faces that no other solid shares."""
    model = read(tmp_path, PLATES)
    assert {k: s.side.tolist() for k, s in model.surfaces.items() if k.startswith("PID_1")} == {
        "PID_1": [0],
        "PID_1.SPOS": [1],
        "PID_1.SNEG": [-1],
    }
    model = read(tmp_path, CUBE + ELEMENTS["wedge6"] + "PSOLID,1,1\n" + MAT1)
    assert model.surfaces["PID_1"].facets.shape == (8, 2)
    assert model.surfaces["PID_1"].nodes_idx.size == 8


def test_sets_hold_all_pieces_of_an_element(tmp_path):
    """A tapered bar is 12 elements, a bushing with two losses 2: lists of ids that have it reach all of them."""
    bulk = (
        "GRID,1,,0.,0.,0.\nGRID,2,,100.,0.,0.\nGRID,3,,0.,50.,0.\nMAT1,1,7.+4,,.3\nCBEAM,13,13,1,2,0.,1.,0.\n"
        "PBEAM,13,1,20.,10.,10.,,10.\n,,,,,,,,\n,YES,1.,10.,5.,5.,,5.\nCROD,14,14,1,3\nPROD,14,1,1.\n"
        "CBUSH,15,15,3,2,,,,0\nPBUSH,15,K,1.,2.,3.,4.,5.,6.\n,GE,.2,.1,.1,.1,.1,.1\nPARAM,W4,10.\n"
        "SET1,7,13\nSET3,8,ELEM,13,THRU,99\nSET,10,ELEM,LIST\n,15\nSURF,11,ELFACE\n,13\n"
    )
    model = read(tmp_path, bulk, "SET 9 = 13, 14\n")
    of_pid = {k: {tuple(at) for at in model.element_sets[f"PID_{k}"].tolist()} for k in (13, 14, 15)}
    assert [len(rows) for rows in of_pid.values()] == [12, 1, 2]
    wanted = {"SET_7": (13,), "SET_8": (13, 14, 15), "SET_9": (13, 14), "SET_10": (15,), "SURF_11": (13,)}
    for name, of in wanted.items():
        rows = model.element_sets[name].tolist()
        assert {tuple(at) for at in rows} == set().union(*(of_pid[k] for k in of))
        assert len(rows) == sum(len(of_pid[k]) for k in of)
