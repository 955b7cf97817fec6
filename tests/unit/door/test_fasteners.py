"""Fasteners, supports and verification pairs exist, apart from each other, at every mesh size."""

from __future__ import annotations

import numpy as np
import pytest

from creak_thesis.door import FINEST_MESH_SIZE
from creak_thesis.door import geometry as geo
from creak_thesis.door.fasteners import SUPPORTS, fasteners
from helpers_door import door

pytestmark = pytest.mark.once

sizes = pytest.mark.parametrize("mesh_size", [40.0, 27.0, 20.0, 13.0, 10.0, FINEST_MESH_SIZE, 3.5])


def test_fasteners_count_as_in_the_reference_door() -> None:
    joined = [(f.name.split("_")[0], f.first, f.second) for f in fasteners()]
    assert joined.count(("HOOK", "PANEL", "FRAME")) == 2
    assert joined.count(("SCREW", "PANEL", "FRAME")) == 1
    assert joined.count(("HOOK", "PANEL", "CARRIER")) == 6
    assert joined.count(("SCREW", "CARRIER", "FRAME")) == 13
    assert sum(len(f.points) for f in fasteners()) == 26


@sizes
def test_patches_are_disjoint_and_keep_off_the_contact(mesh_size: float) -> None:
    d = door(mesh_size)
    patches = [*d.supports, *(end for link in d.links for end in link)]
    assert len({p.name for p in patches}) == len(patches) == 7 + 2 * 26
    contact = {"FRAME": d.parts[0].nodes_of("FRAME_FLANGE"), "PANEL": d.parts[1].nodes_of("PANEL_EDGE")}
    for part in d.parts:
        rows = np.concatenate([p.rows for p in patches if p.part == part.name])
        assert np.unique(rows).size == rows.size
        assert np.intersect1d(rows, contact.get(part.name, [])).size == 0
    assert min(p.rows.size for p in patches) >= 4


@sizes
def test_patches_surround_their_reference_node(mesh_size: float) -> None:
    d = door(mesh_size)
    coords = {p.name: p.coords for p in d.parts}
    for patch in [*d.supports, *(end for link in d.links for end in link)]:
        centre = coords[patch.part][patch.rows].mean(axis=0)
        # The nearest free quad is at most one element away from the place.
        assert np.linalg.norm(centre - patch.ref) < 0.8 * mesh_size + 4.0


@sizes
def test_fasteners_do_not_move_with_the_mesh(mesh_size: float) -> None:
    for a, b in zip(door(mesh_size).links, door(10.0).links, strict=True):
        for end, same in zip(a, b, strict=True):
            np.testing.assert_allclose(end.ref[[0, 2]], same.ref[[0, 2]], atol=1e-9)
            # The height is that of the nearest element, on relief up to 22 mm deep.
            assert abs(end.ref[1] - same.ref[1]) < 12.0


@sizes
def test_verification_pairs_are_distinct_and_opposite(mesh_size: float) -> None:
    d = door(mesh_size)
    frame, panel, _ = d.parts
    for name, count in (("PAIRS", 44), ("PAIRS15", 15)):
        main, secondary = d.pairs[name]
        assert np.unique(main).size == np.unique(secondary).size == count
        apart = (frame.coords[main] - panel.coords[secondary])[:, [0, 2]]
        # Coarse meshes have fewer nodes in the contact area than pairs: the nodes beside it are taken too.
        assert np.linalg.norm(apart, axis=1).max() < (0.8 if mesh_size <= 20 else 1.3) * mesh_size


@sizes
def test_forty_four_pairs_lie_in_the_contact_area_and_fifteen_all_around(mesh_size: float) -> None:
    d = door(mesh_size)
    panel = d.parts[1].coords
    area = geo.PANEL.walk(np.array(geo.CONTACT_AREA))
    ends = np.sort(geo.bow(area[:, 0], area[:, 1]))
    inside = panel[d.pairs["PAIRS"][1]]
    beside = 15.0 if mesh_size <= 20 else 150.0
    assert ends[0] - beside < inside[:, 0].min() < inside[:, 0].max() < ends[1] + beside
    # Two rows of elements from the belt edge, at most 10 mm wide each; 14 mm of slope of the belt.
    assert inside[:, 2].min() > area[:, 1].min() - 36.0
    around = panel[d.pairs["PAIRS15"][1]]
    assert np.ptp(around[:, 0]) > 1100.0
    assert np.ptp(around[:, 2]) > 680.0


def test_supports_hold_what_the_study_needs() -> None:
    fixed = {s.name: s.fixed for s in SUPPORTS}
    assert fixed == {
        "A": (2,),
        "B": (1, 2, 3, 4, 5, 6),
        "C": (2, 6),
        "D": (2, 6),
        "E": (2,),
        "F": (2,),
        "G": (2,),
    }
