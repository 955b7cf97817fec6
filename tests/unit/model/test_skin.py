"""Which side of a surface sends to a listener: in and through the planes of shells and of faces of solids."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from creak.model.materials import SolidSection
from creak.model.mesh import Model
from creak.model.skin import Skin, panels, skin_of
from helpers_core import STEEL, block, model_of, shell
from helpers_solids import solid_mesh

TURNED = Rotation.from_euler("xyz", [0.3, -1.1, 2.0]).as_matrix()
"""No plane of a turned model is one of round-off."""
FAR = 1e5
"""mm, where the model lies: its coordinates are not exact there."""
FIELDS = ("nodes_idx", "corners", "part", "solid")


def sheet(across: np.ndarray, n: int = 8, *, mixed: bool = True) -> Model:
    """Shells over a cross-section (k, 2), extruded to 40 mm; every other element is turned the other way."""
    y = np.linspace(0.0, 40.0, n + 1)
    coords = np.array([(x, b, z) for x, z in across for b in y])
    i = np.arange(coords.shape[0]).reshape(len(across), n + 1)
    quads = np.stack([i[:-1, :-1], i[1:, :-1], i[1:, 1:], i[:-1, 1:]], axis=-1).reshape(-1, 4)
    if mixed:
        quads[::2] = quads[::2, ::-1]
    coords = coords @ TURNED.T + FAR
    return model_of(coords, [block("quad4", quads, shell(1.0))], [("SHEET", range(len(coords)))])


FLAT = np.column_stack([np.linspace(0.0, 80.0, 17), np.zeros(17)])
CORNER = np.concatenate([FLAT, np.column_stack([np.full(8, 80.0), np.linspace(5.0, 40.0, 8)])])
TURN = np.linspace(0.0, np.pi, 25)
HALF_PIPE = 40.0 * np.column_stack([np.cos(TURN), np.sin(TURN)])


def heard(skin: Skin, point: tuple[float, float, float], moves: np.ndarray) -> complex:
    """Sum of area times motion over distance: what is heard of a low frequency."""
    at = TURNED @ np.array(point) + FAR
    sent = np.einsum("nx,nx->n", skin.toward(at), moves @ TURNED.T)
    return complex((sent / np.linalg.norm(skin.centres - at, axis=1)).sum())


@pytest.mark.parametrize("across", [FLAT, CORNER, HALF_PIPE], ids=["flat", "corner", "half pipe"])
@pytest.mark.parametrize("way", [(0.0, 0.0, 1.0), (0.3, 0.1, 0.9)])
def test_level_goes_through_the_planes_of_a_shell(across, way):
    """Along a line through z = 0, the plane of all or of some facets: no step beside that of the distance."""
    skin = skin_of(sheet(across))
    moves = np.ones((skin.count, 1)) * np.array([0.2, 0.1, 1.0])
    start = np.array([200.0, -90.0, 0.0])
    there = [abs(heard(skin, tuple(start + h * np.array(way)), moves)) for h in (-1e-3, -1e-6, 0.0, 1e-6, 1e-3)]
    assert there[2] > 1.0
    np.testing.assert_allclose(there, there[2], rtol=1e-4)


@pytest.mark.parametrize("second", [[[0.0, 3.0], [80.0, 3.0]], [[90.0, 0.0], [90.0, 50.0]]], ids=["parallel", "across"])
def test_level_of_two_panels_goes_through_the_plane_of_one(second):
    """A sign that turns at once is a step of more than 1 dB: before and behind one's plane the sums differ."""
    one, two = skin_of(sheet(FLAT)), skin_of(sheet(np.array(second)))
    both = Skin(*(np.concatenate([getattr(one, f), getattr(two, f) + 1000 * (f == "nodes_idx")]) for f in FIELDS))
    moves = np.concatenate([np.tile([0.0, 0.0, 1.0], (one.count, 1)), np.tile([0.7, 0.0, 0.7], (two.count, 1))])
    height = np.array([*np.linspace(-40.0, 40.0, 801), -1e-6, 0.0, 1e-6])
    level = 20.0 * np.log10([abs(heard(both, (200.0, -90.0, z), moves)) for z in height])
    assert np.abs(np.diff(level[:-3])).max() < 0.2  # .1 mm each
    np.testing.assert_allclose(level[-3:], level[-2], atol=1e-3)


def test_a_flat_shell_in_its_plane_is_the_integral_before_a_wall():
    """All of it with one sign, far from 0 (each area times its motion over its distance)."""
    skin = skin_of(sheet(FLAT, n=16))
    x, y = np.meshgrid(np.linspace(2.5, 77.5, 16), np.linspace(1.25, 38.75, 16), indexing="ij")
    wanted = (5.0 * 2.5 / np.hypot(x - 200.0, y + 90.0)).sum()
    found = heard(skin, (200.0, -90.0, 0.0), np.tile([0.0, 0.0, 1.0], (skin.count, 1)))
    assert abs(found) == pytest.approx(wanted, rel=1e-9)


def test_a_dome_pushes_its_whole_volume_wherever_it_is_seen_from():
    """A half pipe that moves along z displaces its opening, 80 x 40: also for a listener whom half of it looks away from."""
    skin = skin_of(sheet(HALF_PIPE))
    moves = np.tile([0.0, 0.0, 1.0], (skin.count, 1))
    for point in ((1e5, 20.0, 1e3), (0.0, 20.0, 1e5), (-1e5, 0.0, -1e3)):
        assert abs(heard(skin, point, moves)) * 1e5 == pytest.approx(80.0 * 40.0, rel=2e-3)


def test_a_closed_shell_breathes_outwards():
    """A pipe with both ends closed: all facets with one sign, so that it sends as much as it swells."""
    coords, hexes = solid_mesh((4, 4, 4), (30.0, 30.0, 30.0))
    cube = model_of(coords, [block("hex8", hexes, SolidSection("STEEL", STEEL))], [("CUBE", range(len(coords)))])
    quads = skin_of(cube).nodes_idx.copy()
    quads[::3] = quads[::3, ::-1]
    skin = skin_of(model_of(coords, [block("quad4", quads, shell(1.0))], [("BOX", range(len(coords)))]))
    outward = skin.centres - 15.0
    for point in (np.array([500.0, 15.0, 30.0]), np.array([-300.0, 700.0, 0.0]), np.full(3, 15.0)):
        sent = np.einsum("nx,nx->n", skin.toward(point), outward)
        assert (sent > 0.0).all() or (sent < 0.0).all()


def test_a_twisted_strip_has_no_sides_and_each_facet_is_its_own():
    n = 12
    i = np.arange(n)
    a, b = i, n + i
    c, d = np.where(i < n - 1, i + 1, n), np.where(i < n - 1, n + i + 1, 0)
    turn, panel = panels(np.stack([a, c, d, b], axis=1))
    assert np.unique(panel).size == n
    assert (turn == 1.0).all()
    open_turn, open_panel = panels(np.stack([a, c, d, b], axis=1)[:-1])
    assert np.unique(open_panel).size == 1
    assert (open_turn == open_turn[0]).all()


def test_a_solid_fades_from_face_to_face():
    """A cube: continuous through the planes of its faces; a face and its opposite are one whole everywhere."""
    coords, hexes = solid_mesh((3, 3, 3), (30.0, 30.0, 30.0))
    coords = coords @ TURNED.T + FAR
    skin = skin_of(
        model_of(coords, [block("hex8", hexes, SolidSection("STEEL", STEEL))], [("CUBE", range(len(coords)))])
    )
    moves = (skin.centres - FAR) @ TURNED - 15.0
    for edge in (0.0, 30.0):
        there = [heard(skin, (200.0, 12.0, edge + h), moves) for h in (-1e-3, -1e-6, 0.0, 1e-6, 1e-3)]
        np.testing.assert_allclose(there, there[2], rtol=1e-3)
    sizes = np.linalg.norm(skin.toward(TURNED @ np.array([200.0, 12.0, 21.0]) + FAR), axis=1)
    normal = skin.areas @ TURNED / 100.0
    share = {tuple(k): sizes[(normal.round() == k).all(axis=1)].sum() / 900.0 for k in normal.round().astype(int)}
    wanted = {(1, 0, 0): 1.0, (-1, 0, 0): 0.0, (0, 1, 0): 0.4, (0, -1, 0): 0.6, (0, 0, 1): 0.7, (0, 0, -1): 0.3}
    assert share == pytest.approx(wanted, abs=1e-9)


def test_a_panel_and_a_solid_beside_it_are_heard_alike_from_both_sides():
    """Both move along z, and the mirrored listener hears the same with the other sign; the panel is the larger one."""
    coords, hexes = solid_mesh((3, 3, 3), (30.0, 20.0, 10.0))
    coords = (coords + [100.0, 0.0, -5.0]) @ TURNED.T + FAR
    cube = model_of(coords, [block("hex8", hexes, SolidSection("STEEL", STEEL))], [("CUBE", range(len(coords)))])
    one, two = skin_of(sheet(FLAT)), skin_of(cube)
    two = replace(two, nodes_idx=two.nodes_idx + 1000)
    both = Skin(*(np.concatenate([getattr(one, f), getattr(two, f)]) for f in FIELDS))
    moves = np.tile([0.0, 0.0, 1.0], (both.count, 1))
    before, behind = (heard(both, (60.0, 20.0, z), moves) for z in (500.0, -500.0))
    assert behind == pytest.approx(-before, rel=1e-6)
    assert abs(before) > 1.1 * abs(heard(one, (60.0, 20.0, 500.0), moves[: one.count]))
