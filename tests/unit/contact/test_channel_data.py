"""Records of gap channels: every field is selected and joined by one rule."""

from __future__ import annotations

from dataclasses import dataclass, field, fields, is_dataclass

import numpy as np
import pytest
import scipy.sparse as sp

from creak.arrays import FloatArray
from creak.contact.channel_data import joined, per_channel, taken
from creak.contact.gap_operator import GapOperator, join
from creak.contact.laws.parameters import Curves, Friction

OVER_LABELS = {"labels", "G", "tangents"}


def operator(m: int, seed: int, **law) -> GapOperator:
    """m channels over six labels of one node, each with values of its own."""
    rng = np.random.default_rng(seed)
    G, t1, t2 = (sp.csr_matrix(rng.uniform(1.0, 2.0, (m, 6))) for _ in range(3))
    numbers = {name: rng.uniform(1.0, 2.0, m) for name in ("gap0", "stiffness", "damping", "area")}
    return GapOperator(
        labels=np.arange(6) + 6 * seed,
        G=G,
        tangents=(t1, t2),
        step_limited=rng.uniform(size=m) > 0.5,
        names=tuple(f"{seed}:{i}" for i in range(m)),
        nodes_idx=np.full(m, seed),
        group=(f"contact {seed}",) * m,
        **numbers,
        **law,
    )


def curve(top: float) -> FloatArray:
    return np.array([[0.0, 0.0], [1.0, top]])


@pytest.fixture
def three():
    """Laws in different ones of them."""
    rng = np.random.default_rng(0)
    friction = Friction(*np.sort(rng.uniform(0.1, 0.5, (3, 2)), axis=0)[::-1])
    return [
        operator(2, 1, curves=Curves(np.array([1, 0]), np.array([2.0, 3.0]), (curve(5.0), curve(6.0)))),
        operator(2, 2, friction=friction, size=np.array([0.5, 0.7])),
        operator(
            3,
            3,
            preload=np.ones(3),
            held=np.ones((3, 2)),
            curves=Curves(np.array([-1, 0, 0]), np.ones(3), (curve(7.0),)),
        ),
    ]


def same(a, b, kind) -> None:
    """Field by field; what one does not say is what `empty` says."""
    for f in fields(kind):
        if "empty" not in f.metadata or f.metadata["into"]:
            continue
        x, y, empty = getattr(a, f.name), getattr(b, f.name), f.metadata["empty"]
        if is_dataclass(y) and x is not None:
            same(x, y, empty)
        elif not isinstance(empty, type):
            assert np.array_equal(x if x is not None else np.full((len(y), *np.shape(empty)), empty), y), f.name
            assert type(x) is type(y) or x is None


def law_of(gaps: GapOperator, channel: int):
    curves = gaps.curves
    return None if curves is None or curves.of[channel] < 0 else curves.points[curves.of[channel]].tolist()


def test_each_field_of_the_operator_is_per_channel_or_over_labels():
    assert {f.name for f in fields(GapOperator) if "empty" not in f.metadata} == OVER_LABELS


def test_what_was_joined_comes_back_by_selecting(three):
    everything, at = join(three), 0
    for o in three:
        part = everything.select(np.arange(at, at + o.m))
        same(o, part, GapOperator)
        assert part.labels.tolist() == o.labels.tolist()
        assert (part.G != o.G).nnz == 0
        assert part.retained_nodes.tolist() == o.retained_nodes.tolist()
        assert [law_of(part, i) for i in range(o.m)] == [law_of(o, i) for i in range(o.m)]
        at += o.m
    assert everything.m == at == 7


def test_what_no_operator_says_stays_unsaid(three):
    plain = join([operator(2, 1), operator(3, 2)])
    assert (plain.curves, plain.friction, plain.preload, plain.size) == (None, None, None, None)


def test_no_operators_are_no_channels():
    none = join([])
    assert (none.m, none.names, none.preload) == (0, (), None)
    kinds = {f: getattr(none, f).dtype.kind for f in ("gap0", "step_limited", "nodes_idx", "labels")}
    assert kinds == {"gap0": "f", "step_limited": "b", "nodes_idx": "i", "labels": "i"}


@dataclass(frozen=True)
class Worn:
    """A record that the rule has never seen."""

    depth: FloatArray = field(metadata=per_channel(0.25))
    said: tuple[str, ...] = field(metadata=per_channel("-"))


def test_a_new_field_needs_no_word_anywhere_else():
    one = Worn(np.array([1.0, 2.0]), ("a", "b"))
    both = Worn(**joined(Worn, [one, None], [2, 2]))
    assert both.depth.tolist() == [1.0, 2.0, 0.25, 0.25]
    few = taken(both, np.array([3, 0]))
    assert (few.depth.tolist(), few.said) == ([0.25, 1.0], ("-", "a"))
