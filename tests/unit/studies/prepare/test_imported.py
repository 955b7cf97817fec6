"""Superelements of a study: the damping that they bring, and the nodes that they join."""

from __future__ import annotations

import numpy as np
import pytest

from creak.assembly.system import System, to_dense
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
"""
K, M, C = (np.array([[a, -b], [-b, b]]) for a, b in ((50.0, 20.0), (0.3, 0.1), (6.0, 2.0)))
"""Of node 2 along x and a generalised coordinate."""


def ready(folder, damping: str, alpha: str = "") -> Setup:
    write_npz(Superelement("S", np.array([2, 0]), np.array([1, 0]), K, M, C), folder / "s.npz")
    (folder / "deck.inp").write_text(DECK.format(alpha=alpha))
    (folder / "study.toml").write_text(STUDY.format(damping=damping))
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
    setup = ready(tmp_path, damping, alpha)
    np.testing.assert_allclose(damping_of(setup.superelements[0]), expected, rtol=1e-14, atol=1e-14)
    said = [note for note in setup.notes if "superelement S: its own damping is left out" in note]
    assert len(said) == (1 if damping else 0)
