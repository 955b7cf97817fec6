"""What a study asks of the time integration is done, or refused; nothing else is run in silence."""

from __future__ import annotations

import tomllib

import numpy as np
import pytest

import creak
from creak.api.study import make_study, run, set_up
from creak.errors import InputError
from creak.progress import silent
from creak.studies.run.precheck import ready
from helpers_decks import STEEL, STUDY, two_strips

OTHER = STEEL.replace("NAME=STEEL", "NAME=OTHER").replace("ALPHA=5.", "ALPHA=50.")
MASSLESS = {"integrator": "massless-boundary", "step": 5e-4, "end": 0.02}


def study(folder, time, damping=None):
    deck = two_strips().replace(
        "*SHELL SECTION, ELSET=LOWER, MATERIAL=STEEL", OTHER + "*SHELL SECTION, ELSET=LOWER, MATERIAL=OTHER"
    )
    (folder / "strips.inp").write_text(deck, encoding="utf-8")
    tables = tomllib.loads(STUDY)
    method = "massless-boundary" if time.get("integrator") == "massless-boundary" else "craig-bampton"
    tables["reduction"] = {"method": method, "f_max": 1000.0}
    tables |= {"time": time, "reference": {"run": False}}
    return make_study(tables if damping is None else tables | {"damping": damping}, folder)


def test_damping_that_couples_the_modes_is_refused_beside_a_massless_boundary(tmp_path):
    """Before anything is solved for."""
    with pytest.raises(InputError, match="damping that couples the modes") as error:
        ready(set_up(study(tmp_path, MASSLESS)), silent)
    assert "[damping] modal or rayleigh" in str(error.value)


def test_one_damping_of_all_parts_is_marched_by_the_massless_boundary(tmp_path):
    found = run(study(tmp_path, MASSLESS, {"rayleigh": {"alpha": 5.0, "beta": 1e-6}}), converge=False, record=False)
    assert found.runs["reduced"].integrator.startswith("massless boundary")


@pytest.mark.parametrize(
    ("time", "key"),
    [
        ({"integrator": "hht", "rho_inf": 0.8}, "rho_inf"),
        ({"integrator": "generalised-alpha", "alpha": -0.1}, "alpha"),
        ({"alpha": -0.1, "rho_inf": 0.8}, "alpha"),
        ({**MASSLESS, "rho_inf": 0.8}, "rho_inf"),
    ],
)
def test_a_key_of_another_integrator_is_refused(tmp_path, time, key):
    with pytest.raises(InputError, match=f"{key} is nothing that integrator"):
        study(tmp_path, time)


def test_substeps_without_a_scheme_are_refused():
    mass = creak.system_from_matrices(np.zeros((1, 1)), np.eye(1))
    stop = creak.gap_channels(np.eye(1), 1.0, 1.0)
    with pytest.raises(InputError, match="substeps = 4 without a scheme"):
        creak.simulate(mass, stop, creak.make_loads(mass, np.arange(9.0)), substeps=4)
