"""Modal damping of the unreduced model where the reduced one has more modes than are known of the whole."""

from __future__ import annotations

import numpy as np
import pytest
import scipy.linalg as sla

import creak
from creak.arrays import to_dense
from creak.reduction.modal import without_modal_damping
from creak.studies.file.reader import read_study
from creak.studies.models.reduced import reduce_model
from creak.studies.models.reference import build_reference
from creak.studies.prepare.setup import set_up
from creak.studies.run.job import run_study
from creak.studies.spots import handover
from creak.studies.spots.handover import damped_alike
from helpers_decks import STUDY, write_strips

ZETA = 0.03
TEXT = STUDY.replace("step = 5e-4\n", "").replace("periods = 2", "end = 2e-3") + f"[damping]\nmodal = {ZETA}\n"


def silent(*_):
    """No progress."""


def damping(system):
    """C, whole."""
    d = system.damping
    plain = d.alpha * to_dense(system.M) + d.beta * to_dense(system.K)
    return plain + np.asarray(d.other(np.eye(system.n)))


@pytest.fixture(scope="module")
def setup(tmp_path_factory):
    path = write_strips(tmp_path_factory.mktemp("alike"), study=TEXT)
    return set_up(read_study(path))


@pytest.fixture(scope="module")
def complete(setup):
    """The reduced model with all modes that there are, and the reference with few."""
    high = set_up(creak.change_study(setup.study, {"reduction.f_max": 1e8}))
    return run_study(high, silent).reduced, build_reference(setup.structure, setup.band, silent)


def test_every_mode_has_its_share_of_critical(setup, complete):
    """phi' C phi = 2 zeta omega of all modes of the full matrices, by SciPy's eigh; before, of the first ones alone."""
    reduced, reference = complete
    assert reduced.complete
    M, K = to_dense(reference.system.M), to_dense(reference.system.K)
    light = np.flatnonzero(M.diagonal() <= 1e-10 * M.diagonal().max())
    assert not light.size
    omega2, phi = sla.eigh(K, M)
    omega = np.sqrt(omega2)

    def shares(system):
        return np.einsum("ij,ij->j", phi, damping(system) @ phi) / (2.0 * omega)

    like = damped_alike(setup.structure.modal, True, reference, reduced)
    np.testing.assert_allclose(shares(like), ZETA, rtol=1e-6)
    own = phi.T @ damping(like) @ phi
    scale = np.sqrt(np.outer(omega, omega)) * 2.0 * ZETA
    assert np.abs(own - np.diag(np.diag(own))).max() < 1e-6 * scale.max()
    before = shares(reference.system)
    assert before[0] == pytest.approx(ZETA, rel=1e-6)
    assert before[-1] > 5.0 * ZETA


def test_shapes_that_are_not_orthonormal_do_not_damp_low_modes(setup, complete, monkeypatch):
    """The last shape with ten times the first one in it: the share of the first mode was 1e2 omega_n / omega_1 times its
    own."""
    reduced, reference = complete
    real = handover.recovered_on

    def mixed(*given):
        shapes = real(*given).copy()
        shapes[:, -1] += 10.0 * shapes[:, 0]
        return shapes

    monkeypatch.setattr(handover, "recovered_on", mixed)
    system = damped_alike(setup.structure.modal, True, reference, reduced)
    omega2, phi = sla.eigh(to_dense(reference.system.K), to_dense(reference.system.M))
    shares = np.einsum("ij,ij->j", phi, damping(system) @ phi) / (2.0 * np.sqrt(omega2))
    np.testing.assert_allclose(shares, ZETA, rtol=1e-5)


def test_a_structure_that_its_supports_carry_along_is_not_damped(setup, complete):
    """C R s' + C_qs s' = 0 for the motion R without inertia, which has no deformation rate of its own."""
    reduced, reference = complete
    system = damped_alike(setup.structure.modal, True, reference, reduced)
    R, d = reference.support_shapes, system.damping
    sides = d.alpha * to_dense(system.supports.M_qs) + d.beta * to_dense(system.supports.K_qs) + system.supports.C_qs
    force = damping(system) @ R
    np.testing.assert_allclose(force + sides, 0.0, atol=1e-9 * np.abs(force).max())


def test_what_was_damped_comes_back_plain(setup, complete):
    _, reference = complete
    whole = reference.system
    plain = without_modal_damping(whole, reference.support_shapes)
    assert plain.damping.is_rayleigh
    assert (plain.damping.alpha, plain.damping.beta) == (0.0, 0.0)
    scale = np.abs(whole.supports.C_ss).max()
    np.testing.assert_allclose(plain.supports.C_ss, 0.0, atol=1e-12 * scale)
    assert without_modal_damping(plain, reference.support_shapes) is plain


def test_other_damping_and_a_band_that_was_not_raised_stay(setup, complete):
    reduced, reference = complete
    assert damped_alike(None, True, reference, reduced) is reference.system
    few = run_study(setup, silent).reduced
    assert not few.complete
    assert damped_alike(setup.structure.modal, False, reference, few) is reference.system


def test_every_mode_of_gap_modes_has_its_share_whatever_is_known_of_the_whole(setup, complete):
    """Modes beyond the first f_max too, by SciPy's eigh; the residual shapes beyond them more, as their frequency."""
    _, reference = complete
    high = set_up(creak.change_study(setup.study, {"reduction.method": "gap-modes", "reduction.f_max": 1e5}))
    found = reduce_model(high.reduction, reference, high.contacts, silent)
    omega2, phi = sla.eigh(to_dense(found.system.K), to_dense(found.system.M))
    omega, kept = np.sqrt(omega2), found.modes
    shares = np.einsum("ij,ij->j", phi, damping(found.system) @ phi) / (2.0 * omega)
    assert found.system.n > kept > reference.modes.omega2.size
    np.testing.assert_allclose(shares[:kept], ZETA, rtol=1e-6)
    np.testing.assert_allclose(shares[kept:], ZETA * omega[kept:] / omega[kept - 1], rtol=1e-6)
