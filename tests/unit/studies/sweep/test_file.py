"""Sweep files: what they may say, and what is said about mistakes."""

from __future__ import annotations

import codecs
from pathlib import Path

import pytest

from creak.errors import InputError
from creak.studies.file.reader import read_study
from creak.studies.sweep.cases import resolve
from creak.studies.sweep.file import read_sweep
from helpers_decks import write_strips
from helpers_refusal import refusal

GOOD = """title = "all"
base = "study.toml"
seeds = [1, 2]
[grid]
"reduction.f_max" = [2000, 3000]
[[case]]
name = "stiff"
changes = { "contact.tip.stiffness" = 50.0 }
"""


def swept(folder: Path, text: str) -> Path:
    write_strips(folder)
    path = folder / "sweep.toml"
    path.write_text(text, encoding="utf-8")
    return path


def test_a_good_file(tmp_path):
    sweep = read_sweep(swept(tmp_path, GOOD))
    assert sweep.config.grid == {"reduction.f_max": [2000, 3000]}
    assert sweep.config.case[0].changes == {"contact.tip.stiffness": 50.0}
    assert sweep.keys == ["reduction.f_max", "contact.tip.stiffness"]
    assert sweep.study.title == "Two strips"
    assert sweep.where("contact.tip.stiffness").endswith("sweep.toml:8")
    assert sweep.where("reduction.f_max").endswith("sweep.toml:5")


def test_the_mark_of_an_editor_before_the_text_changes_nothing(tmp_path):
    """Some put a mark before UTF-8: study and sweep are read as without it, with the same identities."""
    path = swept(tmp_path, GOOD)
    before = read_sweep(path), resolve(read_sweep(path), tmp_path / "out")
    for name in ("study.toml", "sweep.toml"):
        text = (tmp_path / name).read_text(encoding="utf-8")
        (tmp_path / name).write_text(text, encoding="utf-8-sig")
    assert (read_sweep(path), resolve(read_sweep(path), tmp_path / "out")) == before
    assert read_study(tmp_path / "study.toml").text == text_without_mark(tmp_path / "study.toml")


def text_without_mark(path: Path) -> str:
    return path.read_bytes().removeprefix(codecs.BOM_UTF8).decode("utf-8")


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ('base = "study.toml"\nseed = [1]', ["sweep.toml:2", "unknown key 'seed'", "Did you mean 'seeds'?"]),
        ('base = "study.toml"\n[[case]]\nnam = "a"', ["sweep.toml:3", "unknown key 'case.0.nam'", "'name'"]),
        ("seeds = [1]", ["'base' is missing"]),
        ('base = "study.toml"\nseeds = [-1]', ["sweep.toml:2", "greater than or equal to 0"]),
        ('base = "study.toml"', ["changes nothing"]),
        ('base = "study.toml"\nseeds = [3, 3]', ["seeds lists 3 twice"]),
        ('base = "study.toml"\n[grid]\n"reduction.f_max" = 3', ["sweep.toml:3", "a list in brackets"]),
        ('base = "study.toml"\n[grid]\n"reduction.f_max" = []', ["sweep.toml:3", "at least 1"]),
        ('base = "study.toml"\n[grid]\nreduction.f_max = [3]', ['one by one and in quotes: "reduction.f_max"']),
        ('base = "study.toml"\n[[case]]\nname = "a"\nchanges = { reduction.f_max = 3 }', ['"reduction.f_max"']),
        ('base = "study.toml"\n[grid]\n"time.step" = [1e-4]\nseeds = [1]', ["'seeds' belongs to the sweep"]),
        ('base = "study.toml"\n[[case]]\nname = "a"\nseeds = [1]', ["'seeds' belongs to the sweep"]),
        ('base = "study.toml"\n[[case]]\n', ["a name or changes"]),
        ('base = "study.toml"\n[grid]\n"a.b" = [1]\n"a.b.c" = [1]', ["both 'a.b' and 'a.b.c'"]),
        ('base = "study.toml"\n[grid]\n"a.b" = [1]\n[[case]]\nchanges = { "a.b" = 3 }', ["'a.b'", "changes too"]),
        (
            'base = "study.toml"\nseeds = [3]\n[grid]\n"excitation.root.signal.seed" = [7, 8]',
            ["seeds and", "signal.seed'"],
        ),
        (
            'base = "study.toml"\nseeds = [3]\n[[case]]\nchanges = { "excitation.root.signal" = '
            '{ type = "multisine", f_max = 50, amplitude = 1, seed = 7 } }',
            ["seeds and 'excitation.root.signal'", "give one of them"],
        ),
        ('base = "other.toml"\nseeds = [1]', ["no such study file", "other.toml"]),
        ("base = ", ["not valid TOML"]),
    ],
)
def test_mistakes_are_explained(tmp_path, text, words):
    said = str(refusal(read_sweep, swept(tmp_path, text)))
    for word in words:
        assert word in said


def test_a_wrong_base_study_is_explained_with_its_own_line(tmp_path):
    path = swept(tmp_path, GOOD)
    study = tmp_path / "study.toml"
    study.write_text(study.read_text().replace("f_max = 3000", "f_mx = 3000"))
    with pytest.raises(InputError, match=r"study\.toml:\d+: unknown key 'reduction.f_mx'"):
        read_sweep(path)
