"""Wrong files give one clear InputError: what, where, what to do."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from creak.errors import InputError
from creak.formats.matrices.op4_file import write_op4_matrices
from creak.formats.matrices.superelements import read_superelement, write_superelement
from helpers_matrices import assert_same, random_superelement


@pytest.mark.parametrize("format", ["op4", "npz"])
def test_cut_binary_files(tmp_path, format):
    """No cut gives anything but an InputError with the file's name."""
    part = random_superelement(damping=False)
    path = write_superelement(part, tmp_path, format)[0]
    data = path.read_bytes()
    for count in [*range(0, len(data), 41), len(data) - 1]:
        path.write_bytes(data[:count])
        with pytest.raises(InputError, match=path.name):
            read_superelement(path)
    path.write_bytes(data)
    assert_same(read_superelement(path), part)


def test_damaged_npz(tmp_path):
    """A flipped byte in the compressed matrices fails the checksum."""
    path = write_superelement(random_superelement(), tmp_path, "npz")[0]
    data = bytearray(path.read_bytes())
    data[len(data) // 2] ^= 0xFF
    path.write_bytes(bytes(data))
    with pytest.raises(InputError, match="no complete NumPy file"):
        read_superelement(path)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"K": None}, "there is no array K"),
        ({"M": None}, "there is no array M"),
        ({"dofs": None}, "there is no array dofs"),
        ({"dofs": np.arange(3)}, "15 node_ids and 3 dofs"),
        ({"M": np.eye(4)}, "matrix M is 4 x 4 but the map of nodes and dofs has 15 rows"),
        ({"K": np.arange(225.0).reshape(15, 15)}, "matrix K is not symmetric"),
        ({"K": np.full((15, 15), np.inf)}, "not finite"),
        ({"node_ids": np.full(15, -3)}, "node -3"),
        ({"K": None, "K_row": np.array([15]), "K_column": np.array([0]), "K_value": np.ones(1)}, "triplets of K"),
    ],
)
def test_npz_with_wrong_arrays(tmp_path, change, message):
    path = write_superelement(random_superelement(), tmp_path, "npz")[0]
    with np.load(path) as arrays:
        content = {**arrays, **change}
    np.savez(path, **{key: value for key, value in content.items() if value is not None})
    with pytest.raises(InputError, match=message):
        read_superelement(path)


def test_rounding_of_symmetry_is_averaged(tmp_path):
    """1e-10 of the largest entry is what 11 printed digits leave; it is not an error, and goes."""
    part = random_superelement()
    rough = part.K.copy()
    rough[0, 1] += 1e-10 * np.abs(rough).max()
    path = write_superelement(replace(part, K=rough), tmp_path, "npz")[0]
    again = read_superelement(path)
    np.testing.assert_array_equal(again.K, again.K.T)
    assert again.K[0, 1] == 0.5 * (rough[0, 1] + rough[1, 0])


def test_op4_without_its_map(tmp_path):
    op4, asm = write_superelement(random_superelement(), tmp_path, "op4")
    asm.rename(tmp_path / "elsewhere.asm")
    with pytest.raises(InputError, match=r"part\.op4: the map of rows to grids is missing.*Give the \.asm file"):
        read_superelement(op4)
    assert read_superelement(op4, tmp_path / "elsewhere.asm").n == 15


def test_op4_with_the_map_of_another(tmp_path):
    op4, asm = write_superelement(random_superelement(), tmp_path, "op4")
    asm.write_text("GRID,7\nSPOINT,8,9\n")
    with pytest.raises(InputError, match=r"15 rows, the map part\.asm 8: 6 dofs of 1 grids and 2 scalar points"):
        read_superelement(op4)
    asm.write_text("SECONCT,101,0\n,1,1,7,7\nGRID,7\n")
    with pytest.raises(InputError, match="point 1 of SECONCT or EXTRN has neither a GRID nor an SPOINT card"):
        read_superelement(op4)
    asm.write_text("SECONCT,101,0\n,7,7\nSECONCT,102,0\n,8,8\n")
    with pytest.raises(InputError, match=r"part\.asm:3: SECONCT cards of superelements 101 and 102"):
        read_superelement(op4)


def test_op4_without_mass(tmp_path):
    write_op4_matrices({"KXX": np.eye(2), "PX": np.eye(2)}, tmp_path / "a.op4")
    with pytest.raises(InputError, match=r"a\.op4: there is no mass matrix \(found: KXX\); expected MXX or MAA"):
        read_superelement(tmp_path / "a.op4")


def test_matrix_market_with_missing_or_broken_files(tmp_path):
    K, M, _C, table = write_superelement(random_superelement(), tmp_path, "matrix-market")
    text, rows = M.read_text(), table.read_text()
    for kept in (0, 10, 200, len(text) // 2, text.rstrip("\n").rindex("\n")):
        M.write_text(text[:kept])
        with pytest.raises(InputError, match=r"part_M\.mtx: this is no complete Matrix Market file"):
            read_superelement(K)
    M.write_text(text.replace("real", "complex"))
    with pytest.raises(InputError, match="its entries are complex"):
        read_superelement(K)
    M.unlink()
    with pytest.raises(InputError, match=r"part_M\.mtx: there is no such file"):
        read_superelement(K)
    M.write_text(text)
    table.write_text(rows.replace("node,dof", "dof,node"))
    with pytest.raises(InputError, match=r"part_dofs\.csv:1: the header"):
        read_superelement(K)
    table.write_text(rows.replace("\n0,0", "\n0,x", 1))
    with pytest.raises(InputError, match=r"part_dofs\.csv:14: '0,x,,,' is no row"):
        read_superelement(K)
    table.write_text(rows.rstrip("\n").rpartition("\n")[0])
    with pytest.raises(InputError, match="matrix K is 15 x 15 but the map of nodes and dofs has 14 rows"):
        read_superelement(K)
    table.unlink()
    with pytest.raises(InputError, match=r"part_dofs\.csv: the file cannot be read"):
        read_superelement(K)


def test_unknown_formats(tmp_path):
    with pytest.raises(InputError, match=r"there is no format 'opp4'; expected op4, dmig.*Did you mean 'op4'"):
        write_superelement(random_superelement(), tmp_path, "opp4")
    (tmp_path / "a.xyz").write_text("")
    with pytest.raises(InputError, match=r"a\.xyz: the ending '\.xyz' is none of a superelement; expected \.op4"):
        read_superelement(tmp_path / "a.xyz")
    with pytest.raises(InputError, match=r"b\.op4: there is no such file"):
        read_superelement(tmp_path / "b.op4")
