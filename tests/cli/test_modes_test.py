"""`creak modes --test`: table, page, figures for machines, and one message for each wrong input."""

from __future__ import annotations

import json
import re
from dataclasses import replace

import numpy as np
import pytest

from helpers_modal import (
    COUNT,
    complex_mode,
    csv_text,
    every_mode,
    frames_2420,
    measured_strip,
    normal_mode,
    points_15,
    strip_deck,
    units_164,
)


@pytest.fixture(scope="module")
def strip(tmp_path_factory):
    deck = strip_deck(tmp_path_factory.mktemp("strip"))
    return deck, measured_strip(deck)[1]


def test_table_page_and_figures(creak, strip, tmp_path, monkeypatch):
    deck, t = strip
    monkeypatch.setenv("COLUMNS", "80")
    test, page, figures = tmp_path / "test.unv", tmp_path / "new" / "page.html", tmp_path / "c.json"
    slow = replace(t, frequencies=t.frequencies / np.array([1.0, 1.02, 1.1, 1.0, 1.0, 1.0]))
    test.write_text(points_15(t) + every_mode(slow))
    said = creak("modes", deck, "--test", test, "--page", page, "--json", figures).done()
    table = [line for line in said.out.splitlines() if line[:1] in "│┃┏┡└"]
    assert len(table) == COUNT + 4
    assert max(map(len, table)) <= 80
    assert f"5 of {COUNT} measured modes fit" in said.words
    assert f"not so {slow.frequencies[2]:.4g} Hz (+10.0 %, MAC 1.00)" in said.words
    data = json.loads(figures.read_text())["correlation"]
    assert [p["model"] for p in data["pairs"]] == [*range(1, COUNT + 1)]
    assert data["pairs"][2]["difference"] == pytest.approx(0.1, rel=1e-4)
    assert np.array(data["mac"]).shape[0] == COUNT
    assert {s["by"] for s in data["sensors"]} == {"label"}
    assert data["sentence"] in " ".join(page.read_text(encoding="utf-8").split())


@pytest.mark.parametrize("axes", [("x", "y", "z"), ("0 1 0", "1 2 2", "0.6 0 0.8", "-x")])
def test_the_page_holds_the_measured_points_on_the_shapes(creak, strip, tmp_path, axes):
    """At each pair the points lie on the surface, and beside it: their rows move as the nodes that they are at."""
    import base64

    deck, t = strip
    test, page = tmp_path / "test.csv", tmp_path / "page.html"
    test.write_text(csv_text(t, axes))
    assert creak("modes", deck, "--test", test, "--page", page, "-q").status == 0
    text = page.read_text(encoding="utf-8")
    held = {name: json.loads(re.search(rf'id="{name}">(.*?)</script>', text, re.S)[1]) for name in ("scene", "motions")}
    count, marks = held["scene"]["count"], held["scene"]["marks"]["measured"]
    assert len(marks) == 2 * len(t.labels)
    ids = np.frombuffer(base64.b64decode(held["scene"]["ids"]), dtype="<i4")
    for motion in held["motions"]:
        u = np.frombuffer(base64.b64decode(motion["shapes"]), dtype="<i2").reshape(count, 3).astype(int)
        for row in marks:
            node = int(np.flatnonzero(ids[: marks[0]] == ids[row])[0])
            assert np.abs(u[row] - u[node]).max() <= 1
    assert len(held["motions"]) == COUNT


def test_from_python(strip, tmp_path):
    import creak

    deck, t = strip
    test = tmp_path / "test.csv"
    test.write_text(csv_text(t))
    found = creak.correlate(deck, test)
    assert isinstance(found, creak.Correlation)
    assert [p.model for p in found.pairs] == [*range(COUNT)]


def moved(t, by):
    return replace(t, points=t.points + by)


def one_off(t):
    points = t.points.copy()
    points[4] += [0.0, 0.0, 50.0]
    return replace(t, points=points, labels=[900 + n for n in t.labels])


def wave(t):
    """Modes of a rotating frame: points move on circles."""
    u = t.shapes + 1j * np.roll(t.shapes, 1, axis=2)
    return points_15(t) + "".join(complex_mode(t, k, u[k]) for k in range(COUNT))


def other(t):
    rng = np.random.default_rng(5)
    return csv_text(replace(t, shapes=rng.normal(size=t.shapes.shape)))


def swapped(t):
    """The test's z is the deck's x."""
    return csv_text(replace(t, points=t.points[:, [1, 2, 0]], labels=[900 + n for n in t.labels]))


def inches(t):
    return csv_text(replace(t, points=t.points / 25.4, labels=[900 + n for n in t.labels]))


def metres(t):
    return csv_text(replace(t, points=t.points * 1e-3, labels=[900 + n for n in t.labels]))


def left_handed(t):
    t = replace(t, frames={7: np.vstack([np.diag([1.0, 1.0, -1.0]), np.zeros(3)])})
    return frames_2420(t) + points_15(t, moved=7) + every_mode(t)


def sphere(t):
    t = replace(t, frames={7: np.vstack([np.eye(3), np.zeros(3)])}, kinds={7: 2})
    return frames_2420(t) + points_15(t, moved=7) + every_mode(t)


def lacking(t):
    t = replace(t, frames={7: np.vstack([np.eye(3), np.zeros(3)])})
    return frames_2420(t) + points_15(t, moved=8) + every_mode(t)


def split_rows(text):
    return [line.partition(",") for line in text.splitlines()[1:]]


def row(text, k, old, new):
    lines = text.splitlines()
    assert old in lines[k]
    lines[k] = lines[k].replace(old, new)
    return "\n".join(lines) + "\n"


HEAD = "frequency_hz,damping,sensor,x,y,z,direction,value"
WRONG = {
    "a sensor 50 off": (
        "csv",
        lambda t: csv_text(one_off(t)),
        ["1 of 11 sensors", "sensor 920", "is 50 mm from its nearest node, 20"],
    ),
    "inches": ("csv", inches, ["all sensors are on one spot", " mm, the model ", "times 25.4", "--test-units in"]),
    "metres": ("csv", metres, ["times 1000", "--test-units m"]),
    "units told wrong": (
        "unv",
        lambda t: (
            units_164(1.0)
            + points_15(replace(t, labels=[n + 900 for n in t.labels]))
            + every_mode(replace(t, labels=[n + 900 for n in t.labels]))
        ),
        ["times 0.001", "--test-units mm"],
    ),
    "axes swapped": ("csv", swapped, ["sensors are not on the model", "z, x, y as x, y, z of the deck"]),
    "origin elsewhere": (
        "csv",
        lambda t: csv_text(moved(replace(t, labels=[900 + n for n in t.labels]), 300.0)),
        ["They fit moved by"],
    ),
    "another structure": (
        "csv",
        other,
        ["none of the 6 measured modes has a partner", "highest MAC is", "with the model's"],
    ),
    "a rotating frame": ("unv", wave, ["6 of 6 modes are complex", "rotating frame"]),
    "cut in a mode": (
        "unv",
        lambda t: (points_15(t) + every_mode(t))[:-200],
        ["data set 55 is cut short", "test.unv:"],
    ),
    "cut in the points": ("unv", lambda t: points_15(t)[:300], ["data set 15 is cut short"]),
    "no modes": ("unv", points_15, ["no modes in it", "data sets 55"]),
    "a word among numbers": (
        "unv",
        lambda t: (points_15(t) + every_mode(t)).replace("E+00", "Exxx", 1),
        ["is no number", "test.unv:"],
    ),
    "a left-handed frame": ("unv", left_handed, ["no right-handed frame", "test.unv:"]),
    "a sphere": ("unv", sphere, ["frame 7 is of type 2", "Cartesian"]),
    "a frame that is not there": ("unv", lacking, ["frame 8 is not in the file", "there are 7"]),
    "static deflections": (
        "unv",
        lambda t: points_15(t) + every_mode(t).replace(f"{1:10d}{2:10d}{2:10d}", f"{1:10d}{1:10d}{2:10d}"),
        ["analysis type 1 are no modes"],
    ),
    "nothing moves": (
        "unv",
        lambda t: points_15(t) + normal_mode(t, 0, 0.0 * t.shapes[0]),
        ["nothing moves in any mode"],
    ),
    "labels of no nodes": (
        "unv",
        lambda t: every_mode(replace(t, labels=[n + 900 for n in t.labels])),
        ["sensor 904 has no place", "--sensors"],
    ),
    "an empty table": ("csv", lambda _: "\n", ["the table is empty", HEAD]),
    "a head alone": ("csv", lambda _: HEAD + "\n", ["has no rows"]),
    "a column missing": (
        "csv",
        lambda t: csv_text(t, head=HEAD.replace("sensor", "sensr")),
        ["no column 'sensor'", "Did you mean 'sensr'"],
    ),
    "no shapes": ("csv", lambda t: csv_text(t, head=HEAD.replace("value", "amount")), ["the shapes are not told"]),
    "half a place": ("csv", lambda t: csv_text(t, head=HEAD.replace(",z,", ",height,")), ["not all of x, y, z"]),
    "per cent as a share": (
        "csv",
        lambda t: csv_text(t, damping=100.0),
        ["damping is 1.00588", "damping_percent", "test.csv:2"],
    ),
    "a direction of no axis": (
        "csv",
        lambda t: row(csv_text(t), 4, ",x,", ",up,"),
        ["direction is 'up'", "test.csv:5"],
    ),
    "a value of no number": ("csv", lambda t: row(csv_text(t), 1, ",x,", ",x,nan,"), ["value is 'nan'", "test.csv:2"]),
    "a sensor without a value": (
        "csv",
        lambda t: "\n".join(csv_text(t).splitlines()[:-1]),
        ["sensor 39 has no value along (0, 0, 1)"],
    ),
    "a row twice": ("csv", lambda t: csv_text(t) + csv_text(t).splitlines()[-1], ["second value", "sensor 39"]),
    "a sensor at two places": (
        "csv",
        lambda t: row(csv_text(t), 40, ",0,0,", ",1,0,"),
        ["has two places", "test.csv:41"],
    ),
    "frequencies far below the model's": (
        "csv",
        lambda t: "\n".join([HEAD, *(f"{0.001 * float(f)!r},{rest}" for f, _, rest in split_rows(csv_text(t)))]),
        ["no mode of the model but rigid ones", "Are its frequencies in Hz?"],
    ),
    "another kind of file": ("xlsx", csv_text, ["measured modes in test.xlsx", ".unv"]),
}


@pytest.mark.parametrize("name", WRONG)
def test_wrong_input(creak, strip, tmp_path, name):
    deck, t = strip
    ending, text, words = WRONG[name]
    test, page = tmp_path / f"test.{ending}", tmp_path / "page.html"
    test.write_text(text(t), encoding="utf-8")
    said = creak("modes", deck, "--test", test, "--page", page, "--json", tmp_path / "c.json")
    said.refuses(*words)
    assert not page.exists()
    assert not (tmp_path / "c.json").exists()


@pytest.mark.parametrize(
    ("table", "words"),
    [
        ("sensor,nodes\n4,4\n", ["the header sensor,node"]),
        ("sensor,node\nS4,4\n", ["sensor 'S4' is not in test.csv", "map.csv:2"]),
        ("sensor,node\n4,4\n4,7\n", ["second row", "map.csv:3"]),
        ("sensor,node\n4,4000\n", ["unknown node '4000'", "map.csv:2"]),
    ],
)
def test_wrong_map(creak, strip, tmp_path, table, words):
    deck, t = strip
    (tmp_path / "test.csv").write_text(csv_text(t))
    (tmp_path / "map.csv").write_text(table)
    said = creak("modes", deck, "--test", tmp_path / "test.csv", "--sensors", tmp_path / "map.csv")
    assert said.status == 2
    assert all(word in said.words for word in words)


@pytest.mark.parametrize(
    ("options", "words"),
    [
        (["--page", "p.html"], ["--page without --test"]),
        (["--test-units", "mm"], ["--test-units without --test"]),
        (["--test", "absent.unv"], ["no such file: absent.unv"]),
    ],
)
def test_wrong_options(creak, strip, options, words):
    said = creak("modes", strip[0], *options)
    assert said.status == 2
    assert all(word in said.words for word in words)


def test_test_units_settle_what_the_file_leaves_open(creak, strip, tmp_path):
    deck, t = strip
    test = tmp_path / "test.csv"
    test.write_text(inches(t))
    said = creak("modes", deck, "--test", test, "--test-units", "in").done()
    assert "lengths of the test are taken times 25.4" in said.words
