"""Dataclasses in HDF5 come back as they were."""

from __future__ import annotations

from dataclasses import dataclass, fields
from pathlib import Path

import h5py
import numpy as np
import pytest

from creak.arrays import ComplexArray, FloatArray, IntArray
from creak.formats.tree import BIG, read_tree, write_tree


@dataclass(frozen=True)
class Leaf:
    name: str
    span: tuple[float, float]
    where: Path
    limit: float | None = None


@dataclass(frozen=True)
class Branch:
    rows: IntArray
    values: FloatArray
    leaf: Leaf


@dataclass(frozen=True)
class Tree:
    first: Branch
    others: tuple[Branch, ...]
    by_name: dict[str, ComplexArray]
    leaves: list[Leaf]
    nothing: FloatArray | None
    word: str


def leaf(limit=None):
    return Leaf('"quoted" ä', (0.1, np.inf), Path("a/b.toml"), limit)


def branch(rows):
    return Branch(np.array(rows, dtype=np.int64), np.linspace(0.0, 1.0, len(rows)) / 3.0, leaf(0.25))


def same(a, b):
    if isinstance(a, np.ndarray):
        return a.dtype == b.dtype and np.array_equal(a, b)
    if isinstance(a, (Branch, Tree)):
        return all(same(getattr(a, f.name), getattr(b, f.name)) for f in fields(a))
    if isinstance(a, (tuple, list)) and a and not isinstance(a[0], (float, str)):
        return type(a) is type(b) and len(a) == len(b) and all(same(x, y) for x, y in zip(a, b, strict=True))
    if isinstance(a, dict):
        return list(a) == list(b) and all(same(a[k], b[k]) for k in a)
    return a == b


@pytest.fixture
def tree():
    many = tuple(branch([k]) for k in range(12))  # more than ten, whose names do not sort as numbers
    return Tree(branch([]), many, {"b": np.array([1.0 + 2.0j]), "a": np.zeros(0, complex)}, [leaf(), leaf(1.0)], None, "x" * 200_000)


def test_round_trip(tree, tmp_path):
    with h5py.File(tmp_path / "t.h5", "w") as file:
        write_tree(file.create_group("tree"), tree)
        assert "nothing" not in file["tree"]
    with h5py.File(tmp_path / "t.h5") as file:
        assert same(tree, read_tree(Tree, file["tree"]))


def test_integers_take_four_bytes_where_they_fit_and_large_arrays_are_compressed(tmp_path):
    large = Branch(np.array([2**40]), np.zeros(BIG + 1), leaf())
    with h5py.File(tmp_path / "t.h5", "w") as file:
        write_tree(file.create_group("small"), branch([1, 2]))
        write_tree(file.create_group("large"), large)
        assert file["small/rows"].dtype == np.int32
        assert file["large/rows"].dtype == np.int64
        assert file["large/values"].compression == "gzip"
        assert same(read_tree(Branch, file["large"]), large)


def test_what_is_skipped_has_to_be_given(tree, tmp_path):
    with h5py.File(tmp_path / "t.h5", "w") as file:
        write_tree(file.create_group("tree"), tree, skip=("word",))
        assert "word" not in file["tree"]
        with pytest.raises(KeyError):
            read_tree(Tree, file["tree"])
        assert read_tree(Tree, file["tree"], word="given").word == "given"
