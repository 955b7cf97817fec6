"""A run that created energy is written, told, and ends with status 1; nowhere does it look like a good one."""

from __future__ import annotations

import csv
import json

import pytest

import creak as public
from creak.studies.sweep.case import run_case
from creak.studies.sweep.cases import resolve
from creak.studies.sweep.file import read_sweep
from creak.studies.sweep.job import finished, tasks_of
from helpers_decks import STUDY, two_strips, write_strips

SOUND = STUDY.replace("periods = 2", "periods = 1").replace(
    "[verification]", "[reference]\nrun = false\n[verification]"
)
WILD = (
    SOUND.replace('main = "OVER"', 'main = "OVER"\nstiffness = "hard"').replace("5e-4", "1e-3").replace("0.05", "1.0")
)
"""Hard contact, HHT-alpha, steps of 1 ms and an amplitude of 1 mm."""


def heavy_root() -> str:
    """The two strips; the moving root of the upper one carries a point mass of a million kilograms."""
    mass = "*ELEMENT, TYPE=MASS, ELSET=M\n9001, 14\n*MASS, ELSET=M\n1000.,\n*BOUNDARY\n"
    return two_strips().replace("*BOUNDARY\n", mass)


def test_a_run_that_created_energy_ends_with_status_1_and_all_its_files(creak, tmp_path):
    said = creak("run", write_strips(tmp_path, study=WILD), "--quiet", "--out", tmp_path / "out")
    assert said.status == 1
    last = said.err.strip().splitlines()[-1]
    assert last.startswith("creak: error: unreliable: reduced run: the time integration created energy, ")
    assert str(tmp_path / "out") in last
    assert "warning: reduced run: unreliable: the time integration created energy" in said.err
    assert {p.name for p in (tmp_path / "out").iterdir()} >= {"summary.json", "results.h5", "report.html"}
    summary = json.loads((tmp_path / "out" / "summary.json").read_text())
    run = summary["runs"]["reduced"]
    assert run["energy_created"] > 1.0
    assert run["verdict"] == "unreliable"
    assert "of the work of the loads (at most 0.5 % is sound)" in run["reasons"][0]
    assert any("unreliable" in text and run["reasons"][0] in text for text in summary["warnings"])
    assert "Do not rely on it" in (tmp_path / "out" / "report.html").read_text(encoding="utf-8")
    again = creak("report", tmp_path / "out", "--quiet")
    assert (again.status, "warning: unreliable: reduced run: the time" in again.err) == (0, True)


@pytest.mark.usefixtures("no_page")
def test_a_sound_run_has_no_reason_against_it(creak, tmp_path):
    said = creak("run", write_strips(tmp_path, study=SOUND), "--quiet", "--out", tmp_path / "out")
    assert (said.status, "unreliable" in said.words) == (0, False)
    run = json.loads((tmp_path / "out" / "summary.json").read_text())["runs"]["reduced"]
    assert run["energy_created_of_contact"] == 0.0
    # Its step is forced, so that nothing is known of what it changes; that is no alarm.
    assert run["verdict"] == "unsettled"
    assert "forced" in run["reasons"][0]


@pytest.mark.parametrize(("substeps", "sound"), [(1, False), (20, True)])
@pytest.mark.usefixtures("no_page")
def test_a_light_strip_on_a_heavy_frame(creak, tmp_path, substeps, sound):
    """All that the strip holds is a millionth of the work that moves its frame; unresolved, contact throws it about."""
    law = "" if sound else '\nstiffness = "hard"'
    study = SOUND.replace("0.05", "0.1" if sound else "0.2").replace("5e-4", f"5e-4\nsubsteps = {substeps}")
    path = write_strips(tmp_path, heavy_root(), study.replace('main = "OVER"', f'main = "OVER"{law}'))
    said = creak("run", path, "--quiet", "--out", tmp_path / "out")
    run = json.loads((tmp_path / "out" / "summary.json").read_text())["runs"]["reduced"]
    assert run["energy_created"] < 0.001
    assert said.status == (0 if sound else 1)
    if sound:
        assert run["impulse_total"] < 0.05
        assert run["energy_created_of_contact"] < 0.01
    else:
        assert run["impulse_total"] > 0.4
        assert run["energy_created_of_contact"] > 1.0
        assert "of the energy that contact took up (at most 10 % is sound)" in said.err


def test_python_warns_of_it(tmp_path):
    with pytest.warns(RuntimeWarning, match="unreliable: reduced run: the time integration created energy"):
        result = public.run(write_strips(tmp_path, study=WILD))
    assert len(result.unreliable) == 1


SWEEP = """base = "study.toml"
[[case]]
name = "sound"
[[case]]
name = "wild"
changes = { "contact.tip.stiffness" = "hard", "excitation.root.signal.amplitude" = 1.0, "time.step" = 1e-3 }
"""


def test_a_sweep_marks_the_row_keeps_it_and_ends_with_status_1(creak, tmp_path, monkeypatch):
    write_strips(tmp_path, study=SOUND)
    path, out = tmp_path / "sweep.toml", tmp_path / "out"
    path.write_text(SWEEP, encoding="utf-8")
    out.mkdir()
    cases = resolve(read_sweep(path), out)
    tasks = tasks_of(cases, out)
    first = {c.name: run_case(tasks[c.name]) for c in cases}
    assert {name: o.status for name, o in first.items()} == {"sound": "done", "wild": "unreliable"}
    assert finished(cases, out) == first
    assert run_case(tasks["wild"]) == first["wild"]
    monkeypatch.setattr("creak.studies.tasks.queue.local_workers", None)  # a finished row is not run again
    said = creak("sweep", path, "--out", out)
    assert said.status == 1
    assert "2 of 2 cases have results, 2 from before" in said.out
    assert "warning: wild is unreliable: reduced run: the time integration created energy" in said.err
    assert said.err.strip().splitlines()[-1] == "creak: error: unreliable: 1 of 2 cases: wild"
    with (out / "sweep.csv").open(newline="") as file:
        rows = {row["case"]: row for row in csv.DictReader(file)}
    assert (rows["sound"]["status"], rows["sound"]["error"]) == ("done", "")
    assert rows["wild"]["status"] == "unreliable"
    assert rows["wild"]["error"].startswith("reduced run: the time integration created energy")
    assert float(rows["wild"]["reduced.max_force"]) > float(rows["sound"]["reduced.max_force"]) > 0.0


@pytest.mark.usefixtures("no_page")
def test_axes_without_motion_have_no_fit(creak, tmp_path):
    study = SOUND.replace("[reference]\nrun = false\n", "")
    said = creak("run", write_strips(tmp_path, study=study), "--verbose", "--out", tmp_path / "out").done()
    assert "-, -, 0.99" in said.out
    fit = json.loads((tmp_path / "out" / "summary.json").read_text())["verification"]["nrmse"]
    assert (fit["x"], fit["y"]) == (None, None)
    assert min(fit["z"], fit["all"]) > 0.99
