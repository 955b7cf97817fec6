"""What summary.json and results.h5 say of contact, friction and energy."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path
from typing import Any

import h5py
import numpy as np
import pytest
from scipy import integrate

from creak.contact.laws.parameters import Friction
from creak.dynamics.history import ENERGIES
from creak.studies.file.reader import read_study
from creak.studies.findings.histories import MARGIN
from creak.studies.findings.places import find_places
from creak.studies.prepare.setup import set_up
from creak.studies.run.job import StudyResult, run_study
from creak.verify.slips import find_slips
from helpers_decks import STUDY, write_strips
from helpers_findings import save_plain, summarised

EVERY = 4
SPARSE = (
    STUDY.replace("[verification]", f"[output]\ninterval = {5e-4 * EVERY}\n\n[verification]")
    + "\n[precheck]\nmargin = 0.5\n"
)


@pytest.fixture(scope="module")
def plain(tmp_path_factory) -> StudyResult:
    path = write_strips(tmp_path_factory.mktemp("study"), study=SPARSE)
    return run_study(set_up(read_study(path)), lambda *_: None)


@pytest.fixture(scope="module")
def rubbed(plain) -> StudyResult:
    """The same with every other channel rubbing: made-up slips of 1 ms every 20 ms along the first tangent."""
    m = plain.gaps.m
    static = np.where(np.arange(m) % 2, 0.3, 0.0)
    gaps = replace(plain.gaps, friction=Friction(static, static, np.zeros(m)))
    f = gaps.friction.channels.size

    def with_friction(run):
        h = run.history
        force = h.force.copy()
        force[:, gaps.friction.channels] += 1.0
        speed = np.where(np.arange(h.time.size) % 40 >= 38, 5.0, 0.0)
        sliding, tangential = np.zeros((h.time.size, 2 * f)), np.zeros((h.time.size, 2 * f))
        sliding[:, ::2], tangential[:, ::2] = speed[:, None], -0.3 * force[:, gaps.friction.channels]
        energy = h.energy.copy()
        energy[-1, ENERGIES.index("friction")] = 1.25
        h = replace(h, force=force, sliding=sliding, tangential=tangential, energy=energy, residual=3e-12)
        return replace(run, gaps=gaps, history=h, slips=tuple(find_slips(h, gaps, 1e-3)))

    return replace(plain, gaps=gaps, runs={name: with_friction(run) for name, run in plain.runs.items()})


@pytest.fixture(scope="module")
def written(rubbed, tmp_path_factory) -> Path:
    folder = tmp_path_factory.mktemp("out")
    save_plain(rubbed, folder)
    return folder / "results.h5"


def trapezoid(file: h5py.File, path: str) -> np.ndarray:
    return integrate.trapezoid(file[path][:], file["runs/reduced/time"][:], axis=0)


# --- places ---------------------------------------------------------------------------------------------------------


def test_a_squeak_that_began_before_the_window_is_at_its_place(rubbed):
    """A chain of slips through the whole run, as a trim that never comes to rest has."""
    (name, run), *_ = rubbed.runs.items()
    chain = tuple(find_slips(run.history, rubbed.gaps, 1.0))
    assert [len(e.slips) for e in chain] == [20]
    middle = 0.5 * run.history.time[-1]
    for window, found in (((middle, 2 * middle), 10), ((0.0, 0.5 * chain[0].t_start), 0)):
        late = replace(rubbed, window=window, runs={name: replace(run, slips=chain)})
        assert sum(p.slip_count for p in find_places(late.scope, late.runs[name])) == found


# --- summary.json ---------------------------------------------------------------------------------------------------


def test_verification_figures_follow_from_the_match(plain):
    events, match = summarised(plain)["verification"]["events"], plain.events
    assert match is not None
    assert match.pairs
    assert events["precision"] == len(match.pairs) / (len(match.pairs) + len(match.extra))
    assert events["recall"] == len(match.pairs) / (len(match.pairs) + len(match.missed))
    for name in ("time_error", "force_error", "impulse_error"):
        assert set(events[name]) == {"mean", "bias", "percentile_95", "each"}
        assert len(events[name]["each"]) == len(match.pairs)
    assert set(events["statistics"]) == {"chaotic", "rate", "force_distance", "impulse_distance"}
    assert events["statistics"]["rate"]["reference"] == pytest.approx(
        (len(match.pairs) + len(match.missed)) / (plain.window[1] - plain.window[0])
    )


def test_run_figures_are_those_of_its_history(plain):
    for name, run in summarised(plain)["runs"].items():
        h = plain.runs[name].history
        assert list(run["energies"]) == list(ENERGIES)
        assert list(run["energies"].values()) == h.energy[-1].tolist()
        assert run["gap_min"] == h.gap.min()
        assert run["penetration_max"] == run["max_penetration"] == max(0.0, -h.gap.min())
        assert run["slip_events"] == []
        assert run["squeak_rate"] == {}
        # Even steps: the trapezoidal sum is the plain one, but for half of the first and last instant.
        ends = 0.5 * 5e-4 * (h.force[0] + h.force[-1]).sum()
        assert run["impulse_total"] == pytest.approx(h.force.sum() * 5e-4 - ends, rel=1e-12)
        assert run["impulse_total"] == pytest.approx(sum(e["impulse"] for e in run["events"]), rel=1e-12)
        for e in run["events"]:
            assert len(e["touches"]) == e["contacts"]


def test_slips_energies_and_residual_are_told(rubbed):
    summary = summarised(rubbed)
    json.dumps(summary, allow_nan=False)
    for run in summary["runs"].values():
        assert run["energies"]["friction"] == 1.25
        assert run["worst_residual"] == 3e-12
        assert len(run["slip_events"]) == 20  # 800 steps, a slip in every 40
        e = run["slip_events"][0]
        assert {
            *("contact", "channel", "node", "t_start", "t_end", "slip_length", "speed_peak", "friction_work"),
            *("rate", "slips"),
        } <= set(e)
        assert e["slip_length"] == pytest.approx(2 * 5e-4 * 5.0)
        assert run["squeak_rate"]["tip"] == pytest.approx(50.0, rel=0.11)


# --- results.h5 -----------------------------------------------------------------------------------------------------


def test_output_means_keep_the_impulse(rubbed, written):
    h, run = rubbed.runs["reduced"].history, summarised(rubbed)["runs"]["reduced"]
    with h5py.File(written) as file:
        group = file["runs/reduced"]
        assert group["normal_force"].shape == (h.time.size // EVERY + 1, rubbed.gaps.m)
        assert "mean over the output interval" in group["normal_force"].attrs["note"]
        assert trapezoid(file, "runs/reduced/normal_force").sum() == pytest.approx(run["impulse_total"], rel=1e-10)
        for e in run["events"]:  # peaks lie between the output times, those of two events perhaps in one interval
            column = group["channels"].asstr()[()].tolist().index(e["channel"])
            assert group["peak_force"][round(e["t_peak"] / group["time"][1]), column] >= e["force_peak"]
        assert group["normal_force"][()].max() < 0.99 * run["max_force"] == 0.99 * group["peak_force"][()].max()
        assert group["friction_force"].attrs["unit"] == "N"
        assert group["slip_speed"].attrs["unit"] == "mm/s"
        assert group["rubbing_channels"][:].tolist() == rubbed.gaps.friction.channels.tolist()
        f = rubbed.gaps.friction.channels.size
        assert group["friction_force"].shape == (h.time.size // EVERY + 1, f, 2)
        for name, full in (("friction_force", h.tangential), ("slip_speed", h.sliding)):
            np.testing.assert_allclose(
                trapezoid(file, f"runs/reduced/{name}").reshape(-1),
                integrate.trapezoid(full, h.time, axis=0),
                rtol=1e-10,
            )


def test_contact_is_stored_at_full_resolution(plain, tmp_path):
    save_plain(plain, tmp_path)
    h = plain.runs["reduced"].history
    pressed = np.flatnonzero(h.force.any(axis=1))
    with h5py.File(tmp_path / "results.h5") as file:
        group = file["runs/reduced/contact"]
        rows, channels = group["instant"][:], group["channel"][:]
        assert set(pressed) <= set(rows)
        assert max(np.abs(pressed - r).min() for r in rows) == MARGIN
        np.testing.assert_array_equal(group["time"][:], h.time[rows])
        np.testing.assert_array_equal(group["force"][:], h.force[np.ix_(rows, channels)])
        np.testing.assert_array_equal(group["gap"][:], h.gap[np.ix_(rows, channels)])
        assert group["force"][:].sum() == pytest.approx(h.force.sum())
        assert group["gap"].attrs["unit"] == "mm"
        assert "tangential" not in group
        assert "friction_force" not in file["runs/reduced"]


def test_friction_is_stored_with_the_contact(rubbed, written):
    h = rubbed.runs["reduced"].history
    with h5py.File(written) as file:
        group: Any = file["runs/reduced/contact"]
        rows = group["instant"][:]
        np.testing.assert_array_equal(group["tangential"][:], h.tangential[rows])
        np.testing.assert_array_equal(group["sliding"][:], h.sliding[rows])
        assert group["sliding"].attrs["unit"] == "mm/s"


def test_uneven_steps_keep_output_and_impulse(plain, tmp_path):
    """Three of four instants left out while nothing presses: the same impulse at the same output times."""
    run = plain.runs["reduced"]
    h = run.history
    near = np.convolve(h.force.any(axis=1), np.ones(9), mode="same") > 0.5
    keep = np.flatnonzero(near | (np.arange(h.time.size) % EVERY == 0))
    assert keep.size < 0.9 * h.time.size
    thin = replace(
        h,
        time=h.time[keep],
        gap=h.gap[keep],
        force=h.force[keep],
        energy=h.energy[keep],
        output_index=np.flatnonzero(keep % EVERY == 0),
    )
    result = replace(plain, runs={"reduced": replace(run, history=thin)}, events=None)
    summary = summarised(result)
    assert summary["runs"]["reduced"]["impulse_total"] == pytest.approx(
        summarised(plain)["runs"]["reduced"]["impulse_total"], rel=1e-12
    )
    save_plain(result, tmp_path)
    with h5py.File(tmp_path / "results.h5") as file:
        np.testing.assert_array_equal(file["runs/reduced/time"][:], h.time[::EVERY])
        total = trapezoid(file, "runs/reduced/normal_force").sum()
        assert total == pytest.approx(summary["runs"]["reduced"]["impulse_total"], rel=1e-10)
