"""The findings of the thesis's studies that a coarse door shows too."""

from __future__ import annotations

import json
from dataclasses import replace

import numpy as np
import pytest

from creak_thesis import doors as bench
from creak_thesis.plan import plan
from creak_thesis.run import run_thesis

pytestmark = [pytest.mark.slow, pytest.mark.once]

LOAD = "A3"
NAMES = ("Ref StS", "D8", "F300", "P45")


def chosen():
    return [replace(c, loads=(LOAD,), newton=False) for c in plan() if c.name in NAMES]


@pytest.fixture(scope="module")
def result(tmp_path_factory):
    """Of one period, not five."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(bench, "SCHEME", {**bench.SCHEME, "time.periods": 1})
        return run_thesis(40.0, tmp_path_factory.mktemp("thesis"), lambda *_: None, chosen())


def test_every_case_has_a_name_of_its_own_and_an_unreduced_partner():
    cases = {c.name: c for c in plan()}
    assert len(cases) == len(plan())
    for case in cases.values():
        partner = cases[case.against]
        assert partner.reduction is None
        assert set(case.loads) <= set(partner.loads)


def test_contact_events_of_d8_are_those_of_the_unreduced_model(result):
    """Thesis: force 6 to 22 % too high at f_max 1500 Hz; here at the lower end of that, by steps of 1 ms."""
    reference, d8 = (result.outcomes[n].loads[LOAD] for n in ("Ref StS", "D8"))
    assert len(reference.events) >= 3
    assert [p[0] for p in d8.pairs] == list(range(len(reference.events)))
    assert len(d8.events) == len(reference.events)
    ratio = np.mean([d8.events[j].force / reference.events[i].force for i, j in d8.pairs])
    assert ratio == pytest.approx(1.0, abs=0.06)
    assert min(d8.nrmse.values()) > 0.99
    assert min(result.outcomes["D8"].mac) > 0.999
    assert max(reference.energy_created, d8.energy_created) < 1e-6


def test_more_fixed_interface_modes_fit_better(result):
    assert result.outcomes["F300"].loads[LOAD].nrmse["all"] < result.outcomes["D8"].loads[LOAD].nrmse["all"]
    assert sum(result.outcomes["F300"].modes.values()) < sum(result.outcomes["D8"].modes.values())


def test_dropping_interface_dofs_by_participation_loses_modes_and_events(result):
    p45, d8 = (result.outcomes[n] for n in ("P45", "D8"))
    assert sum(p45.retained.values()) < sum(d8.retained.values())
    assert min(p45.mac) < 0.9
    assert len(p45.loads[LOAD].pairs) < len(d8.loads[LOAD].pairs)


def test_a_second_run_takes_what_is_finished(result, monkeypatch):
    monkeypatch.setattr("creak_thesis.run.measure", lambda *_: pytest.fail("measured again"))
    again = run_thesis(40.0, result.folder, lambda *_: None, chosen())
    assert json.dumps(again.outcomes["D8"].mac) == json.dumps(result.outcomes["D8"].mac)
    assert again.outcomes["D8"].loads[LOAD].events == result.outcomes["D8"].loads[LOAD].events
