"""Where the model is cut, and where superelements meet the deck, what was joined stays joined and no more: closed forms
of beams."""

from __future__ import annotations

import warnings

import numpy as np
import pytest

from creak.api.study import run
from creak.errors import NumericalError
from creak.reduction.diagonal import diagonalise
from creak.studies.file.reader import read_study
from creak.studies.models.health import require_no_softer
from creak.studies.models.reduced import reduced_modes
from helpers_core import system_of

E, G, AREA, INERTIA, TORSION, DENSITY = 70000.0, 26923.0, 100.0, 900.0, 1500.0, 2.7e-9
EI, LENGTH, FORCE = E * INERTIA, 400.0, 10.0
SECTION = (
    f"*BEAM GENERAL SECTION, ELSET={{}}, SECTION=GENERAL, DENSITY={DENSITY}\n"
    f"{AREA}, {INERTIA}, 0., {INERTIA}, {TORSION}\n0, 1, 0\n{E}, {G}\n"
)
STUDY = """
[model]
deck = "deck.inp"
units = "mm-t-s"
[damping]
modal = 0.3
[excitation.push]
node_set = "PUSHED"
dof = "z"
kind = "force"
signal = {{ type = "smooth-step", values = [[0, 0], [0.1, {force}]] }}
[time]
end = 0.3
[output]
nodes = "PUSHED"
{more}
"""


def beam(first: int, names: tuple[str, ...], length: float, n: int = 8) -> str:
    """n elements along x, as many in each set."""
    each = n // len(names)
    nodes = "".join(f"{first + i}, {length * i / n}, 0, 0\n" for i in range(n + 1))
    elements = ""
    for k, name in enumerate(names):
        rows = range(first + k * each, first + (k + 1) * each)
        elements += f"*ELEMENT, TYPE=B33, ELSET={name}\n" + "".join(f"{i}, {i}, {i + 1}\n" for i in rows)
        elements += SECTION.format(name)
    return f"*NODE\n{nodes}{elements}"


def settled(folder, deck: str, more: str) -> float:
    """Motion of the pushed node along the force, once it rests."""
    (folder / "deck.inp").write_text(deck, encoding="utf-8")
    path = folder / "study.toml"
    path.write_text(STUDY.format(force=FORCE, more=more), "utf-8")
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        return float(run(read_study(path)).history.displacement[-1][2])


CLAMPED = "*NSET, NSET=ENDS\n1, 9\n*BOUNDARY\nENDS, 1, 6\n"


@pytest.mark.parametrize("reduction", ['substructures = ["RIGHT"]', 'unreduced = ["RIGHT"]'])
@pytest.mark.parametrize(
    ("pushed", "support", "w"),
    [
        (5, "", FORCE * LENGTH**3 / (192.0 * EI)),
        # Two spans l over a support, pushed in the middle of one: fixed ends, and the node between them turns.
        (3, "*BOUNDARY\n5, 3\n", FORCE * (0.5 * LENGTH) ** 3 / EI * (1.0 / 192.0 + 1.0 / 512.0)),
    ],
)
def test_a_beam_that_is_cut_where_something_else_acts_stays_whole(tmp_path, reduction, pushed, support, w):
    """A hinge there would give four times as much: F L^3 / (48 E I)."""
    deck = beam(1, ("LEFT", "RIGHT"), LENGTH) + CLAMPED + support + f"*NSET, NSET=PUSHED\n{pushed}\n"
    assert settled(tmp_path, deck, f"[reduction]\n{reduction}") == pytest.approx(w, rel=1e-6)


def test_an_unreduced_rod_does_not_hold_the_rotation_of_the_beam_that_it_meets(tmp_path):
    """A rod has no rotations: the cantilever's tip turns on."""
    rod = f"*NODE\n20, {LENGTH}, 0, 100\n*ELEMENT, TYPE=T3D2, ELSET=ROD\n20, 9, 20\n"
    rod += "*SOLID SECTION, ELSET=ROD, MATERIAL=SOFT\n1.\n*MATERIAL, NAME=SOFT\n*ELASTIC\n100., 0.3\n*DENSITY\n1e-9\n"
    deck = beam(1, ("BEAM",), LENGTH) + rod + "*BOUNDARY\n1, 1, 6\n20, 1, 3\n*NSET, NSET=PUSHED\n9\n"
    w = FORCE / (3.0 * EI / LENGTH**3 + 1.0)
    assert settled(tmp_path, deck, '[reduction]\nunreduced = ["ROD"]') == pytest.approx(w, rel=1e-6)


@pytest.mark.parametrize("method", ["none", "gap-modes", "craig-bampton"])
def test_a_spring_does_not_hold_the_rotation_of_the_superelement_that_it_meets(tmp_path, method):
    """The superelement is the tip of a cantilever; a spring to ground makes its node one of the deck's."""
    L, k = LENGTH, 2.0
    entries = {(1, 1): E * AREA / L, (4, 4): G * TORSION / L, (5, 5): 4.0 * EI / L, (6, 6): 4.0 * EI / L}
    entries |= {(2, 2): 12.0 * EI / L**3, (3, 3): 12.0 * EI / L**3, (2, 6): -6.0 * EI / L**2, (3, 5): 6.0 * EI / L**2}
    mass = {(i, i): 1e-5 if i < 4 else 1e-2 for i in range(1, 7)}
    cards = ""
    for name, matrix in (("KAAX", entries), ("MAAX", mass)):
        cards += f"DMIG    {name:8s}       0       6       2       0\n"
        for (i, j), value in sorted(matrix.items(), key=lambda item: item[0][::-1]):
            cards += f"DMIG*   {name:8s}        {9:16d}{j:16d}\n*       {9:16d}{i:16d}{value:16.9E}\n"
    (tmp_path / "tip.pch").write_text(cards, encoding="utf-8")
    deck = f"*NODE\n9, {L}, 0, 0\n20, {L}, 0, 100\n*ELEMENT, TYPE=SPRING2, ELSET=S\n1, 9, 20\n*SPRING, ELSET=S\n3, 3\n{k}\n"
    deck += beam(31, ("OTHER",), LENGTH) + "*BOUNDARY\n20, 1, 6\n31, 1, 6\n*NSET, NSET=PUSHED\n9\n"
    more = f'[superelement.tip]\nfile = "tip.pch"\n[reduction]\nmethod = "{method}"'
    assert settled(tmp_path, deck, more) == pytest.approx(FORCE / (3.0 * EI / L**3 + k), rel=1e-6)


def frequencies(K: np.ndarray) -> np.ndarray:
    """Of a reduced model of unit mass, Hz."""
    return reduced_modes(diagonalise(system_of(np.eye(len(K)), K)), 1e6).frequencies


def test_a_reduced_model_that_is_softer_is_refused():
    """Joints that were lost would show: frequencies of any basis lie above those of the whole (Courant, Fischer)."""
    K, rng = np.diag([0.0, 4.0, 9.0, 25.0, 1e4]), np.random.default_rng(3)
    whole = np.sqrt(np.diag(K)) / (2.0 * np.pi)
    for n in (2, 3, 4):
        basis = np.linalg.qr(rng.standard_normal((5, n)))[0]
        require_no_softer(frequencies(basis.T @ K @ basis), whole[:4])
    with pytest.raises(NumericalError, match=r"mode 3 .* 0\.4456 Hz, and 0\.4775 Hz"):
        require_no_softer(frequencies(np.diag([0.0, 4.0, 7.84])), whole)
