"""A tiny study from end to end: same input, same summary; reduced equals reference where nothing is lost."""

from __future__ import annotations

import gc
import json
import weakref
from pathlib import Path
from typing import Any

import pytest

from creak.studies.file.reader import read_study
from creak.studies.models import reference as whole
from creak.studies.prepare.setup import set_up
from creak.studies.run.job import run_study
from helpers_decks import STUDY, two_strips, write_strips
from helpers_findings import summarised

TIMINGS = ("wall_s", "cpu_s", "setup_s", "offline_cpu_s", "offline_wall_s", "peak_rss_gb")


def summary_of(folder: Path, study: str = STUDY.replace("periods = 2", "end = 0.12")) -> dict[str, Any]:
    folder.mkdir(exist_ok=True)
    path = write_strips(folder, study=study)
    out = summarised(run_study(set_up(read_study(path)), lambda *_: None))
    for run in out["runs"].values():
        for key in TIMINGS:
            run.pop(key, None)
    assert out["run"].pop("id")  # of this run alone
    return out


@pytest.fixture(scope="module")
def summary(tmp_path_factory) -> dict[str, Any]:
    return summary_of(tmp_path_factory.mktemp("first"))


def test_same_seed_gives_the_same_summary(summary, tmp_path):
    assert summary_of(tmp_path / "again") == summary


def test_summary_is_plain_json(summary):
    assert json.loads(json.dumps(summary, allow_nan=False)) == summary


def test_summary_has_what_the_design_promises(summary):
    assert {"nodes", "elements", "dof", "mass", "parts"} <= set(summary["model"])
    for name in ("reduced", "reference"):
        run = summary["runs"][name]
        assert {
            *("dof", "retained", "modes", "channels", "steps", "energy_error", "events"),
            *("max_force", "impulse_total"),
        } <= set(run)
        assert {
            *("channel", "node", "t_start", "t_peak", "t_end", "force_peak", "force_peak_filtered"),
            *("impulse", "closing_speed"),
        } <= set(run["events"][0])
    verification = summary["verification"]
    assert {"mac", "frequencies", "nrmse", "events"} <= set(verification)
    assert set(verification["nrmse"]) == {"x", "y", "z", "all"}
    assert summary["seeds"] == {"root": 3}


class Enough(Exception):
    """Parts are being reduced."""


def test_no_factor_of_the_whole_is_held_while_parts_are_reduced(tmp_path, monkeypatch):
    """It is the largest piece of memory there is."""
    made, alive = [], []

    def factor(K):
        found = regular_factor(K)
        made.append(weakref.ref(found))
        return found

    def look(what: str, done: int, total: int) -> None:
        if what.endswith("constraint modes"):
            gc.collect()
            alive.extend(ref() for ref in made)
            raise Enough

    regular_factor = whole.regular_factor
    monkeypatch.setattr(whole, "regular_factor", factor)
    path = write_strips(tmp_path, study=STUDY)
    for start in (run_study, reduce_alone):
        with pytest.raises(Enough):
            start(set_up(read_study(path)), look)
    assert len(made) == 2
    assert alive == [None] * 3  # one of the first, two of the second


def reduce_alone(setup, look) -> None:
    """As `creak reduce`."""
    from creak.cli.cluster import distribution_of
    from creak.cli.reduce import _reduced

    class Quiet:
        progress = staticmethod(look)

    here = distribution_of(None, None, None, None, None)
    _reduced(setup, setup.study.path.parent / "out", Quiet(), here, ())


def test_both_runs_have_the_same_channels_and_steps(summary):
    a, b = summary["runs"]["reduced"], summary["runs"]["reference"]
    assert a["channels"] == b["channels"] > 0
    assert a["steps"] == b["steps"] == 240
    assert a["dof"] < b["dof"]
    assert all(0.99 <= mac <= 1.0 for mac in summary["verification"]["mac"])
    # Rayleigh-Ritz: reduced frequencies are upper bounds, to round-off of the eigensolvers.
    for reference, reduced in summary["verification"]["frequencies"]:
        assert reduced >= reference * (1 - 1e-7)


@pytest.mark.slow
def test_damping_that_couples_modes_passes_the_pre_check(tmp_path):
    """A spring without damping between damped strips: the channels that the pre-check keeps see what all see."""
    spring = "*ELEMENT, TYPE=SPRING2, ELSET=JOIN\n901, 18, 1018\n*SPRING, ELSET=JOIN\n3, 3\n4.0\n"
    text = STUDY.replace("step = 5e-4\nperiods = 2", 'end = 0.07\naccuracy = "quick"\n[reference]\nrun = false')
    text, impulses = text.replace("0.05,", "0.2,"), []
    for name, more in (("checked", ""), ("every", "\n[precheck]\nenabled = false\n")):
        (tmp_path / name).mkdir()
        path = write_strips(tmp_path / name, two_strips() + spring, text + more)
        run = run_study(set_up(read_study(path)), lambda *_: None).runs["reduced"]
        assert "exact flow" in run.integrator
        impulses.append(sum(e.impulse for e in run.events))
    assert impulses[0] == pytest.approx(impulses[1], rel=1e-6)
    assert impulses[0] > 0.0
