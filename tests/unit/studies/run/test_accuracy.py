"""[time] accuracy: steps that follow from it, what may stand beside it, error bars and verdict."""

from __future__ import annotations

import json

import pytest

from creak.api.study import run, run_setup, set_up
from creak.errors import InputError
from creak.studies.converge.repeats import repeated_setup
from creak.studies.converge.settling import (
    BAND,
    BASE,
    CHANCE,
    FINER,
    LAST_TWO,
    MORE_MODES,
    SCATTER,
    SOFTER,
    STIFFER,
    UNREDUCED,
    WAYS,
)
from creak.studies.converge.words import REMEDIES
from creak.studies.file.reader import read_study
from creak.studies.prepare.flight_steps import with_flight_steps
from creak.verify.rubbing import FIGURES as OF_RUB
from helpers_decks import STUDY, write_strips

RECORDED = {"section": "contact, exact flow"}

pytestmark = pytest.mark.slow

FREE = STUDY.replace("step = 5e-4\n", "")
"""The two strips without a word on steps."""


def study(folder, text=FREE):
    return read_study(write_strips(folder, study=text))


def timed(folder, lines):
    return study(folder, FREE.replace("[time]\n", f"[time]\n{lines}\n"))


# --- the study file -------------------------------------------------------------------------------------------------


def test_nothing_but_the_length_is_needed(tmp_path):
    table = study(tmp_path).config.time
    assert (table.exact, table.accuracy, table.integrator) == (True, "settled", "exact")


@pytest.mark.parametrize(
    ("line", "integrator"),
    [
        ("step = 1e-3", "hht"),
        ("alpha = -0.1", "hht"),
        ("substeps = 4", "hht"),
        ("rho_inf = 0.8", "generalised-alpha"),
        ('integrator = "hht"', "hht"),
        ('integrator = "exact"', "exact"),
    ],
)
def test_a_forced_step_asks_for_its_scheme(tmp_path, line, integrator):
    assert timed(tmp_path, line).config.time.integrator == integrator


@pytest.mark.parametrize(
    "lines",
    [
        'accuracy = "fine"\nstep = 1e-3',
        'accuracy = "quick"\nintegrator = "hht"',
        'integrator = "exact"\nsubsteps = 2',
    ],
)
def test_accuracy_and_a_forced_step_exclude_each_other(tmp_path, lines):
    with pytest.raises(InputError, match=r"chooses (the|its) steps itself"):
        timed(tmp_path, lines)


# --- steps ----------------------------------------------------------------------------------------------------------


def test_steps_follow_the_excitation_and_divide_its_period(tmp_path):
    c = with_flight_steps(study(tmp_path))[0].config
    signal = c.excitation["root"].signal
    assert c.time.step <= 0.1 / signal.f_max
    assert signal.period / c.output.interval == pytest.approx(round(signal.period / c.output.interval))
    assert c.output.interval / c.time.step == pytest.approx(round(c.output.interval / c.time.step))


def test_an_interval_that_is_given_stays(tmp_path):
    c = with_flight_steps(study(tmp_path, FREE + "\n[output]\ninterval = 2e-3\n"))[0].config
    assert c.output.interval == 2e-3
    assert 2e-3 / c.time.step == pytest.approx(round(2e-3 / c.time.step))


def test_steps_stay_where_they_are_forced(tmp_path):
    forced = study(tmp_path, STUDY)
    assert with_flight_steps(forced)[0] is forced


def test_looking_twice_changes_nothing(tmp_path):
    once, _ = with_flight_steps(study(tmp_path))
    assert with_flight_steps(once)[0].config == once.config


# --- error bars and verdict -----------------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def found(tmp_path_factory):
    text = FREE.replace("periods = 2", "end = 0.1") + "\n[reference]\nrun = true\n"
    return run(study(tmp_path_factory.mktemp("exact"), text))


def test_each_thing_that_may_matter_is_varied_once(found):
    assert list(found.convergence.outcomes) == [BASE, FINER, SOFTER, STIFFER, MORE_MODES]
    runs = found.summary["convergence"]["runs"]
    assert runs[BASE]["modes"] == found.summary["runs"]["reduced"]["modes"]
    assert runs[MORE_MODES]["modes"] >= 1.5 * runs[BASE]["modes"]


def test_every_place_says_how_far_it_has_settled(found):
    """What is followed of a place is what a run of its own says of it, N5 included; the largest change is told."""
    before = found.found.setup
    setup = repeated_setup(before, found.convergence.outcomes[FINER].repeat, before.study.config.time.substeps)
    alone = setup.study.config.reference.model_copy(update={"run": False})
    finer = run_setup(setup.with_tables(reference=alone), converge=False)
    place, again = (r.summary["runs"]["reduced"]["places"][0] for r in (found, finer))
    for name, figure in found.convergence.places[0].items():
        assert figure.values[FINER] == pytest.approx(again[name], rel=1e-6), name
        assert figure.values[BASE] == pytest.approx(place[name], rel=1e-12), name
        assert place["settled_to"][name] == sum(figure.sources.values()), name
    assert place["settled_to"].keys() == {"events", "impulse", "force", "closing_speed", "n5", *OF_RUB}
    assert "N5" in " ".join(found.summary["convergence"]["findings"])


def test_every_event_says_how_far_it_has_settled(found):
    reduced = found.summary["runs"]["reduced"]
    assert reduced["events"]
    assert reduced["verdict"] in ("settled", "statistics", "unsettled")
    if reduced["verdict"] == "settled":  # one event, or 5 % of them, may be open, and is named
        assert all(text.startswith("event at") for text in reduced["reasons"])
        assert len(reduced["reasons"]) <= max(1, len(reduced["events"]) // 20)
    else:
        assert reduced["reasons"]
    for event, of in zip(reduced["events"], found.convergence.events, strict=True):
        settled = event["settled_to"]
        assert set(settled) == {"t_start", "duration", "impulse", "force", "closing_speed"}
        if not of.problem:
            impulse = of.figures["impulse"]
            most = max(abs(x / impulse.values[BASE] - 1.0) for x in impulse.values.values())
            assert 0.8 * most <= settled["impulse"] == sum(impulse.sources.values())  # shares of the other run's value


def test_places_hold_the_events_and_their_force(found):
    places = found.summary["runs"]["reduced"]["places"]
    window = found.summary["verification"]["window"]
    inside = [e for e in found.summary["runs"]["reduced"]["events"] if window[0] <= e["t_start"] <= window[1]]
    assert sum(p["impulse"] for p in places) == pytest.approx(sum(e["impulse"] for e in inside), rel=1e-9)
    assert all(0.0 < p["share"] <= 1.0 for p in places)
    assert max(e["force_place"] for e in inside) >= max(e["force_peak_filtered"] for e in inside)


def test_contact_stiffness_is_used_as_it_is(found):
    before = found.found.setup.contacts
    given = dict(zip(before.names, before.stiffness, strict=True))
    assert found.found.gaps.stiffness.tolist() == [given[name] for name in found.found.gaps.names]
    assert not any("lowered" in note for note in found.notes)


def test_reduced_by_exact_flow_is_unreduced_by_collocation(found, measured):
    """Two models and two schemes; the seven events hang together, so that other steps alone move their sum by .7 %."""
    events = found.summary["verification"]["events"]
    assert events["matched"] == events["reference"] == events["reduced"] > 0
    assert events["impulse_ratio_mean"] == pytest.approx(1.0, abs=0.05)  # the accuracy of an event
    runs = found.summary["runs"]
    measured(
        "two strips, exact flow on the reduced / collocation on the unreduced model: total impulse",
        runs["reduced"]["impulse_total"] / runs["reference"]["impulse_total"],
        1.0,
        abs=0.03,
        source="another scheme and model",
    )


SHORT = FREE.replace("periods = 2", "end = 0.1\n\n[reference]\nrun = false")


def test_quick_has_no_error_bars(tmp_path):
    result = run(study(tmp_path, SHORT.replace("[time]\n", '[time]\naccuracy = "quick"\n')))
    assert result.summary["runs"]["reduced"]["events"]
    assert result.convergence is None
    assert "verdict" not in result.summary["runs"]["reduced"]


def test_a_result_without_repeats_says_nothing_of_settling(tmp_path):
    result = run_setup(set_up(study(tmp_path, SHORT)), converge=False)
    assert result.summary["runs"]["reduced"]["events"]
    assert all(x is None for e in result.summary["runs"]["reduced"]["events"] for x in e["settled_to"].values())


# --- [reference] until ----------------------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def ends_early(tmp_path_factory):
    text = FREE.replace("[time]\nperiods = 2", "[reference]\nuntil = 0.1\n\n[time]\nperiods = 1")
    return run_setup(set_up(study(tmp_path_factory.mktemp("early"), text)), converge=False, record=True)


def test_the_unreduced_run_may_end_early(ends_early):
    result = ends_early
    reference, reduced = (result.runs[n].history for n in ("reference", "reduced"))
    assert reference.time[-1] == pytest.approx(0.1)
    assert reduced.time[-1] == pytest.approx(0.2)
    assert result.summary["verification"]["window"][1] == pytest.approx(0.1)
    assert result.summary["runs"]["reference"]["end"] == pytest.approx(0.1)
    assert result.summary["verification"]["nrmse"]["all"] > 0.95


def test_summary_is_json(found):
    assert json.loads(json.dumps(found.summary, allow_nan=False))


def test_every_family_has_its_advice():
    assert set(REMEDIES) == {*LAST_TWO, UNREDUCED, CHANCE, BAND, WAYS, SCATTER}


def test_hard_contact_creates_no_energy_in_either_model(tmp_path):
    text = FREE.replace('method = "surface', 'stiffness = "hard"\nmethod = "surface').replace(
        "periods = 2", "end = 0.1"
    )
    result = run_setup(set_up(study(tmp_path, text + "\n[reference]\nrun = true\n")), converge=False)
    for each in result.summary["runs"].values():
        assert each["energy_created_of_contact"] < 0.01
        assert "verdict" not in each
    assert result.summary["verification"]["events"]["impulse_ratio_mean"] == pytest.approx(1.0, abs=0.03)


def test_motion_is_kept_where_the_page_shows_events(ends_early):
    motions = ends_early.main.recording.motions
    assert motions
    assert all(m.event.t_start <= 0.1 for m in motions)
