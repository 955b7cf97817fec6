"""Elements of the flange merged along the contact line: the mesh stays whole, the rest of the door stays put."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner

from creak.arrays import FloatArray, IntArray
from creak.cli.main import app
from creak.errors import InputError
from creak.formats.abaqus.reader import read_deck
from creak_thesis.door import write_door
from creak_thesis.door.deck import mass
from creak_thesis.door.frame import flange_segments, spacing
from creak_thesis.door.mesh import PartMesh, coarsen_band, kept_columns, structured_quads
from helpers_door import door

pytestmark = pytest.mark.once

cases = pytest.mark.parametrize(
    ("mesh_size", "coarsen"), [(40.0, 2), (40.0, 3), (20.0, 2), (20.0, 3), (13.0, 3), (10.0, 2)]
)


def all_edges(part: PartMesh) -> IntArray:
    """Edges (n, 2) of all elements in the sense in which each walks them."""
    return np.concatenate(
        [np.stack([c, np.roll(c, -1, axis=1)], axis=-1).reshape(-1, 2) for c in (part.quads, part.tris)]
    )


def free_edge_length(part: PartMesh) -> float:
    """Length of the edges that belong to one element only."""
    edges, count = np.unique(np.sort(all_edges(part), axis=1), axis=0, return_counts=True)
    ends = part.coords[edges[count == 1]]
    return float(np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1).sum())


def angles(part: PartMesh) -> FloatArray:
    """Angles of all corners, degrees."""
    out = []
    for corners in (part.quads, part.tris):
        x = part.coords[corners]
        a, b = np.roll(x, -1, axis=1) - x, np.roll(x, 1, axis=1) - x
        cosine = (a * b).sum(axis=2) / np.linalg.norm(a, axis=2) / np.linalg.norm(b, axis=2)
        out.append(np.degrees(np.arccos(cosine)).ravel())
    return np.concatenate(out)


@cases
def test_mesh_conforms(mesh_size: float, coarsen: int) -> None:
    plain, frame = door(mesh_size).parts[0], door(mesh_size, coarsen).parts[0]
    edges = all_edges(frame)
    # Inside, two elements share every edge and walk it in opposite senses; a hanging node would open a free edge.
    assert np.unique(edges, axis=0).shape == edges.shape
    count = np.unique(np.sort(edges, axis=1), axis=0, return_counts=True)[1]
    assert count.max() == 2
    assert free_edge_length(frame) == pytest.approx(free_edge_length(plain), rel=1e-12)
    euler = frame.coords.shape[0] - count.size + frame.quads.shape[0] + frame.tris.shape[0]
    assert euler == -1  # one piece with two holes
    used = np.unique(np.concatenate([frame.quads.ravel(), frame.tris.ravel()]))
    np.testing.assert_array_equal(used, np.arange(frame.coords.shape[0]))


@cases
def test_elements_are_well_shaped(mesh_size: float, coarsen: int) -> None:
    frame = door(mesh_size, coarsen).parts[0]
    # The plain mesh is sheared to 37 degrees; cut to a third of its width the angle is atan(tan(37) / 2) = 21.
    assert angles(frame).min() > 18.0
    assert angles(frame).max() < 163.0
    q, t = frame.coords[frame.quads], frame.coords[frame.tris]
    side = np.cross(q[:, 2] - q[:, 0], q[:, 3] - q[:, 1])
    for k in range(4):
        corner = np.cross(q[:, (k + 1) % 4] - q[:, k], q[:, k - 1] - q[:, k])
        assert ((corner * side).sum(axis=1) > 0).all()
    area = 0.5 * np.linalg.norm(np.cross(t[:, 1] - t[:, 0], t[:, 2] - t[:, 0]), axis=1)
    assert area.min() > 0.05 * mesh_size**2


@cases
def test_flange_has_so_many_nodes_fewer(mesh_size: float, coarsen: int) -> None:
    plain, frame = door(mesh_size).parts[0], door(mesh_size, coarsen).parts[0]
    before, after = plain.nodes_of("FRAME_FLANGE").size, frame.nodes_of("FRAME_FLANGE").size
    segments = flange_segments(spacing(mesh_size))
    columns = sum(segments)
    # Each of the seven pieces may end with a shorter element.
    assert after * columns == before * sum(-(-n // coarsen) for n in segments)
    assert coarsen * (1 - 7 / (columns / coarsen + 7)) < before / after <= coarsen


def places(coords: FloatArray) -> set[bytes]:
    """Of nodes, to the last bit."""
    return {x.tobytes() for x in coords}


@cases
def test_only_the_flange_and_its_neighbours_change(mesh_size: float, coarsen: int) -> None:
    plain, frame = door(mesh_size).parts[0], door(mesh_size, coarsen).parts[0]
    before, after = (
        {quad.tobytes(): quad for quad in part.coords[part.quads[~part.tags["FRAME_FLANGE"]]]}
        for part in (plain, frame)
    )
    both, near = before | after, places(plain.coords[plain.nodes_of("FRAME_FLANGE")])
    assert all(near & places(both[quad]) for quad in before.keys() ^ after.keys())
    kept, whole = places(frame.coords), places(plain.coords)
    assert kept < whole
    assert whole - kept < near


@cases
def test_mass_joints_and_pairs_stay(mesh_size: float, coarsen: int) -> None:
    plain, coarse = door(mesh_size), door(mesh_size, coarsen)
    # Arcs become chords; 120 mm of chord on a radius of 110 mm is beyond the thousandth.
    rel = 1e-3 if coarsen * mesh_size <= 100 else 1.3e-3
    assert sum(mass(coarse).values()) == pytest.approx(sum(mass(plain).values()), rel=rel)
    frame, panel, _ = coarse.parts
    for (main, secondary), before in zip(coarse.pairs.values(), plain.pairs.values(), strict=True):
        assert np.unique(main).size == main.size == before[0].size
        np.testing.assert_array_equal(secondary, before[1])
        apart = (frame.coords[main] - panel.coords[secondary])[:, [0, 2]]
        # Where the flange has fewer nodes than pairs, those of the frame up to two rows beside it are taken too.
        assert np.linalg.norm(apart, axis=1).max() < 0.5 * mesh_size * (coarsen + 1) + (mesh_size > 10) * mesh_size
    for old, new in zip(plain.supports, coarse.supports, strict=True):
        np.testing.assert_array_equal(old.ref, new.ref)
        np.testing.assert_allclose(coarse.parts[0].coords[new.rows], plain.parts[0].coords[old.rows], atol=1e-12)
    contact = frame.nodes_of("FRAME_FLANGE")
    for link in coarse.links:
        assert all(end.rows.size >= 4 for end in link)
        assert not any(np.isin(end.rows, contact).any() for end in link if end.part == "FRAME")


@pytest.mark.parametrize("coarsen", [2, 3])
def test_deck_reads_with_the_sets_of_the_door(coarsen: int, tmp_path: Path) -> None:
    model = read_deck(write_door(40.0, tmp_path, coarsen)[0])
    coarse = door(40.0, coarsen)
    assert not any(u.changes_answer for u in model.unread)
    assert model.surfaces["FRAME_FLANGE"].facets.shape[0] == coarse.parts[0].tags["FRAME_FLANGE"].sum()
    assert model.nodes.count == coarse.n_nodes
    assert len(model.parts) == 3
    assert model.node_set("PAIRS_MAIN").size == model.node_set("PAIRS_SECONDARY").size == 44


@pytest.mark.parametrize("coarsen", [0, -1, 4])
def test_other_numbers_are_refused_and_nothing_is_written(coarsen: int, tmp_path: Path) -> None:
    out = tmp_path / "door"
    with pytest.raises(InputError, match=r"coarsening of the door.*cannot be merged.*expected 1, 2 or 3"):
        write_door(40.0, out, coarsen)
    assert not out.exists()


def test_command_takes_the_option(tmp_path: Path) -> None:
    out = tmp_path / "door"
    result = CliRunner().invoke(app, ["example", "door", "--mesh-size", "40", "--coarsen", "2", "--out", str(out)])
    assert result.exit_code == 0, result.output
    assert "2 elements merged into one" in (out / "door.inp").read_text(encoding="utf-8")


def test_columns_that_stay() -> None:
    # 5 = 2 + 2 + 1 and 4 = 2 + 2: the first node of every piece stays.
    np.testing.assert_array_equal(kept_columns([5, 4], 2), [0, 2, 4, 5, 7])
    np.testing.assert_array_equal(kept_columns([5, 4], 3), [0, 3, 5, 8])


@pytest.mark.parametrize("flip", [False, True])
@pytest.mark.parametrize(("merge", "n_tris"), [(2, 1), (3, 2)])
def test_ring_of_quads_keeps_its_area_and_sense(merge: int, n_tris: int, flip: bool) -> None:
    n_column, radii = 24, np.array([1.0, 1.3, 1.6, 1.9, 2.2])
    angle = 2 * np.pi * np.arange(n_column) / n_column
    coords = np.stack([np.outer(radii, np.cos(angle)), np.outer(radii, np.sin(angle)), np.zeros((5, n_column))], -1)
    quads = structured_quads(5, n_column, closed=True, flip=flip)
    band = np.repeat([False, True, True, False], n_column)
    ring = PartMesh("RING", coords.reshape(-1, 3), quads, np.zeros((0, 3), dtype=np.int64), {"BAND": band}, {})
    lines = np.arange(n_column, 4 * n_column).reshape(3, n_column)
    coarse = coarsen_band(ring, "BAND", lines, kept_columns([12, 12], merge))
    # Both borders of the ring stay, so its area does.
    assert coarse.area() == pytest.approx(ring.area(), rel=1e-12)
    assert coarse.tris.shape[0] == 2 * n_tris * n_column // merge
    for corners in (coarse.quads, coarse.tris):
        x = coarse.coords[corners]
        assert (np.sign(np.cross(x[:, 1] - x[:, 0], x[:, 2] - x[:, 0])[:, 2]) == (1 if flip else -1)).all()
