"""Pages made of the record of `benchmarks.evidence`: up to date, and an error where their sentences are not true."""

from __future__ import annotations

import copy
import re

import pytest

from creak.studies.advise.evidence import record
from helpers_docs import PAGES, ROOT, text_of, tool


@pytest.fixture(scope="module")
def evidence_pages():
    pytest.importorskip("jinja2", reason="jinja2 is not installed: pip install 'creak[report]'")
    return tool("evidence_pages")


def test_the_pages_are_those_of_the_record(evidence_pages):
    for name in evidence_pages.PAGES:
        assert text_of(evidence_pages.DOCS / name) == evidence_pages.page(name, record()), "run: make docs"
    assert (evidence_pages.DOCS / "accuracy.png").stat().st_size > 10_000


def test_another_record_makes_other_pages(evidence_pages):
    """One figure changed, and the table that shows it changes."""
    changed = copy.deepcopy(dict(record()))
    row = next(r for r in changed["door"]["reductions"] if r["name"] == "Craig-Bampton 15 x")
    row["unknowns"] += 7
    for name in ("guidelines.md", "reduction.md"):
        found = evidence_pages.page(name, changed)
        assert f"{row['unknowns']:,}" in found
        assert found != evidence_pages.page(name, record())


@pytest.mark.parametrize(
    ("page", "case", "change"),
    [
        ("guidelines.md", "Craig-Bampton 15 x", {"impulse_error": 0.2}),
        ("guidelines.md", "Guyan", {"missed": 0}),
        ("reduction.md", "spacing 2", {"missed": 0, "extra": 0}),
        ("reduction.md", "keep_out 40", {"impulse_error": 0.5}),
    ],
)
def test_a_sentence_that_is_no_longer_true_is_an_error(evidence_pages, page, case, change):
    changed = copy.deepcopy(dict(record()))
    next(r for r in changed["door"]["reductions"] if r["name"] == case).update(change)
    with pytest.raises(ValueError, match="does not bear out"):
        evidence_pages.page(page, changed)


def test_a_step_that_would_find_all_events_is_an_error(evidence_pages):
    changed = copy.deepcopy(dict(record()))
    changed["contact"]["steps"]["rows"][0]["missed"] = 0
    with pytest.raises(ValueError, match="does not bear out"):
        evidence_pages.page("contact_convergence.md", changed)


def test_no_page_speaks_of_another_door():
    for page in [*PAGES, *(ROOT / "tools" / "pages").glob("*.j2")]:
        assert not re.search(r"(earlier|older|former)\s+(shape|door)", text_of(page)), page.name


@pytest.mark.parametrize(
    ("value", "digits", "text"),
    [(0.0186, 3, ".0186"), (1.04, 2, "1.0"), (9.96, 2, "10"), (1234.0, 2, "1,200"), (0.0, 2, "0"), (None, 2, "-")],
)
def test_numbers_of_the_pages(evidence_pages, value, digits, text):
    assert evidence_pages.short(value, digits) == text


def test_signs_of_the_pages(evidence_pages):
    assert [evidence_pages.signed(x) for x in (0.0146, -0.5, None)] == ["+1.5", "-50", "-"]
