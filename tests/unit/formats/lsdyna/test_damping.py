"""*DAMPING of LS-DYNA decks: alpha and beta by closed forms and by own matrices; what is no such number is named."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.linalg import expm

from creak.arrays import to_dense
from creak.errors import InputError
from creak.formats.abaqus.reader import read_deck
from creak.formats.abaqus.writer import write_deck
from creak.formats.deck.catalogue import stop_on_unread
from creak.formats.lsdyna.reader import read_lsdyna
from creak.studies.models.deck_modes import deck_matrices, deck_modes

E, RHO, AREA, LENGTH, MASS, SPRING = 2000.0, 1.2e-9, 3.0, 50.0, 4e-8, 70.0
CHAIN = (
    "*KEYWORD\n*NODE\n1,0.,0.,0.,7,7\n2,50.,0.,0.,5,7\n3,100.,0.,0.,5,7\n"
    "*ELEMENT_BEAM\n1,1,1,2\n2,2,2,3\n*ELEMENT_MASS\n5,3,4.e-8\n*ELEMENT_DISCRETE\n7,3,1,3\n"
    "*PART\nleft\n1,1,1\n*PART\nright\n2,1,1\n*PART\nspring\n3,3,3\n*SECTION_BEAM\n1,3\n3.\n"
    "*SECTION_DISCRETE\n3\n0.\n*MAT_SPRING_ELASTIC\n3,70.\n*MAT_ELASTIC\n1,1.2e-9,2000.,.3\n"
    "*SET_PART_LIST\n8\n1,2\n"
)
"""Two trusses in a row from a wall, a mass at their end, a spring from the wall to the mass: x of nodes 2 and 3."""
ONE = (
    "*KEYWORD\n*NODE\n1,0.,0.,0.,7,7\n2,50.,0.,0.,5,7\n*ELEMENT_BEAM\n1,1,1,2\n*PART\nbar\n1,1,1\n"
    "*SECTION_BEAM\n1,3\n3.\n*MAT_ELASTIC\n1,1.2e-9,2000.,.3\n"
)
"""One truss: k = E A/L, m = rho A L/3."""
CURVE = "*DEFINE_CURVE\n4,0,1.,2.,0.,3.\n0.,7.\n1.,7.\n"
"""SFO (7 + OFFO) = 20."""


def read(folder, text):
    path = folder / "deck.k"
    path.write_text(f"{text}*END\n", encoding="utf-8")
    return read_lsdyna(path)


def damping(model):
    """C in x, in the order of the nodes; zero where there is none."""
    found, _ = deck_matrices(model)
    order = np.argsort(found.node_ids)
    C = np.zeros((order.size, order.size)) if found.C is None else to_dense(found.C)
    return C[np.ix_(order, order)]


def own(alpha, beta, of_mass=0.0):
    """C of the chain from the numbers of each truss."""
    C = np.zeros((3, 3))
    for i in (0, 1):
        C[i : i + 2, i : i + 2] += alpha[i] * RHO * AREA * LENGTH / 6.0 * np.array([[2.0, 1.0], [1.0, 2.0]])
        C[i : i + 2, i : i + 2] += beta[i] * E * AREA / LENGTH * np.array([[1.0, -1.0], [-1.0, 1.0]])
    C[2, 2] += of_mass * MASS
    return C[1:, 1:]


def same(model, expected):
    assert damping(model) == pytest.approx(expected, rel=1e-9, abs=1e-12 * np.abs(expected).max())


@pytest.mark.parametrize(
    ("keyword", "alpha", "beta"),
    [
        ("*DAMPING_GLOBAL\n0,900.\n", 900.0, 0.0),
        ("*DAMPING_PART_MASS\n1,4,45.\n" + CURVE, 900.0, 0.0),
        ("*DAMPING_PART_STIFFNESS\n1,-2.e-6\n", 0.0, 2e-6),
        ("*DAMPING_GLOBAL\n0,900.\n*DAMPING_PART_STIFFNESS\n1,-2.e-6\n", 900.0, 2e-6),
    ],
)
def test_one_dof_dies_out_as_alpha_and_beta_say(tmp_path, keyword, alpha, beta):
    """u = u0 e^(-d t) (cos w t + d/w sin w t), d = (alpha + beta w0^2)/2, w^2 = w0^2 - d^2, w0^2 = 3 E/(rho L^2)."""
    found, _ = deck_matrices(read(tmp_path, ONE + keyword))
    k, m, c = (to_dense(A)[0, 0] for A in (found.K, found.M, found.C))
    w0 = np.sqrt(3.0 * E / RHO) / LENGTH
    d = 0.5 * (alpha + beta * w0 * w0)
    w = np.sqrt(w0 * w0 - d * d)
    for t in (0.3 / w0, 5.0 / w0, 40.0 / w0):
        moved = expm(t * np.array([[0.0, 1.0], [-k / m, -c / m]]))[0, 0]
        assert moved == pytest.approx(np.exp(-d * t) * (np.cos(w * t) + d / w * np.sin(w * t)), rel=1e-8)


@pytest.mark.parametrize(
    ("keyword", "alpha", "beta", "of_mass"),
    [
        ("*DAMPING_GLOBAL\n0,25.\n", (25.0, 25.0), (0.0, 0.0), 25.0),
        ("*DAMPING_GLOBAL\n0,25.,2.,2.,2.,2.,2.,2.\n", (50.0, 50.0), (0.0, 0.0), 50.0),
        ("*DAMPING_GLOBAL\n4\n" + CURVE, (20.0, 20.0), (0.0, 0.0), 20.0),
        ("*DAMPING_PART_MASS\n1,4\n2,4,.5\n" + CURVE, (20.0, 10.0), (0.0, 0.0), 0.0),
        ("*DAMPING_PART_MASS\n1,4,1.,1\n3.,3.,3.,3.,3.,3.\n2,4\n" + CURVE, (60.0, 20.0), (0.0, 0.0), 0.0),
        ("*DAMPING_PART_MASS_SET\n8,4\n" + CURVE, (20.0, 20.0), (0.0, 0.0), 0.0),
        ("*DAMPING_PART_STIFFNESS\n1,-1.e-5\n2,-3.e-5\n", (0.0, 0.0), (1e-5, 3e-5), 0.0),
        ("*DAMPING_PART_STIFFNESS_SET\n8,-1.e-5\n", (0.0, 0.0), (1e-5, 1e-5), 0.0),
        ("*DAMPING_PART_STIFFNESS\n1,0.\n", (0.0, 0.0), (0.0, 0.0), 0.0),
    ],
)
def test_parts_have_their_own(tmp_path, keyword, alpha, beta, of_mass):
    """Against matrices made here: all elements, parts, part sets; nothing is left unread. The spring has none."""
    model = read(tmp_path, CHAIN + keyword)
    assert model.unread == ()
    same(model, own(alpha, beta, of_mass))
    write_deck(model, tmp_path / "copy.inp")
    same(read_deck(tmp_path / "copy.inp"), own(alpha, beta, of_mass))


@pytest.mark.parametrize(
    ("keyword", "why"),
    [
        ("*DAMPING_GLOBAL\n0,25.,1.,1.,0.,1.,1.,1.\n", "its directions (STX to SRZ) are not damped alike"),
        ("*DAMPING_GLOBAL\n4\n" + CURVE.replace("1.,7.", "1.,8."), "its curve 4 is not constant"),
        ("*DAMPING_GLOBAL\n5\n", "its curve 5 is no *DEFINE_CURVE"),
        ("*DAMPING_GLOBAL\n0,25.\n*DAMPING_GLOBAL\n0,26.\n", "more than once, with other numbers"),
        ("*DAMPING_PART_MASS\n1\n", "it has no curve (LCID)"),
        ("*DAMPING_PART_MASS\n1,4,1.,1\n1.,1.,1.,0.,0.,0.\n" + CURVE, "not damped alike"),
        ("*DAMPING_PART_MASS\n1,4,1.,1\n\n" + CURVE, "not damped alike"),
        ("*DAMPING_PART_MASS\n6,4\n" + CURVE, "part 6 is not defined"),
        ("*DAMPING_PART_MASS_SET\n9,4\n" + CURVE, "part set 9 is not defined"),
        ("*DAMPING_PART_STIFFNESS\n1,.1\n", "a share of critical damping at high frequencies"),
        ("*DAMPING_PART_STIFFNESS_SET\n8,.1\n", "a share of critical damping at high frequencies"),
        ("*DAMPING_PART_STIFFNESS\n3,-1.e-5\n", "creak gives none to the discrete elements of part 3"),
        ("*DAMPING_FREQUENCY_RANGE\n.01,1.,30.\n", "creak does not read this damping"),
        ("*DAMPING_FREQUENCY_RANGE_DEFORM\n.01,1.,30.\n", "creak does not read this damping"),
        ("*DAMPING_RELATIVE\n.01,1.,1\n", "creak does not read this damping"),
    ],
)
def test_what_is_neither_alpha_nor_beta_is_named_and_matters(tmp_path, keyword, why):
    """It damps nothing, and stops what depends on damping; modes do not."""
    model = read(tmp_path, CHAIN + keyword)
    (found,) = model.unread
    name = keyword.split("\n")[0]
    assert (found.keyword, found.changes_answer, found.damps) == (name, True, True)
    assert why in found.why
    assert "[damping] in a study stands in its place" in found.why
    assert not damping(model).any()
    with pytest.raises(InputError, match=rf"\{name} is not read by creak and would change the answer"):
        stop_on_unread(model, ())
    assert len(deck_modes(tmp_path / "deck.k", count=1).frequencies) == 1


def test_what_has_two_numbers_is_named(tmp_path):
    """*DAMPING_GLOBAL holds; of two of one part the first."""
    both = read(tmp_path, CHAIN + "*DAMPING_GLOBAL\n0,25.\n*DAMPING_PART_MASS\n1,4\n" + CURVE)
    assert "creak takes *DAMPING_GLOBAL alone" in both.unread[0].why
    same(both, own((25.0, 25.0), (0.0, 0.0), 25.0))
    twice = read(tmp_path, CHAIN + "*DAMPING_PART_STIFFNESS\n1,-1.e-5\n1,-2.e-5\n")
    assert "part 1 has it twice" in twice.unread[0].why
    same(twice, own((0.0, 0.0), (1e-5, 0.0)))


@pytest.mark.parametrize(
    ("keyword", "said"),
    [
        ("*DAMPING_GLOBAL\n0,-25.\n", r"field 2 of \*DAMPING_GLOBAL is '-25.'; expected a damping of zero or more"),
        ("*DAMPING_PART_MASS\n1,4,-1.\n" + CURVE, r"field 3 of \*DAMPING_PART_MASS is '-1.'; expected a damping"),
        ("*DAMPING_PART_MASS\n1,4,1.,1\n", "expected a line of STX, STY, STZ, SRX, SRY, SRZ after one with FLAG 1"),
    ],
)
def test_wrong_damping_is_refused(tmp_path, keyword, said):
    with pytest.raises(InputError, match=said):
        read(tmp_path, CHAIN + keyword)
