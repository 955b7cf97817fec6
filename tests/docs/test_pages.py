"""README.md and docs/: links lead somewhere, commands and options exist, programs compile and studies are valid."""

from __future__ import annotations

import re
import tomllib
from typing import Any, get_args

import pytest
import typer

from creak.cli.main import app
from creak.studies.file.config import StudyConfig
from creak.studies.file.excitation_tables import ExcitationTable
from helpers_docs import MADE, PAGES, ROOT, anchors, commands, fences, links, name_of, text_of, tool

each_page = pytest.mark.parametrize("page", PAGES, ids=name_of)
LOCAL = ("http://", "https://", "mailto:")
SWEEP = {"base", "seeds", "grid", "case"}
"""Keys of sweep files."""


@each_page
def test_links_and_anchors_lead_somewhere(page):
    for link in links(page):
        if link.startswith(LOCAL):
            continue
        file, _, anchor = link.partition("#")
        if file.split("/")[0] in MADE:
            continue
        target = (page.parent / file).resolve() if file else page
        assert target.exists(), f"{page.name}: {link}"
        if anchor:
            assert anchor in anchors(target), f"{page.name}: {link}"


def test_every_page_of_docs_is_in_the_navigation():
    text = (ROOT / "mkdocs.yml").read_text(encoding="utf-8") if (ROOT / "mkdocs.yml").exists() else ""
    if not text:
        pytest.skip("mkdocs.yml belongs to the source tree")
    told = set(re.findall(r": (\w+\.md)$", text, flags=re.MULTILINE))
    assert told - MADE == {p.name for p in PAGES} - {"README.md"}


def test_tests_that_are_named_exist():
    for page in PAGES:
        for path in re.findall(r"`((?:tests|examples|tools)/[\w/]+\.\w+)`", text_of(page)):
            assert (ROOT / path).exists(), f"{page.name}: {path}"


@each_page
def test_commands_and_options_exist(page):
    for words in commands(page):
        check(words, page.name)


def check(words: list[str], page: str) -> None:
    """The command, and each option, are those of the command line; options that stand alone are the program's own."""
    root: Any = typer.main.get_command(app)
    command, rest = root, list(words)
    while rest and hasattr(command, "commands") and not rest[0].startswith("-") and not rest[0].isupper():
        assert rest[0] in command.commands, f"{page}: creak {' '.join(words)}"
        command = command.commands[rest.pop(0)]
    known = {o for p in command.params for o in [*p.opts, *p.secondary_opts]} | {"--help"}
    for word in rest:
        for option in re.findall(r"(?<![\w-])--?[a-z][\w-]*", word):
            assert option in known, f"{page}: creak {' '.join(words)} has {option}"


def test_the_check_of_commands_can_fail():
    with pytest.raises(AssertionError, match="wobble"):
        check(["run", "study.toml", "--wobble"], "a page")
    with pytest.raises(AssertionError, match="ruin"):
        check(["ruin", "study.toml"], "a page")


def test_commands_are_found_at_all():
    found = {words[0] for page in PAGES for words in commands(page)}
    root: Any = typer.main.get_command(app)
    assert found >= set(root.commands)


@each_page
def test_python_compiles(page):
    for block in fences(page):
        if block.language == "python":
            compile(block.text, page.name, "exec")


MARKED = [(p, b) for p in PAGES for b in fences(p) if b.mark == "run"]


@pytest.mark.parametrize(("page", "block"), MARKED, ids=[f"{p.stem}-{i}" for i, (p, _) in enumerate(MARKED)])
def test_marked_python_runs(page, block, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    exec(compile(block.text, page.name, "exec"), {"__name__": "docs"})


@each_page
def test_studies_are_valid(page):
    """Whole studies as they are, excerpts beside a deck that stands in for what they leave out."""
    for block in fences(page):
        if block.language == "toml":
            tables = tomllib.loads(block.text)
            if not SWEEP & set(tables):
                StudyConfig.model_validate({"model": {"deck": "model.inp"}, **tables})


def test_every_kind_of_excitation_is_named():
    (told,) = re.findall(r"^`kind` is (.*?)\.", text_of(ROOT / "docs" / "study.md"), flags=re.MULTILINE)
    kinds = get_args(ExcitationTable.model_fields["kind"].annotation)
    assert set(re.findall(r'"([\w-]+)"', told)) == set(kinds)


def test_there_are_studies_and_programs_to_check():
    languages = [b.language for p in PAGES for b in fences(p)]
    assert languages.count("toml") > 4
    assert languages.count("python") > 5
    assert len(MARKED) > 1


@each_page
def test_tables_have_as_many_cells_in_every_row(page):
    table = 0
    for line in text_of(page).splitlines():
        row = re.sub(r"\\\||`[^`]*`", "x", line.strip())
        cells = row.count("|") if row.startswith("|") else 0
        assert not (table and cells) or cells == table, f"{page.name}: {line}"
        table = cells


def test_equations_become_mathml():
    pytest.importorskip("latex2mathml", reason="latex2mathml is not installed: pip install 'creak[docs]'")
    site_math = tool("site_math")
    blocks = [b.text for p in PAGES for b in fences(p) if b.language == "math"]
    assert len(blocks) > 8
    for text in blocks:
        made = site_math.fence(text, "math", "math", None, None)
        assert "<math" in made
        assert "\\" not in made, text  # a command that was not understood would stay
