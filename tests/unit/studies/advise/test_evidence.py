"""One record behind advice and pages: its figures are in the words, no figure stands beside it."""

from __future__ import annotations

import ast
import copy
import re
from pathlib import Path
from typing import Any

import pytest

import creak.studies.advise
from creak.progress import silent
from creak.studies.advise import choice, evidence, words
from creak.studies.advise.choice import ALL, ASSEMBLY, ENOUGH
from creak.studies.advise.evidence import case, doors, measured, points, record, step_evidence, steps
from creak.studies.advise.facts import Facts, gather
from creak.studies.file.reader import read_study
from creak.studies.prepare.setup import Setup, set_up
from creak_thesis.door import LOADS, build_door
from helpers_advise import settings_of
from helpers_decks import STUDY, write_strips

SETTLED = 0.05
"""Share of its impulse to which an event is settled by default."""
EXACT = STUDY.replace('integrator = "hht"\n', "").replace("step = 5e-4\n", "")
CACHES = (evidence.record, evidence.points, evidence.steps)
FIGURE = re.compile(r"\d *%|\d of \d|\d unknowns|\d events|\d times (left|the speed)")
"""What would be a measurement."""


@pytest.fixture(scope="module")
def exact(tmp_path_factory) -> tuple[Setup, Facts]:
    setup = set_up(read_study(write_strips(tmp_path_factory.mktemp("strips"), None, EXACT)))
    assert setup.study.config.time.exact
    return setup, gather(setup, silent)


@pytest.fixture
def other_record(monkeypatch):
    """Replaces the record by a changed one."""

    def clear() -> None:
        for cached in CACHES:
            getattr(cached, "cache_clear", lambda: None)()

    def put(changed: Any) -> None:
        clear()
        for module in (evidence, words, choice):
            if hasattr(module, "record"):
                monkeypatch.setattr(module, "record", lambda: changed)

    yield put
    monkeypatch.undo()
    clear()


def scaled(value: Any, by: float) -> Any:
    """All errors of a record times a factor."""
    if isinstance(value, dict):
        return {k: by * v if k.endswith("_error") and v is not None else scaled(v, by) for k, v in value.items()}
    return [scaled(v, by) for v in value] if isinstance(value, list) else value


def said(setup: Setup, facts: Facts) -> str:
    return "\n".join(choice.choose(settings_of(setup), facts).because)


def test_each_part_of_the_record_says_where_it_comes_from():
    for part in record():
        made = record()[part]["made"]
        assert made.keys() == {"creak", "commit", "date", "machine", "command"}
        assert re.fullmatch(r"[0-9a-f]{7,}", made["commit"])  # nothing was changed since that commit
        assert made["command"].startswith("python -m benchmarks.evidence")


def test_the_record_is_of_the_door_of_today():
    """The loads and the mesh's size are those that `creak example door` writes."""
    for found in doors(record()):
        assert found["amplitudes"] == {load: LOADS[load] for load in ("A2", "A3", "A4")}
    assert record()["door"]["dofs"] == build_door(record()["door"]["mesh_size"]).n_dof


def test_points_are_the_rows_of_the_record_the_worse_of_both_doors():
    for method, family in evidence.FAMILIES.items():
        for p in points()[method]:
            rows = [
                row
                for door in doors(record())
                for row in door["reductions"]
                if row["name"] == f"{family} {p.multiple:g} x"
            ]
            assert p.impulse_error == max(row["impulse_error"] for row in rows)
            assert p.force_error == max(row["force_error"] for row in rows)
    assert len(points()["craig-bampton"]) == 6


def test_what_is_advised_was_good_enough():
    """Half of what an event is settled to, with the multiples that are advised; all of it where it is left as it is."""
    for method, multiple, limit in (
        ("craig-bampton", ALL, 0.5 * SETTLED),
        ("craig-bampton", ENOUGH, SETTLED),
        ("gap-modes", ASSEMBLY, SETTLED),
    ):
        found = measured(method, multiple)
        assert found is not None
        assert found.impulse_error < limit, (method, multiple)


def test_words_of_steps_are_those_of_the_record():
    rows = {(r["scheme"], r["step"]): r for r in record()["contact"]["steps"]["rows"]}
    assert [s.per_period for s in steps()] == pytest.approx([10.0, 40.0, 100.0])
    for s, h in zip(steps(), (1e-3, 2.5e-4, 1e-4), strict=True):
        assert s.hht.startswith(f"{rows['HHT', h]['matched']} of {rows['HHT', h]['reference']} events")
    assert step_evidence(9.0) is None
    assert step_evidence(50.0) == steps()[1]


def test_advice_of_the_default_tells_what_matters(exact):
    text = said(*exact)
    rows = {(r["kind"], r["factor"]): r for r in record()["contact"]["physics"]}
    assert "steps: accuracy = 'settled' chooses them" in text
    assert f"{rows['damping', 0.5]['events']} and {rows['damping', 2.0]['events']} events for" in text
    assert f"{rows['load', 0.9]['events']} and {rows['load', 1.1]['events']} events for" in text
    assert re.search(r"^stiffness: .*half and twice of it changed", text, flags=re.MULTILINE)
    assert "substeps" not in text
    modes = case(record(), "gap modes 7 x")
    assert f"{modes['unknowns']:,} unknowns and {100 * modes['impulse_error']:.2g} %" in text


def test_words_follow_the_record(exact, other_record):
    """Twice the errors in the record: every figure that was one of them is twice as large in the advice."""
    before = said(*exact)
    changed = scaled(copy.deepcopy(dict(record())), 2.0)
    expected = [
        f"{100 * 2.0 * max(c['impulse_error'] for c in rows):.2g} %"
        for m in (3, 7)
        for rows in [[r for d in doors(record()) for r in d["reductions"] if r["name"] == f"gap modes {m} x"]]
    ]
    other_record(changed)
    after = said(*exact)
    assert after != before
    for figure in expected:
        assert figure in after


def test_no_figure_stands_beside_the_record():
    """No text of the advice holds a measurement of its own; the thesis's are its own."""
    folder = Path(creak.studies.advise.__path__[0])
    for file in sorted(folder.glob("*.py")):
        for text in strings(file.read_text(encoding="utf-8")):
            assert not FIGURE.search(text), f"{file.name}: {text}"


def strings(source: str) -> list[str]:
    """Constants that are no docstrings."""
    tree = ast.parse(source)
    alone = {id(n.value) for n in ast.walk(tree) if isinstance(n, ast.Expr)}
    return [
        n.value
        for n in ast.walk(tree)
        if isinstance(n, ast.Constant) and isinstance(n.value, str) and id(n) not in alone
    ]


def test_a_figure_of_its_own_would_be_seen():
    assert [t for t in strings('"""7 %"""\nx = f"left {y} and 2.6 % of it"\n') if FIGURE.search(t)]
    assert not [t for t in strings('"""7 %"""\n') if FIGURE.search(t)]
