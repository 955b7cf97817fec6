"""Superelements of a study: the damping that they bring, and the nodes that they join."""

from __future__ import annotations

import numpy as np
import pytest

from creak.arrays import FloatArray
from creak.assembly.system import System, to_dense
from creak.errors import InputError
from creak.formats.matrices.npz import write_npz
from creak.model.superelement import Superelement
from creak.studies.file.reader import read_study
from creak.studies.prepare.setup import Setup, set_up

DECK = """*NODE, NSET=ALL
 1, 0., 0., 0.
 2, 3., 0., 0.
*ELEMENT, TYPE=SPRING2, ELSET=S
 1, 1, 2
*ELEMENT, TYPE=MASS, ELSET=M
 2, 2
*SPRING, ELSET=S
 1, 1
 90.
*MASS, ELSET=M{alpha}
 .4
*BOUNDARY
 1, 1, 6
 2, 2, 3
"""
STUDY = """[model]
deck = "deck.inp"
units = "m-kg-s"
{damping}
[nodes.P]
labels = [2]
[excitation.f]
node_set = "P"
dof = "x"
kind = "force"
signal = {{ type = "sine", frequency = 1.0, amplitude = 1.0 }}
[time]
end = 0.1
[output]
nodes = ["P"]
[superelement.S]
file = "s.npz"
{more}
"""
K, M, C = (np.array([[a, -b], [-b, b]]) for a, b in ((50.0, 20.0), (0.3, 0.1), (6.0, 2.0)))
"""Of node 2 along x and a generalised coordinate."""


def ready(folder, deck: str, study: str, place: list[float] | None = None) -> Setup:
    """With a superelement of node 2, which may say where that lies."""
    positions: dict[int, FloatArray] = {} if place is None else {2: np.array(place)}
    write_npz(Superelement("S", np.array([2, 0]), np.array([1, 0]), K, M, C, positions), folder / "s.npz")
    (folder / "deck.inp").write_text(deck)
    (folder / "study.toml").write_text(study)
    return set_up(read_study(folder / "study.toml"))


def damping_of(system: System) -> np.ndarray:
    d = system.damping
    whole = d.alpha * to_dense(system.M) + d.beta * to_dense(system.K)
    return whole if d.extra is None else whole + to_dense(d.extra)


@pytest.mark.parametrize(
    ("damping", "alpha", "expected"),
    [
        ("", "", C),
        ("", ", ALPHA=7.", C),
        ("[damping]\nrayleigh = { alpha = 3.0, beta = 0.01 }", "", 3.0 * M + 0.01 * K),
        ("[damping]\nmodal = 0.02", "", 0.0 * M),
    ],
    ids=["none", "of the deck", "rayleigh", "modal"],
)
def test_damping_of_a_study_replaces_that_of_a_superelement(tmp_path, damping, alpha, expected):
    setup = ready(tmp_path, DECK.format(alpha=alpha), STUDY.format(damping=damping, more=""))
    np.testing.assert_allclose(damping_of(setup.superelements[0]), expected, rtol=1e-14, atol=1e-14)
    said = [note for note in setup.notes if "superelement S: its own damping is left out" in note]
    assert len(said) == (1 if damping else 0)


INSTANCES = """*PART, NAME=P
*NODE, NSET=ALL
 1, 0., 0., 0.
 2, 3., 0., 0.
*ELEMENT, TYPE=SPRING2, ELSET=S
 1, 1, 2
*ELEMENT, TYPE=MASS, ELSET=M
 2, 2
*SPRING, ELSET=S
 1, 1
 90.
*MASS, ELSET=M
 .4
*END PART
*ASSEMBLY, NAME=A
*INSTANCE, NAME=A-1, PART=P
*END INSTANCE
*INSTANCE, NAME=B-1, PART=P
 0., {apart}, 0.
*END INSTANCE
*NSET, NSET=ROOT, INSTANCE=A-1
 1
*NSET, NSET=ROOT, INSTANCE=B-1
 1
*NSET, NSET=P, INSTANCE=A-1
 2
*NSET, NSET=P, INSTANCE=B-1
 2
*END ASSEMBLY
*BOUNDARY
 ROOT, 1, 6
 P, 2, 3
"""


def joined(folder, place: list[float] | None, more: str = "", apart: float = 2.0) -> str:
    """The node of a deck with two instances that a superelement of node 2 joins."""
    text = STUDY.format(damping="", more=more).replace("[nodes.P]\nlabels = [2]\n", "")
    setup = ready(folder, INSTANCES.format(apart=apart), text, place)
    return setup.model.nodes.label(int(setup.superelements[0].coordinates[0]) // 6)


def test_a_superelement_joins_the_instance_where_it_lies(tmp_path):
    assert joined(tmp_path, [3.0, 0.0, 0.0]) == "A-1.2"
    assert joined(tmp_path, [3.0, 2.0, 0.0]) == "B-1.2"
    assert joined(tmp_path, [3.0, 2e-4, 0.0], apart=2e-4) == "B-1.2"  # skins closer than nodes may be off


def test_a_superelement_joins_the_instance_that_the_study_names(tmp_path):
    assert joined(tmp_path, None, 'instance = "A-1"') == "A-1.2"
    assert joined(tmp_path, None, 'instance = "b-1"') == "B-1.2"
    assert joined(tmp_path, [3.0, 0.0, 0.0], 'instance = "B-1"', apart=0.0) == "B-1.2"


@pytest.mark.parametrize(
    ("place", "more", "apart", "message"),
    [
        (None, "", 2.0, r"node 2, of which the deck has 2 \(A-1\.2, B-1\.2\), and does not say .*instance = \"A-1\""),
        ([3.0, 0.0, 0.0], "", 0.0, r"\(A-1\.2, B-1\.2\), and has more than one of them at its place"),
        ([3.0, 1.6, 0.0], "", 2.0, r"node B-1\.2 lies at .* None of A-1\.2, B-1\.2 lies there"),
        ([3.0, 2.0, 0.0], 'instance = "A-1"', 2.0, r"node A-1\.2 lies at \[3\.0, 0\.0, 0\.0\]"),
        (None, 'instance = "C-1"', 2.0, r"study\.toml:\d+.* unknown instance 'C-1'"),
    ],
    ids=["no place", "one place", "elsewhere", "other instance", "unknown"],
)
def test_a_superelement_that_could_join_more_nodes_is_refused(tmp_path, place, more, apart, message):
    with pytest.raises(InputError, match=message):
        joined(tmp_path, place, more, apart)
