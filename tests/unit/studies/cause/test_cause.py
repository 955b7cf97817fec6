"""What causes a place: sums of modes, excitations and contacts; changes predicted on the reduced model, and checked."""

from __future__ import annotations

from dataclasses import replace
from functools import partial

import numpy as np
import pytest

import creak
from creak.dynamics.diagonal import is_modal
from creak.dynamics.loads import Loads
from creak.report.words.terminal import cause_lines
from creak.studies.cause import decompose
from creak.studies.cause.changes import candidates
from creak.studies.cause.decompose import CONTACT, EXCITATION, REST, find_causes
from creak.studies.cause.effects import cause_dict, causes_of, checked_by_run, driven_level, find_changes, try_changes
from creak.studies.findings.sound import heard_places
from helpers_decks import STUDY, two_strips, write_strips
from helpers_findings import summarised

RECORDED = {"section": "verdicts"}

BASE = STUDY.replace("step = 5e-4\nperiods = 2", 'end = 0.12\naccuracy = "quick"\n[reference]\nrun = false\n')
BASE = BASE.replace("f_max = 3000", "f_max = 1500").replace("0.05,", "0.08,")
STOP = """
[[connector]]
type = "play"
name = "stop"
nodes = "TIP_UPPER"
dof = "z"
lower = -5.0
upper = 0.8
stiffness = 20.0
"""


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    folder = tmp_path_factory.mktemp("cause")
    write_strips(folder, study=BASE + STOP)
    return folder


@pytest.fixture(scope="module")
def result(folder):
    return creak.run(creak.read_study(folder / "study.toml"), converge=False, record=False)


@pytest.fixture(scope="module")
def places(result):
    return heard_places(result.found.scope, result.main, result.sound)


def causes_in(result, places):
    return find_causes(result.found.setup.marching, result.found.setup.reduction, result.main, places)


@pytest.fixture(scope="module")
def causes(result, places):
    return causes_in(result, places)


def test_modes_sources_and_parts_sum_to_the_gap(causes, measured):
    assert {s.name for c in causes for s in c.sources if s.kind == CONTACT} == {"tip", "stop"}
    worst = max(abs(c.total - (c.gap - c.gap0)) / max(c.gap0, 1e-3) for c in causes)
    parts = max(abs(sum(v for _, v in c.parts) - (c.gap - c.gap0)) / max(c.gap0, 1e-3) for c in causes)
    measured(
        "cause of a place: modes times sources against the run's gap",
        max(worst, parts),
        0.0,
        abs=1e-10,
        unit="-",
        source="superposition",
    )
    for cause in causes:
        rest = next(s for s in cause.sources if s.kind == REST)
        assert abs(rest.modes).max() < 0.01 * max(abs(s.total) for s in cause.sources)
        assert cause.modes.sum() + sum(s.direct for s in cause.sources) == pytest.approx(cause.total, abs=1e-12)


def test_modes_that_a_dashpot_couples_have_causes_and_sound(tmp_path):
    """By up to a sixth of critical; contact and stop are told apart by pairs of complex modes."""
    write_strips(tmp_path, two_strips() + DASHPOT, BASE + STOP)
    result = creak.run(creak.read_study(tmp_path / "study.toml"), converge=False, record=False)
    assert not is_modal(result.main.system)
    assert result.sound.heard[0][0].n5 > 1.0
    found = causes_in(result, heard_places(result.found.scope, result.main, result.sound))
    assert {s.name for c in found for s in c.sources if s.kind == CONTACT} == {"tip", "stop"}
    for cause in found:
        assert cause.total == pytest.approx(cause.gap - cause.gap0, abs=1e-10)
        rest = next(s for s in cause.sources if s.kind == REST)
        assert abs(rest.modes).max() < 0.01 * max(abs(s.total) for s in cause.sources)


def test_what_the_run_kept_of_its_motion_is_not_marched_again(causes, folder, monkeypatch):
    kept = creak.run(creak.read_study(folder / "study.toml"), converge=False)
    march = decompose.marched

    def free_alone(marching, system, gaps, loads, steps):
        assert not gaps.presses
        return march(marching, system, gaps, loads, steps)

    monkeypatch.setattr(decompose, "marched", free_alone)
    again = causes_in(kept, heard_places(kept.found.scope, kept.main, kept.sound))
    assert [c.gap for c in again] == [c.gap for c in causes]
    for a, b in zip(again, causes, strict=True):
        np.testing.assert_allclose(a.modes, b.modes, rtol=1e-12, atol=1e-12 * np.abs(b.modes).max())


def test_an_excitation_alone_is_the_motion_without_contact(causes, result, folder):
    free = creak.change_study(creak.read_study(folder / "study.toml"), {"contact.tip.clearance": 50.0})
    free = creak.change_study(free, {"connector.0.upper": 50.0, "precheck.enabled": False})
    other = creak.run(free, converge=False, record=False)
    gaps = other.found.gaps
    for cause in causes:
        channel = gaps.names.index(result.found.gaps.names[cause.channel])
        row = int(np.abs(other.history.time - cause.time).argmin())
        alone = sum(s.total for s in cause.sources if s.kind == EXCITATION)
        assert other.history.time[row] == pytest.approx(cause.time, abs=1e-9)
        assert other.history.gap[row, channel] - gaps.gap0[channel] == pytest.approx(alone, abs=1e-6)


def test_words_say_what_moves_it(causes, result):
    found = cause_dict(causes[0], result.found.setup.loads, result.found.gaps, "mm")
    assert sum(s["closing"] for s in found["sources"]) == pytest.approx(found["closing"], abs=1e-12)
    whole = sum(m["closing"] for m in found["modes"]) + found["other_modes"] + found["with_supports"]
    assert whole == pytest.approx(found["closing"], abs=1e-12)
    for mode in found["modes"]:
        assert sum(mode["of"].values()) == pytest.approx(mode["closing"], abs=1e-12)
    assert "by excitation root" in found["words"]
    first = found["modes"][0]
    assert first["coincides"]  # the strip's first mode is driven by 5 to 60 Hz
    assert f"{first['frequency']:.4g} Hz" in found["words"]
    assert {p["name"] for p in found["parts"]} <= {"UPPER", "LOWER"}


def test_a_mode_coincides_with_the_line_that_drives_it():
    time = np.arange(2001) * 1e-3
    support = np.zeros((3, time.size, 1))
    support[2, :, 0] = np.sin(2 * np.pi * 50 * time)
    level = driven_level(
        Loads(time, support, np.zeros((time.size, 0))), np.array([50.2, 300.0]), np.array([0.02, 0.02])
    )
    assert level[0] > -1.0
    assert level[1] < -80.0


CLIPS = """
[[clip]]
type = "foam"
name = "foam"
nodes = ["ROOT_LOWER", "ROOT_UPPER"]
axis = [0, 0, -1]
table = [[0, 0], [0.1, 0.02], [0.3, 0.2]]
gap = 0.3
[[clip]]
type = "pull-out"
name = "hook"
nodes = ["ROOT_LOWER", "ROOT_UPPER"]
axis = [0, 0, 1]
stiffness = 2.0
pull_out = 0.1
"""


def test_what_other_clips_are_takes_no_change_from_a_contact(tmp_path):
    """Foam has a table and a hook presses at rest: the contact beside them can be softer and have more gap all the same."""
    write_strips(tmp_path, study=BASE.replace("end = 0.12", "end = 0.05") + CLIPS)
    result = creak.run(creak.read_study(tmp_path / "study.toml"), converge=False, record=False)
    found, every = result.found, heard_places(result.found.scope, result.main, result.sound)
    kinds = {}
    for place, cause in zip(every, causes_in(result, every), strict=True):
        made = candidates(place, cause, found.setup.reduction, found.reference, found.reduced, found.gaps, found.gaps)
        kinds[place.contact] = {change.kind for change in made}
    assert {"gap", "stiffness"} <= kinds["tip"]
    assert "gap" not in kinds["hook"]


@pytest.mark.slow
def test_predicted_changes_hold_in_a_full_run(result, places, causes, measured):
    """Mass and fastener change the modes: the reduced model with a low-rank change against one reduced anew."""
    found = result.found
    place, cause = next((p, c) for p, c in zip(places, causes, strict=True) if p.contact == "tip")
    now, every = try_changes(found, None, place, cause)
    assert [c.kind for c, _ in every][:4] == ["gap", "stiffness", "damping", "mass"]
    worst = 0.0
    for wanted in ("mass", "fastener", "damping"):
        change, effect = next((c, e) for c, e in every if c.kind == wanted)
        checked = checked_by_run(found.setup, None, lambda *_: None, place, change)
        worst = max(worst, abs(effect.total_impulse - checked.total_impulse) / now.total_impulse)
        # Motion with more mass is chaotic: round-off alone moves the impulse of one place by .2 of that now.
        assert effect.impulse == pytest.approx(checked.impulse, abs=0.4 * now.impulse)
    measured(
        "change predicted on the reduced model: impulse of all places against a full run",
        worst,
        0.0,
        abs=0.05,
        unit="-",
        source="reduction made anew",
    )


def test_the_best_changes_are_told(result, places, causes):
    tried = partial(try_changes, result.found, None)
    told = find_changes(places[:1], causes[:1], tried, None, lambda *_: None)
    some = told[places[0].number]
    assert 0 < len(some) <= 3
    assert len({c["change"] for c in some}) == len(some)
    left = [c["predicted"]["impulse"] for c in some]
    assert left == sorted(left)
    assert left[0] < some[0]["now"]["impulse"]
    assert some[0]["now"]["impulse"] == pytest.approx(places[0].impulse, rel=1e-9)  # whole hits, as the place has it


def test_summary_and_terminal_have_them(result, places):
    causes, notes = causes_of(result.found, result.sound, lambda *_: None)
    assert notes == []
    summary = summarised(result.found, None, result.sound, causes)
    told = summary["runs"]["reduced"]["places"]
    assert [p["cause"]["words"] for p in told] == [causes[p.number]["words"] for p in places]
    told[0]["cause"]["changes_words"] = ["more gap"]
    assert cause_lines(summary)[:2] == [
        f"{told[0]['name']}: {told[0]['cause']['words']}",
        f"{told[0]['name']}: would help: more gap",
    ]


def test_a_run_without_modes_says_why(result):
    unreduced = {"reference": replace(result.main, name="reference")}
    causes, notes = causes_of(
        replace(result.found, reduced=None, runs=unreduced), result.sound, lambda *_: None, "predicted"
    )
    assert causes == {}
    assert notes == ["no cause is told of the places: only a reduced model has few enough modes"]


DASHPOT = """*ELEMENT, TYPE=DASHPOT2, ELSET=DAMP
902, 18, 1018
*DASHPOT, ELSET=DAMP
3, 3
1e-2,
"""
JOINED = """*ELEMENT, TYPE=SPRING2, ELSET=JOIN
901, 18, 1018
*SPRING, ELSET=JOIN
3, 3
4.0
"""
"""Between the strips, a third of the way to their tips."""


@pytest.mark.slow
def test_changes_hold_with_static_loads_and_a_fastener_is_moved(tmp_path):
    """Under gravity each change has an equilibrium of its own, and a fastener can be put elsewhere: against full runs."""
    weight = "\n[damping]\nmodal = 0.02\n\n[[static]]\ngravity = [0.0, 0.0, -9810.0]\n"
    write_strips(tmp_path, two_strips() + JOINED, BASE.replace("end = 0.12", "end = 0.2") + weight)
    result = creak.run(creak.read_study(tmp_path / "study.toml"), converge=False, record=False)
    found, place = result.found, heard_places(result.found.scope, result.main, result.sound)[0]
    now, every = try_changes(found, None, place, causes_in(result, [place])[0])
    assert [c.kind for c, _ in every][:4] == ["gap", "stiffness", "damping", "mass"]
    assert "moved to" in next(c.words for c, _ in every if c.kind == "moved")
    for change, effect in ((c, e) for c, e in every if c.kind in ("gap", "mass", "moved")):
        checked = checked_by_run(found.setup, None, lambda *_: None, place, change)
        assert effect.total_impulse == pytest.approx(checked.total_impulse, abs=0.03 * now.total_impulse), change.words
        assert effect.total_impulse != pytest.approx(now.total_impulse, rel=1e-3), change.words
