"""Contact of surfaces: patch test, partition, rigid motion, sides, thickness, search, messages."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from creak.contact.facets import facets_of, nodal_normals
from creak.contact.node_to_surface import node_to_surface
from creak.contact.search import project_along, project_closest
from creak.contact.surface_to_surface import surface_to_surface
from creak.errors import InputError
from creak.model.mesh import Model
from helpers_contact import HEIGHT, METHODS, T_HIGH, T_LOW, both, pair, stacked
from helpers_core import NO_DAMPING, STEEL, block, model_of, part_system, plate, shell, whole_block
from helpers_fem import random_rotation, rigid_modes


def motion(model: Model, operator, u: np.ndarray) -> np.ndarray:
    """Change of the gaps under the nodal motion u (6 n_node,)."""
    return np.asarray(operator.G @ u[operator.labels])


# --- what rigid motion does to the gaps -----------------------------------------------------------------------


@both
@pytest.mark.parametrize("kinds", [("quad4", "quad4"), ("quad4", "tri3"), ("tri3", "quad4"), ("tri3", "tri3")])
def test_gaps_do_not_see_a_common_translation(method, kinds):
    """Every row of G sums to zero along each axis: what presses one side presses the other back."""
    model = stacked(kinds=kinds)
    operator, notes = METHODS[method](model, pair())
    assert notes == []
    translations = rigid_modes(model.nodes.coords)[:, :3]
    assert operator.m == 32
    for u in translations.T:
        np.testing.assert_allclose(motion(model, operator, u), 0.0, atol=1e-14)  # round-off
        for tangent in operator.tangents:
            np.testing.assert_allclose(tangent @ u[operator.labels], 0.0, atol=1e-14)


@both
def test_gaps_open_by_exactly_the_rigid_normal_motion(method):
    model = stacked()
    operator, _ = METHODS[method](model, pair())
    u = np.zeros(6 * model.nodes.count)
    top = model.node_sets["TOP_NODES"]
    u[6 * top + 2] = 1.0
    np.testing.assert_allclose(motion(model, operator, u), 1.0, rtol=1e-12)
    u[:] = 0.0
    u[6 * np.arange(top[0]) + 2] = 1.0
    np.testing.assert_allclose(motion(model, operator, u), -1.0, rtol=1e-12)


@both
def test_sliding_moves_no_gap_and_shows_in_the_tangents(method):
    model = stacked()
    operator, _ = METHODS[method](model, pair())
    u = np.zeros(6 * model.nodes.count)
    top = model.node_sets["TOP_NODES"]
    u[6 * top], u[6 * top + 1] = 3.0, 4.0
    np.testing.assert_allclose(motion(model, operator, u), 0.0, atol=1e-13)
    slip = np.hypot(*(t @ u[operator.labels] for t in operator.tangents))
    np.testing.assert_allclose(slip, 5.0, rtol=1e-12)


@both
def test_a_tilt_opens_each_gap_by_its_lever(method):
    """The top turns about the y axis: the gap at x opens by -x theta, exactly also between nodes."""
    model = stacked()
    operator, _ = METHODS[method](model, pair())
    top = model.node_sets["TOP_NODES"]
    u = np.zeros(6 * model.nodes.count)
    u[6 * top + 2] = model.nodes.coords[top, 0]
    change = motion(model, operator, u)
    # The weighted mean of x over each tributary region lies inside the plate; total moment is the plate's.
    if method == "node-to-surface":
        np.testing.assert_allclose(change, model.nodes.coords[operator.nodes_idx, 0], atol=1e-13)
    else:
        assert change @ operator.area == pytest.approx(0.5 * 0.3 * 0.06, rel=1e-12)


@both
@pytest.mark.parametrize("seed", [1, 2])
def test_rotated_model_has_the_same_gaps_and_stiffness(method, seed):
    plain, _ = METHODS[method](stacked(), pair())
    R = random_rotation(seed)
    turned, _ = METHODS[method](stacked(rotation=R), pair())
    np.testing.assert_allclose(turned.gap0, plain.gap0, rtol=1e-9)
    np.testing.assert_allclose(turned.stiffness, plain.stiffness, rtol=1e-9)
    np.testing.assert_array_equal(turned.nodes_idx, plain.nodes_idx)
    # The same push along the turned normal.
    u = np.random.default_rng(0).standard_normal((stacked().nodes.count, 3))
    straight, oblique = (np.zeros((u.shape[0], 6)) for _ in range(2))
    straight[:, :3], oblique[:, :3] = u, u @ R.T
    np.testing.assert_allclose(
        turned.G @ oblique.ravel()[turned.labels], plain.G @ straight.ravel()[plain.labels], atol=1e-9
    )


@both
def test_tangents_are_at_right_angles_to_the_normal(method):
    operator, _ = METHODS[method](stacked(rotation=random_rotation(5)), pair())
    G, (t1, t2) = operator.G.toarray(), operator.tangents
    for a, b in ((G, t1), (G, t2), (t1.toarray(), t2)):
        # Per label triplet the vectors are weight x unit vectors, so the sum over a row vanishes.
        np.testing.assert_allclose((a * b.toarray()).sum(axis=1), 0.0, atol=1e-13)


# --- pressure -------------------------------------------------------------------------------------------------


@cache
def pressed_stack(kinds: tuple[str, str]):
    """Main and secondary pushed together evenly: channel pressures and nodal forces."""
    model = stacked((5, 4), (3, 7), kinds=kinds)
    operator, _ = surface_to_surface(model, pair(stiffness=1e9))
    depth = 1e-5
    p = operator.stiffness * depth
    force = np.zeros(6 * model.nodes.count)
    force[operator.labels] = operator.G.T @ p
    return model, operator, p, force.reshape(-1, 6)[:, :3]


@pytest.mark.parametrize("kinds", [("quad4", "quad4"), ("tri3", "quad4"), ("quad4", "tri3")])
def test_even_pressure_gives_even_channel_pressure_and_the_exact_force(kinds):
    """Penalty 1e9 per area, 1e-5 deep, on .06 m^2: 600 N, the same 1e4 Pa in every channel, edges included."""
    _, operator, p, force = pressed_stack(kinds)
    np.testing.assert_allclose(p / operator.area, 1e4, rtol=1e-12)
    assert operator.area.sum() == pytest.approx(0.06, rel=1e-12)
    n = force.shape[0] - 32
    assert force[n:].sum(axis=0) == pytest.approx([0.0, 0.0, 600.0], abs=1e-9)
    assert force[:n].sum(axis=0) == pytest.approx([0.0, 0.0, -600.0], abs=1e-9)


@pytest.mark.parametrize("kinds", [("quad4", "quad4"), ("quad4", "tri3")])
def test_even_pressure_loads_the_secondary_like_a_uniform_load(kinds):
    """Forces on the secondary are int N p dA: exact for its own shape functions."""
    model, _, _, force = pressed_stack(kinds)
    facets = facets_of(model, "TOP", where="")
    area = np.linalg.norm(facets.area_normals, axis=1)
    corners = np.where(facets.is_triangle, 3, 4)
    expected = np.zeros(model.nodes.count)
    for k in range(4):
        use = (k < 3) | ~facets.is_triangle
        np.add.at(expected, facets.nodes[use, k], (area / corners)[use] * 1e4)
    np.testing.assert_allclose(force[32 - 2 :, 2][-32:], expected[-32:], rtol=1e-9)


def test_contact_moment_is_balanced_to_the_quadrature():
    """Forces on both sides have the same resultant moment about the mid-height (points face each other)."""
    model, _, _, force = pressed_stack(("quad4", "quad4"))
    x = model.nodes.coords
    moments = np.cross(x, force)
    # Normal forces on parallel planes: equal and opposite moments about x and y, since sum N_j x_j is the point.
    np.testing.assert_allclose(moments.sum(axis=0), 0.0, atol=1e-9 * np.abs(moments).sum())


def patch_pressure(low: tuple[int, int], high: tuple[int, int], stiffness: float) -> np.ndarray:
    """Channel pressures / 1e4 of a top plate under 1e4 Pa on a lower plate on an even elastic bed.

    The exact answer is even pressure without bending.
    """
    model = stacked(low, high, height=0.5 * (T_LOW + T_HIGH))
    operator, _ = surface_to_surface(model, pair(stiffness=stiffness))
    n = 6 * model.nodes.count
    K = np.zeros((n, n))
    for i in range(2):
        part = part_system(model, i, NO_DAMPING)
        K[np.ix_(part.coordinates, part.coordinates)] += part.K.toarray()
    axis = np.arange(n) % 6
    K[np.diag_indices(n)] += np.where(axis == 2, 1e8 * np.repeat(tributary(model, "LOW"), 6), 0.0)
    K[np.diag_indices(n)] += np.where(axis < 2, 1e-6 * K.diagonal().max(), 0.0)  # holds the plates in their plane
    G = np.zeros((operator.m, n))
    G[:, operator.labels] = operator.G.toarray()
    f = np.zeros(n)
    f[2::6] = -1e4 * tributary(model, "TOP")
    u = np.linalg.solve(K + (G.T * operator.stiffness) @ G, f)
    force = -operator.stiffness * (G @ u)
    assert force.sum() == pytest.approx(600.0, rel=1e-6)
    return force / operator.area / 1e4


def test_contact_patch_test_where_the_meshes_nest():
    """Every secondary facet lies within one main facet: the quadrature is exact, so the pressure is even."""
    np.testing.assert_allclose(patch_pressure((6, 4), (12, 8), 1e11), 1.0, rtol=1e-5)  # round-off of a stiff contact


NON_MATCHING = [((5, 4), (3, 7)), ((3, 7), (5, 4)), ((7, 5), (12, 9)), ((10, 10), (9, 11))]


@pytest.mark.parametrize(("low", "high"), NON_MATCHING)
def test_contact_patch_test_on_non_matching_shells_is_as_good_as_the_quadrature(low, high):
    """3 x 3 points do not see the edges of the main facets under them: some per cent of a facet's load."""
    np.testing.assert_allclose(patch_pressure(low, high, 1e9), 1.0, rtol=0.03)


@pytest.mark.parametrize(("low", "high"), NON_MATCHING)
def test_contact_patch_test_on_non_matching_shells_to_one_per_cent(low, high):
    """About 1 %, with a very stiff penalty (2e11: 10 kappa G t per facet); the quadrature misses facet edges."""
    np.testing.assert_allclose(patch_pressure(low, high, 2e11), 1.0, rtol=0.011)


def tributary(model: Model, name: str) -> np.ndarray:
    """(n_node,) int N dA of a surface of rectangles."""
    facets = facets_of(model, name, where="")
    area = np.linalg.norm(facets.area_normals, axis=1)
    out = np.zeros(model.nodes.count)
    np.add.at(out, facets.nodes, (area / 4)[:, None])
    return out


# --- gaps, thickness, sides -----------------------------------------------------------------------------------


@both
def test_half_of_both_thicknesses_counts(method):
    operator, _ = METHODS[method](stacked(), pair())
    np.testing.assert_allclose(operator.gap0, HEIGHT - 0.5 * (T_LOW + T_HIGH), rtol=1e-9)


def test_node_set_as_secondary_has_no_thickness():
    operator, _ = node_to_surface(stacked(), pair(secondary="TOP_NODES"))
    np.testing.assert_allclose(operator.gap0, HEIGHT - 0.5 * T_LOW, rtol=1e-9)


@both
def test_clearance_replaces_the_geometric_gap(method):
    operator, notes = METHODS[method](stacked(), pair(clearance=3.7e-3))
    np.testing.assert_array_equal(operator.gap0, 3.7e-3)
    assert notes == []


@both
def test_small_overclosure_is_set_to_zero_and_noted(method):
    model = stacked(height=1e-3)  # .5 mm inside: half thicknesses are .5 + 1 mm
    operator, notes = METHODS[method](model, pair())
    np.testing.assert_array_equal(operator.gap0, 0.0)
    assert len(notes) == 1
    assert "32 channel(s) start closed, by up to 0.0005 at node" in notes[0]
    assert "[contact.stack]" in notes[0]


@both
def test_surfaces_that_never_face_each_other_are_refused(method):
    model = stacked(offset=(5.0, 0.0))
    with pytest.raises(InputError, match=r"\[contact.stack\].*'TOP' and 'LOW' never face each other"):
        METHODS[method](model, pair())
    with pytest.raises(InputError, match=r"surface 'LOW' touches itself"):
        METHODS["surface-to-surface"](model, replace(pair(), secondary="LOW"))


def test_wrong_side_never_faces():
    """SPOS of the lower plate looks up (+z), where the top lies; SNEG looks away."""
    up, _ = surface_to_surface(stacked(sides=(1, -1)), pair())
    assert up.m == 32
    with pytest.raises(InputError, match="never face each other"):
        surface_to_surface(stacked(sides=(-1, 0)), pair())
    with pytest.raises(InputError, match="never face each other"):
        surface_to_surface(stacked(sides=(0, 1)), pair())
    upside_down, _ = surface_to_surface(stacked(sides=(-1, -1), flip_low=True), pair())
    assert upside_down.m == 32


@both
def test_contact_acts_where_the_surfaces_overlap(method):
    """The top is shifted by half its length: nodes beyond the edge get no channel."""
    model = stacked((6, 4), (6, 4), offset=(0.15, 0.0))
    operator, _ = METHODS[method](model, pair())
    x = model.nodes.coords[operator.nodes_idx, 0]
    assert x.max() <= 0.3 + 1e-9
    assert operator.m == 4 * 5
    if method == "surface-to-surface":
        assert operator.area.sum() == pytest.approx(0.15 * 0.2, rel=1e-12)


def test_automatic_stiffness_is_ten_times_the_softer_parent():
    """10 kappa G t of the thinner plate (per node) or over its facet's area (per area)."""
    G = STEEL.shear_modulus
    nts, _ = node_to_surface(stacked(), pair())
    np.testing.assert_allclose(nts.stiffness, 10 * 5 / 6 * G * T_LOW, rtol=1e-9)
    sts, _ = surface_to_surface(stacked((5, 4), (5, 4)), pair())
    facet = 0.06 / 20
    np.testing.assert_allclose(sts.stiffness / sts.area, 10 * 5 / 6 * G * T_LOW / facet, rtol=1e-9)


@both
def test_given_stiffness_is_taken(method):
    operator, _ = METHODS[method](stacked(), pair(stiffness=123.0))
    expected = 123.0 if method == "node-to-surface" else 123.0 * operator.area
    np.testing.assert_allclose(operator.stiffness, expected, rtol=1e-12)


@both
def test_channels_are_named_after_pair_and_node(method):
    operator, _ = METHODS[method](stacked(), pair())
    assert operator.names[0] == "stack:31"
    assert set(operator.group) == {"stack"}
    np.testing.assert_array_equal(operator.nodes_idx, np.arange(30, 62))


# --- search ---------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("kind", ["quad4", "tri3"])
@pytest.mark.parametrize("seed", [0, 1])
def test_search_finds_the_same_facet_as_brute_force(kind, seed):
    """A wavy main surface: the tree's candidates hold the facet that a look at all facets finds."""
    rng = np.random.default_rng(seed)
    coords, elements = plate(9, 8, (0.3, 0.3), 0.0, kind)
    coords[:, 2] = 0.01 * np.sin(12 * coords[:, 0]) * np.cos(9 * coords[:, 1])
    model = model_of(coords, [block(kind, elements, shell(1e-3))], surfaces=[whole_block(0, elements.shape[0])])
    main = facets_of(model, "S", where="")
    points = np.column_stack([rng.uniform(0.01, 0.29, (40, 2)), rng.uniform(0.015, 0.03, 40)])
    down = np.tile([0.0, 0.0, -1.0], (40, 1))
    met = project_along(points, down, main, 0.2)
    assert met.found.all()
    for i, point in enumerate(points):
        flat = [inside_in_plane(main.coords[f], bool(main.is_triangle[f]), point) for f in range(main.count)]
        owners = np.flatnonzero(flat)
        assert met.facet[i] in owners
    hit = np.einsum("nj,njx->nx", met.shape, main.coords[met.facet])
    np.testing.assert_allclose(hit, points + met.distance[:, None] * down, atol=1e-10)
    np.testing.assert_allclose(met.shape.sum(axis=1), 1.0, rtol=1e-12)
    closest = project_closest(points, main, 0.2)
    assert closest.found.mean() > 0.9
    foot = np.einsum("nj,njx->nx", closest.shape, main.coords[closest.facet])
    # The foot is on the facet, along its own normal there.
    ok = closest.found
    along = points[ok] + closest.distance[ok, None] * closest.direction[ok]
    np.testing.assert_allclose(foot[ok], along, atol=1e-9)


def inside_in_plane(x: np.ndarray, triangle: bool, point: np.ndarray) -> bool:
    """Is the point over the facet, seen along z? The facets are rectangles or half rectangles in that view."""
    corners = x[:3, :2] if triangle else x[:, :2]
    edges = np.roll(corners, -1, axis=0) - corners
    side = edges[:, 0] * (point[1] - corners[:, 1]) - edges[:, 1] * (point[0] - corners[:, 0])
    return bool((side >= -1e-9).all() or (side <= 1e-9).all())


def test_normals_of_mixed_orientation_are_turned_to_one_side():
    coords, quads = plate(3, 3)
    quads[4] = quads[4][::-1]
    model = model_of(coords, [block("quad4", quads, shell(1e-3))], surfaces=[whole_block(0, 9)])
    normals = nodal_normals(facets_of(model, "S", where=""))
    np.testing.assert_allclose(np.abs(normals[:, 2]), 1.0, rtol=1e-12)
    assert abs(normals[:, 2].sum()) == pytest.approx(16.0)


# --- wrong input ----------------------------------------------------------------------------------------------


@both
def test_unknown_surface_is_named_with_a_suggestion(method):
    with pytest.raises(InputError, match=r"\[contact.stack\] main: unknown surface or set 'LOVW'.*'LOW'"):
        METHODS[method](stacked(), pair(main="LOVW"))


def test_node_set_as_facets_is_refused_with_the_way_out():
    with pytest.raises(InputError, match=r"'TOP_NODES' is a set of nodes.*node-to-surface"):
        surface_to_surface(stacked(), pair(secondary="TOP_NODES"))
    with pytest.raises(InputError, match="'TOP_NODES' is a set of nodes, without facets"):
        node_to_surface(stacked(), pair(main="TOP_NODES"))


def test_surface_of_beams_is_refused():
    from helpers_core import beam_section, straight_beam

    coords, elements = straight_beam(3, 1.0)
    model = model_of(coords, [block("beam2", elements, beam_section())], surfaces=[whole_block(0, 3, 0, "LOW")])
    with pytest.raises(InputError, match="surface 'LOW' holds beam2 elements"):
        facets_of(model, "LOW", where="[contact.x] main")


@both
def test_deep_overclosure_is_refused(method):
    """Facing sides given, but the top lies far on the wrong side of the lower plate."""
    if method == "surface-to-surface":
        with pytest.raises(InputError, match="never face each other"):
            surface_to_surface(stacked(height=-0.01, sides=(1, -1)), pair())
    else:
        with pytest.raises(InputError, match="inside the main surface, more than the shells' thickness"):
            node_to_surface(stacked(height=-0.01, sides=(1, -1)), pair())


# --- several operators ----------------------------------------------------------------------------------------


def test_selected_and_joined_channels_keep_their_numbers():
    from creak.contact.gap_operator import join

    model = stacked()
    a, _ = surface_to_surface(model, pair(name="a"))
    b, _ = node_to_surface(model, pair(name="b"))
    both_ = join([a, b])
    u = np.random.default_rng(3).standard_normal(6 * model.nodes.count)
    np.testing.assert_allclose(
        motion(model, both_, u), np.concatenate([motion(model, o, u) for o in (a, b)]), atol=1e-12
    )
    keep = np.array([1, 5, a.m + 2])
    few = both_.select(keep)
    np.testing.assert_allclose(motion(model, few, u), motion(model, both_, u)[keep], atol=1e-12)
    assert few.names == tuple(both_.names[i] for i in keep)
    assert few.group == ("a", "a", "b")
    np.testing.assert_array_equal(few.stiffness, both_.stiffness[keep])
    assert not both_.without_force().stiffness.any()
