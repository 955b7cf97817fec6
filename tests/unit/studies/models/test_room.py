"""Memory that does not hold the whole model: its parts do instead, or the study is refused before it starts."""

from __future__ import annotations

import re
import weakref
from dataclasses import replace
from functools import partial

import numpy as np
import pytest
import scipy.sparse as sp
from threadpoolctl import threadpool_limits

from creak.assembly.system import System
from creak.errors import NumericalError
from creak.linalg.factor import factor, factor_bytes
from creak.linalg.memory import OVERRIDE, OutOfMemory, free_bytes
from creak.linalg.mkl import has_pardiso
from creak.linalg.pieces.dissection import cut_once_more, whole
from creak.linalg.pieces.factor import Pieces
from creak.progress import silent
from creak.reduction import inside as limits
from creak.studies.file.reader import read_study
from creak.studies.models import of_parts
from creak.studies.models import of_parts as module
from creak.studies.models.of_parts import Room, only_parts_fit, room
from creak.studies.models.reference import assembled, build_reference
from creak.studies.prepare import structure
from creak.studies.prepare.setup import Setup, set_up
from creak.studies.run.job import run_study
from creak.studies.run.precheck import WITHOUT_WHOLE, ready
from helpers_core import system_of
from helpers_decks import STUDY, write_strips

ALONE = (
    STUDY.replace("step = 5e-4\n", "").replace("periods = 2", 'end = 0.1\naccuracy = "quick"')
    + "\n[reference]\nrun = false\n[precheck]\nmargin = 0.5\n"
)


@pytest.fixture(scope="module")
def setup(tmp_path_factory) -> Setup:
    return set_up(read_study(write_strips(tmp_path_factory.mktemp("strips"), None, ALONE)))


def changed(setup: Setup, table: str, **values: object) -> Setup:
    return setup.with_tables(**{table: getattr(setup.study.config, table).model_copy(update=values)})


@pytest.mark.skipif(not has_pardiso(), reason="SuperLU does not tell what it will need")
def test_the_analysis_tells_the_memory_of_the_factor(setup):
    K = build_reference(setup.structure, setup.band, silent).system.K
    with threadpool_limits(1):  # the work space of several threads is larger than so small a factor
        assert factor_bytes(K) == pytest.approx(factor(K).memory, rel=0.05)


def test_a_small_model_is_not_looked_at(setup, monkeypatch):
    parts = assembled(setup.structure, silent).parts
    monkeypatch.setattr(module, "factor_bytes", lambda _: pytest.fail("analysed"))
    assert room(parts) is None
    assert not only_parts_fit((), parts)


def test_the_whole_takes_more_than_its_largest_part(setup, monkeypatch):
    parts = assembled(setup.structure, silent).parts
    monkeypatch.setattr(limits, "PLENTY", 0.0)
    monkeypatch.setattr(module, "factor_bytes", lambda K: 100.0 * K.nnz)
    found = room(parts)
    assert found is not None
    K, M = (sum(getattr(p, name).nnz for p in parts) for name in "KM")
    assert found.largest in {p.name for p in parts}
    assert found.whole > 100.0 * K + 1.2 * 12.0 * (K + M)
    assert found.whole > 1.5 * found.part > 40.0 * K


def test_the_motion_before_contact_is_that_of_the_whole(setup, monkeypatch):
    """Modes, gaps of the linear run and dofs; the reduced model, and what it does, are the same but for round-off."""
    _, whole, gaps, _ = ready(setup, silent)
    plain = run_study(setup, silent)
    monkeypatch.setattr(of_parts, "only_parts_fit", lambda *_: True)
    _, parts, kept, notes = ready(setup, silent)
    assert parts.system.n < 0.7 * whole.system.n
    assert parts.free_dof == whole.free_dof == whole.system.n
    assert WITHOUT_WHOLE in notes
    n = whole.modes.omega2.size
    np.testing.assert_allclose(parts.modes.frequencies[:n], whole.modes.frequencies, rtol=2e-3)
    moved = np.abs(whole.linear_gaps - setup.contacts.gap0)
    np.testing.assert_allclose(parts.linear_gaps, whole.linear_gaps, atol=1e-3 * moved.max())
    assert kept.names == gaps.names
    alone = run_study(setup, silent)
    a, b = (r.runs["reduced"].history for r in (plain, alone))
    assert alone.modes is None
    assert plain.modes is not None
    np.testing.assert_allclose(b.force.max(axis=0), a.force.max(axis=0), rtol=1e-6, atol=1e-6 * a.force.max())
    assert a.force.max() > 0.0


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({}, r"does not hold the reduction of part UPPER: at least 2 GB are needed, 1 GB are free\. Cut it into"),
        (
            {"reference": {"run": True}},
            r'\[reference\] run = "whole" takes: at least 3 GB .* \[reference\] run = "spots"; parts alone take 2 GB',
        ),
        ({"reduction": {"method": "gap-modes"}}, r"\[reduction\] method = \"gap-modes\" takes"),
        (
            {"reference": {"run": True}, "reduction": {"method": "gap-modes"}},
            r'which .*gap-modes" and \[reference\] run = "whole" take: .* method = "craig-bampton", \[reference\] run = "spots";',
        ),
        (
            {"reduction": {"method": "none"}},
            r"\[reduction\] method = \"none\" takes: at least 3 GB .* without it: method = \"craig-bampton\"; parts",
        ),
    ],
)
def test_what_does_not_fit_is_refused_before_it_starts(change, words, setup, monkeypatch):
    for table, values in change.items():
        setup = changed(setup, table, **values)
    monkeypatch.setenv(OVERRIDE, "1")
    monkeypatch.setattr(module, "room", lambda *_: Room(3e9, 2e9, "UPPER"))
    monkeypatch.setattr(of_parts, "joined_reference", lambda *_: pytest.fail("started"))
    with pytest.raises(OutOfMemory, match=words) as said:
        ready(setup, silent)
    insisted = re.search(rf"set {OVERRIDE}=(\S+) ", str(said.value))
    assert insisted is not None
    monkeypatch.setenv(OVERRIDE, insisted[1])
    assert only_parts_fit(setup.takes_whole, ()) == (not change)


def test_parts_alone_where_the_whole_does_not_fit(setup, monkeypatch):
    monkeypatch.setattr(module, "room", lambda *_: Room(3e9, 2e9, "UPPER"))
    monkeypatch.setenv(OVERRIDE, "2.5")
    assert only_parts_fit(setup.takes_whole, ())
    monkeypatch.setenv(OVERRIDE, "3.5")
    assert not only_parts_fit(setup.takes_whole, ())


def test_no_matrix_of_a_part_stays_in_memory(setup, monkeypatch):
    """Where only the parts fit, those of all of them would take as much as a factor."""
    made, left = [], []
    for owner, name in ((structure, "part_system"), (of_parts, "_reduced")):
        monkeypatch.setattr(owner, name, partial(_noted, getattr(owner, name), made, left))
    monkeypatch.setattr(of_parts, "only_parts_fit", lambda *_: True)
    ready(setup, silent)
    assert len(left) == len(setup.model.parts)
    assert not any(left)


def _noted(call, made, left, first, *rest, **more):
    """Matrices of the systems that `call` makes; those still there when it is given a system."""
    if isinstance(first, System):
        left.append([ref() for ref in made if ref() is not None])
        return call(first, *rest, **more)
    found = call(first, *rest, **more)
    made.extend(weakref.ref(x) for x in (found.K.data, found.M.data))
    return found


def test_parts_that_only_contact_holds_need_the_whole(setup, monkeypatch):
    monkeypatch.setattr(of_parts, "only_parts_fit", lambda *_: True)
    monkeypatch.setattr(of_parts, "required_labels", lambda *_: np.zeros(0, dtype=np.int64))
    with pytest.raises(NumericalError, match="memory does not hold a factor of the whole model, and without it part "):
        ready(setup, silent)


def refused(A: sp.csr_matrix, **_: object) -> None:
    raise OutOfMemory("too large")


def halves(K: sp.csr_matrix, M: sp.csr_matrix) -> Pieces:
    """What `pieces_of` finds where there is room for a half."""
    cut = cut_once_more(sp.csr_matrix(abs(K) + abs(M)), whole(K.shape[0]), len)
    assert cut is not None
    return Pieces(cut, (1e9, 1e9), 1e9, 2e9)


def test_a_run_whose_parts_are_reduced_in_pieces_is_the_same(setup, monkeypatch):
    """To round-off, which the bounces of a symmetric strip make larger; the user is told; the check has its verdict."""
    plain = run_study(setup, silent)
    monkeypatch.setattr(of_parts, "only_parts_fit", lambda *_: True)
    monkeypatch.setattr(limits, "factor", refused)
    monkeypatch.setattr(limits, "pieces_of", halves)
    cut = run_study(setup, silent)
    told = [note for note in cut.notes if note.startswith("part UPPER does not fit: 2 GB for its factor, 1 GB free")]
    assert len(told) == 1
    assert re.search(r"cut into 2 pieces that \d+ dofs join, .* \(one at least, 1 GB\)", told[0])
    a, b = (r.runs["reduced"] for r in (plain, cut))
    np.testing.assert_allclose(b.history.force.max(axis=0), a.history.force.max(axis=0), rtol=1e-3, atol=1e-3)
    assert len(a.events) == len(b.events) > 0
    for name, found in plain.health.items():
        assert cut.health[name].good == found.good
        np.testing.assert_allclose(cut.health[name].fixed.frequencies, found.fixed.frequencies, rtol=1e-8)


@pytest.mark.skipif(not has_pardiso(), reason="SuperLU does not tell what it will need")
def test_a_part_whose_factor_does_not_fit_comes_in_pieces(setup, monkeypatch):
    """Until what joins them does not fit either."""
    line = sp.diags([-1.0, 2.0, -1.0], [-1, 0, 1], shape=(60, 60))
    K = sp.csr_matrix(sp.kron(sp.kronsum(line, line), 0.9 * np.eye(6) + 0.1))
    M = sp.identity(K.shape[0], format="csr")
    part = replace(system_of(np.eye(1), np.eye(1)), name="PANEL", K=K, M=M, coordinates=np.arange(K.shape[0]))
    monkeypatch.setattr(limits, "PLENTY", 0.0)
    factor, rest = factor_bytes(K), limits.beside_factor(part.n, K.nnz, M.nnz)

    def free(bytes_: float) -> None:
        monkeypatch.setenv(OVERRIDE, f"{bytes_ / 1e9:.9f}")

    free(rest + 1.1 * factor)
    assert limits.pieces_of(K, M) is None
    rest = limits.beside_pieces(part.n, M.nnz)
    free(rest + 0.9 * factor)
    cut = limits.pieces_of(K, M)
    assert cut is not None
    assert cut.count > 1
    assert cut.instead == factor
    found = room([part])
    assert found is not None
    assert rest + cut.bytes == pytest.approx(found.part, rel=1e-6)
    assert found.part <= free_bytes() < found.whole
    assert only_parts_fit((), [part])
    free(rest)
    least = limits.pieces_of(K, M)
    assert least is not None
    assert not least.fits
    words = rf"does not hold the reduction of part PANEL, cut into {least.count} pieces: at least (\S+) GB"
    with pytest.raises(OutOfMemory, match=words) as said:
        only_parts_fit((), [part])
    insisted = re.search(rf"set {OVERRIDE}=(\S+) ", str(said.value))
    assert insisted is not None
    monkeypatch.setenv(OVERRIDE, insisted[1])
    assert only_parts_fit((), [part])
