"""An Abaqus and a Nastran deck of the same model give the same K and M.

The formats differ by default in two things that go together: Nastran lumps mass (PARAM,COUPMASS: linear shape functions)
and its CQUAD4 is softer in transverse shear; creak's Abaqus decks have consistent mass and plain quadrilaterals. The tests
therefore ask for the same mass form on both sides, for each of the three, and compare the defaults where they must agree.
Entries are compared relative to the diagonal, |K_ij| <= sqrt(K_ii K_jj): both decks go through the same elements, so what
is left is round-off, about the number of added terms times 2e-16.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
import pytest
from numpy.testing import assert_allclose

from creak.arrays import to_dense
from creak.assembly.coupling import Driven
from creak.formats.abaqus.reader import read_deck
from creak.formats.nastran.reader import read_nastran
from creak.model.mesh import Model
from creak.studies.models.deck_modes import model_modes
from helpers_nastran import assembled, rigid_mass
from helpers_same_model import HELD, HUB, SEAT, abaqus_deck, mesh, nastran_deck

RECORDED = {"section": "decks", "source": "each other"}

ROUND_OFF = 1e-14
MESH = mesh()


@dataclass(frozen=True)
class Matrices:
    """K and M of a model, rows sorted by (node label, dof)."""

    rows: list[tuple[int, int]]
    K: np.ndarray
    M: np.ndarray


def matrices(model: Model) -> Matrices:
    system = assembled(model)
    rows = [(int(model.nodes.ids[c // 6]), c % 6 + 1) for c in system.coordinates.tolist()]
    order = sorted(range(len(rows)), key=rows.__getitem__)
    K, M = (to_dense(A)[np.ix_(order, order)] for A in (system.K, system.M))
    return Matrices([rows[k] for k in order], K, M)


def pair(folder, *, held: bool, parameters: str = "PARAM,COUPMASS,1") -> tuple[Model, Model]:
    (folder / "same.inp").write_text(abaqus_deck(MESH, held=held), encoding="utf-8")
    (folder / "same.bdf").write_text(nastran_deck(MESH, held=held, parameters=parameters), encoding="utf-8")
    return read_deck(folder / "same.inp"), read_nastran(folder / "same.bdf")


def difference(A: np.ndarray, B: np.ndarray) -> np.ndarray:
    """|A - B| over the geometric mean of the diagonal; rows without anything (rotations of lumped mass) count as 1."""
    scale = np.sqrt(np.maximum(np.abs(np.diag(A)), np.abs(np.diag(B))))
    scale[scale == 0.0] = 1.0
    return np.abs(A - B) / np.outer(scale, scale)


@pytest.mark.parametrize("held", [True, False])
@pytest.mark.parametrize(
    ("form", "parameters"), [("lumped", "PARAM,COUPMASS,-1"), ("linear", "PARAM,COUPMASS,1"), ("consistent", "")]
)
def test_stiffness_and_mass_are_the_same(tmp_path, form, parameters, held, measured):
    abaqus, nastran = pair(tmp_path, held=held, parameters=parameters)
    assert not [u for model in (abaqus, nastran) for u in model.unread if u.changes_answer]
    a, b = matrices(replace(abaqus, mass_form=form)), matrices(replace(nastran, mass_form=form))
    assert a.rows == b.rows
    dependent = 6 * len(HUB) + 6  # the shells keep a drilling rotation at each held node
    assert len(a.rows) == 6 * len(MESH.nodes) - dependent - (5 * len(HELD) + 2 if held else 0)
    worst = max(difference(a.K, b.K).max(), difference(a.M, b.M).max())
    measured("same model as Abaqus and Nastran deck: K and M, relative difference", worst, at_most=ROUND_OFF)


def test_the_nastran_deck_asks_for_its_mass_form(tmp_path):
    assert pair(tmp_path, held=True)[1].mass_form == "linear"
    assert pair(tmp_path, held=True, parameters="")[1].mass_form == "lumped"


@pytest.mark.parametrize("held", [True, False])
def test_frequencies_are_the_same(tmp_path, held, measured):
    """Free, the two plates have twelve rigid motions, of which two springs and the rod hold three.

    Round-off in K moves omega^2 by 1e-14 of the highest one: 1e-8 of low ones.
    """
    abaqus, nastran = pair(tmp_path, held=held)
    (_, a), (_, b) = (model_modes(m, Driven({}), count=16) for m in (replace(abaqus, mass_form="linear"), nastran))
    assert int((a.omega2 == 0.0).sum()) == int((b.omega2 == 0.0).sum()) == (0 if held else 9)
    assert_allclose(a.frequencies, b.frequencies, rtol=1e-8)
    elastic = b.frequencies > 0.0
    ratio = a.frequencies[elastic] / b.frequencies[elastic]
    measured("same model as Abaqus and Nastran deck: ratio of frequencies, worst", ratio, 1.0, rel=1e-8)


def test_defaults_agree_where_they_must(tmp_path):
    """Rigid-body mass, and stiffness away from the quadrilaterals: only those are softer in shear in Nastran decks."""
    abaqus, nastran = pair(tmp_path, held=False, parameters="")
    assert (abaqus.mass_form, nastran.mass_form) == ("consistent", "lumped")
    rigid = [rigid_mass(m)[:3, :3] for m in (abaqus, nastran)]
    assert_allclose(rigid[0], rigid[1], rtol=1e-12, atol=1e-12 * rigid[0].max())
    a, b = matrices(abaqus), matrices(nastran)
    found = difference(a.K, b.K)
    softer = {MESH.label(n) for row in (*MESH.quads, *MESH.sheet) for n in row}
    softer |= {MESH.label(n) for n in (*HUB, *SEAT, "p", "q")}
    away = [k for k, (node, _) in enumerate(a.rows) if node not in softer]
    assert len(away) >= 6 * 4
    assert found[away].max() < ROUND_OFF
    assert found.max() > 1e-4


@pytest.mark.parametrize(("old", "new"), [("0.8\n*ORIENT", "0.8001\n*ORIENT"), ("\n3, 30.0\n", "\n3, 31.0\n")])
def test_a_small_change_of_one_deck_is_seen(tmp_path, old, new):
    _, nastran = pair(tmp_path, held=True)
    text = abaqus_deck(MESH)
    assert old in text
    (tmp_path / "same.inp").write_text(text.replace(old, new), encoding="utf-8")
    changed = replace(read_deck(tmp_path / "same.inp"), mass_form="linear")
    assert difference(matrices(changed).K, matrices(nastran).K).max() > 1e-5
