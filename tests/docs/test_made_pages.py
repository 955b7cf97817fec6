"""Pages that are made from the program: all keys and names are in them, and they are up to date."""

from __future__ import annotations

import ast
import importlib
import json
import os
import subprocess
import sys
from typing import Any

import h5py
import numpy as np
import pytest
from pydantic import BaseModel

import creak
from creak.formats.stored.results import ContactRecord, Field, RunRecord, put_results
from creak.studies.file.config import StudyConfig
from helpers_docs import ROOT, tool
from helpers_measured import Measured, merge, place


def tables(model: type[BaseModel]) -> set[type[BaseModel]]:
    """A table of the study and all tables inside."""
    found = {model}
    for field in model.model_fields.values():
        for inner in _models(field.annotation):
            found |= tables(inner)
    return found


def _models(annotation: Any) -> set[type[BaseModel]]:
    if isinstance(annotation, type) and issubclass(annotation, BaseModel):
        return {annotation}
    return {m for a in getattr(annotation, "__args__", ()) for m in _models(a)}


def test_the_page_of_keys_is_up_to_date():
    study_page = tool("study_page")
    assert study_page.PAGE.read_text(encoding="utf-8") == study_page.page(), "run: python -m tools.study_page"


def test_every_key_of_a_study_is_in_its_table():
    text = tool("study_page").page()
    for table in tables(StudyConfig):
        keys = [
            name
            for name, field in table.model_fields.items()
            if table is not StudyConfig or not _models(field.annotation)
        ]
        assert keys
        assert any(all(f"\n| `{key}` |" in section for key in keys) for section in text.split("\n#")), table


@pytest.fixture(scope="module")
def verification_page():
    return tool("verification_page")


def test_the_page_of_verified_quantities_is_up_to_date(verification_page):
    pages = verification_page.pages(verification_page.read())
    for name, text in pages.items():
        assert (verification_page.DOCS / name).read_text(encoding="utf-8") == text, (
            f"docs/{name} is not that of docs/verification.json: python -m tools.verification_page"
        )
        assert len(text) < 100_000, "a page that loads and can be read"
    chapters = [key for _, sections in verification_page.CHAPTERS.values() for key in sections]
    assert sorted(chapters) == sorted(verification_page.SECTIONS), "each section stands in one chapter"
    for picture, _ in verification_page.PICTURES.values():
        assert (verification_page.DOCS / picture).stat().st_size > 10_000


def test_every_verified_quantity_passes_and_has_its_test(verification_page):
    record = verification_page.read()
    assert {row["section"] for row in record["quantities"]} == set(verification_page.SECTIONS)
    for row in record["quantities"]:
        assert verification_page.passes(row), row
    for row in [*record["quantities"], *record["curves"]]:
        assert place(row["test"])[1] >= 0, f"{row['test']} is no test: run make verification"


def test_every_test_that_records_has_a_section(verification_page):
    texts = (path.read_text("utf-8") for path in (ROOT / "tests").rglob("test_*.py"))
    named, count = set(), 0
    for text in (text for text in texts if "(measured" in text or " measured" in text):
        nodes = [*ast.walk(ast.parse(text))]
        tests = [f for f in nodes if isinstance(f, ast.FunctionDef) and "measured" in {a.arg for a in f.args.args}]
        calls = [c for f in tests for c in ast.walk(f) if isinstance(c, ast.Call) and ast.unparse(c.func) == "measured"]
        given = [a.value for a in nodes if isinstance(a, ast.Assign) and ast.unparse(a.targets[0]) == "RECORDED"]
        own = [k.value for c in calls for k in c.keywords if k.arg == "section"]
        named |= {ast.literal_eval(d)["section"] for d in given} | {ast.literal_eval(s) for s in own}
        count += len(calls)
        assert given or len(own) == len(calls)
    assert count > 200
    assert named <= {*verification_page.SECTIONS}


def test_a_quantity_out_of_tolerance_is_seen(verification_page):
    row = verification_page.read()["quantities"][0]
    for change in (
        {"difference": 3.0 * (row["high"] - row["low"])},
        {"expected": None, "low": 2.0 * abs(row["value"]) + 1.0},
    ):
        assert not verification_page.passes({**row, **change})


def test_a_record_keeps_the_worst_case_and_rows_of_tests_that_did_not_run(tmp_path):
    file, one, two = tmp_path / "record.json", Measured(), Measured()
    for value in (1.001, 0.996, 1.002):
        one("a ratio", value, 1.0, rel=0.01)
    one("frequency {}", [2.0, 3.0], [2.0, 3.1], rel=0.1)
    here = "tests/docs/test_made_pages.py::test_a_record_keeps_the_worst_case_and_rows_of_tests_that_did_not_run"
    merge(file, one, {here})
    found = json.loads(file.read_text(encoding="utf-8"))["quantities"]
    assert [(r["quantity"], r["value"]) for r in found] == [
        ("a ratio", 0.996),
        ("frequency 1", 2.0),
        ("frequency 2", 3.0),
    ]
    merge(file, two, set())
    assert json.loads(file.read_text(encoding="utf-8"))["quantities"] == found
    merge(file, two, {here})
    assert json.loads(file.read_text(encoding="utf-8"))["quantities"] == []


def test_every_public_name_is_on_the_python_page():
    python_page = tool("python_page")
    told = [name for names in python_page.GROUPS.values() for name in names]
    assert sorted(told) == sorted(creak.__all__)
    for name in told:
        module = importlib.import_module(python_page.home(name))
        assert getattr(module, name).__doc__


@pytest.mark.parametrize("name", ["report_tools", "stepping"])
def test_every_name_of_a_public_module_is_on_the_python_page(name):
    module, text = importlib.import_module(f"creak.{name}"), tool("python_page").page()
    assert module.__doc__ in text
    for public in module.__all__:
        value = getattr(module, public)
        where = f"::: {getattr(value, '__module__', '')}.{public}\n"
        assert where in text or f"`{public}`" in module.__doc__, f"{public} is neither documented nor in the words"


def test_docstrings_become_lists():
    pytest.importorskip("griffe", reason="mkdocstrings is not installed: pip install 'creak[docs]'")
    text = tool("docstring_sections").markdown(
        "Do it.\n\nParameters\n----------\nK, M : matrices\n    of one size.\ncount : modes. f_max : Hz.\n\n"
        "Raises\n------\nInputError : no modes.\n\nThe end."
    )
    assert text == (
        "Do it.\n\n**Parameters**\n\n- `K, M`: matrices of one size.\n- `count`: modes.\n- `f_max`: Hz.\n\n"
        "**Raises**\n\n- `InputError`: no modes.\n\nThe end."
    )


def test_every_example_has_a_page_with_its_code():
    gallery = tool("gallery")
    pages = gallery.pages()
    names = {p.stem for p in (ROOT / "examples").glob("*.py")}
    assert set(pages) == {f"gallery/{name}.md" for name in names} | {"gallery/index.md"}
    assert set(gallery.QUICK) <= names
    for name in names:
        assert f"]({name}.md)" in pages["gallery/index.md"]
        assert (f"]({name}.png)" in pages["gallery/index.md"]) == (name in gallery.pictures())
    for name in names:
        assert pages[f"gallery/{name}.md"].startswith("# ")
        assert "def main(" in pages[f"gallery/{name}.md"]


def test_every_field_of_results_is_documented(tmp_path):
    """A file with friction and a field, written as `creak run` writes it."""
    one, index = np.zeros((2, 1)), np.zeros(1, dtype=np.int64)
    two, time = np.zeros((2, 2)), np.arange(2.0)
    contact = ContactRecord(np.arange(2), time, index, one, one, index, two, two)
    field = Field(time, iter([(slice(0, 2), np.zeros((2, 1, 3)))]), index, np.zeros((1, 3)))
    run = RunRecord(
        time,
        one,
        one,
        one,
        one,
        two,
        two,
        contact,
        np.zeros((2, 1, 6)),
        index,
        ["1"],
        ["c:1"],
        index,
        one,
        ["kinetic"],
        field,
    )
    put_results(tmp_path / "results.h5", {"reduced": run}, {"creak": "0"}, "mm-t-s")
    names: list[str] = []
    with h5py.File(tmp_path / "results.h5") as file:
        file["runs/reduced"].visititems(
            lambda name, item: names.append(name) if isinstance(item, h5py.Dataset) else None
        )
    page = (ROOT / "docs" / "results.md").read_text(encoding="utf-8")
    assert len(names) > 15
    for name in names:
        assert f"`{name}`" in page, name


def test_the_site_builds_without_a_warning(tmp_path, monkeypatch):
    pytest.importorskip("mkdocs", reason="mkdocs is not installed: pip install 'creak[docs]'")
    pytest.importorskip("material", reason="mkdocs-material is not installed: pip install 'creak[docs]'")
    pytest.importorskip("mkdocstrings", reason="mkdocstrings is not installed: pip install 'creak[docs]'")
    if not (ROOT / "mkdocs.yml").exists():
        pytest.skip("mkdocs.yml belongs to the source tree")
    found = subprocess.run(
        [sys.executable, "-m", "mkdocs", "build", "--strict", "--quiet", "--site-dir", str(tmp_path / "site")],
        cwd=ROOT,
        capture_output=True,
        text=True,
        check=False,
        timeout=300,
        env={**os.environ, "NO_MKDOCS_2_WARNING": "1"},
    )
    assert found.returncode == 0, found.stdout + found.stderr
    pages = list((tmp_path / "site").rglob("*.html"))
    assert len(pages) > 30
    for page in pages:
        text = page.read_text(encoding="utf-8")
        assert 'src="http' not in text, page  # nothing comes from the network
        assert '<link rel="stylesheet" href="http' not in text, page
