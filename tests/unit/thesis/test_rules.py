"""Each mark of the thesis page is computed by a rule that data can break: for every finding, data for each of its marks."""

from collections.abc import Callable
from dataclasses import replace
from functools import cache

import pytest

from creak_thesis.outcome import EventRow, Outcome
from creak_thesis.record import RecordStudy, study_record
from creak_thesis.report.facts import Facts
from creak_thesis.report.summary import findings
from helpers_thesis import fake_outcomes

Outcomes = dict[str, Outcome]
ETAS = ("P2", "P5", "P10", "P15", "P20", "P25", "P30", "P35", "P37", "P40", "P45")


def like_the_thesis() -> Outcomes:
    """Outcomes that agree with the thesis in every finding that can be the same."""
    made = fake_outcomes(force=1.2)
    for name in ("P40", "P45"):
        made = losing(made, name, 0.3)
    made = costing(costing(made, "D90", 1.4), "C5", 0.4)
    made = forced(made, "Ref NtS", 1.5)
    return forced(made, "Red NtS", 3.0)


def forced(made: Outcomes, name: str, by: float, load: str = "") -> Outcomes:
    """Forces of a case times a factor, under one load or all."""
    loads = {
        k: replace(run, events=[replace(e, force=by * e.force) for e in run.events]) if load in ("", k) else run
        for k, run in made[name].loads.items()
    }
    return made | {name: replace(made[name], loads=loads)}


def losing(made: Outcomes, name: str, share: float) -> Outcomes:
    """Only the first events of a case."""
    loads = {}
    for k, run in made[name].loads.items():
        n = int(share * len(run.events))
        loads[k] = replace(run, events=run.events[:n], pairs=[p for p in run.pairs if p[1] < n])
    return made | {name: replace(made[name], loads=loads)}


def adding(made: Outcomes, name: str, count: int) -> Outcomes:
    """Events that the reference does not have."""
    more = [EventRow(4.97 + 1e-3 * k, 4.98, 1.0, 1.0, 1e-3) for k in range(count)]
    loads = {k: replace(run, events=[*run.events, *more]) for k, run in made[name].loads.items()}
    return made | {name: replace(made[name], loads=loads)}


def fitting(made: Outcomes, name: str, fit: float, load: str) -> Outcomes:
    loads = made[name].loads | {load: replace(made[name].loads[load], nrmse={"all": fit})}
    return made | {name: replace(made[name], loads=loads)}


def costing(made: Outcomes, name: str, by: float) -> Outcomes:
    """CPU times of a case times a factor, plain Newton's and its own."""
    return own(plain(made, name, by), name, by)


def plain(made: Outcomes, name: str, by: float) -> Outcomes:
    newton = made[name].newton
    assert newton is not None
    return made | {name: replace(made[name], newton={k: by * v for k, v in newton.items()})}


def own(made: Outcomes, name: str, by: float) -> Outcomes:
    loads = {k: replace(run, cpu_s=by * run.cpu_s) for k, run in made[name].loads.items()}
    return made | {name: replace(made[name], loads=loads)}


def modes_kept(made: Outcomes, name: str, count: int) -> Outcomes:
    mac = [1.0 if k < count else 0.3 for k in range(len(made[name].mac))]
    return made | {name: replace(made[name], mac=mac)}


def sized(made: Outcomes, name: str, n: int) -> Outcomes:
    return made | {name: replace(made[name], n=n)}


def edge_at(made: Outcomes, last_right: str, share: float) -> Outcomes:
    """Participation right up to a configuration, a share of the events beyond it."""
    fresh = fake_outcomes(force=1.2)
    for name in ETAS:
        made = made | {name: fresh["P2"]}
        if ETAS.index(name) > ETAS.index(last_right):
            made = losing(made, name, share)
    return made


def without(made: Outcomes, name: str) -> Outcomes:
    return {k: v for k, v in made.items() if k != name}


def mark(start: str, made: Outcomes, record: RecordStudy | None = None) -> str:
    (found,) = (f for f in findings(Facts(20.0, made), record) if f.thesis.startswith(start))
    assert found.rule
    return found.mark


ALIKE = like_the_thesis()
AS_GOOD = fake_outcomes(force=1.0)
RULES: list[tuple[str, str, Callable[[], Outcomes]]] = [
    ("Too many retained", "same", lambda: ALIKE),
    ("Too many retained", "explained", lambda: plain(ALIKE, "C1", 0.7)),
    ("Too many retained", "differs", lambda: plain(plain(ALIKE, "C1", 0.7), "C5", 60.0)),
    ("Too many retained", "differs", lambda: sized(plain(ALIKE, "C1", 0.7), "Ref C", 10_000_000)),
    ("Too many retained", "not run", lambda: without(ALIKE, "C5")),
    ("Retaining fewer", "same", lambda: ALIKE),
    ("Retaining fewer", "differs", lambda: modes_kept(ALIKE, "C5", 15)),
    ("Retaining fewer", "differs", lambda: modes_kept(ALIKE, "C1", 15)),
    ("Fixed-interface", "same", lambda: ALIKE),
    ("Fixed-interface", "same", lambda: fitting(ALIKE, "F1100", 0.5, "A4")),
    ("Fixed-interface", "differs", lambda: fitting(ALIKE, "F1300", 0.5, "A4")),
    ("Fixed-interface", "differs", lambda: fitting(ALIKE, "F1100", 0.5, "A2")),
    ("More unreduced", "same", lambda: ALIKE),
    ("More unreduced", "differs", lambda: fitting(ALIKE, "D90", 0.5, "A1")),
    ("More unreduced", "differs", lambda: losing(ALIKE, "D40", 0.7)),
    ("D8 finds nearly", "same", lambda: ALIKE),
    ("D8 finds nearly", "differs", lambda: losing(ALIKE, "D8", 0.8)),
    ("D8 finds nearly", "differs", lambda: adding(ALIKE, "D8", 3)),
    ("The reduced model's forces", "same", lambda: ALIKE),
    ("The reduced model's forces", "explained", lambda: AS_GOOD),
    ("The reduced model's forces", "differs", lambda: forced(AS_GOOD, "D8", 0.8, "A2")),
    ("The reduced model's forces", "differs", lambda: forced(AS_GOOD, "D8 h/4", 1.3)),
    ("The reduced model's forces", "differs", lambda: without(AS_GOOD, "D8 h/4")),
    ("The level of contact", "same", lambda: ALIKE),
    ("The level of contact", "differs", lambda: fitting(ALIKE, "D8", 0.7, "A4")),
    ("The level of contact", "differs", lambda: fitting(ALIKE, "D8", 0.99, "A4")),
    ("The level of contact", "differs", lambda: losing(ALIKE, "D8", 0.5)),
    ("Leaving out dofs", "same", lambda: ALIKE),
    ("Leaving out dofs", "explained", lambda: edge_at(ALIKE, "P15", 0.3)),
    ("Leaving out dofs", "differs", lambda: edge_at(ALIKE, "P15", 0.7)),
    ("Leaving out dofs", "differs", lambda: edge_at(ALIKE, "P45", 1.0)),
    ("Leaving out dofs", "differs", lambda: losing(ALIKE, "P10", 0.3)),
    ("A coarser mesh", "same", lambda: plain(ALIKE, "M2", 0.6)),
    ("A coarser mesh", "explained", lambda: losing(plain(ALIKE, "M2", 0.6), "M2", 0.5)),
    ("A coarser mesh", "differs", lambda: losing(losing(plain(ALIKE, "M2", 0.6), "M2", 0.5), "M2 own", 0.5)),
    ("A coarser mesh", "differs", lambda: losing(ALIKE, "M2", 0.5)),
    ("A coarser mesh", "differs", lambda: ALIKE),
    ("Node to surface gives", "same", lambda: ALIKE),
    ("Node to surface gives", "differs", lambda: forced(ALIKE, "Ref NtS", 0.6, "A3")),
    ("Reduced, node to surface", "same", lambda: ALIKE),
    ("Reduced, node to surface", "differs", lambda: forced(ALIKE, "Red NtS", 0.4, "A4")),
    ("The reduced model takes", "same", lambda: ALIKE),
    ("The reduced model takes", "explained", lambda: plain(ALIKE, "D8", 8.0)),
    ("The reduced model takes", "differs", lambda: costing(ALIKE, "D8", 8.0)),
    ("The reduced model takes", "differs", lambda: plain(ALIKE, "D8", 30.0)),
    ("The reduced model takes", "differs", lambda: sized(plain(ALIKE, "D8", 8.0), "Ref StS", 1_153_185)),
    ("The number of interface", "same", lambda: ALIKE),
    ("The number of interface", "explained", lambda: own(ALIKE, "D90", 1 / 1.4)),
    ("The number of interface", "differs", lambda: plain(ALIKE, "D90", 1 / 1.4)),
    ("Generalised interface", "explained", lambda: sized(ALIKE, "X50", 100)),
    ("Generalised interface", "differs", lambda: ALIKE),
    ("Generalised interface", "differs", lambda: without_fits(sized(ALIKE, "X50", 100))),
]


def without_fits(made: Outcomes) -> Outcomes:
    for name in ("X50", "X100", "X200"):
        made = fitting(made, name, 0.5, "A3")
    return made


@pytest.mark.parametrize(("start", "expected", "data"), RULES)
def test_a_mark_is_what_its_rule_says_of_the_data(start, expected, data):
    assert mark(start, data()) == expected


@cache
def record() -> RecordStudy:
    return study_record(duration=8.0, rate=8000.0)


@pytest.mark.parametrize(
    ("change", "expected"),
    [({}, "same"), ({"drift": 0.5}, "differs"), ({"mean": 0.1}, "differs"), ({"error_max": 0.4}, "differs")],
)
def test_the_mark_of_the_record(change, expected):
    assert mark("Integrated twice", ALIKE, replace(record(), **change)) == expected


def test_every_finding_has_a_rule_that_was_broken():
    """No finding without data that makes it differ."""
    broken = {start for start, expected, _ in RULES if expected == "differs"} | {"Integrated twice"}
    for found in findings(Facts(20.0, ALIKE), record()):
        assert any(found.thesis.startswith(start) for start in broken), found.thesis
        assert found.rule.startswith(("Same:", "Explained:", "Plain Newton. Same:", "D90 over D8. Same:"))


def test_data_like_the_thesis_is_the_same_throughout():
    made = findings(Facts(20.0, plain(sized(ALIKE, "X50", 100), "M2", 0.6)), record())
    assert {f.thesis for f in made if f.mark != "same"} == {f.thesis for f in made if f.section == "generalised"}
    assert {f.mark for f in made} == {"same", "explained"}
