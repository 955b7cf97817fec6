"""The modal assurance criterion and the pairing of modes, for any shapes."""

from __future__ import annotations

import numpy as np
from hypothesis import example, given, settings
from hypothesis import strategies as st

from creak.verify.mac import mac_matrix, pair_modes


@st.composite
def shapes(draw: st.DrawFn) -> tuple[np.ndarray, np.ndarray]:
    n, a, b = draw(st.integers(1, 12)), draw(st.integers(1, 6)), draw(st.integers(1, 6))
    rng = np.random.default_rng(draw(st.integers(0, 2**32 - 1)))
    scale = 10.0 ** draw(st.integers(-6, 6))
    return rng.standard_normal((n, a)) * scale, rng.standard_normal((n, b))


@settings(max_examples=200, deadline=None)
@given(shapes())
def test_mac_lies_between_zero_and_one(pair):
    mac = mac_matrix(*pair)
    assert (mac >= 0.0).all()
    assert (mac <= 1.0 + 1e-12).all()  # Cauchy-Schwarz, to round-off


@settings(max_examples=100, deadline=None)
@given(shapes(), st.floats(-1e6, 1e6).filter(lambda x: abs(x) > 1e-6))
def test_mac_does_not_depend_on_scale_or_sign(pair, factor):
    a, b = pair
    np.testing.assert_allclose(mac_matrix(a * factor, b), mac_matrix(a, b), rtol=1e-9, atol=1e-12)
    np.testing.assert_allclose(np.diag(mac_matrix(a, a)), 1.0, rtol=1e-12)
    np.testing.assert_allclose(mac_matrix(a, b), mac_matrix(b, a).T, rtol=1e-12)


@settings(max_examples=200, deadline=None)
@given(shapes(), st.integers(0, 2**32 - 1))
@example((np.array([[1.0, -1.0, 6.0, 1.0, -5.0, 3.0]]), np.array([[1.0, 1.0, -1.0, -1.0]])), 84)  # one of three alike
def test_paired_mac_lies_between_zero_and_one_and_no_mode_pairs_twice(pair, seed):
    a, b = pair
    rng = np.random.default_rng(seed)
    f_a, f_b = np.sort(rng.uniform(0, 5, a.shape[1])).round(1), np.sort(rng.uniform(0, 5, b.shape[1])).round(1)
    found = pair_modes(f_a, a, f_b, b)
    assert ((found.mac >= 0.0) & (found.mac <= 1.0)).all()
    used = found.partner[found.partner >= 0]
    assert np.unique(used).size == used.size
    assert (found.mac[found.partner < 0] == 0.0).all()
