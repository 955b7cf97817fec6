"""A reduction that gets more modes is the one that had them from the beginning."""

from __future__ import annotations

import numpy as np
import pytest
import scipy.sparse as sp

from creak.arrays import to_dense
from creak.assembly.damping import Damping
from creak.linalg.modes import BAND, DENSE_LIMIT
from creak.reduction.craig_bampton import fixed_interface_basis, reduced_matrices
from creak.reduction.inside import Inside
from creak.reduction.raised import raised
from helpers_core import NO_DAMPING, block, model_of, part_system, plate, shell


@pytest.fixture(scope="module", params=[False, True], ids=["dense", "sparse"])
def part(request):
    """A plate that is held at some of its nodes, small enough for the dense eigensolver or not."""
    coords, quads = plate(*((13, 9) if request.param else (6, 5)), (0.4, 0.25))
    system = part_system(model_of(coords, [block("quad4", quads, shell(1e-3))]), 0, NO_DAMPING)
    assert (system.n > DENSE_LIMIT) == request.param
    return system


@pytest.mark.parametrize("dashpots", [False, True])
@pytest.mark.parametrize("f_max", [1.0, 300.0, 2000.0])
def test_raised_is_as_good_as_reduced_anew(part, f_max, dashpots):
    """Both solve K x = lam M x to a residual of 1e-9 or better: omega^2 agree to that, other rows but for signs."""
    if dashpots:
        own = sp.diags_array(np.linspace(0.0, 1.0, part.n), format="csr")
        part = type(part)(**{**part.__dict__, "damping": Damping(0.0, 0.0, own)})
    inside = Inside(part, np.arange(24))
    basis = fixed_interface_basis(inside, None, f_max, None, further=True)
    found, matrices = raised(part, basis, reduced_matrices(part, basis), BAND * f_max)
    known, every = basis.fixed.omega2.size, found.fixed.omega2.size
    assert every >= known + max(3, known / 2)
    np.testing.assert_array_equal(found.fixed.shapes[:, :known], basis.fixed.shapes)
    anew = fixed_interface_basis(Inside(part, np.arange(24)), None, None, every)
    np.testing.assert_allclose(found.fixed.omega2, anew.fixed.omega2, rtol=1e-6)
    exact = reduced_matrices(part, found)
    for name in ("K", "M", "M_alone", "C"):
        mine, right = (getattr(m, name) for m in (matrices, exact))
        if right is None:
            assert mine is None
            continue
        mine, right = to_dense(mine), to_dense(right)
        np.testing.assert_allclose(mine, right, rtol=0.0, atol=1e-7 * np.abs(right).max(), err_msg=name)


@pytest.mark.parametrize("thick", [1e-3, 2e-5])
def test_modes_that_are_all_found_anew_bring_their_own_rows(thick):
    """So many more modes that the dense eigensolver finds all of them, with other signs than Lanczos had.

    The rows of M are Phi' (M_ib + M_ii Psi), Psi by a dense solver: the kinetic energy of one and the same motion.
    """
    coords, quads = plate(13, 9, (0.4, 0.25))
    part = part_system(model_of(coords, [block("quad4", quads, shell(thick))]), 0, NO_DAMPING)
    inside, f_max = Inside(part, np.arange(24)), 3e7 * thick
    basis = fixed_interface_basis(inside, None, f_max, None, further=True)
    found, matrices = raised(part, basis, reduced_matrices(part, basis), 2.0 * f_max)
    shapes, known = found.fixed.shapes, basis.fixed.omega2.size
    assert not np.array_equal(shapes[:, :known], basis.fixed.shapes)
    Psi = -np.linalg.solve(inside.K_ii.toarray(), inside.K_ib.toarray())
    right = shapes.T @ (inside.M_ib + inside.M_ii @ Psi)
    np.testing.assert_allclose(to_dense(matrices.M)[24:, :24], right, rtol=0.0, atol=1e-7 * np.abs(right).max())


def test_a_complete_part_stays_as_it_is(part):
    inside = Inside(part, np.arange(24))
    basis = fixed_interface_basis(inside, None, 1e9, None, further=True)
    assert basis.fixed.next_omega2 == np.inf
    found, _ = raised(part, basis, reduced_matrices(part, basis), 2e9)
    assert found.fixed.omega2.size == basis.fixed.omega2.size
