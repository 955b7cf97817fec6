"""Parts cut up into pieces that share nodes, and joined again."""

from __future__ import annotations

import numpy as np
import pytest
import scipy.linalg as sla

from creak.arrays import to_dense
from creak.assembly.coupling import couple
from creak.assembly.part import part_system
from creak.assembly.partition import cut, shared_nodes
from creak.assembly.system import System, by_node, recovered
from creak.linalg.factor import Factor
from creak.model.constraints import Fixed, KinematicCoupling
from creak.model.materials import SolidSection
from creak.model.mesh import Model
from creak.reduction import inside as inside_module
from creak.reduction.craig_bampton import craig_bampton
from creak.reduction.inside import Inside
from helpers_core import NO_DAMPING, NONE, STEEL, block, model_of, plate, shell
from helpers_solids import solid_mesh

NX, NY = 6, 4


def held_plate(**extra: object) -> Model:
    coords, quads = plate(NX, NY, (0.6, 0.4))
    left = np.flatnonzero(coords[:, 0] == 0.0)
    return model_of(coords, [block("quad4", quads, shell(2e-3))], fixed=[Fixed(left, (1, 2, 3, 4, 5, 6))], **extra)


def halves(model: Model) -> list[np.ndarray]:
    """Group 1 for elements right of the middle."""
    centre = model.nodes.coords[model.blocks[0].nodes_idx].mean(axis=1)
    return [(centre[:, 0] > 0.3).astype(np.int64)]


def parts_of(model: Model) -> list[System]:
    return [part_system(model, i, NO_DAMPING) for i in range(len(model.parts))]


def frequencies(system: System) -> np.ndarray:
    return np.sqrt(np.maximum(sla.eigh(to_dense(system.K), to_dense(system.M), eigvals_only=True), 0.0))


def test_cut_parts_share_the_nodes_of_the_cut_and_lose_no_element():
    model = held_plate()
    pieces = cut(model, halves(model), ["RIGHT"])
    assert [p.name for p in pieces.model.parts] == ["PART", "RIGHT"]
    assert pieces.group == (0, 1)
    assert pieces.model.n_elements == model.n_elements
    at = shared_nodes(pieces.model)
    assert at.size == NY + 1
    np.testing.assert_allclose(model.nodes.coords[at, 0], 0.3)


def test_pieces_tied_at_shared_nodes_are_the_whole():
    """The same matrices, up to the order of the dofs: frequencies agree to round-off."""
    model = held_plate()
    pieces = cut(model, halves(model), ["RIGHT"]).model
    whole, joined = (couple(parts_of(m), m, NONE, NO_DAMPING) for m in (model, pieces))
    assert joined.n == whole.n
    # Round-off: eps x (highest / lowest eigenvalue), some 1e9 here.
    np.testing.assert_allclose(frequencies(joined)[:40], frequencies(whole)[:40], rtol=1e-6)


def test_solids_are_cut_beside_a_shell_that_is_another_part():
    """A shell that shares no node with them has no side in common with either half; both keep their mass."""
    bricks, elements = solid_mesh((2, 1, 1), (0.4, 0.1, 0.1))
    corners, squares = plate(2, 1, (0.4, 0.1), z=1.0)
    model = model_of(
        np.concatenate([bricks, corners]),
        [
            block("hex8", elements, SolidSection("SOLID", STEEL)),
            block("quad4", squares + len(bricks), shell(1e-3), 1, 10),
        ],
        [("BRICKS", range(len(bricks))), ("SHELL", range(len(bricks), len(bricks) + len(corners)))],
    )
    pieces = cut(model, [np.array([0, 1]), np.zeros(2, dtype=np.int64)], ["RIGHT"]).model
    moving = [(system, system.coordinates % 6 == 0) for system in parts_of(pieces)]
    masses = [to_dense(system.M)[along][:, along].sum() for system, along in moving]
    # Sums of few terms of one size: round-off.
    np.testing.assert_allclose([masses[0], masses[2]], STEEL.density * 0.2 * 0.1 * 0.1, rtol=1e-12)


@pytest.mark.parametrize("reduce", [(0,), (1,), (0, 1)])
def test_a_reduced_piece_with_all_modes_is_the_whole(reduce):
    """One side or both as superelements: all fixed-interface modes kept lose nothing."""
    model = held_plate()
    pieces = cut(model, halves(model), ["RIGHT"]).model
    edge = shared_nodes(pieces)
    held = np.flatnonzero(model.nodes.coords[:, 0] == 0.0)
    systems = parts_of(pieces)
    for k in reduce:
        boundary = np.flatnonzero(np.isin(systems[k].coordinates // 6, np.union1d(edge, held)))
        systems[k] = craig_bampton(systems[k], boundary, count=10_000)
    whole = couple(parts_of(model), model, NONE, NO_DAMPING)
    joined = couple(systems, pieces, NONE, NO_DAMPING)
    np.testing.assert_allclose(frequencies(joined)[:40], frequencies(whole)[:40], rtol=1e-6)


def test_dofs_that_one_side_does_not_retain_stay_loose():
    """Every second node of the cut retained: the rest gapes, frequencies fall, and the unreduced side is observed."""
    model = held_plate()
    pieces = cut(model, halves(model), ["RIGHT"]).model
    edge = shared_nodes(pieces)
    systems = parts_of(pieces)
    full = couple(systems, pieces, NONE, NO_DAMPING)
    boundary = np.flatnonzero(np.isin(systems[1].coordinates // 6, edge[::2]))
    systems[1] = craig_bampton(systems[1], boundary, count=10_000)
    loose = couple(systems, pieces, NONE, NO_DAMPING)
    assert loose.n == full.n + 6 * edge[1::2].size
    assert (frequencies(loose)[:8] < frequencies(full)[:8]).all()
    labels = 6 * edge[1::2] + 2
    own = couple(systems[:1], pieces, NONE, NO_DAMPING)
    # The observed row is the unreduced copy: it has one entry, at that piece's own coordinate.
    np.testing.assert_array_equal(np.diff(loose.rows(labels)[0].indptr), np.diff(own.rows(labels)[0].indptr))


def test_a_coupling_across_the_cut_is_kept():
    """Reference node and coupled nodes on both sides of the cut move as one rigid body."""
    coords, quads = plate(NX, NY, (0.6, 0.4))
    coords = np.vstack([coords, [0.3, 0.2, 0.1]])
    ref, near = coords.shape[0] - 1, np.flatnonzero(np.abs(coords[:, 0] - 0.3) < 0.11)[:9]
    near = near[near < coords.shape[0] - 1]
    left = np.flatnonzero(coords[:, 0] == 0.0)
    model = model_of(
        coords,
        [block("quad4", quads, shell(2e-3))],
        fixed=[Fixed(left, (1, 2, 3, 4, 5, 6))],
        constraints=[KinematicCoupling("c", ref, near, (1, 2, 3, 4, 5, 6))],
    )
    pieces = cut(model, halves(model), ["RIGHT"]).model
    whole, joined = (couple(parts_of(m), m, NONE, NO_DAMPING) for m in (model, pieces))
    np.testing.assert_allclose(frequencies(joined)[:40], frequencies(whole)[:40], rtol=1e-6)


def reduced_halves() -> tuple[Model, np.ndarray, list[System], System]:
    """A plate, its held nodes, its halves, and these reduced and joined."""
    model = held_plate()
    pieces = cut(model, halves(model), ["RIGHT"]).model
    edge, held = shared_nodes(pieces), np.flatnonzero(model.nodes.coords[:, 0] == 0.0)
    systems = parts_of(pieces)
    boundary = [np.flatnonzero(np.isin(s.coordinates // 6, np.union1d(edge, held))) for s in systems]
    small = couple(
        [craig_bampton(s, b, count=3) for s, b in zip(systems, boundary, strict=True)], pieces, NONE, NO_DAMPING
    )
    return model, held, systems, small


def test_recovered_field_is_the_same_in_blocks_and_at_once():
    model, held, _, small = reduced_halves()
    q = np.random.default_rng(3).standard_normal((small.n, 7))
    at_once = small.recover(q)
    through_rows = np.asarray(small.rows(small.labels)[0] @ q)
    # Two routes to the same motion: a back-substitution per instant or per dof. Round-off times the conditioning of K_ii.
    np.testing.assert_allclose(at_once, through_rows, atol=1e-8 * np.abs(at_once).max())
    blocks = list(recovered(small, q, np.zeros((0, 7)), block=3))
    assert [here.stop - here.start for here, _ in blocks] == [3, 3, 1]
    np.testing.assert_allclose(np.hstack([u for _, u in blocks]), at_once, atol=1e-9 * np.abs(at_once).max())
    field = by_node(at_once, small.labels, model.nodes.count)
    assert field.shape == (7, model.nodes.count, 3)
    np.testing.assert_allclose(field[:, held], 0.0, atol=1e-12)


def test_some_of_the_field_is_that_of_all_and_asks_no_part_that_has_none_of_it(monkeypatch):
    """With memory for no second factor each is made for its part and goes again; a part that is far needs none."""
    made, made_of = [], Inside._regular

    def counted(inside: Inside) -> Factor:
        made.append(inside.name)
        return made_of(inside)

    monkeypatch.setattr(Inside, "_regular", counted)
    _, _, systems, small = reduced_halves()
    q, rng = np.random.default_rng(3).standard_normal((small.n, 7)), np.random.default_rng(4)
    whole = small.recover(q)
    at = rng.permutation(small.labels.size)[:50]
    some = small.recover(q, at=at)
    np.testing.assert_allclose(some, whole[at], atol=1e-12 * np.abs(whole).max())
    np.testing.assert_allclose(small.recover(q[:, 0], at=at), whole[at, 0], atol=1e-9 * np.abs(whole).max())
    monkeypatch.setattr(inside_module, "free_bytes", lambda: 0.0)
    small.recover(q)  # what was there goes
    made.clear()
    np.testing.assert_allclose(small.recover(q, at=at), whole[at], atol=1e-12 * np.abs(whole).max())
    assert sorted(made) == sorted(s.name for s in systems)
    right = np.flatnonzero(np.isin(small.labels, np.setdiff1d(systems[1].labels, systems[0].labels)))
    np.testing.assert_allclose(small.recover(q, at=right), whole[right], atol=1e-12 * np.abs(whole).max())
    assert made[2:] == [systems[1].name]
