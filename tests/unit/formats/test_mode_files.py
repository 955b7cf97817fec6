"""Mode shapes in VTU and UFF files, read back field by field."""

from __future__ import annotations

import numpy as np
import pytest

from creak.formats.abaqus.reader import read_deck
from creak.formats.measured.punch import write_mode_punch
from creak.formats.measured.uff import write_uff
from creak.formats.vtu import write_vtu
from helpers_punch import punched
from helpers_uff import data_sets, fields
from helpers_vtu import arrays

DECK = """\
*NODE
 10, 0., 0., 0.
 20, 1., 0., 0.
 30, 1., 1., 0.
 40, 0., 1., 0.
 50, 0., 0., 1.
 61, .5, 0., 0.
 62, .5, .5, 0.
 63, 0., .5, 0.
 64, 0., 0., .5
 65, .5, 0., .5
 66, 0., .5, .5
 70, 2., 0., -1.5
 80, 9., 9., 9.
*ELEMENT, TYPE=S4, ELSET=Q
 3, 10, 20, 30, 40
*ELEMENT, TYPE=C3D10, ELSET=T
 5, 10, 20, 40, 50, 61, 62, 63, 64, 65, 66
*ELEMENT, TYPE=B31, ELSET=B
 7, 20, 70
*ELEMENT, TYPE=MASS, ELSET=M
 9, 70
*MASS, ELSET=M
 1.
*MATERIAL, NAME=S
*ELASTIC
 210000., .3
*DENSITY
 7.85e-9
*SHELL SECTION, ELSET=Q, MATERIAL=S
 1.,
*SOLID SECTION, ELSET=T, MATERIAL=S
*BEAM SECTION, ELSET=B, MATERIAL=S, SECTION=CIRC
 .1
 0., 1., 0.
"""
FREQUENCIES = [0.0, 123.456789]


@pytest.fixture
def model(tmp_path):
    path = tmp_path / "deck.inp"
    path.write_text(DECK)
    return read_deck(path)


@pytest.fixture
def shapes(model):
    return np.random.default_rng(3).standard_normal((2, model.nodes.count, 3)) * [[[1.0]], [[1e-120]]]


def test_vtu(model, shapes, tmp_path, measured):
    write_vtu(tmp_path / "m.vtu", model, FREQUENCIES, iter(shapes))
    found = arrays(tmp_path / "m.vtu")
    np.testing.assert_array_equal(found["Points"], model.nodes.coords)
    np.testing.assert_array_equal(found["node"], model.nodes.ids)
    np.testing.assert_allclose(found["mode_001_0_Hz"], shapes[0], rtol=1e-7)
    measured(
        "decks",
        "shapes in a VTU file, relative error",
        np.abs(found["mode_001_0_Hz"] / np.where(shapes[0], shapes[0], 1.0) - (shapes[0] != 0.0)).max(),
        at_most=1e-7,
        source="themselves",
    )
    assert found["mode_002_123.457_Hz"].shape == (13, 3)
    np.testing.assert_array_equal(found["frequency"], FREQUENCIES)
    cells = np.split(found["connectivity"], found["offsets"][:-1])
    kinds = {
        int(k): (int(t), model.nodes.ids[c].tolist())
        for k, t, c in zip(found["element"], found["types"], cells, strict=True)
    }
    assert kinds[3] == (9, [10, 20, 30, 40])
    assert kinds[5] == (24, [10, 20, 40, 50, 61, 62, 63, 64, 65, 66])
    assert kinds[7] == (3, [20, 70])
    assert kinds[9] == (1, [70])


def test_vtu_is_complete_or_absent(model, shapes, tmp_path):
    with pytest.raises(ValueError, match="shorter"):
        write_vtu(tmp_path / "m.vtu", model, FREQUENCIES, iter(shapes[:1]))
    assert not list(tmp_path.glob("*m.vtu*"))


def test_uff(model, shapes, tmp_path, measured):
    write_uff(tmp_path / "m.unv", model, FREQUENCIES, iter(shapes), "m-kg-s", title="a title " * 20)
    sets = data_sets(tmp_path / "m.unv")
    assert [number for number, _ in sets] == [164, 15, 2412, 82, 55, 55]
    units, nodes, elements, lines, _, mode = (content for _, content in sets)
    assert [float(x.replace("D", "E")) for x in fields(units[1], 25)] == [1.0, 1.0, 1.0]
    for line, label, x in zip(nodes, model.nodes.ids, model.nodes.coords, strict=True):
        assert int(line[:10]) == label
        assert [float(v) for v in fields(line[40:], 13)] == pytest.approx(x.tolist(), rel=1e-5)
    read = {}
    for head, *rest in (elements[:2], elements[2:]):
        number, descriptor, _, _, _, n = (int(v) for v in fields(head, 10))
        read[number, descriptor] = [int(v) for row in rest for v in fields(row, 10)]
        assert len(read[number, descriptor]) == n
    # A parabolic tetrahedron: corners 10, 20, 40, 50; each mid-side node between its corners.
    assert read == {(3, 94): [10, 20, 30, 40], (5, 118): [10, 61, 20, 62, 40, 63, 64, 65, 66, 50]}
    assert [int(v) for v in fields(lines[0], 10)][:2] == [1, 2]
    assert [int(v) for v in fields(lines[2], 10)] == [20, 70]
    assert [int(v) for v in fields(mode[5], 10)] == [1, 2, 2, 8, 2, 3]
    assert [int(v) for v in fields(mode[6], 10)] == [2, 4, 1, 2]
    assert [float(v) for v in fields(mode[7], 13)] == [123.457, 1.0, 0.0, 0.0]
    assert not any(float(v) for row in mode[9::2] for v in fields(row, 13))  # 1e-120 does not fit E13.5
    first = sets[4][1]
    assert [int(v) for v in first[8::2]] == model.nodes.ids.tolist()
    got = [[float(v) for v in fields(row, 13)] for row in first[9::2]]
    np.testing.assert_allclose(got, shapes[0], rtol=1e-5)
    measured(
        "decks",
        "shapes in a universal file, relative error",
        np.abs(got / np.where(shapes[0], shapes[0], 1.0) - (shapes[0] != 0.0)).max(),
        at_most=1e-5,
        source="themselves",
    )


def test_uff_numbers_the_nodes_where_instances_repeat_labels(model, shapes, tmp_path):
    ids = model.nodes.ids.copy()
    ids[:] = 1
    object.__setattr__(model.nodes, "ids", ids)
    write_uff(tmp_path / "m.unv", model, FREQUENCIES, iter(shapes))
    sets = dict(data_sets(tmp_path / "m.unv"))
    assert [int(line[:10]) for line in sets[15]] == list(range(1, 14))
    assert [int(v) for v in sets[55][8::2]] == list(range(1, 14))
    assert float(sets[164][1][:25].replace("D", "E")) == 1000.0


def test_punch(model, tmp_path, measured):
    motions = np.random.default_rng(4).standard_normal((2, model.nodes.count, 6)) * [[[1e-7]], [[1e-120]]]
    write_mode_punch(tmp_path / "m.pch", model, FREQUENCIES, iter(motions), title="a title " * 20)
    first, second = punched(tmp_path / "m.pch")
    assert first.head[3:6] == ["$EIGENVECTOR", "$REAL OUTPUT", "$SUBCASE ID =           1"]
    assert second.after("$LABEL   =") == "mode 2, 123.457 Hz"
    value, number = second.after("$EIGENVALUE =").split("MODE =")
    assert float(value) == pytest.approx((2.0 * np.pi * 123.456789) ** 2, rel=1e-7)
    assert int(number) == 2
    assert list(first.rows) == model.nodes.ids.tolist()
    got = np.array([*first.rows.values()])
    measured(
        "decks",
        "shapes in a punch file, relative error",
        np.abs(got / motions[0] - 1.0).max(),
        at_most=5.1e-7,
        source="themselves",
    )
    assert not np.array([*second.rows.values()]).any()  # 1e-120 does not fit 1PE18.6 of two digits


def test_punch_numbers_the_nodes_where_instances_repeat_labels(model, tmp_path):
    object.__setattr__(model.nodes, "ids", np.ones_like(model.nodes.ids))
    write_mode_punch(tmp_path / "m.pch", model, [1.0], iter([np.ones((13, 6))]))
    (only,) = punched(tmp_path / "m.pch")
    assert list(only.rows) == list(range(1, 14))
