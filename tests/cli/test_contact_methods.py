"""Contact laws and integrators through the command, and runs that end early."""

from __future__ import annotations

import json

import h5py
import numpy as np
import pytest

from creak.studies.file import table
from helpers_decks import STUDY, write_strips


def run(creak, folder, study):
    """What the command says, and the summary."""
    path = write_strips(folder)
    path.write_text(study)
    said = creak("run", path, "--quiet", "--out", folder / "out")
    return said, json.loads((folder / "out" / "summary.json").read_text())


def changed(*pairs):
    study = STUDY + "\n[precheck]\nmargin = 0.5\n"
    for old, new in pairs:
        assert old in study
        study = study.replace(old, new)
    return study


@pytest.mark.usefixtures("no_page")
def test_generalised_alpha_with_divided_steps(creak, tmp_path):
    study = changed(("[time]\n", '[time]\nintegrator = "generalised-alpha"\nrho_inf = 0.8\nsubsteps = 4\n'))
    said, summary = run(creak, tmp_path, study)
    said.done()
    for name in ("reduced", "reference"):
        figures = summary["runs"][name]
        assert figures["integrator"] == "generalised-alpha, 4 substeps near contact"
        assert figures["events"]
        assert figures["energy_created"] <= 0.005
        assert figures["steps"] > 800  # divided near contact only
        assert figures["steps"] < 4 * 800
    assert summary["verification"]["events"]["missed"] == 0


@pytest.mark.usefixtures("no_page")
def test_hard_contact_with_friction(creak, tmp_path):
    study = changed(
        ('main = "OVER"\n', 'main = "OVER"\nstiffness = "hard"\nfriction = 0.3\n'),
        ("step = 5e-4\nperiods = 2", "end = 0.1"),
        ("[time]", "[reference]\nrun = false\n[time]"),
    )
    said, summary = run(creak, tmp_path, study)
    said.done()
    figures = summary["runs"]["reduced"]
    assert figures["integrator"].startswith("exact flow")
    assert figures["events"]
    assert figures["energy_created"] <= 0.005
    assert figures["energies"]["friction"] >= 0.0
    with h5py.File(tmp_path / "out" / "results.h5") as file:
        group = file["runs/reduced"]
        pressed, rubbed = group["normal_force"][:], np.linalg.norm(group["friction_force"][:], axis=-1)
        # The spring is a hundred times as stiff as the structure behind its channel (`flow.hard`).
        assert 0.0 < figures["penetration_max"] < 0.01 * group["gap"][:].max()
        assert rubbed.max() > 0.0
        assert (rubbed <= 0.3 * (1.0 + 1e-5) * pressed).all()  # between kept instants, `rows.CLOSE`


def test_a_run_that_diverges_keeps_what_it_has(creak, tmp_path, monkeypatch):
    """A motion beyond the range of numbers: one message, status 1, results up to there."""
    monkeypatch.setattr(table, "LARGEST", 1e300)
    start = STUDY.index("amplitude = ")
    end = STUDY.index("}", start)
    study = STUDY[:start] + "amplitude = 1e160 " + STUDY[end:] + "\n[precheck]\nenabled = false\n"
    said, summary = run(creak, tmp_path, study)
    assert said.status == 1
    told = said.err
    assert "no longer finite at t = " in told
    assert "Traceback" not in told
    assert "What was computed until then is in" in told
    assert "no longer finite" in summary["stopped"]
    assert (tmp_path / "out" / "results.h5").exists()
    assert "ended early" in (tmp_path / "out" / "report.html").read_text()
