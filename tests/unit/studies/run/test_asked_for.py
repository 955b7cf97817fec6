"""What a study asks of the time integration is done, or refused; nothing else is run in silence.

A screening looks at the whole run, from rest.
"""

from __future__ import annotations

import tomllib

import numpy as np
import pytest

import creak
from creak.api.study import make_study
from creak.cli.run import first_look
from creak.errors import InputError
from creak.progress import silent
from creak.studies.file.reader import read_study
from creak.studies.prepare.setup import set_up
from creak.studies.run.screen import screen
from helpers_decks import STEEL, STUDY, two_strips, write_strips
from helpers_refusal import refusal

OTHER = STEEL.replace("NAME=STEEL", "NAME=OTHER").replace("ALPHA=5.", "ALPHA=50.")


def study(folder, time, damping=None):
    deck = two_strips().replace(
        "*SHELL SECTION, ELSET=LOWER, MATERIAL=STEEL", OTHER + "*SHELL SECTION, ELSET=LOWER, MATERIAL=OTHER"
    )
    (folder / "strips.inp").write_text(deck, encoding="utf-8")
    tables = tomllib.loads(STUDY)
    tables["reduction"] = {"f_max": 1000.0}
    tables |= {"time": time, "reference": {"run": False}}
    return make_study(tables if damping is None else tables | {"damping": damping}, folder)


@pytest.mark.parametrize("table", ["time", "reduction", "both"])
def test_a_massless_boundary_is_told_what_to_take_instead(tmp_path, table):
    """One message, at the line of the key, whichever asks for it."""
    lines = STUDY.splitlines()
    keys = {"time": "integrator", "reduction": "method"}
    for name, key in keys.items():
        if table in (name, "both"):
            lines.insert(lines.index(f"[{name}]") + 1, f'{key} = "massless-boundary"')
    path = write_strips(tmp_path, study="\n".join(lines))
    with pytest.raises(InputError, match=r"creak has no massless boundary.*craig-bampton.*without integrator") as error:
        read_study(path)
    first = "time" if table == "time" else "reduction"
    at = lines.index(f'{keys[first]} = "massless-boundary"') + 1
    assert error.value.where == f"{path}:{at}"


@pytest.mark.parametrize(
    ("time", "key"),
    [
        ({"integrator": "hht", "rho_inf": 0.8}, "rho_inf"),
        ({"integrator": "generalised-alpha", "alpha": -0.1}, "alpha"),
        ({"alpha": -0.1, "rho_inf": 0.8}, "alpha"),
    ],
)
def test_a_key_of_another_integrator_is_refused(tmp_path, time, key):
    with pytest.raises(InputError, match=f"{key} is nothing that integrator"):
        study(tmp_path, time)


@pytest.mark.parametrize("asked", ["none", "spots", False])
def test_an_end_of_no_unreduced_run_is_refused(tmp_path, asked):
    """`until` ends the run from rest: where none is made, it would do nothing."""
    lines = [*STUDY.splitlines(), "[reference]", "until = 0.1"]
    path = write_strips(tmp_path, study="\n".join(lines))
    given = read_study(path)
    assert given.config.proof == "whole"
    for whole in ("whole", True):
        assert creak.change_study(given, {"reference.run": whole}).config.reference.until == 0.1
    value = "false" if asked is False else f'"{asked}"'
    said = refusal(creak.change_study, given, {"reference.run": asked})
    assert said.what == f"until = 0.1 ends a run of the unreduced model from rest, and run = {value} makes none"
    path.write_text("\n".join([*lines, f"run = {value}"]))
    assert refusal(read_study, path).where == f"{path}:{len(lines)} [reference.until]"


def test_an_end_of_a_run_that_is_compared_with_none_is_refused(tmp_path):
    """Without a reduction there is one run, which [time] ends."""
    given = read_study(write_strips(tmp_path, study=f"{STUDY}\n[reference]\nuntil = 0.1\n"))
    said = refusal(creak.change_study, given, {"reduction.method": "none"})
    assert said.what.endswith('method = "none" reduces nothing')
    assert said.where.startswith("the change reduction.method = 'none' of ")


def test_a_first_look_needs_no_end_of_the_unreduced_run(tmp_path):
    """`--quick` makes no unreduced run, so it leaves `until` out."""
    study = first_look(write_strips(tmp_path, study=f"{STUDY}\n[reference]\nuntil = 0.1\n"))
    assert (study.config.proof, study.config.reference.until) == ("none", None)


def test_substeps_without_a_scheme_are_refused():
    mass = creak.system_from_matrices(np.zeros((1, 1)), np.eye(1))
    stop = creak.gap_channels(np.eye(1), 1.0, 1.0)
    with pytest.raises(InputError, match="substeps = 4 without a scheme"):
        creak.simulate(mass, stop, creak.make_loads(mass, np.arange(9.0)), substeps=4)


def test_screening_sees_what_closes_before_the_window(tmp_path):
    """The window of four periods is the last one; of the same run the first two have a peak of their own."""
    found = {}
    for periods in (2, 3, 4):
        folder = tmp_path / str(periods)
        folder.mkdir()
        study = write_strips(folder, two_strips(0.3), STUDY.replace("periods = 2", f"periods = {periods}"))
        found[periods] = screen(set_up(read_study(study)), silent).linear.closing
    tolerance = 1e-9 * found[4].max()
    assert (found[3] >= found[2] - tolerance).all()
    assert (found[4] >= found[3] - tolerance).all()
