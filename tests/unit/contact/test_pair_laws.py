"""What the study's numbers become on the channels: hard, curves, damping, friction, clearances, normals, sizes."""

from __future__ import annotations

import numpy as np
import pytest

from creak.contact.gap_operator import join
from creak.errors import InputError
from creak.model.contact_law import ContactLaw
from creak.studies.prepare.watched import slip_warnings
from helpers_contact import HEIGHT, METHODS, T_HIGH, T_LOW, both, pair, stacked
from helpers_fem import random_rotation

CURVE = np.array([[0.0, 0.0], [1e-3, 2e6], [3e-3, 3e6]])


def built(method: str, model=None, **changes):
    return METHODS[method](stacked() if model is None else model, pair(method=method, **changes))


def scale_of(operator, method: str) -> np.ndarray:
    return operator.area if method == "surface-to-surface" else np.ones(operator.m)


@both
def test_hard_contact_has_infinite_stiffness(method):
    operator, notes = built(method, stiffness=np.inf)
    assert np.isinf(operator.stiffness).all()
    assert not operator.step_limited.any()
    assert notes == []
    assert "hard contact takes no damping" in built(method, stiffness=np.inf, damping=1.0)[1][0]


@both
def test_curve_acts_as_pressure_or_force(method):
    operator, _ = built(method, curve=CURVE)
    assert operator.curves is not None
    np.testing.assert_array_equal(operator.curves.of, 0)
    np.testing.assert_allclose(operator.curves.scale, scale_of(operator, method), rtol=1e-14)
    np.testing.assert_array_equal(operator.curves.points[0], CURVE)
    np.testing.assert_allclose(operator.stiffness, 2e9 * scale_of(operator, method), rtol=1e-12)
    assert not operator.step_limited.any()


@pytest.mark.parametrize(
    ("points", "message"),
    [
        ([[0, 0]], "has 1 point"),
        ([[0, 1], [1, 2]], r"starts at \[0.0, 1.0\]"),
        ([[1e-3, 0], [1, 2]], r"starts at \[0.001, 0.0\]"),
        ([[0, 0], [1, 2], [1, 3]], r"does not rise from \[1.0, 2.0\] to \[1.0, 3.0\]"),
        ([[0, 0], [1, 2], [2, 1]], r"does not rise from \[1.0, 2.0\] to \[2.0, 1.0\]"),
        ([[0, 0], [1, 0]], "does not rise"),
    ],
)
def test_wrong_curves_are_refused(points, message):
    with pytest.raises(InputError, match=r"\[contact.stack\] overclosure: .*" + message):
        built("surface-to-surface", curve=np.array(points, dtype=float))


@both
def test_damping_is_per_area_or_per_node(method):
    operator, _ = built(method, damping=3.0)
    np.testing.assert_allclose(operator.damping, 3.0 * scale_of(operator, method), rtol=1e-14)


@both
def test_friction_goes_to_every_channel(method):
    operator, _ = built(method, friction=(0.3, 0.2, 5.0))
    f = operator.friction
    assert f is not None
    assert f.channels.size == operator.m
    assert (f.static[0], f.kinetic[0], f.decay[0]) == (0.3, 0.2, 5.0)
    assert built(method)[0].friction is None


@pytest.mark.parametrize("friction", [(-0.1, -0.1, 0.0), (0.2, 0.3, 0.0), (0.2, 0.1, -1.0), (np.nan, 0.0, 0.0)])
def test_wrong_friction_is_refused(friction):
    with pytest.raises(InputError, match=r"\[contact.stack\] friction: .*expected 0 <= kinetic <= static"):
        built("node-to-surface", friction=friction)


# --- clearances -----------------------------------------------------------------------------------------------


@both
def test_clearances_by_node_replace_the_geometric_gap_where_given(method):
    model = stacked()
    table = {30: 1e-3, 35: 2e-3}
    operator, notes = built(method, model, clearance=table)
    at = {int(n): g for n, g in zip(operator.nodes_idx, operator.gap0, strict=True)}
    assert (at[30], at[35]) == (1e-3, 2e-3)
    assert at[31] == pytest.approx(HEIGHT - 0.5 * (T_LOW + T_HIGH))
    assert len(notes) == 1
    assert "30 node(s) have no row in the table of clearances and keep their geometric gap: 32, 33" in notes[0]


@both
def test_rows_for_nodes_that_face_nothing_are_noted(method):
    """The top is shifted off the lower plate by half its length."""
    model = stacked((6, 4), (6, 4), offset=(0.15, 0.0))
    rows = model.node_sets["TOP_NODES"]
    _, notes = built(method, model, clearance=dict.fromkeys(map(int, rows), 1e-3))
    assert len(notes) == 1
    assert "15 row(s) of the table of clearances are for nodes that face nothing" in notes[0]


# --- normal ---------------------------------------------------------------------------------------------------


@both
@pytest.mark.parametrize("seed", [None, 4])
def test_given_normal_replaces_the_surfaces_own(method, seed):
    """Along (0, s, c) the gap between parallel plates is longer by 1/c, and opens by the motion along it."""
    R = np.eye(3) if seed is None else random_rotation(seed)
    c, s = np.cos(0.2), np.sin(0.2)
    n = R @ [0.0, s, c]
    model = stacked(rotation=R)
    operator, _ = built(method, model, normal=tuple(7.0 * n))
    half = 0.5 * (T_LOW + T_HIGH)
    np.testing.assert_allclose(operator.gap0, HEIGHT / c - half, rtol=1e-9)
    u = np.zeros((model.nodes.count, 6))
    push = np.array([0.3, -0.2, 0.9])
    u[model.node_sets["TOP_NODES"], :3] = push
    np.testing.assert_allclose(operator.G @ u.ravel()[operator.labels], push @ n, rtol=1e-9)


@both
def test_normal_of_the_wrong_sense_is_a_deep_overclosure(method):
    with pytest.raises(InputError, match=r"starts 0.0115 inside the main surface.*Does the normal point from the main"):
        built(method, normal=(0.0, 0.0, -1.0))


@both
def test_normal_of_length_zero_is_refused(method):
    with pytest.raises(InputError, match=r"\[contact.stack\] normal: normal = \[0.0, 0.0, 0.0\] has no direction"):
        built(method, normal=(0.0, 0.0, 0.0))


@both
def test_sides_count_along_a_given_normal(method):
    with pytest.raises(InputError, match=r"never face each other.*along the normal \[0.0, 0.0, 1.0\]"):
        built(method, stacked(sides=(-1, 0)), normal=(0.0, 0.0, 1.0))


# --- size and slip --------------------------------------------------------------------------------------------


@both
def test_size_is_the_smaller_width_of_both_sides(method):
    """LOW 5 x 4 on .3 x .2: 50 mm wide; TOP 3 x 7: 28.6 mm."""
    operator, _ = built(method)
    np.testing.assert_allclose(operator.size, 0.2 / 7, rtol=1e-9)
    np.testing.assert_allclose(operator.select(np.array([3, 5])).size, 0.2 / 7, rtol=1e-9)


def test_slip_beyond_half_an_element_is_told_with_the_channel():
    a, _ = built("surface-to-surface", name="a")
    b, _ = built("node-to-surface", name="b")
    gaps = join([a, b])
    slip = np.zeros(gaps.m)
    assert slip_warnings(gaps, slip, "mm") == []
    slip[:] = 0.49 * 0.2 / 7
    assert slip_warnings(gaps, slip, "mm") == []
    slip[[2, 4, gaps.m - 1]] = 0.02, 0.025, 0.016
    told = slip_warnings(gaps, slip, "mm")
    assert len(told) == 2
    assert told[0].startswith("[contact.a] 2 channel(s) slip by more than half an element: a:35, a:33.")
    assert "a:35 slips farthest, by 0.025 mm on elements 0.0286 mm wide" in told[0]
    assert "b:62" in told[1]


def test_channels_without_a_size_never_warn():
    from creak.contact.play import Play, play_channels

    model = stacked()
    stop = play_channels(model, Play("stop", ("TOP_NODES",), 3, None, 0.1, ContactLaw(1e4)), "")
    assert slip_warnings(stop, np.full(stop.m, 1e9), "mm") == []
    a, _ = built("surface-to-surface", model)
    both_ = join([a, stop])
    assert np.isinf(both_.size[a.m :]).all()
    assert slip_warnings(both_, np.append(np.zeros(a.m), np.full(stop.m, 1e9)), "mm") == []
