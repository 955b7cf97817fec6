"""What is written is read back: all formats, bit by bit."""

from __future__ import annotations

import re
from dataclasses import replace

import numpy as np
import pytest
from scipy import sparse

from creak.errors import InputError
from creak.formats.matrices.checks import dense
from creak.formats.matrices.superelements import FORMATS, files_of, read_superelement, write_superelement
from helpers_matrices import assert_same, random_superelement

RECORDED = {"section": "decks"}


@pytest.mark.parametrize("damping", [True, False])
@pytest.mark.parametrize("format", FORMATS)
def test_round_trip(tmp_path, format, damping, measured):
    """OP4 and npz hold doubles; 17 decimal digits identify a double (IEEE 754), so all must be exact."""
    part = random_superelement(3, damping)
    files = write_superelement(part, tmp_path, format)
    assert all(file.is_file() and file.parent == tmp_path for file in files)
    assert not list(tmp_path.glob(".*")), "no temporary files stay"
    assert {file.name for file in files} <= set(files_of(part.name, format)), "all were told beforehand"
    again = read_superelement(files[0])
    assert again.name == "part"
    assert again.source == str(files[0])
    assert_same(again, part)
    measured(
        f"matrices written and read, {format}: K, largest difference",
        abs(dense(again.K) - part.K).max(),
        0.0,
        source="themselves",
    )


@pytest.mark.parametrize("format", FORMATS)
def test_nodes_with_some_dofs_only(tmp_path, format):
    """A node may keep any of its dofs; rows come back in the writers' order, sorted by node and dof."""
    part = random_superelement(4)
    keep = np.array([0, 1, 2, 7, 11, 12, 13, 14])
    few = replace(
        part,
        node_ids=part.node_ids[keep],
        dofs=part.dofs[keep],
        K=part.K[np.ix_(keep, keep)],
        M=part.M[np.ix_(keep, keep)],
        C=part.C[np.ix_(keep, keep)],
    )
    assert_same(read_superelement(write_superelement(few, tmp_path, format)[0]), few)


@pytest.mark.parametrize("format", ["op4", "dmig", "abaqus", "abaqus-matrix-output"])
def test_rows_in_any_order_come_back_sorted(tmp_path, format):
    part = random_superelement(5)
    mixed = np.random.default_rng(1).permutation(12)
    order = np.concatenate([[12], mixed, [13, 14]])
    shuffled = replace(
        part,
        node_ids=part.node_ids[order],
        dofs=part.dofs[order],
        K=part.K[np.ix_(order, order)],
        M=part.M[np.ix_(order, order)],
        C=part.C[np.ix_(order, order)],
    )
    assert_same(read_superelement(write_superelement(shuffled, tmp_path, format)[0]), part)


@pytest.mark.parametrize("format", ["npz", "matrix-market"])
def test_sparse_matrices_stay_sparse(tmp_path, format):
    part = random_superelement(6)
    thin = replace(part, K=sparse.csr_array(np.diag(np.arange(1.0, 16.0))), C=None)
    again = read_superelement(write_superelement(thin, tmp_path, format)[0])
    assert sparse.issparse(again.K)
    assert again.K.nnz == 15
    np.testing.assert_array_equal(dense(again.K), dense(thin.K))
    np.testing.assert_array_equal(dense(again.M), part.M)


def test_npz_opens_with_numpy(tmp_path):
    part = random_superelement()
    with np.load(write_superelement(part, tmp_path, "npz")[0], allow_pickle=False) as arrays:
        np.testing.assert_array_equal(arrays["K"], part.K)
        np.testing.assert_array_equal(arrays["positions"][arrays["position_nodes"] == 1203][0], part.positions[1203])


def test_file_names_follow_the_name(tmp_path):
    part = replace(random_superelement(), name="door / left 2.1")
    written = write_superelement(part, tmp_path / "new", "op4")
    assert [p.suffix for p in written] == [".op4", ".asm"]
    assert len({p.stem for p in written}) == 1
    assert all(re.fullmatch(r"door\w+-[0-9a-f]{8}", p.stem) for p in written)  # changed names are told apart


def test_a_failed_write_leaves_no_file(tmp_path):
    homeless = replace(random_superelement(), positions={})
    for format in ("op4", "dmig"):
        with pytest.raises(InputError, match="place of node 7 is not known"):
            write_superelement(homeless, tmp_path, format)
    assert list(tmp_path.iterdir()) == []


def test_ids_too_large_for_nastran(tmp_path):
    part = random_superelement()
    far = replace(part, node_ids=np.where(part.node_ids == 1203, 99_999_999, part.node_ids))
    with pytest.raises(InputError, match="above Nastran's largest id"):
        write_superelement(far, tmp_path, "dmig")
