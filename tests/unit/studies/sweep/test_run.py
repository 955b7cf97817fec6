"""Cases of a sweep: what is left on disk, what is shared, what ends up in the table; without a cluster."""

from __future__ import annotations

import csv
import json
import shutil
import socket
import subprocess
import sys
import threading
from dataclasses import replace
from pathlib import Path

import h5py
import pytest

import creak
from creak.errors import InputError
from creak.formats.deck.command_files import one_command
from creak.formats.destination import partial_name, remove_dead
from creak.studies.models.saved import Store, shared_path
from creak.studies.models.superelements import save_superelement
from creak.studies.prepare.setup import set_up
from creak.studies.run.job import run_study
from creak.studies.sweep.case import Outcome, Task, finished_record, publish, run_case
from creak.studies.sweep.cases import resolve
from creak.studies.sweep.figures import OF_A_PLACE, OF_FRICTION, friction_of
from creak.studies.sweep.file import SweepFile, read_sweep
from creak.studies.sweep.job import Row, columns, finished, tasks_of, waiting, write_table
from creak.studies.tasks.queue import Queue
from helpers_decks import STUDY, write_strips
from helpers_docs import ROOT
from helpers_stored import write_changed_json

SWEEP = """base = "study.toml"
[grid]
"contact.tip.stiffness" = [50.0, 60.0]
"reduction.f_max" = [3000, 12000]
[[case]]
name = "good"
[[case]]
name = "bad"
changes = { "excitation.root.node_set" = "NOWHERE" }
"""
COSTS = ("wall_s", "setup_s", "cpu_s", "offline_cpu_s", "offline_wall_s", "peak_rss_gb")


def sweep_in(folder: Path, text: str = SWEEP) -> SweepFile:
    write_strips(folder, study=STUDY.replace("periods = 2", "end = 0.1"))
    (folder / "sweep.toml").write_text(text, encoding="utf-8")
    return read_sweep(folder / "sweep.toml")


@pytest.fixture(scope="module")
def ran(tmp_path_factory):
    """Every case run once, in order."""
    folder = tmp_path_factory.mktemp("sweep")
    sweep, out = sweep_in(folder), folder / "out"
    cases = resolve(sweep, out)
    out.mkdir()
    tasks = tasks_of(cases, out)
    return sweep, cases, out, tasks, [Row(c, run_case(tasks[c.name])) for c in cases]


def test_a_failed_case_does_not_lose_the_others(ran):
    _, cases, out, _, rows = ran
    assert [r.outcome.status for r in rows] == ["done"] * 4 + ["failed"] * 4
    assert "unknown node set 'NOWHERE'" in rows[4].outcome.error
    for case, row in zip(cases, rows, strict=True):
        folder = out / case.folder_name
        assert folder.exists() == (row.outcome.status == "done")
        if folder.exists():
            assert sorted(p.name for p in folder.iterdir()) == ["case.json", "results.h5", "summary.json"]
    assert not [p.name for p in out.iterdir() if p.name.startswith(".")]


def test_superelements_and_references_are_shared(ran):
    records = [r.outcome.record for r in ran[4][:4]]
    # Grid order: stiffness, then f_max. Superelements depend on f_max alone, the reference on the stiffness alone.
    assert [(r["superelements_made"], r["superelements_reused"]) for r in records] == [(2, 0), (2, 0), (0, 2), (0, 2)]
    assert [r["reference_reused"] for r in records] == [False, True, False, True]
    assert len(list((ran[2] / "superelements").glob("*.h5"))) == 4
    assert len(list((ran[2] / "references").iterdir())) == 2


def without_costs(value):
    if isinstance(value, dict):
        return {k: without_costs(v) for k, v in value.items() if k not in (*COSTS, "notes")}
    return value


def test_what_is_shared_changes_nothing(ran):
    """A case that took superelements and another that took the reference, against the same studies run alone."""
    _, cases, out, tasks, _ = ran
    for k in (1, 2):
        alone = creak.run(tasks[cases[k].name].study, record=False).summary
        saved = json.loads((out / cases[k].folder_name / "summary.json").read_text())
        assert saved.pop("sha256")
        ids = [summary["run"].pop("id") for summary in (saved, alone)]
        assert ids[0] != ids[1]
        assert without_costs(saved) == without_costs(alone)


@pytest.mark.slow
@pytest.mark.parametrize("converge", [None, False])
def test_a_case_is_what_run_finds(tmp_path, converge):
    """Sound, causes, repeats, ranks and events of the unreduced model too: the same digits, as a study has them by default."""
    write_strips(tmp_path, study=STUDY.replace("step = 5e-4\nperiods = 2", "end = 0.06"))
    (tmp_path / "sweep.toml").write_text('base = "study.toml"\n[grid]\n"contact.tip.stiffness" = [50.0]\n')
    out = tmp_path / "out"
    out.mkdir()
    (case,) = resolve(read_sweep(tmp_path / "sweep.toml"), out, converge)
    task = tasks_of([case], out)[case.name]
    record = run_case(task).record
    alone = creak.run(task.study, converge=converge, record=False).summary
    saved = json.loads((out / case.folder_name / "summary.json").read_text())
    assert saved.pop("sha256")
    assert saved["run"].pop("id") != alone["run"].pop("id")
    assert without_costs(saved) == without_costs(alone)
    (place, *_) = saved["runs"]["reduced"]["places"]
    assert place["events"] > 0
    assert place["n5"] is not None
    asked = converge is None
    assert (place["cause"] is not None, "convergence" in saved) == (asked, asked)
    assert bool(saved["verification"].get("spots")) == asked
    assert (out / case.folder_name / "convergence.csv").exists() == (converge is None)
    assert record["reduced.first_place"] == place["name"]
    assert record["reduced.force"] == max(p["force"] for p in saved["runs"]["reduced"]["places"])
    assert record["reduced.n5"] == max(p["n5"] for p in saved["runs"]["reduced"]["places"])
    # One that nothing has checked is not taken for one that is repeated.
    other = resolve(read_sweep(tmp_path / "sweep.toml"), out, True)[0]
    assert other.id != case.id


def test_a_finished_case_is_not_run_again(ran):
    _, cases, out, tasks, rows = ran
    record = out / cases[0].folder_name / "case.json"
    before = record.stat().st_mtime_ns
    again = run_case(tasks[cases[0].name])
    assert again.record == rows[0].outcome.record
    assert record.stat().st_mtime_ns == before
    assert list(finished(cases, out)) == [c.name for c in cases[:4]]


def test_another_version_is_refused(ran):
    task = replace(ran[3][ran[1][4].name], creak="0.0")
    assert "started with 0.0" in run_case(task).error


def test_a_case_whose_workers_died_has_failed_unless_its_result_is_there(ran):
    made, never = (ran[3][ran[1][k].name] for k in (0, 4))
    assert made.lost("died", 0.0).record == ran[4][0].outcome.record
    assert (never.lost("died", 0.0).status, never.lost("died", 0.0).error) == ("failed", "died")


def test_results_follow_a_case_that_is_renamed(ran, tmp_path):
    _, cases, out, _, _ = ran
    old = tmp_path / "old name"
    old.mkdir()
    (old / "case.json").write_bytes((out / cases[0].folder_name / "case.json").read_bytes())
    assert list(finished(cases[:1], tmp_path, rename=False)) == [cases[0].name]
    assert old.exists()
    assert list(finished(cases[:1], tmp_path)) == [cases[0].name]
    assert [p.name for p in tmp_path.iterdir()] == [cases[0].folder_name]


def test_what_is_no_result_is_not_overwritten(ran, tmp_path):
    (tmp_path / ran[1][0].folder_name).mkdir()
    with pytest.raises(InputError, match="in the way"):
        finished(ran[1], tmp_path)


def test_the_table(ran, tmp_path):
    sweep, cases, _, _, rows = ran
    write_table(sweep, [*rows[:-1], waiting(cases[-1])], tmp_path)
    with (tmp_path / "sweep.csv").open(newline="") as file:
        table = list(csv.DictReader(file))
    assert [r["case"] for r in table] == [c.name for c in cases]
    assert [float(r["reduction.f_max"]) for r in table] == [3000.0, 12000.0] * 4
    assert [r["status"] for r in table] == ["done"] * 4 + ["failed"] * 3 + ["not run"]
    assert "NOWHERE" in table[4]["error"]
    assert table[4]["reduced.dof"] == ""
    assert {r["seed"] for r in table} == {"3"}
    for name in ("creak", "study_hash", "deck_hash", "date", "host", "python", "numpy", "scipy", "threads"):
        assert all(r[name] for r in table[:7]), name
    figures = rows[0].outcome.record
    assert int(table[0]["reduced.places"]) == figures["reduced.places"] > 0
    assert table[0]["reduced.first_place"] == figures["reduced.first_place"]
    assert table[0]["reduced.verdict"] == figures["reduced.verdict"]
    told = {key for key, value in figures.items() if value is not None}
    assert told - {*table[0]} == {"id", "name", "unreliable"}
    with h5py.File(tmp_path / "sweep.h5") as file:
        assert file.attrs["columns"].tolist() == list(table[0])
        assert file["reduced.max_force"][0] == float(table[0]["reduced.max_force"]) == figures["reduced.max_force"]
        assert file["reduced.max_force"].attrs["unit"] == "N"
        assert file["nrmse_all"].shape == (8,)
        for name in ("reduced.force", "reduced.n5"):
            assert file[name][0] == float(table[0][name]) == figures[name], name
        assert [file[f"reduced.{key}"].attrs["unit"] for key in ("force", "n5")] == ["N", "sone"]
        assert file["case"].asstr()[:].tolist() == [c.name for c in cases]


@pytest.mark.parametrize("text", ["", '[grid]\n"contact.tip.friction" = [0.0, 0.2]\n'])
def test_a_table_gives_way_to_that_of_the_next_start(tmp_path, text):
    """Whether keys are changed or seeds alone; what is no table of a sweep stays."""
    sweep, out = sweep_in(tmp_path, f'base = "study.toml"\nseeds = [1, 2]\n{text}'), tmp_path / "out"
    out.mkdir()
    rows = [waiting(case) for case in resolve(sweep, out)]
    for _ in range(2):
        with one_command():
            paths = write_table(sweep, rows, out)
    paths[0].write_text("case,length,status\n")
    with one_command(), pytest.raises(InputError, match="no file that creak wrote"):
        write_table(sweep, rows, out)


def test_figures_are_those_of_the_summary(ran):
    _, cases, out, _, rows = ran
    summary = json.loads((out / cases[0].folder_name / "summary.json").read_text())
    record = rows[0].outcome.record
    for name, run in summary["runs"].items():
        for key in ("dof", "retained", "modes", "channels", "wall_s", "max_force", "impulse_total", "energy_error"):
            assert record[f"{name}.{key}"] == run[key]
        assert record[f"{name}.events"] == len(run["events"]) > 0
    check = summary["verification"]
    assert record["worst_mac"] == min(check["mac"])
    assert record["nrmse_z"] == check["nrmse"]["z"]
    assert record["events_missed"] == check["events"]["missed"]
    assert record["impulse_ratio"] == check["events"]["impulse_ratio_mean"]


def test_columns_leave_out_what_no_case_has(ran):
    table = columns([waiting(ran[1][0])])
    assert list(table) == ["case", *ran[1][0].changes, "seed", "status", "error", "study_hash", "deck_hash"]


def place(friction, energy, **more):
    known = {"slips": 3, "slip_rate": 90.0, "slip_path": 2.0} if friction else dict.fromkeys(OF_A_PLACE)
    return {"contact": "base", **known, "friction": friction, "friction_energy": energy, **more}


def test_friction_is_that_of_the_place_that_rubs_most():
    run = {"places": [place(None, None, name="tip 1"), place("stick-slip", 5.0, name="base 2")]}
    run |= {"resting": [place("stick", 0.1)], "slip_events": [{}, {}], "energies": {"friction": 5.2}}
    told = {"rubbing_place": "base 2", "friction": "stick-slip", "slips": 3, "slip_rate": 90.0, "slip_path": 2.0}
    told |= {"friction_energy": 5.0, "stick_slip_events": 2, "friction_energy_total": 5.2}
    assert friction_of(run) == told
    rests = friction_of(run | {"places": []})
    assert (rests["rubbing_place"], rests["friction"]) == ("base", "stick")
    smooth = friction_of({"places": run["places"][:1], "resting": [], "energies": {"friction": 0.0}})
    assert set(smooth) == set(told)
    assert set(smooth.values()) == {None}


def test_the_table_tells_friction(tmp_path):
    """Strips that rub at their tip, in one case; the page of sweeps has each column."""
    sweep = sweep_in(tmp_path, 'base = "study.toml"\n[grid]\n"contact.tip.friction" = [0.3]\n')
    (case,) = resolve(sweep, tmp_path / "out")
    (tmp_path / "out").mkdir()
    outcome = run_case(tasks_of([case], tmp_path / "out")[case.name])
    run = json.loads((tmp_path / "out" / case.folder_name / "summary.json").read_text())["runs"]["reduced"]
    write_table(sweep, [Row(case, outcome)], tmp_path)
    (row,) = csv.DictReader((tmp_path / "sweep.csv").read_text().splitlines())
    most = max(run["places"], key=lambda p: p["friction_energy"])
    assert row["reduced.friction"] == most["friction"]
    assert float(row["reduced.slip_path"]) == most["slip_path"] > 0.0
    assert float(row["reduced.friction_energy_total"]) == run["energies"]["friction"] > 0.0
    with h5py.File(tmp_path / "sweep.h5") as file:
        names = ("slip_path", "friction_energy", "friction_energy_total")
        assert [file[f"reduced.{name}"].attrs["unit"] for name in names] == ["mm", "mJ", "mJ"]
    page = (ROOT / "docs" / "sweeps.md").read_text(encoding="utf-8")
    for name in OF_FRICTION:
        assert f"`{name}`" in page, name


def test_a_verdict_that_no_case_has_is_no_column_and_the_page_says_so(ran):
    record = dict(ran[4][0].outcome.record) | {"reduced.verdict": None, "reference.verdict": None}
    table = columns([Row(ran[1][0], Outcome("done", "", record))])
    assert "reduced.events" in table
    assert not [name for name in table if name.endswith("verdict")]
    page = " ".join((ROOT / "docs" / "sweeps.md").read_text(encoding="utf-8").split())
    assert "empty for every case is left out. So there is no `verdict` with `--no-converge`" in page


def test_a_folder_is_complete_or_absent(tmp_path):
    def fails(folder: Path) -> None:
        (folder / "half").write_text("")
        raise ValueError("disk full")

    with pytest.raises(ValueError, match="disk full"):
        publish(tmp_path / "case", "1", fails)
    assert list(tmp_path.iterdir()) == []


def record(number: str):
    return lambda folder: write_changed_json(folder / "case.json", {"id": number})


def test_newer_results_replace_those_of_another_study_only(tmp_path):
    folder = tmp_path / "case"
    publish(folder, "1", record("1"))
    (folder / "mark").write_text("first")
    publish(folder, "1", record("1"))  # a second worker with the same case: the first result stays
    assert (folder / "mark").exists()
    publish(folder, "2", record("2"))
    assert finished_record(folder) == {"id": "2"}
    assert not (folder / "mark").exists()
    assert [p.name for p in tmp_path.iterdir()] == ["case"]


def test_a_case_of_several_runs_is_not_finished(ran, tmp_path):
    _, cases, out, _, _ = ran
    one, two = (out / case.folder_name for case in cases[:2])
    folder = shutil.copytree(one, tmp_path / one.name)
    record = finished_record(folder)
    with h5py.File(folder / "results.h5") as file:
        assert record["run_id"] == file.attrs["run_id"]
    for name in ("summary.json", "results.h5"):
        shutil.copy(two / name, folder / name)
        assert finished_record(folder) is None
        shutil.copy(one / name, folder / name)
        assert finished_record(folder) == record
    (folder / "results.h5").write_bytes(b"half")
    assert finished_record(folder) is None


def test_leftovers_of_dead_processes_are_removed(tmp_path):
    dead = subprocess.Popen([sys.executable, "-c", ""])
    dead.wait()
    mine, other = tmp_path / partial_name("a.b"), tmp_path / ".a.elsewhere.1.abcd.partial"
    left = tmp_path / f".a.{socket.gethostname()}.{dead.pid}.abcd.partial"
    for folder in (mine, other, left):
        folder.mkdir()
    remove_dead(tmp_path)
    assert set(tmp_path.iterdir()) == {mine, other}


def test_two_that_write_a_superelement_at_once_leave_a_whole_one(tmp_path):
    sweep_in(tmp_path)
    setup = set_up(creak.change_study(tmp_path / "study.toml", {"time.end": 0.01}))
    result = run_study(setup, lambda *_: None)
    reduced, store = result.reduced.superelements[0], tmp_path / "store"
    together = threading.Barrier(4)

    def write() -> None:
        together.wait()
        save_superelement(store, reduced, setup.model, {}, shared=True)

    threads = [threading.Thread(target=write) for _ in range(4)]
    for t in threads:
        t.start()
    for t in threads:
        t.join()
    path = shared_path(store, reduced.system.name, reduced.made_from)
    assert list(store.iterdir()) == [path]
    again = run_study(setup, lambda *_: None, Store(store))
    assert [r.reused for r in again.reduced.superelements] == [True, False]


def task(name: str, reference: Path | None) -> Task:
    here = Path("x")
    return Task(name, name, here, here, here, reference, {}, "")


def test_one_case_makes_the_reference_the_others_wait(tmp_path):
    a, b = tmp_path / "a.npz", tmp_path / "b.npz"
    queue = Queue([task("a1", a), task("a2", a), task("b1", b), task("none", None), task("a3", a)])
    first = queue.ready(9)
    assert [t.name for t in first] == ["a1", "b1", "none"]
    assert queue.ready(9) == []
    queue.ended(first[0])  # failed without a reference: the next one makes it
    second = queue.ready(9)
    assert [t.name for t in second] == ["a2"]
    a.touch()
    queue.ended(second[0])
    assert [t.name for t in queue.ready(9)] == ["a3"]


def test_no_more_are_handed_out_than_there_is_room_for():
    queue = Queue([task(str(k), None) for k in range(3)])
    assert [t.name for t in queue.ready(2)] == ["0", "1"]
    assert queue.ready(0) == []
    assert [t.name for t in queue.ready(2)] == ["2"]


def test_a_kept_reference_of_another_end_is_made_again(tmp_path):
    """Two cases that are given the same file: each has the events of its own run, made without a file."""
    study = write_strips(tmp_path, study=STUDY.replace("periods = 2", "end = 0.2"))
    file, found = tmp_path / "kept.npz", []
    for end in (0.07, 0.1, 0.1):
        bench = creak.make_bench(creak.change_study(study, {"time.end": end, "precheck.enabled": False}))
        run, alone = bench.run(keep=file), bench.run()
        assert run.history.time[-1] == alone.history.time[-1]
        assert [e.t_start for e in run.events] == [e.t_start for e in alone.events] != []
        found.append(bool(run.notes))
    assert found == [False, False, True]
