"""Stored files that were damaged, or made on purpose: refused in a few words, never read."""

from __future__ import annotations

import json
import random
import struct
import sys
from dataclasses import replace

import h5py
import numpy as np
import pytest
import scipy.sparse as sp

from creak.errors import InputError
from creak.formats.matrices.superelements import read_superelement, write_superelement
from creak.formats.measured.histories import read_histories
from creak.formats.stored import superelement as module
from creak.formats.stored.npz_arrays import read_arrays
from creak.formats.stored.sealed import BLOCK, MARK, Damaged, opened_hdf5, read_sealed, sealed_text
from creak.formats.stored.superelement import SavedSuperelement, read_superelement_file, write_superelement_file
from helpers_matrices import random_superelement
from helpers_stored import changed_hdf5, resealed, write_small_results

FLIPS = 150


@pytest.fixture
def saved():
    """A superelement of 3 boundary dofs seen through 2 shapes, 2 modes of 5 inner dofs."""
    rng = np.random.default_rng(3)
    K, M = (sp.csr_matrix(np.diag(rng.random(4))) for _ in range(2))
    about = {"deck": "a.inp"}
    shape, modes = sp.csr_matrix(rng.random((3, 2))), rng.random((5, 2))
    made_from = {"stiffness": "ab", "creak": "1"}
    at = np.array([1, 4])
    names = np.array([7, 8, 0, 0]), np.array([1, 2, 0, 0])
    matrices = {"K": K, "M": M, "M_alone": M.toarray()}
    return SavedSuperelement(
        "DOOR", made_from, matrices, shape, np.array([1.0, 4.0]), modes, 9.0, *names, about, at, rng.random((2, 2))
    )


@pytest.fixture
def superelement_file(saved, tmp_path):
    path = tmp_path / "DOOR.h5"
    write_superelement_file(path, saved)
    return path


@pytest.fixture
def results(tmp_path):
    path = tmp_path / "results.h5"
    write_small_results(path)
    return path


def test_a_superelement_comes_back_as_it_was(saved, superelement_file):
    again = read_superelement_file(superelement_file)
    for key, A in saved.matrices.items():
        np.testing.assert_array_equal(
            np.asarray(sp.csr_matrix(again.matrices[key]).toarray()), sp.csr_matrix(A).toarray()
        )
    np.testing.assert_array_equal(again.modes, saved.modes)
    assert (again.name, again.made_from, again.about) == (saved.name, saved.made_from, saved.about)


@pytest.mark.skipif(sys.platform == "win32", reason="there a file that is mapped cannot be replaced")
def test_many_modes_stay_in_the_file(saved, superelement_file, monkeypatch):
    monkeypatch.setattr(module, "MAPPED", 0)
    monkeypatch.setattr(module, "ROWS", 32)
    again = read_superelement_file(superelement_file)
    assert isinstance(again.modes, np.memmap)
    np.testing.assert_array_equal(again.modes, saved.modes)
    write_superelement_file(superelement_file, replace(saved, modes=np.asfortranarray(2.0 * saved.modes)))
    np.testing.assert_array_equal(again.modes, saved.modes)  # the file of before, for as long as it is read
    np.testing.assert_array_equal(read_superelement_file(superelement_file).modes, 2.0 * saved.modes)


@pytest.mark.parametrize("read", [read_superelement_file, read_histories])
def test_no_flipped_bit_passes(read, superelement_file, results):
    path = {read_superelement_file: superelement_file, read_histories: results}[read]
    whole, rng = path.read_bytes(), random.Random(1)
    for at in (0, len(MARK), BLOCK, len(whole) - 1, *(rng.randrange(len(whole)) for _ in range(FLIPS))):
        data = bytearray(whole)
        data[at] ^= 1 << rng.randrange(8)
        path.write_bytes(data)
        with pytest.raises(InputError, match=r"damaged|cut short"):
            read(path)
    path.write_bytes(whole)
    read(path)


def test_a_file_that_is_longer_or_shorter_is_refused(results):
    whole = results.read_bytes()
    for data in (whole + b"\0", whole[:-1], whole[:BLOCK], whole[:5], b""):
        results.write_bytes(data)
        with pytest.raises(InputError, match="cut short or damaged"):
            read_histories(results)


@pytest.mark.parametrize(
    ("key", "data"),
    [
        ("K/indices", np.array([0, 1, 2, 10**8], dtype=np.int32)),
        ("K/indices", np.array([0, 1, -2, 3], dtype=np.int32)),
        ("K/indptr", np.array([0, 9, 2, 3, 4], dtype=np.int32)),
        ("K/indptr", np.array([0, 1, 2], dtype=np.int32)),
        ("K/data", np.array([1.0, np.nan, 1.0, 1.0])),
        ("P/indices", np.array([0, 1, 0, 1, 0, 2], dtype=np.int32)),
        ("M_alone", np.ones((3, 4))),
        ("M_alone", np.array([["a"]], dtype="S1")),
        ("modes", np.ones((5, 3))),
        ("modes", np.full((5, 2), np.inf)),
        ("omega2", np.ones((2, 2))),
        ("dofs", np.array([1, 2])),
        ("node_ids", np.array([1.5, 2.0, 0.0, 0.0])),
        ("static_at", np.array([1, 5])),
        ("static_rows", np.ones((2, 3))),
    ],
)
def test_a_superelement_made_of_parts_that_do_not_fit_is_refused(superelement_file, key, data):
    with changed_hdf5(superelement_file) as file:
        del file[key]
        file[key] = data
    with pytest.raises(InputError, match=r"DOOR\.h5: the superelement file is damaged"):
        read_superelement_file(superelement_file)


@pytest.mark.parametrize("attribute", ["about", "first_left_out", "made_from"])
def test_a_superelement_without_an_attribute_is_refused(superelement_file, attribute):
    with changed_hdf5(superelement_file) as file:
        file.attrs[attribute] = np.zeros((2, 2))
    with pytest.raises(InputError, match="damaged"):
        read_superelement_file(superelement_file)


def test_files_of_an_earlier_version_are_told(superelement_file, results):
    with h5py.File(superelement_file, "w") as file:
        file.attrs["creak_superelement"] = 2
    with pytest.raises(InputError, match=r"superelement file of version 2; expected version 3\. Delete it"):
        read_superelement_file(superelement_file)
    with h5py.File(results, "w") as file:
        file.create_group("runs")
    with pytest.raises(InputError, match=r"no checksum: .* an earlier creak.*Run the study again"):
        read_histories(results)


def test_nothing_outside_the_file_is_read(results, tmp_path):
    (tmp_path / "secret").write_bytes(b"password" * 4)
    with changed_hdf5(results) as file:
        group = file["runs/reduced"]
        del group["time"]
        dcpl = [(str(tmp_path / "secret"), 0, 32)]
        group.create_dataset("time", (4,), dtype="f8", external=dcpl)
    with pytest.raises(InputError, match="time lies in another file"):
        read_histories(results)
    for link in (h5py.ExternalLink("secret", "/x"), h5py.SoftLink("/runs/reduced/gap")):
        with changed_hdf5(results) as file:
            del file["runs/reduced/time"]
            file["runs/reduced/time"] = link
        with pytest.raises(InputError, match="time is a link to another place"):
            read_histories(results)
    with changed_hdf5(results) as file:
        del file["runs/reduced/time"]
        layout = h5py.VirtualLayout((4,), dtype="f8")
        layout[:] = h5py.VirtualSource("secret", "x", (4,))
        file["runs/reduced"].create_virtual_dataset("time", layout)
    with pytest.raises(InputError, match="time lies in another file"):
        read_histories(results)


def test_numbers_that_are_only_announced_take_no_memory(results):
    with changed_hdf5(results) as file:
        del file["runs/reduced/gap"]
        file["runs/reduced"].create_dataset("gap", (10**6, 10**6), dtype="f8", chunks=(1000, 1000), compression="gzip")
    with pytest.raises(InputError, match="gap announces more numbers than it holds"):
        read_histories(results)


@pytest.mark.parametrize(
    ("name", "data"),
    [
        ("gap", np.ones((4, 2))),
        ("displacement", np.ones((4, 1, 3))),
        ("normal_force", np.ones(4)),
        ("time", np.array([0.0, np.nan, 1.0, 2.0])),
        ("time", np.array([0.0, 2.0, 1.0, 3.0])),
        ("time", np.float64(1.0)),
        ("channels", np.array([1.0])),
        ("node_ids", np.array([3, 4])),
    ],
)
def test_histories_that_do_not_fit_are_refused(results, name, data):
    with changed_hdf5(results) as file:
        del file[f"runs/reduced/{name}"]
        file[f"runs/reduced/{name}"] = data
    with pytest.raises(InputError, match="cut short or damaged"):
        read_histories(results)


def test_units_that_are_not_known_are_refused(results):
    with changed_hdf5(results) as file:
        file.attrs["units"] = "furlong"
    with pytest.raises(InputError, match="cut short or damaged"):
        read_histories(results)


def test_a_plain_hdf5_library_reads_a_sealed_file(results):
    with h5py.File(results) as file:
        assert file["runs/reduced/gap"].shape == (4, 1)
        assert file.userblock_size == BLOCK
    resealed(results)
    with opened_hdf5(results) as file:
        assert list(file["runs"]) == ["reduced"]


def test_a_summary_keeps_its_checksum_through_any_layout_and_no_change(tmp_path):
    path = tmp_path / "summary.json"
    data = {"b": [1, 2.5, None, True], "a": {"x": 1e-300, "y": "\u00e9"}}
    path.write_text(sealed_text(data), encoding="utf-8")
    assert read_sealed(path) == data
    path.write_text(json.dumps(json.loads(path.read_text()), sort_keys=True))
    assert read_sealed(path) == data
    path.write_text(path.read_text().replace("2.5", "2.6"))
    with pytest.raises(Damaged, match="checksum does not fit"):
        read_sealed(path)
    for text in ("", "[]", "3", "{}", "[" * 100_000, "\0", '{"sha256": null}'):
        path.write_text(text)
        with pytest.raises(Damaged, match=r"\w"):
            read_sealed(path)


def good():
    n = 3
    ids, dofs = np.array([1, 1, 2]), np.array([1, 2, 1])
    return {"K": np.eye(n), "M": np.eye(n), "node_ids": ids, "dofs": dofs}


RECORD = np.zeros(3, dtype=[("a", "f8"), ("b", "i4")])
TRIPLETS = {"K_row": np.array([0, 1, 2]), "K_column": np.array([0, 1, 2]), "K_value": np.ones(3)}


@pytest.mark.parametrize(
    "change",
    [
        {"K": np.array([None, {}, 3], dtype=object)},
        {"K": RECORD},
        {"dofs": RECORD},
        {"K": np.array(3.0)},
        {"node_ids": np.array(1)},
        {"node_ids": np.array([1.0, np.nan, 2.0])},
        {"node_ids": np.array([1e300, 1.0, 2.0])},
        {"dofs": np.array(["a", "b", "c"])},
        {"dofs": np.array([1 + 2j, 1, 1])},
        {"K": np.eye(3) * 1j},
        {"K": np.ones((3, 3, 3))},
        {"positions": np.array(1.0), "position_nodes": np.array(1)},
        {"positions": np.ones((2, 3)), "position_nodes": np.array([1])},
        {"positions": np.array(["x"]), "position_nodes": np.array([1])},
        {**TRIPLETS, "K_row": np.array([0, 1, 3])},
        {**TRIPLETS, "K_row": np.array([0, 1, -1])},
        {**TRIPLETS, "K_row": np.array(2)},
        {**TRIPLETS, "K_value": np.array(["1", "2", "3"])},
        {**TRIPLETS, "K_column": RECORD},
    ],
)
def test_npz_files_that_are_no_matrices_are_refused(change, tmp_path):
    path = tmp_path / "part.npz"
    arrays = good() if "K_row" not in change else {k: v for k, v in good().items() if k != "K"}
    np.savez(path, **{**arrays, **change})
    with pytest.raises(InputError, match=r"part\.npz"):
        read_superelement(path)


def test_no_flipped_bit_changes_an_npz(tmp_path):
    """Zip keeps a CRC of each array; what it does not cover (names, dates) changes no number."""
    path = tmp_path / "part.npz"
    np.savez_compressed(path, **good())
    whole, rng = path.read_bytes(), random.Random(2)
    for _ in range(4 * FLIPS):
        data = bytearray(whole)
        data[rng.randrange(len(whole))] ^= 1 << rng.randrange(8)
        path.write_bytes(data)
        try:
            found = read_superelement(path)
        except InputError:
            continue
        np.testing.assert_array_equal(found.K, np.eye(3))
        np.testing.assert_array_equal(found.node_ids, [1, 1, 2])


def test_an_npz_array_longer_than_its_file_takes_no_memory(tmp_path):
    path = tmp_path / "big.npz"
    np.savez(path, K=np.zeros(4))
    data = path.read_bytes()
    path.write_bytes(data.replace(b"(4,), }          ", b"(40000000000,), }"))
    with pytest.raises(Damaged, match=r"\w"):
        read_arrays(path)


def test_a_zero_byte_in_a_matrix_market_file_is_told(tmp_path):
    K, *_ = write_superelement(random_superelement(), tmp_path, "matrix-market")
    text = K.read_bytes()
    for at in (20, len(text) // 2, len(text) - 2):
        K.write_bytes(text[:at] + b"\0" + text[at + 1 :])
        with pytest.raises(InputError, match=r"part_K\.mtx: .*it holds zero bytes"):
            read_superelement(K)
    K.write_bytes(text)
    read_superelement(K)


@pytest.mark.parametrize(
    ("rows", "reason"),
    [
        ("x" * 200_000, r"part_dofs\.csv:2: this row cannot be read"),
        ('1,1,"' + "0" * 200_000, r"part_dofs\.csv:2: this row cannot be read"),
        ("1" * 5000 + ",1", "is no row of a map"),
        (f"{10**30},1", "is no row of a map"),
        (f"1,{-(10**30)}", "is no row of a map"),
        ("1,1,nan,0,0", "three finite coordinates|rows"),
    ],
)
def test_a_damaged_map_is_told(tmp_path, rows, reason):
    K, _, _, table = write_superelement(random_superelement(), tmp_path, "matrix-market")
    table.write_text(f"node,dof,x,y,z\n{rows}\n")
    with pytest.raises(InputError, match=reason) as stop:
        read_superelement(K)
    assert len(str(stop.value)) < 1000


def test_an_op4_header_of_absurd_size_takes_no_memory(tmp_path):
    path, *_ = write_superelement(random_superelement(), tmp_path, "op4")
    data = bytearray(path.read_bytes())
    data[4:12] = struct.pack("<2i", 2**31 - 1, 2**31 - 1)
    path.write_bytes(data)
    with pytest.raises(InputError, match=r"part\.op4: this is no complete OUTPUT4 file"):
        read_superelement(path)
