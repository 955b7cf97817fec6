"""Dataclasses in HDF5 come back as they were."""

from __future__ import annotations

from dataclasses import dataclass, fields
from pathlib import Path
from typing import Any, TypeVar

import h5py
import numpy as np
import pytest
from typing_extensions import TypeAliasType

from creak.arrays import ComplexArray, FloatArray, IntArray
from creak.formats.stored.tree import BIG, read_tree, write_tree

T = TypeVar("T", bound=np.generic)
Named = TypeAliasType("Named", np.ndarray[Any, np.dtype[T]], type_params=(T,))
"""As NumPy 2.5 makes `NDArray`: neither an array nor a generic of one."""


@dataclass(frozen=True)
class Spelt:
    """The same array under every hint that may stand for one."""

    alias: Named[np.float64]
    perhaps: Named[np.float64] | None
    absent: Named[np.float64] | None
    many: tuple[Named[np.int64], ...]
    two: tuple[Named[np.int64], float]
    by_name: dict[str, Named[np.bool_]]
    bare: np.ndarray
    none_of_them: tuple[Branch, ...]


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
    return Tree(
        branch([]),
        many,
        {"b": np.array([1.0 + 2.0j]), "a": np.zeros(0, complex)},
        [leaf(), leaf(1.0)],
        None,
        "x" * 200_000,
    )


def test_round_trip(tree, tmp_path):
    with h5py.File(tmp_path / "t.h5", "w") as file:
        write_tree(file.create_group("tree"), tree)
        assert "nothing" not in file["tree"]
    with h5py.File(tmp_path / "t.h5") as file:
        assert same(tree, read_tree(Tree, file["tree"]))


def test_values_tell_arrays_not_the_spelling_of_hints(tmp_path):
    x, rows = np.array([0.5, np.nan, -1.0]), np.array([3, 1])
    told = Spelt(x, x, None, (rows, rows[:1]), (rows, 0.25), {"on": rows > 1}, x, ())
    with h5py.File(tmp_path / "t.h5", "w") as file:
        write_tree(file, told)
        assert sorted(k for k, v in file.items() if isinstance(v, h5py.Group)) == ["by_name", "many", "two"]
        back = read_tree(Spelt, file)
    for name in ("alias", "perhaps", "bare"):
        np.testing.assert_array_equal(getattr(back, name), x)
    for found, wanted in zip(
        (*back.many, back.two[0], back.by_name["on"]), (rows, rows[:1], rows, rows > 1), strict=True
    ):
        assert found.dtype == wanted.dtype
        np.testing.assert_array_equal(found, wanted)
    assert (back.absent, back.two[1], back.none_of_them) == (None, 0.25, ())


@pytest.mark.parametrize(("name", "value"), [("leaf", np.zeros(3)), ("rows", "[1, 2]")])
def test_an_array_where_there_is_none_and_none_where_there_is_one_are_told(name, value, tmp_path):
    with h5py.File(tmp_path / "t.h5", "w") as file:
        write_tree(file, branch([1, 2]))
        del file[name]
        file[name] = value
        with pytest.raises(TypeError, match=f"/{name} holds"):
            read_tree(Branch, file)


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
        with pytest.raises(KeyError, match="word"):
            read_tree(Tree, file["tree"])
        assert read_tree(Tree, file["tree"], word="given").word == "given"
