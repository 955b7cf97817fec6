"""Matrix Market files: the same as SciPy's, and damaged ones refused."""

from __future__ import annotations

import io

import numpy as np
import pytest
import scipy.io
from scipy import sparse

from creak.errors import InputError
from creak.formats.matrices.matrix_market import read_matrix_market
from creak.formats.matrices.superelements import write_superelement
from helpers_matrices import random_superelement


def written(matrix, symmetry: str) -> str:
    file = io.BytesIO()
    scipy.io.mmwrite(file, matrix, symmetry=symmetry, precision=17)
    return file.getvalue().decode()


@pytest.fixture
def folder(tmp_path):
    write_superelement(random_superelement(), tmp_path, "matrix-market")
    return tmp_path


@pytest.mark.parametrize("layout", ["array", "coordinate"])
@pytest.mark.parametrize("symmetry", ["general", "symmetric", "skew-symmetric"])
def test_what_scipy_writes_is_read(folder, layout, symmetry):
    n = read_matrix_market(folder / "part_K.mtx").node_ids.size
    A = np.random.default_rng(2).standard_normal((n, n))
    A = {"general": A, "symmetric": A + A.T, "skew-symmetric": A - A.T}[symmetry]
    made = A if layout == "array" else sparse.coo_array(np.where(np.abs(A) > 0.5, A, 0.0))
    (folder / "part_C.mtx").write_text(written(made, symmetry))
    if symmetry != "symmetric":
        with pytest.raises(InputError, match="not symmetric"):
            read_matrix_market(folder / "part_K.mtx")
        return
    C = read_matrix_market(folder / "part_K.mtx").C
    assert C is not None
    dense = [x.toarray() if sparse.issparse(x) else x for x in (C, made)]
    assert np.array_equal(*dense)


@pytest.mark.parametrize(
    ("old", "new", "told"),
    [
        ("%%MatrixMarket", "%%Matrix", "first line"),
        (" real ", " complex ", "complex, not real"),
        (" symmetric", " hermitian", "hermitian"),
        ("e+", "\0e+", "zero bytes"),
        (".", "_", "is no entry"),
        (".", "." + "9" * 400 + ".", "complete Matrix Market file"),
        ("\n-", "\n- ", "is no entry"),
    ],
)
def test_damaged_files_are_refused(folder, old, new, told):
    path = folder / "part_K.mtx"
    text = path.read_text()
    head, body = text[:60], text[60:]
    text = head.replace(old, new, 1) + body if old in head else head + body.replace(old, new, 1)
    path.write_text(text)
    with pytest.raises(InputError, match=told):
        read_matrix_market(path)
