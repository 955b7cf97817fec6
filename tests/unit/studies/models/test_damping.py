"""Damping of a study: every mode gets it, in both models, and a model without any is told."""

from __future__ import annotations

import re

import numpy as np
import pytest
import scipy.linalg as sla

from creak.assembly.damping import undamped_words
from creak.assembly.system import System
from creak.dynamics.diagonal import modal_matrices
from creak.formats.abaqus.reader import read_deck
from creak.linalg.modes import modes
from creak.progress import silent
from creak.reduction.modal import with_modal_damping
from creak.studies.file.reader import read_study
from creak.studies.models.reduced import reduce_model
from creak.studies.prepare.setup import set_up
from creak.studies.propose.proposal import propose
from creak.studies.propose.text import proposal_text
from creak.studies.run.precheck import ready
from creak.studies.warned import warnings_of
from helpers_core import chain, system_of
from helpers_decks import STUDY, two_strips, write_strips

RECORDED = {"section": "verdicts"}

ZETA = 0.02
UNDAMPED = re.sub(r"\*DAMPING[^\n]*\n", "", two_strips())
MODAL = STUDY.replace("step = 5e-4\n", "").replace("[reduction]", f"[damping]\nmodal = {ZETA}\n[reduction]")


def fractions(system: System) -> tuple[np.ndarray, np.ndarray]:
    """omega and zeta of all modes of a sparse System, and a check that C couples none of them."""
    K, M = system.K.toarray(), system.M.toarray()
    omega2, Phi = sla.eigh(K, M)
    d = system.damping
    C = d.alpha * M + d.beta * K + np.asarray(d.other(np.eye(system.n)))
    modal = Phi.T @ C @ Phi
    np.testing.assert_allclose(modal - np.diag(modal.diagonal()), 0.0, atol=1e-9 * modal.max())
    return np.sqrt(omega2), modal.diagonal() / (2.0 * np.sqrt(omega2))


def test_modes_beyond_the_computed_ones_are_damped_like_their_stiffness(measured):
    M, K = chain(20)
    system = system_of(M, K)
    found = modes(system.K, system.M, count=5)
    omega, zeta = fractions(with_modal_damping(system, found, np.zeros((20, 0)), ZETA, beyond=True))
    expected = ZETA * np.maximum(1.0, omega / omega[4])
    np.testing.assert_allclose(zeta, expected, rtol=1e-7)
    alone = fractions(with_modal_damping(system, found, np.zeros((20, 0)), ZETA))[1]
    np.testing.assert_allclose(alone, np.where(np.arange(20) < 5, ZETA, 0.0), atol=1e-9)
    measured(
        "fraction of critical of the highest mode", zeta[-1], expected[-1], rel=1e-7, source="zeta omega / omega_b"
    )


@pytest.fixture(scope="module")
def both(tmp_path_factory):
    """The two models of a study with modal damping."""
    setup = set_up(read_study(write_strips(tmp_path_factory.mktemp("strips"), UNDAMPED, MODAL)))
    _, reference, gaps, _ = ready(setup, silent)
    return setup, reference, reduce_model(setup.reduction, reference, gaps, silent)


def test_every_mode_of_the_reduced_model_has_the_damping_of_the_study(both):
    _, reference, reduced = both
    m, c, k = modal_matrices(reduced.system)
    omega = np.sqrt(k[m > 0.0])
    assert omega.max() > 10.0 * 2.0 * np.pi * reference.modes.frequencies.max()
    np.testing.assert_allclose(c[m > 0.0], 2.0 * ZETA * omega, rtol=1e-9)


def test_the_unreduced_model_agrees_in_the_band_and_is_damped_beyond(both):
    setup, reference, _ = both
    omega, zeta = fractions(reference.system)
    band = omega <= 2.0 * np.pi * setup.study.config.reduction.f_max
    assert band.sum() > 3
    np.testing.assert_allclose(zeta[band], ZETA, rtol=1e-4)
    assert zeta[~band].min() > ZETA * (1.0 - 1e-4)


def test_a_dashpot_in_an_undamped_structure_is_told_as_none(tmp_path):
    """And the study that creak proposes says how the others are damped."""
    dashpot = "*ELEMENT, TYPE=DASHPOT1, ELSET=D\n9001, 13\n*DASHPOT, ELSET=D\n3\n1e-6\n*BOUNDARY\n"
    deck = UNDAMPED.replace("*BOUNDARY\n", dashpot, 1)
    (said,) = warnings_of(set_up(read_study(write_strips(tmp_path, deck))).notes)
    assert said.startswith("48 of 48 shells, solids and beams are undamped: the deck damps other elements alone")
    line = re.search(r"damping\.modal = [\d.]+", said).group()
    assert warnings_of(set_up(read_study(write_strips(tmp_path, deck, f"{line}\n{STUDY}"))).notes) == []
    model = read_deck(tmp_path / "strips.inp")
    text = proposal_text(propose(model, None, None, silent), model, "strips.inp", "strips")
    assert "# Damping: 48 of 48 shells, solids and beams of the deck have none." in text
    assert "modal = 0.02" in text


def test_structural_damping_of_the_deck_goes_into_its_first_study(tmp_path):
    """Half of it does the same at resonance; of materials that differ the usual share is left."""
    deck = UNDAMPED.replace("*DENSITY", "*DAMPING, STRUCTURAL=0.06\n*DENSITY", 1)
    write_strips(tmp_path, deck)
    model = read_deck(tmp_path / "strips.inp")
    text = proposal_text(propose(model, None, None, silent), model, "strips.inp", "strips")
    assert "# Damping: *DAMPING, STRUCTURAL of the deck, as the share of critical" in text
    assert "modal = 0.03 " in text


def test_structural_damping_of_one_material_is_not_given_to_all(tmp_path):
    """Nor that of a bushing: what a rubber loses is not what the steel beside it loses."""
    steel = re.search(r"\*MATERIAL, NAME=STEEL\n(?:(?!\*SHELL).*\n)*", UNDAMPED).group()
    rubber = steel.replace("STEEL", "RUBBER").replace("*DENSITY", "*DAMPING, STRUCTURAL=0.3\n*DENSITY", 1)
    deck = UNDAMPED.replace(steel, steel + rubber).replace("MATERIAL=STEEL", "MATERIAL=RUBBER", 1)
    assert deck.count("MATERIAL=STEEL") == 1
    write_strips(tmp_path, deck)
    model = read_deck(tmp_path / "strips.inp")
    text = proposal_text(propose(model, None, None, silent), model, "strips.inp", "strips")
    assert "# Damping: creak does not read *DAMPING, STRUCTURAL of the deck." in text
    assert "modal = 0.02 " in text


@pytest.mark.parametrize(
    ("lines", "share"), [("1, 9, 0.03", 0.03), ("1, 4, 0.03\n5, 9, 0.01", 0.02), ("1, 9, 3.", 0.02)]
)
def test_modal_damping_of_a_step_goes_into_the_first_study(tmp_path, lines, share):
    """Where all modes have the same; else the usual share is left."""
    step = f"*STEP\n*STEADY STATE DYNAMICS\n1., 100.\n*MODAL DAMPING\n{lines}\n*END STEP\n"
    write_strips(tmp_path, UNDAMPED + step)
    model = read_deck(tmp_path / "strips.inp")
    text = proposal_text(propose(model, None, None, silent), model, "strips.inp", "strips")
    assert f"modal = {share} " in text
    assert ("# Damping: *MODAL DAMPING of the deck" in text) is (share == 0.03)


def test_elements_of_a_rigid_body_need_no_damping(tmp_path):
    """The undamped upper strip hangs on a reference node; the lower one is damped."""
    steel = re.search(r"\*MATERIAL, NAME=STEEL\n(?:(?!\*SHELL).*\n)*", two_strips()).group()
    bare = re.sub(r"\*DAMPING[^\n]*\n", "", steel).replace("STEEL", "BARE")
    deck = (
        two_strips().replace(steel, steel + bare).replace("ELSET=UPPER, MATERIAL=STEEL", "ELSET=UPPER, MATERIAL=BARE")
    )
    rigid = "*NODE\n9001, 0., 0., 9.\n*NSET, NSET=ALL_UPPER, GENERATE\n1, 39, 1\n*RIGID BODY, REF NODE=9001, TIE NSET=ALL_UPPER\n"
    (tmp_path / "a.inp").write_text(deck)
    (tmp_path / "b.inp").write_text(deck.replace("*BOUNDARY\n", f"{rigid}*BOUNDARY\n9001, 1, 6\n", 1))
    assert undamped_words(read_deck(tmp_path / "a.inp")) == ""  # half of them
    extra = deck.replace("ELSET=LOWER, MATERIAL=STEEL", "ELSET=LOWER, MATERIAL=BARE").replace("BARE", "STEEL", 0)
    (tmp_path / "c.inp").write_text(
        extra + "*ELEMENT, TYPE=DASHPOT1, ELSET=D\n9101, 1013\n*DASHPOT, ELSET=D\n3\n1e-6\n"
    )
    assert undamped_words(read_deck(tmp_path / "c.inp")).startswith("48 of 48")
    assert undamped_words(read_deck(tmp_path / "b.inp")) == ""


def test_a_model_without_damping_is_told_what_to_write(tmp_path):
    (said,) = warnings_of(set_up(read_study(write_strips(tmp_path, UNDAMPED))).notes)
    assert "nothing is damped" in said
    line = re.search(r"damping\.modal = [\d.]+", said).group()
    assert warnings_of(set_up(read_study(write_strips(tmp_path, UNDAMPED, f"{line}\n{STUDY}"))).notes) == []
    for cure in ("modal = 0", "rayleigh = { beta = 1e-6 }"):
        study = STUDY.replace("[reduction]", f"[damping]\n{cure}\n[reduction]")
        assert warnings_of(set_up(read_study(write_strips(tmp_path, UNDAMPED, study))).notes) == []
    assert warnings_of(set_up(read_study(write_strips(tmp_path))).notes) == []


@pytest.mark.parametrize(("deck", "lines"), [(UNDAMPED, 1), (two_strips(), 0)])
def test_a_new_study_damps_what_the_deck_does_not(tmp_path, deck, lines):
    path = tmp_path / "strips.inp"
    path.write_text(deck)
    model = read_deck(path)
    text = proposal_text(propose(model, None, None, silent), model, "strips.inp", "strips")
    assert text.count("[damping]\nmodal = 0.02") == lines
