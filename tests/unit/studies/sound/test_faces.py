"""Listeners that name surfaces and element sets: what of a model radiates to them."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from creak.errors import InputError
from creak.model.materials import SolidSection
from creak.model.mesh import Surface
from creak.model.skin import skin_of
from creak.reduction.band_modes import Losses
from creak.studies.file.places import Places
from creak.studies.file.sound_tables import ListenerTable
from creak.studies.sound.listeners import listeners_of
from creak.studies.sound.plates_heard import plate_heard
from creak.studies.sound.sheets import pushes, sheets_of
from creak.studies.sound.statistics import _beams, _sent, _straight, statistics_of
from helpers_core import STEEL, block, channels, model_of
from helpers_plate import supported_plate
from helpers_solids import solid_mesh

N = (12, 10)


def named(model, name: str, rows: np.ndarray):
    """The model with an element set of its first block, and a surface of the same."""
    of = np.column_stack([np.zeros(rows.size, dtype=np.int64), rows])
    surface = Surface(f"{name}_TOP", of, np.ones(rows.size, dtype=np.int64), np.zeros(0, dtype=np.int64))
    return replace(model, element_sets={name: of}, surfaces={surface.name: surface})


def heard(model, *names: str):
    table = ListenerTable(position=(0.1, 0.1, 2.0), parts=list(names))
    (one,) = listeners_of(model, {"ear": table}, Places(Path("study.toml")), 1.0)
    return one


@pytest.fixture(scope="module")
def plate():
    return named(supported_plate(N), "LEFT", np.arange(3 * N[1]))  # a quarter of its elements


def test_an_element_set_and_a_surface_are_heard_as_their_facets(plate):
    whole, left, top, both = (heard(plate, *n) for n in ((), ("left",), ("LEFT_TOP",), ("LEFT", "PLATE")))
    assert whole.skin.count == both.skin.count == N[0] * N[1]
    assert left.skin.count == top.skin.count == 3 * N[1]
    np.testing.assert_array_equal(left.skin.nodes_idx, plate.blocks[0].nodes_idx[: 3 * N[1]])
    assert left.parts == ("PLATE",)


def test_of_solids_what_no_other_covers_is_heard(plate):
    coords, elements = solid_mesh((4, 2, 2), (0.4, 0.2, 0.2))
    model = model_of(coords, [block("hex8", elements, SolidSection("STEEL", STEEL))])
    skin = skin_of(model)
    end = np.flatnonzero(coords[elements].mean(axis=1)[:, 0] < 0.1)
    found = heard(named(model, "END", end), "END").skin
    assert found.count == 4 + 8  # its face, and a strip of four sides
    assert found.count < skin.count
    assert (found.centres[:, 0] < 0.1).all()


@pytest.mark.parametrize(
    ("name", "says"),
    [
        ("LEFTT", "unknown part 'LEFTT'.*a part, a surface or an element set.*Did you mean 'LEFT'"),
        ("NODES", "'NODES' is a set of nodes, without faces"),
    ],
)
def test_a_name_that_has_no_face_is_refused(plate, name, says):
    with pytest.raises(InputError, match=says):
        heard(replace(plate, node_sets={"NODES": np.arange(3)}), name)


def test_statistics_send_as_much_as_is_heard(plate):
    """A quarter of a plate: a quarter of its waves; what a force sends by itself where it pushes that quarter."""
    n = plate.nodes.count
    x = plate.nodes.coords[:, 0]
    left, right = int(np.flatnonzero(x < 0.05)[5]), int(np.flatnonzero(x > 0.4)[5])
    G = np.zeros((2, 6 * n))
    G[[0, 1], [6 * left + 2, 6 * right + 2]] = 1.0
    (push,) = pushes(sheets_of(plate, skin_of(plate), 1.0), channels(G, [0.0, 0.0], [1.0, 1.0]), np.array([0, 1]))
    whole, some = (plate_heard(push, heard(plate, *names), 1.0) for names in ((), ("LEFT",)))
    assert _sent(some, 15) == pytest.approx(0.25 * _sent(whole, 15))
    straight = [_straight([h], 2, 500.0)[:, 0] for h in (whole, some)]
    assert abs(straight[1][0]) == pytest.approx(abs(straight[0][0]))
    assert straight[1][1] == 0.0


def test_listeners_of_two_halves_of_a_plate_each_hear_their_own(plate):
    """What is known of the faces of one is not taken for those of the other."""
    right = named(plate, "RIGHT", np.arange(9 * N[1], 12 * N[1])).element_sets
    model = replace(plate, element_sets={**plate.element_sets, **right})
    G = np.zeros((1, 6 * plate.nodes.count))
    G[0, 6 * 40 + 2] = 1.0
    gaps, row = channels(G, 0.0, 1.0), np.array([0])
    known = [statistics_of(model, skin_of(model), gaps, row, Losses(zeta=0.02), (500.0, 1e4), 1.0) for _ in range(2)]
    (push,) = pushes(known[0].sheets, gaps, row)
    left, other = (_beams(known[0], push.part, heard(model, name)) for name in ("LEFT", "RIGHT"))
    assert np.abs(left - other).max() > 0.01
    np.testing.assert_array_equal(other, _beams(known[1], push.part, heard(model, "RIGHT")))


def test_a_measured_way_is_that_of_a_part(plate, tmp_path):
    (tmp_path / "way.csv").write_text("frequency,amplitude\n10,1\n1000,1\n")
    table = ListenerTable(position=(0.1, 0.1, 2.0), transfer={"LEFT": {"file": "way.csv"}})
    with pytest.raises(InputError, match="unknown part 'LEFT'"):
        listeners_of(plate, {"ear": table}, Places(tmp_path / "study.toml"), 1.0)
