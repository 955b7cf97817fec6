"""f_max = "auto": as many modes as it takes, each model run once, a budget that is kept, and what is said of it."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest
import scipy.linalg as sla

from creak.api.study import run, run_setup
from creak.errors import InputError
from creak.progress import silent
from creak.signals.spectra import low_pass_uneven
from creak.studies.converge import auto_band, repeats
from creak.studies.converge.settling import BASE, MORE_MODES
from creak.studies.evaluate import evaluate
from creak.studies.file.reader import read_study
from creak.studies.models import superelements
from creak.studies.models.reduced import reduce_model
from creak.studies.models.saved import Store
from creak.studies.prepare.setup import set_up
from creak.studies.run import job
from creak.studies.spots import beside
from creak.verify.matching import figures_of
from creak.verify.unreduced import Spot, Structure
from helpers_bar import IMPULSE, LASTS, bar
from helpers_decks import write_study

AUTO = 'f_max = "auto"'
UNCHECKED = 'end = 2e-4\n[reference]\nrun = "none"'
"""Where the stages alone are looked at: no event is held against the unreduced model."""


@pytest.fixture(autouse=True)
def patient(monkeypatch):
    """Stages are looked at on models that are small."""
    monkeypatch.setattr(auto_band, "PATIENCE", 600.0)
    monkeypatch.setattr(auto_band, "SMALL", 0.0)
    monkeypatch.setattr(auto_band, "WORTH", 0.0)


def blow(found):
    (event,) = found.summary["runs"]["reduced"]["events"]
    return event["t_end"] - event["t_start"], event["impulse"]


@pytest.mark.parametrize("end", [2e-4, 2e-2])
def test_a_bar_on_a_wall_settles_to_its_closed_form(tmp_path, end):
    """A blow of 2 L / c, however long the run is, and with it the frequency that the first stage begins at."""
    found = run(bar(tmp_path, AUTO, n=50, time=f"end = {end}"))
    lasts, impulse = blow(found)
    assert lasts == pytest.approx(LASTS, rel=0.05)
    assert impulse == pytest.approx(IMPULSE, rel=0.02)
    told = found.summary["runs"]["reduced"]
    assert told["verdict"] == "settled"
    stages = told["stages"]
    good = [s["same"] and s["proven"] is not False for s in stages]
    assert good == [*[False] * (len(stages) - 2), True, None]
    assert told["f_max"] == stages[-2]["f_max"]
    assert told["modes"] == stages[-2]["modes"]
    assert found.summary["convergence"]["runs"][MORE_MODES]["modes"] == stages[-1]["modes"]
    assert "(auto)" in found.page(0.0)


def test_all_modes_are_taken_once_the_stages_took_as_long(tmp_path, monkeypatch):
    """A second stage, and then all modes in place of a third: of a bar they cost next to nothing."""
    monkeypatch.setattr(auto_band, "WORTH", 100.0)
    found = run(bar(tmp_path, AUTO, n=50))
    lasts, impulse = blow(found)
    assert (lasts, impulse) == (pytest.approx(LASTS, rel=0.05), pytest.approx(IMPULSE, rel=0.02))
    stages = found.summary["runs"]["reduced"]["stages"]
    assert (len(stages), stages[-1]["same"]) == (3, None)
    assert found.found.reduced.complete
    assert stages[0]["modes"] < stages[1]["modes"] < stages[2]["modes"] == found.summary["runs"]["reduced"]["modes"]


def test_a_small_model_has_all_modes_at_once(tmp_path, monkeypatch):
    """A first run with few, and one with all: nothing is left out, and no spot check counts."""
    monkeypatch.setattr(auto_band, "SMALL", 10.0)
    found = run(bar(tmp_path, AUTO, n=50))
    lasts, impulse = blow(found)
    assert lasts == pytest.approx(LASTS, rel=0.05)
    assert impulse == pytest.approx(IMPULSE, rel=0.02)
    told = found.summary["runs"]["reduced"]
    assert (told["verdict"], [s["same"] for s in told["stages"]]) == ("settled", [False, None])
    assert found.found.reduced.complete
    omega = np.sqrt(found.found.reduced.system.K.diagonal().max() / found.found.reduced.system.M.diagonal().min())
    assert told["modes"] == told["stages"][-1]["modes"] > told["stages"][0]["modes"]
    assert told["f_max"] > 0.5 * omega / (2.0 * np.pi)
    assert len(found.summary["verification"]["spots"]) <= 3


def test_no_model_is_run_twice(tmp_path, monkeypatch):
    """Stages and repeats together: a base run for each stage, one of them with half the tolerance."""
    sizes, real = [], job.march_run

    def counted(name, marching, observed, model, *rest, **options):
        sizes.append((model.system.n, marching.resolution))
        return real(name, marching, observed, model, *rest, **options)

    for module in (job, repeats):
        monkeypatch.setattr(module, "march_run", counted)
    found = run(bar(tmp_path, AUTO, n=40, time=UNCHECKED))
    stages = found.summary["runs"]["reduced"]["stages"]
    assert len(stages) > 2
    assert len(sizes) == len(set(sizes)) == len(stages) + 1


@pytest.mark.parametrize("method", ["craig-bampton", "gap-modes"])
def test_the_model_that_was_chosen_comes_again_from_its_setup(tmp_path, method):
    found = run(bar(tmp_path, f'{AUTO}\nmethod = "{method}"', n=40, time=UNCHECKED), converge=False)
    result = found.found
    assert result.setup.raised > 0
    again = reduce_model(result.setup.reduction, result.reference, result.gaps, silent)
    assert (again.modes, again.system.n) == (result.reduced.modes, result.reduced.system.n)


def test_a_second_run_computes_no_modes_and_finds_the_same(tmp_path, monkeypatch):
    """Further modes of every stage stay beside the superelements, for runs and for the cases of a sweep."""
    study = bar(tmp_path, AUTO, n=40, time=UNCHECKED)
    for keep in ("last", "all"):
        store = tmp_path / keep
        store.mkdir()
        setup = set_up(study)
        first = evaluate(setup, silent, store=Store(store, keep), converge=False)
        assert first.found.setup.raised > 0
        with monkeypatch.context() as patched:
            for name in ("fixed_interface_basis", "raised"):
                patched.setattr(superelements, name, lambda *_, **__: pytest.fail("modes were computed"))
            second = evaluate(setup, silent, store=Store(store, keep), converge=False)
        one, other = (x.found.runs["reduced"].history for x in (first, second))
        np.testing.assert_allclose(other.force, one.force, rtol=1e-6, atol=1e-9 * one.force.max())
        assert all(r.reused for r in second.found.reduced.superelements)
        assert [s.modes for s in second.found.band.stages] == [s.modes for s in first.found.band.stages]


def differing(by):
    """Spot checks of every event that find the impulse off by the next of `by`."""
    calls = []

    def check(run, *_, **__):
        off = by[min(len(calls), len(by) - 1)]
        calls.append(run.reduced.modes)
        own = [figures_of(e) for e in run.run.events]
        pairs = zip(run.run.events, own, strict=True)
        spots = tuple(Spot(e, "drawn", f, f | {"impulse": (1.0 + off) * f["impulse"]}) for e, f in pairs)
        return Structure(spots, first_end=min(e.t_end for e in run.run.events))

    return check, calls


def test_where_the_unreduced_model_disagrees_there_are_more_modes(tmp_path, monkeypatch):
    """The stage at which more modes change nothing is not the last one; each model is checked once."""
    check, calls = differing([0.1, 0.1, 0.001])
    monkeypatch.setattr(beside, "events_beside", check)
    found = run(bar(tmp_path, AUTO, n=40))
    told = found.summary["runs"]["reduced"]
    proven = [s["proven"] for s in told["stages"]]
    assert [p for p in proven if p is not None] == [False, False, True]
    assert proven[-2:] == [True, None]
    assert calls == [s["modes"] for s in told["stages"] if s["proven"] is not None]
    assert told["verdict"] == "settled"
    assert found.found.band.structure.spots == found.convergence.structure.spots


def test_each_stage_is_announced(tmp_path, monkeypatch):
    """So that runs that look the same are not taken for one that goes round in circles."""
    check, _ = differing([0.1, 0.1, 0.001])
    monkeypatch.setattr(beside, "events_beside", check)
    told = list[str]()
    found = run(bar(tmp_path, AUTO, n=40), progress=lambda stage, *_: told.append(str(stage)))
    stages = found.summary["runs"]["reduced"]["stages"]
    said = [t for t in told if t.startswith('f_max = "auto"')]
    assert [f"{s['f_max']:,.0f} Hz" in t for s, t in zip(stages[1:], said, strict=True)] == [True] * (len(stages) - 1)


def test_a_budget_that_does_not_satisfy_the_unreduced_model_is_told(tmp_path, monkeypatch):
    check, calls = differing([0.1])
    monkeypatch.setattr(beside, "events_beside", check)
    monkeypatch.setattr(auto_band, "BUDGET", 0.0)
    monkeypatch.setattr(auto_band, "PATIENCE", 0.1)
    told = run(bar(tmp_path, AUTO, time="end = 2e-3"))
    while told.summary["runs"]["reduced"]["stages"][-2]["proven"] is None:  # the first stages change by themselves
        monkeypatch.setattr(auto_band, "PATIENCE", 1.5 * auto_band.PATIENCE)
        told = run(bar(tmp_path, AUTO, time="end = 2e-3"))
    found = told.summary["runs"]["reduced"]
    assert (found["verdict"], found["stages"][-2]["same"], found["stages"][-2]["proven"]) == ("unsettled", True, False)
    assert "would take some" in found["reasons"][-1]
    assert len(calls) >= 1


def test_a_budget_that_is_spent_says_what_it_would_take(tmp_path, monkeypatch):
    monkeypatch.setattr(auto_band, "BUDGET", 0.0)
    monkeypatch.setattr(auto_band, "PATIENCE", 0.0)
    told = run(bar(tmp_path, AUTO, n=40, time=UNCHECKED)).summary["runs"]["reduced"]
    assert told["verdict"] == "unsettled"
    assert len(told["stages"]) == 2
    assert told["stages_ended"] in told["reasons"][-1]
    assert "Hz would take some" in told["stages_ended"]


def test_memory_that_does_not_hold_more_says_so(tmp_path, monkeypatch):
    monkeypatch.setattr(auto_band, "fits", lambda _: False)
    told = run(bar(tmp_path, AUTO, n=40, time=UNCHECKED)).summary["runs"]["reduced"]
    assert told["verdict"] == "unsettled"
    assert "unknowns" in told["reasons"][-1]


def test_a_part_that_becomes_complete_ends_the_stages(tmp_path):
    """Two elements have two modes; with them nothing is left out."""
    found = run(bar(tmp_path, AUTO, n=2, time="end = 2e-2"))
    assert found.summary["runs"]["reduced"]["modes"] == 2
    assert found.convergence.outcomes[MORE_MODES].steps == 0
    assert found.convergence.outcomes[BASE].modes == 2


def test_nothing_that_presses_and_no_modes_need_no_stages(tmp_path):
    for reduction in (f'{AUTO}\nmethod = "guyan"', f'{AUTO}\nmethod = "none"'):
        found = run(bar(tmp_path, reduction, n=10), converge=False)
        assert not any("stages" in r for r in found.summary["runs"].values())


def test_a_forced_step_has_its_stages_too(tmp_path):
    told = run(bar(tmp_path, AUTO, n=40, time=f"step = 2e-7\n{UNCHECKED}"), converge=False).summary["runs"]["reduced"]
    assert len(told["stages"]) > 1


def test_what_is_no_frequency_is_refused(tmp_path):
    with pytest.raises(InputError, match=r"f_max.*'auto'|auto"):
        bar(tmp_path, 'f_max = "automatic"')


def test_a_number_stays_a_number(tmp_path):
    setup = set_up(bar(tmp_path, "f_max = 700"))
    assert (setup.band.auto, setup.band.f_max) == (False, 700.0)
    told = run_setup(setup, converge=False).summary["runs"]["reduced"]
    assert told["f_max"] == 700.0
    assert "stages" not in told
    assert read_study(tmp_path / "study.toml").config.reduction.f_max == 700.0


def pressed_rod(folder, n=12, length=0.2, side=0.01, young=2e9, density=1000.0, preload=50.0):
    """A rod of beams between a support and a stop that it presses on; its lowest modes bend, the load is along it."""
    rod = (
        "*NODE, NSET=ALL\n"
        + "".join(f"{i + 1}, {length * i / n:.12g}, 0., 0.\n" for i in range(n + 1))
        + "*ELEMENT, TYPE=B33, ELSET=ROD\n"
        + "".join(f"{i}, {i}, {i + 1}\n" for i in range(1, n + 1))
        + f"*NSET, NSET=FOOT\n1\n*NSET, NSET=MIDDLE\n{n // 2 + 1}\n*NSET, NSET=HEAD\n{n + 1}\n"
        + f"*MATERIAL, NAME=SOFT\n*ELASTIC\n{young}, 0.\n*DENSITY\n{density},\n"
        + f"*BEAM SECTION, SECTION=RECT, ELSET=ROD, MATERIAL=SOFT\n{side}, {side}\n0., 1., 0.\n"
        + "*BOUNDARY\nHEAD, 1, 6\nFOOT, 2, 4\nALL, 2, 2\nALL, 4, 4\nALL, 6, 6\n"
    )
    return write_study(
        folder,
        '[model]\ndeck = "deck.inp"\nunits = "m-kg-s"\n[damping]\nmodal = 0.001\n'
        '[[connector]]\ntype = "play"\nname = "stop"\nnodes = ["FOOT"]\ndof = "x"\nstiffness = 1e6\nlower = 0.0\n'
        f'[[static]]\nforce = {-preload}\nnode_set = "FOOT"\ndof = "x"\n'
        '[excitation.middle]\nnode_set = "MIDDLE"\ndof = "x"\nkind = "force"\n'
        'signal = { type = "step", amplitude = 5.0 }\n[time]\nend = 0.02\n[reference]\nrun = "none"\n',
        {"deck.inp": rod},
    )


def along_the_rod(time, n=400, length=0.2, ea=2e5, mass=0.1, k=1e6, zeta=0.001, amplitude=5.0):
    """What a step in the middle adds to the force of the stop: 400 linear elements along the rod, 30 modes."""
    h = length / n
    K, M = np.zeros((n + 1, n + 1)), np.zeros((n + 1, n + 1))
    for i in range(n):
        K[i : i + 2, i : i + 2] += ea / h * np.array([[1, -1], [-1, 1]])
        M[i : i + 2, i : i + 2] += mass * h / length / 6 * np.array([[2, 1], [1, 2]])
    K[0, 0] += k
    omega2, shapes = sla.eigh(K[:n, :n], M[:n, :n], subset_by_index=(0, 29))
    omega = np.sqrt(omega2)[:, None]
    damped = omega * np.sqrt(1.0 - zeta**2)
    course = 1.0 - np.exp(-zeta * omega * time) * (
        np.cos(damped * time) + zeta * omega / damped * np.sin(damped * time)
    )
    return -k * shapes[0] @ (shapes[n // 2, :, None] * amplitude / omega2[:, None] * course)


def test_modes_that_nothing_excites_settle_nothing(tmp_path):
    """The first modes bend a rod that is pushed along itself: they change nothing, and say nothing of those above."""
    found = run(pressed_rod(tmp_path))
    stages = found.summary["runs"]["reduced"]["stages"]
    assert stages[1]["impulse"] == pytest.approx(stages[0]["impulse"], rel=1e-12)
    assert stages[-1]["impulse"] != pytest.approx(stages[0]["impulse"], rel=1e-7)
    assert found.summary["runs"]["reduced"]["verdict"] == "settled"
    time = np.linspace(0.0, 0.02, 20_001)
    f_max = found.found.setup.study.config.verification.f_max
    _, force = low_pass_uneven(time, along_the_rod(time)[:, None], f_max)
    (told,) = found.summary["convergence"]["friction"]
    fluctuation, mean = (told["figures"][name] for name in ("force_rms", "force_mean"))
    bar = fluctuation["settled_to"] * 0.1 * mean["values"]["base"]
    assert fluctuation["values"]["base"] == pytest.approx(force.std(), abs=bar)


def test_stages_that_leave_the_verdict_open_are_followed_by_more(tmp_path, monkeypatch):
    """What ended them said that nothing changes any more; where the verdict lacks modes all the same, they go on."""
    study = pressed_rod(tmp_path)
    before = len(run(study).summary["runs"]["reduced"]["stages"])
    said = iter([True, False])
    monkeypatch.setattr("creak.studies.converge.settled.lacks_modes", lambda _: next(said))
    stages = run(study).summary["runs"]["reduced"]["stages"]
    assert len(stages) > before
    assert stages[before - 2]["same"] is True
    assert next(said, None) is None


def taps(force, count=4):
    """40 blows and some taps of a fiftieth of their impulse."""
    hard = [SimpleNamespace(impulse=1.0, force_place=1.0) for _ in range(40)]
    return [*hard, *(SimpleNamespace(impulse=0.02, force_place=force) for _ in range(count))]


@pytest.mark.parametrize(("force", "count", "enough"), [(0.3, 4, False), (0.05, 4, True), (0.3, 2, True)])
def test_as_many_events_stay_as_the_verdict_asks_for(force, count, enough):
    """Taps that carry .2 % of the impulse count, unless they are few or faint: the verdict counts them too."""
    events = taps(force, count)
    assert auto_band._enough(events, [e.impulse == 1.0 for e in events]) is enough


@pytest.mark.parametrize(("lost", "same"), [(0, False), (6, True)])
def test_samples_are_compared_only_where_single_events_are_lost(monkeypatch, lost, same):
    """A tenth of the events is off by 10 %: all of them have partners, so more modes will tell; or some have none."""
    figure = SimpleNamespace(problem="", settled_to=0.1, limit=0.05, changes={"modes": 0.1})
    events = [SimpleNamespace(impulse=1.0, force_place=1.0, t_start=0.0, t_end=1.0) for _ in range(40)]
    judged = [
        SimpleNamespace(event=e, problem="absent" if k < lost else "", figures={"duration": figure})
        for k, e in enumerate(events)
    ]
    sample = SimpleNamespace(rates_alike=True, force=SimpleNamespace(alike=True), impulse=None)
    found = SimpleNamespace(totals={}, judged=judged, events=events, statistics={"modes": sample})
    for name, value in (("assess", found), ("outcome_of", None), ("_slip_alike", True), ("_press_alike", True)):
        monkeypatch.setattr(auto_band, name, lambda *_, value=value, **__: value)
    v = SimpleNamespace(event_tolerance=1e-3, f_max=500.0)
    run_of = SimpleNamespace(name="reduced")
    assert auto_band.tell_the_same(v, (0.0, 1.0), run_of, run_of) is same


MEASURED = [
    ("door, 40 mm", 14_859, 10_881, 2886, 21_398, 23, 0, 0, 17.5),
    ("door, 40 mm", 14_859, 15_652, 4090, 24_196, 23, 0, 0, 50.0),
    ("door, 20 mm", 55_881, 7_536, 1039, 65_325, 31, 0, 0, 15.1),
    ("door, 20 mm", 55_881, 9_594, 2177, 65_380, 31, 0, 0, 22.6),
    ("cockpit, 10 mm", 27_052, 2_826, 338, 137_452, 9, 0, 0, 3.1),
    ("cockpit, 10 mm", 27_052, 7_501, 1786, 202_275, 9, 0, 0, 12.2),
    ("two strips, friction", 468, 90, 90, 311_843, 12, 227_902, 12, 8.4),
    ("beam on block, friction", 144, 144, 150, 211_549, 9, 204_387, 7, 1.8),
]
"""Dofs, back-substitutions, unknowns, instants and channels of a stage, its instants with contact and channels that may
rub where some do, and the s of CPU that it took on one core."""


@pytest.mark.parametrize(
    ("name", "dofs", "solves", "n", "instants", "channels", "contact", "rubbing", "took"), MEASURED
)
def test_what_a_stage_takes_is_told_to_a_factor_of_two(
    name, dofs, solves, n, instants, channels, contact, rubbing, took
):
    unreduced, reduced = SimpleNamespace(free_dof=dofs), SimpleNamespace(solves=solves, system=SimpleNamespace(n=n))
    history = SimpleNamespace(time=np.zeros(instants), gap=np.zeros((1, channels)), contact_steps=contact)
    run = SimpleNamespace(history=history, gaps=SimpleNamespace(rubbing=rubbing))
    told = auto_band._reckoned(unreduced, reduced, run, share=auto_band.BLOCKED)
    assert 0.5 * took < told < 2.0 * took, name
