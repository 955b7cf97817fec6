"""The main job on a small model, through the command."""

import json
import math

import h5py
import numpy as np
import pytest

from helpers_cli import say
from helpers_decks import STOP, STUDY, stop_study, write_strips


@pytest.fixture(scope="module")
def strips(tmp_path_factory):
    folder = tmp_path_factory.mktemp("strips")
    say("run", write_strips(folder), "--quiet", "--out", folder / "out").done()
    return folder / "out", json.loads((folder / "out" / "summary.json").read_text())


def without_costs(summary):
    costs = ("wall_s", "setup_s", "cpu_s", "offline_cpu_s", "offline_wall_s", "peak_rss_gb")
    return (
        json.dumps(summary, default=str)
        if not isinstance(summary, dict)
        else {k: without_costs(v) for k, v in summary.items() if k not in costs}
    )


def test_three_files_come_out(strips):
    out, _ = strips
    assert sorted(p.name for p in out.iterdir()) == ["report.html", "results.h5", "summary.json"]


def test_model_figures(strips):
    model = strips[1]["model"]
    assert model["nodes"] == 78
    assert model["elements"] == 48
    assert model["dof"] == 6 * 78
    assert list(model["parts"]) == ["UPPER", "LOWER"]
    assert model["mass"] == pytest.approx(7.85e-9 * 120 * 20 * (1.0 + 1.5), rel=1e-9)  # volume x density


def test_both_runs_rattle_and_agree(strips):
    summary = strips[1]
    assert summary["runs"]["reference"]["events"]
    check = summary["verification"]
    assert min(check["mac"]) > 0.999
    assert check["nrmse"]["all"] > 0.98  # f_max is 50 x the excitation; the motion is not chaotic
    assert check["events"]["missed"] == 0
    assert check["events"]["impulse_ratio_mean"] == pytest.approx(1.0, abs=0.05)


@pytest.mark.parametrize("run", ["reduced", "reference"])
def test_no_energy_is_created(strips, run):
    assert strips[1]["runs"][run]["energy_created"] <= 0.005


@pytest.mark.parametrize("run", ["reduced", "reference"])
def test_histories_agree_with_the_summary(strips, run):
    out, summary = strips
    with h5py.File(out / "results.h5") as file:
        group = file[f"runs/{run}"]
        time, force = group["time"][:], group["normal_force"][:]
        assert time.size == 801
        assert group["displacement"].shape == (801, 4, 6)
        assert group["node_ids"][:].tolist() == [1039, 39, 1013, 13]
        assert group["gap"].attrs["unit"] == "mm"
        assert group["slip"].shape == group["gap"].shape == force.shape
    figures = summary["runs"][run]
    assert force.max() == pytest.approx(figures["max_force"])
    assert force.sum() * (time[1] - time[0]) == pytest.approx(figures["impulse_total"])
    assert sum(e["impulse"] for e in figures["events"]) == pytest.approx(figures["impulse_total"])
    assert max(e["force_peak"] for e in figures["events"]) == pytest.approx(figures["max_force"])


@pytest.mark.usefixtures("no_page")
def test_same_seed_same_summary(creak, strips, tmp_path):
    creak("run", write_strips(tmp_path), "--quiet", "--out", tmp_path / "again").done()
    again = json.loads((tmp_path / "again" / "summary.json").read_text())
    before = {**strips[1], "run": dict(strips[1]["run"])}
    assert again["run"].pop("id") != before["run"].pop("id")
    assert again.pop("sha256") != before.pop("sha256")  # of a content with the id
    assert without_costs(again) == without_costs(before)


@pytest.mark.usefixtures("no_page")
def test_other_seed_other_motion(creak, strips, tmp_path):
    study = write_strips(tmp_path, study=STUDY.replace("seed = 3", "seed = 4") + "\n[reference]\nrun = false\n")
    creak("run", study, "--quiet", "--out", tmp_path / "out").done()
    other = json.loads((tmp_path / "out" / "summary.json").read_text())
    assert other["runs"]["reduced"]["impulse_total"] != strips[1]["runs"]["reduced"]["impulse_total"]


@pytest.mark.usefixtures("no_page")
def test_reduction_none_runs_the_unreduced_model_alone(creak, strips, tmp_path):
    study = STUDY.replace("[reduction]\n", '[reduction]\nmethod = "none"\n')
    creak("run", write_strips(tmp_path, study=study), "--quiet", "--out", tmp_path / "out").done()
    alone = json.loads((tmp_path / "out" / "summary.json").read_text())
    assert list(alone["runs"]) == ["reference"]
    assert alone["runs"]["reference"]["events"] == strips[1]["runs"]["reference"]["events"]


@pytest.mark.usefixtures("no_page")
def test_node_to_surface_and_output_interval(creak, tmp_path):
    study = STUDY.replace('"surface-to-surface"', '"node-to-surface"')
    study += '\n[output]\nnodes = ["TIP_UPPER"]\ninterval = 1e-3\n'
    creak("run", write_strips(tmp_path, study=study), "--quiet", "--out", tmp_path / "out").done()
    summary = json.loads((tmp_path / "out" / "summary.json").read_text())
    assert summary["verification"]["events"]["missed"] == 0
    with h5py.File(tmp_path / "out" / "results.h5") as file:
        assert file["runs/reduced/time"].shape == (401,)
        assert np.isin([13, 26, 39], file["runs/reduced/node_ids"][:]).all()


@pytest.mark.parametrize("method", ["none", "craig-bampton"])
@pytest.mark.usefixtures("no_page")
def test_mass_on_a_penalty_stop_from_a_deck(creak, method, tmp_path):
    """omega = sqrt((k + K)/m): half a period in contact, F = K v / omega (phase error of the step 1e-7)."""
    study = write_strips(tmp_path, deck=STOP, study=stop_study(2e-5, 0.05, method))
    creak("run", study, "--quiet", "--out", tmp_path / "out").done()
    summary = json.loads((tmp_path / "out" / "summary.json").read_text())
    run = summary["runs"]["reference"]
    event = run["events"][0]
    omega = math.sqrt(1.01e6 / 100.0)
    assert event["force_peak"] == pytest.approx(1e6 / omega, rel=1e-6)
    assert event["impulse"] == pytest.approx(2e6 / omega**2, rel=1e-6)
    assert event["t_end"] - event["t_start"] == pytest.approx(math.pi / omega, rel=1e-5)


def test_modes_and_info_commands(creak, tmp_path):
    write_strips(tmp_path)
    modes = json.loads(creak("modes", tmp_path / "strips.inp", "--count", "4", "--json", "-").done().out)
    assert modes["rigid"] == 1  # the root of the upper strip is free in z, for the study to drive
    assert modes["frequencies"] == sorted(modes["frequencies"])
    text = creak("info", tmp_path / "strips.inp").done().out
    for word in ("UPPER", "LOWER", "UNDER", "PAIRS", "every keyword was read"):
        assert word in text


def test_converge_tells_what_has_settled(creak, tmp_path):
    short = STUDY.replace("f_min = 5", "f_min = 20").replace("period = 0.2", "period = 0.05")
    study = write_strips(tmp_path, study=short + "\n[reference]\nrun = false\n")
    printed = creak("run", study, "--converge", "--verbose", "--out", tmp_path / "out").done().out
    summary = json.loads((tmp_path / "out" / "summary.json").read_text())
    told = summary["convergence"]
    assert list(told["runs"]) == ["base", "h/2", "h/4", "2 x stiffness", "10 x stiffness", "more modes"]
    assert list(summary["runs"]) == ["reduced"]
    table = (tmp_path / "out" / "convergence.csv").read_text().splitlines()
    assert len(table) == 1 + 5 * len(told["events"])
    assert "Convergence: the runs" in printed
    assert "are settled in every figure" in printed
    report = (tmp_path / "out" / "report.html").read_text()
    assert report.count('class="open"') + report.count('class="settled"') == 6 * len(told["events"])
