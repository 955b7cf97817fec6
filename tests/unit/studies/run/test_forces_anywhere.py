"""A force may act on any node: at a channel, away from all of them, on a support."""

from __future__ import annotations

import tomllib

import numpy as np
import pytest

from creak.api.study import make_study, run, set_up
from creak.progress import silent
from creak.studies.models.reference import build_reference, in_modes
from creak.studies.run.integrate import linear_gaps
from creak.studies.run.precheck import with_linear_gaps
from helpers_decks import STUDY, two_strips

TIPS = (
    "*ELSET, ELSET=UTIP\n11, 12, 23, 24\n*ELSET, ELSET=LTIP\n1010, 1011, 1012, 1022, 1023, 1024\n"
    "*NSET, NSET=AWAY\n1005\n*NSET, NSET=SOME\n5, 1013\n*NSET, NSET=HELD\n1\n"
)
DAMPING = {"deck": None, "none": {}, "modal": {"modal": 0.02}, "rayleigh": {"rayleigh": {"alpha": 5.0, "beta": 1e-6}}}


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """The strips, which meet at their tips alone."""
    found = tmp_path_factory.mktemp("tips")
    deck = two_strips().replace("UPPER, SNEG", "UTIP, SNEG").replace("LOWER, SPOS", "LTIP, SPOS") + TIPS
    (found / "strips.inp").write_text(deck, encoding="utf-8")
    return found


def study(folder, node_set, damping, method="craig-bampton"):
    tables = tomllib.loads(STUDY)
    force = {"node_set": node_set, "dof": "z", "kind": "force", "signal": {"type": "sine", "frequency": 50.0}}
    force["signal"]["amplitude"] = 1.0
    tables["excitation"]["push"] = force
    tables["reduction"]["method"] = method
    tables |= {"time": {"end": 0.02, "accuracy": "quick"}, "reference": {"run": False}}
    return make_study(tables if damping is None else tables | {"damping": damping}, folder)


@pytest.mark.parametrize("node_set", ["AWAY", "SOME", "HELD"])
@pytest.mark.parametrize("damping", DAMPING.values(), ids=DAMPING.keys())
def test_the_precheck_feels_a_force_anywhere(folder, node_set, damping):
    """The System that it keeps without damping moves as the one that is made of the damped whole."""
    setup = set_up(study(folder, node_set, damping))
    reference = build_reference(setup.structure, setup.band, silent)
    whole, contacts = in_modes(reference, setup.reduction), setup.contacts
    expected = linear_gaps(setup.marching, contacts, whole).lowest
    found = with_linear_gaps(
        setup.study.config.precheck, setup.reduction, setup.marching, reference, silent
    ).linear_gaps
    scale = float(np.abs(expected - setup.contacts.gap0).max())
    assert found == pytest.approx(expected, abs=1e-9 * scale)  # round-off


@pytest.mark.slow
@pytest.mark.parametrize("method", ["craig-bampton", "none", "gap-modes"])
def test_a_study_with_a_force_runs_with_its_elines(folder, method):
    found = run(study(folder, "AWAY", DAMPING["modal"], method), converge=False, record=False)
    assert found.stopped is None
    assert found.found.elines is not None
    assert found.found.elines.why == ""
    assert found.found.elines.linear is not None
