"""Each mistake ends in one message that says what, where and what to do; exit status 2; nothing written.

Memory that does not suffice, and figures that are no numbers, in words.
"""

from __future__ import annotations

import json
import os
import re

import numpy as np
import pytest
from scipy import sparse

from creak.cli import main as command
from creak.cli.output import Output
from creak.errors import NumericalError
from creak.formats import decks
from creak.linalg import factor as linalg
from helpers_decks import STUDY, two_strips, write_strips

pytestmark = pytest.mark.usefixtures("no_page")


DECK_MISTAKES = {
    "element on an unknown node": (("1, 1, 2, 15, 14", "1, 1, 2, 15, 9999"), ["strips.inp:", "9999"]),
    "element without a section": (
        ("*SHELL SECTION, ELSET=LOWER, MATERIAL=STEEL\n1.5,\n", ""),
        ["strips.inp:", "section", "1001"],
    ),
    "section with an unknown material": (
        ("ELSET=LOWER, MATERIAL=STEEL", "ELSET=LOWER, MATERIAL=STEAL"),
        ["strips.inp:", "STEAL", "STEEL"],
    ),
    "zero thickness": (("MATERIAL=STEEL\n1.5,", "MATERIAL=STEEL\n0.0,"), ["strips.inp:", "thickness", "0"]),
    "negative thickness": (("MATERIAL=STEEL\n1.5,", "MATERIAL=STEEL\n-1.5,"), ["strips.inp:", "thickness", "-1.5"]),
    "zero density": (("7.85e-9,", "0.0,"), ["strips.inp:", "density", "0"]),
    "negative density": (("7.85e-9,", "-7.85e-9,"), ["strips.inp:", "density", "-7.85e-9"]),
    "unknown element type": (("TYPE=S4, ELSET=LOWER", "TYPE=S44, ELSET=LOWER"), ["strips.inp:", "S44"]),
    "surface that faces nothing": (
        ("*SURFACE, NAME=OVER\nLOWER, SPOS", "*SURFACE, NAME=OVER\nLOWER, SNEG"),
        ["[contact.tip]", "UNDER", "OVER", "never face"],
    ),
    "part that nothing holds": (("ROOT_LOWER, 1, 6\n", ""), ["strips.inp", "nothing holds", "LOWER", "*BOUNDARY"]),
    "misspelt keyword": (
        ("*BOUNDARY\n", "*BOUNDRY\n"),
        ["strips.inp:", "*BOUNDRY", "Did you mean 'BOUNDARY'? Remove it"],
    ),
    "folded shell": (
        ("1, 1, 2, 15, 14", "1, 1, 2, 14, 16"),
        ["strips.inp:", "element 1: a corner angle is not between 0 and 180"],
    ),
    "keyword that changes the answer": (
        ("*BOUNDARY\n", "*EMBEDDED ELEMENT\nLOWER\n*BOUNDARY\n"),
        ["strips.inp:", "*EMBEDDED ELEMENT", "--ignore"],
    ),
}

STUDY_MISTAKES = {
    "no such deck": (('"strips.inp"', '"stripes.inp"'), ["stripes.inp", "Did you mean 'strips.inp'"]),
    "unknown set": (('"ROOT_UPPER"', '"ROOT_UPER"'), ["study.toml:12", "ROOT_UPER", "Did you mean 'ROOT_UPPER'"]),
    "unknown surface": (('"UNDER"', '"UNDR"'), ["UNDR", "[contact.tip]", "Did you mean 'UNDER'"]),
    "misspelt key": (("secondary =", "secondry ="), ["study.toml:7", "secondry", "Did you mean 'secondary'"]),
    "misspelt table": (("[reduction]", "[reducton]"), ["study.toml:17", "reducton", "Did you mean 'reduction'"]),
    "f_max below the excitation": (("f_max = 3000", "f_max = 50"), ["study.toml:18", "50 Hz", "60 Hz", "Raise f_max"]),
    "unknown word for a stiffness": (
        ('main = "OVER"\n', 'main = "OVER"\nstiffness = "atuo"\n'),
        ["study.toml:9", "atuo", "number", "'auto' or 'hard'"],
    ),
    "multisine without a line": (("period = 0.2", "period = 0.001"), ["study.toml:15", "multiples of 1000 Hz", "none"]),
    "multisine with limits the wrong way": (
        ("f_min = 5", "f_min = 500"),
        ["study.toml:15", "500 Hz is above f_max = 60"],
    ),
    "NaN amplitude": (("amplitude = 0.05", "amplitude = nan"), ["study.toml:15", "amplitude", "nan", "finite"]),
    "unknown signal": (('"multisine"', '"multisin"'), ["study.toml:15", "multisin", "Did you mean 'multisine'"]),
    "massless boundary": (
        ("[reduction]\n", '[reduction]\nmethod = "massless-boundary"\n'),
        [
            "study.toml:18",
            "reduction.method = 'massless-boundary'",
            "has no massless boundary",
            "craig-bampton",
            "Change it",
        ],
    ),
    "massless boundary as an integrator": (
        ("[time]\n", '[time]\nintegrator = "massless-boundary"\n'),
        ["study.toml:21", "time.integrator = 'massless-boundary'", "has no massless boundary", "without integrator"],
    ),
    "friction": (('main = "OVER"\n', 'main = "OVER"\nfriction = -0.3\n'), ["study.toml:9", "friction", "-0.3", "0"]),
    "kinetic above static": (
        ('main = "OVER"\n', 'main = "OVER"\nfriction = { static = 0.2, kinetic = 0.3 }\n'),
        ["study.toml:9", "kinetic = 0.3", "static = 0.2"],
    ),
    "not TOML": (("[time]", "[time"), ["study.toml", "not valid TOML", "line"]),
    "connectors as a table": (
        ("[time]", '[connector]\ntype = "play"\n[time]'),
        ["study.toml:20", "Write [[connector]]"],
    ),
    "contact as a list": (("[contact.tip]", "[[contact]]"), ["study.toml:6", "Write [contact.NAME]"]),
    "path with backslashes": (('"strips.inp"', '"data\\strips.inp"'), ["study.toml", "line 4", "Write paths with /"]),
    "deck that is a folder": (('"strips.inp"', '"."'), ["cannot read the deck", "directory", "Check the path"]),
    "odd pairs": (('pairs = "PAIRS"', 'pairs = "ROOT_LOWER"'), ["study.toml", "ROOT_LOWER", "even"]),
}


def assert_refused(creak, study, words, tmp_path):
    before = sorted(p.name for p in tmp_path.iterdir())
    said = creak("run", study, "--quiet", "--out", tmp_path / "out")
    said.refuses()
    text = " ".join(said.err.split())
    assert text.startswith("creak: ")
    for word in words:
        assert re.search(re.escape(word), text, re.IGNORECASE), f"{word!r} not in {text!r}"
    assert sorted(p.name for p in tmp_path.iterdir()) == before


@pytest.mark.parametrize("mistake", DECK_MISTAKES)
def test_mistake_in_the_deck_is_named(creak, mistake, tmp_path):
    (old, new), words = DECK_MISTAKES[mistake]
    deck = two_strips()
    assert old in deck
    assert_refused(creak, write_strips(tmp_path, deck.replace(old, new)), words, tmp_path)


@pytest.mark.parametrize("mistake", STUDY_MISTAKES)
def test_mistake_in_the_study_is_named(creak, mistake, tmp_path):
    (old, new), words = STUDY_MISTAKES[mistake]
    assert old in STUDY
    (tmp_path / "table.csv").write_text("time,value\n0,0\n1,nan\n2,1\n", encoding="utf-8")
    study = write_strips(tmp_path, study=STUDY.replace(old, new, 1))
    assert_refused(creak, study, words, tmp_path)


def test_output_folder_that_is_a_file_is_refused_before_any_work(creak, tmp_path):
    study = write_strips(tmp_path)
    (tmp_path / "taken").write_text("", encoding="utf-8")
    creak("run", study, "--out", tmp_path / "taken" / "out").refuses("taken is a file", "--out")


@pytest.mark.parametrize("folder", ["/proc/creak", "/sys/creak"])
def test_output_folder_that_cannot_be_written_is_refused(creak, folder, tmp_path):
    creak("run", write_strips(tmp_path), "--out", folder).refuses("cannot write")


def test_study_that_is_no_text(creak, tmp_path):
    (tmp_path / "study.toml").write_bytes(bytes(range(256)))
    creak("run", tmp_path / "study.toml").refuses("it is not text in UTF-8. Give the .toml file.")


def test_no_such_study(creak, tmp_path):
    creak("run", tmp_path / "none.toml").refuses("none.toml")


@pytest.mark.parametrize("size", ["0", "-5", "41", "nan"])
def test_bad_mesh_size_of_the_door(creak, size, tmp_path):
    out = tmp_path / "door"
    said = creak("example", "door", "--mesh-size", size, "--out", out)
    assert said.status == 2
    assert "mesh size" in said.err.lower()
    assert not out.exists()


def test_unknown_command_gets_a_hint(creak):
    creak("rum").refuses("rum", "--help")


def test_a_wrong_option_names_the_help_of_its_command(creak):
    creak("robust", "study.toml", "-n", "64").refuses("No such option: -n. Try: creak robust --help")


def test_deck_as_study_is_explained(creak, tmp_path):
    write_strips(tmp_path)
    creak("run", tmp_path / "strips.inp").refuses("study")


def test_table_with_decimal_commas_is_refused(creak, tmp_path):
    (tmp_path / "table.csv").write_text("time,value\n0,0,0,0\n0,5,1,0\n", encoding="utf-8")
    signal = 'signal = { type = "multisine", f_min = 5, f_max = 60, amplitude = 0.05, period = 0.2, seed = 3 }'
    text = STUDY.replace(signal, 'signal = { type = "table", file = "table.csv" }').replace("periods = 2", "end = 0.1")
    words = ["table.csv:2", "has 4 values", "two: time,value", "Write decimals with a point"]
    assert_refused(creak, write_strips(tmp_path, study=text), words, tmp_path)


def test_table_with_nan_names_its_line(creak, tmp_path):
    (tmp_path / "table.csv").write_text("time,value\n0,0\n1,nan\n2,1\n", encoding="utf-8")
    signal = 'signal = { type = "multisine", f_min = 5, f_max = 60, amplitude = 0.05, period = 0.2, seed = 3 }'
    text = STUDY.replace(signal, 'signal = { type = "table", file = "table.csv" }').replace("periods = 2", "end = 0.1")
    assert_refused(creak, write_strips(tmp_path, study=text), ["table.csv:3", "nan", "two finite numbers"], tmp_path)


def test_a_study_from_a_pipe_is_refused_before_anything_else(creak, tmp_path):
    """As a shell gives one for <(...): no results folder is looked for beside it."""
    read, write = os.pipe()
    try:
        said = creak("run", f"/dev/fd/{read}")
    finally:
        os.close(read)
        os.close(write)
    assert said.status == 2
    assert said.err == f"creak: /dev/fd/{read} is a pipe or a device; expected a plain file. Name another file.\n"


def test_memory_is_told_with_what_was_to_be_held(creak, tmp_path, monkeypatch):
    def large(*_):
        raise MemoryError("Unable to allocate 3.24 GiB for an array with shape (20844, 20844) and data type float64")

    (tmp_path / "a.inp").write_text(two_strips())
    monkeypatch.setattr(decks, "read_model", large)
    said = creak("info", tmp_path / "a.inp")
    assert said.status == 1
    assert "out of memory (unable to allocate 3.24 GiB for an array with shape (20844, 20844)" in said.words
    assert "coarser mesh" not in said.words
    assert command._out_of_memory(MemoryError()).startswith("out of memory; ")


@pytest.mark.parametrize("code", [-2, -9])
def test_pardiso_says_memory(code, monkeypatch):
    class Library:
        def pardiso(self, *arguments):
            arguments[-1]._obj.value = code if arguments[4]._obj.value > 0 else 0

    monkeypatch.setattr(linalg, "mkl_library", Library)
    with pytest.raises(NumericalError, match=r"memory does not hold the factor of 3 equations"):
        linalg._PardisoFactor(sparse.csr_array(np.eye(3)), True)


def test_figures_that_are_no_numbers_are_null(capsys):
    Output(as_json=True).result({"mass": float("nan"), "parts": [{"mass": float("inf")}, 1.5]})
    assert json.loads(capsys.readouterr().out) == {"mass": None, "parts": [{"mass": None}, 1.5]}
