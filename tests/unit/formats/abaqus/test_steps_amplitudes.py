"""*AMPLITUDE: kinds, files, and what is wrong with one."""

import math
import re

import numpy as np
import pytest

from creak.errors import InputError
from creak.formats.abaqus.reader import read_deck_run
from helpers_dynamic_decks import cantilever_deck

STEP = "*STEP\n*DYNAMIC\n1.E-3, 0.1\n*END STEP\n"


@pytest.fixture
def read(tmp_path):
    def reader(text):
        path = tmp_path / "deck.inp"
        path.write_text(cantilever_deck(STEP, text))
        return read_deck_run(path)[1].amplitudes["A"]

    return reader


def test_tabular_has_pairs_on_lines(read):
    a = read("*AMPLITUDE, NAME=a\n0., 0., 0.1, 1., 0.2, 3.\n0.5, 2.\n")
    assert a.kind == "tabular"
    assert np.array_equal(a.points, [[0, 0], [0.1, 1], [0.2, 3], [0.5, 2]])
    assert (a.rounding, a.absolute) == (0.25, False)


def test_smooth_and_absolute(read):
    a = read("*AMPLITUDE, NAME=A, SMOOTH=0.05, VALUE=ABSOLUTE, TIME=TOTAL TIME\n0., 0., 1., 2.\n")
    assert (a.rounding, a.absolute) == (0.05, True)


def test_smooth_step(read):
    assert read("*AMPLITUDE, NAME=A, DEFINITION=SMOOTH STEP\n0., 0., 1., 2.\n").kind == "smooth step"


def test_equally_spaced(read):
    a = read("*AMPLITUDE, NAME=A, DEFINITION=EQUALLY SPACED, FIXED INTERVAL=0.5, BEGIN=1.\n0., 4.\n8.\n")
    assert np.array_equal(a.points, [[1, 0], [1.5, 4], [2, 8]])


def test_periodic(read):
    a = read("*AMPLITUDE, NAME=A, DEFINITION=PERIODIC\n2, 62.83185307, 0.01, 0.5\n1., 2., 3., 4.\n")
    assert a.frequency == pytest.approx(10.0)
    assert (a.start, a.mean, a.cosine, a.sine) == (0.01, 0.5, (1.0, 3.0), (2.0, 4.0))
    assert math.isclose(2.0 * math.pi * a.frequency, 62.83185307)


def test_input_file(read, tmp_path):
    (tmp_path / "curve.txt").write_text("0., 0.\n1., 5.\n")
    assert read("*AMPLITUDE, NAME=A, INPUT=curve.txt\n").points[1].tolist() == [1.0, 5.0]


WRONG = {
    "*AMPLITUDE, NAME=A, DEFINITION=DECAY\n1., 2.\n": ("DEFINITION=DECAY", 0),
    "*AMPLITUDE, NAME=A, TIME=FREQUENCY\n0., 1.\n": ("TIME=FREQUENCY", 0),
    "*AMPLITUDE, NAME=A, VALUE=BOTH\n0., 1.\n": ("VALUE=BOTH", 0),
    "*AMPLITUDE, NAME=A, SMOOTH=0.6\n0., 1.\n": ("SMOOTH=0.6", 0),
    "*AMPLITUDE, NAME=A\n": ("no points", 0),
    "*AMPLITUDE, NAME=A\n0., 1., 2.\n": ("3 numbers", 1),
    "*AMPLITUDE, NAME=A\n0., 1.\n0., 2.\n": ("time 0 follows 0", 2),
    "*AMPLITUDE, NAME=A\n0., one\n": ("'one'", 1),
    "*AMPLITUDE, NAME=A, DEFINITION=SMOOTH STEP\n0., 1.\n": ("one point", 0),
    "*AMPLITUDE, NAME=A, DEFINITION=PERIODIC\n1, 0., 0., 0.\n1., 1.\n": ("circular frequency", 1),
    "*AMPLITUDE, NAME=A, DEFINITION=PERIODIC\n2, 5., 0., 0.\n1., 1.\n": ("2 coefficients for 2", 1),
    "*AMPLITUDE, NAME=A\n0., 1.\n*AMPLITUDE, NAME=a\n0., 1.\n": ("defined twice", 2),
}


@pytest.mark.parametrize("text", WRONG)
def test_wrong_amplitudes(read, text):
    what, below = WRONG[text]
    with pytest.raises(InputError, match=re.escape(what)) as caught:
        read(text)
    first = next(i for i, line in enumerate(cantilever_deck(STEP, text).splitlines(), 1) if line.startswith("*AMPL"))
    assert caught.value.where.endswith(f"deck.inp:{first + below}")


def test_parameters_that_change_it_are_listed(tmp_path):
    path = tmp_path / "deck.inp"
    path.write_text(cantilever_deck(STEP, "*AMPLITUDE, NAME=A, SCALEY=3.\n0., 1.\n"))
    model, _ = read_deck_run(path)
    assert [u.keyword for u in model.unread if u.changes_answer] == ["*AMPLITUDE, SCALEY"]
