"""`creak modes --test` with frequency response functions: table, page, figures, and one message for each wrong input."""

from __future__ import annotations

import json
import re

import numpy as np
import pytest

from helpers_frfs import FREQ, accelerance, function, masses_deck, points, receptance, units


@pytest.fixture(scope="module")
def deck(tmp_path_factory):
    return masses_deck(tmp_path_factory.mktemp("masses"))


def good() -> bytes:
    gamma = np.full(FREQ.size, 0.98)
    return b"".join(
        [
            (units(1.0) + points(1e-3)).encode(),
            function(accelerance(2, 2), (2, 1)),
            function(-2.0 * accelerance(3, 2), (3, 1), binary="<"),
            function(gamma, (3, 1), kind=6, data=4, quantity=0, over=0),
        ]
    )


def test_table_page_and_figures(creak, deck, tmp_path, monkeypatch):
    monkeypatch.setenv("COLUMNS", "80")
    test, page, figures = tmp_path / "test.unv", tmp_path / "page.html", tmp_path / "c.json"
    test.write_bytes(good())
    said = creak("modes", deck, "--test", test, "--page", page, "--json", figures).done()
    table = [line for line in said.out.splitlines() if line[:1] in "│┃┏┡└"]
    assert len(table) == 6
    assert max(map(len, table)) <= 80
    assert "1 of 2 frequency response functions fit" in said.words
    assert "3 X / 2 X (FRAC 1.00, −6.0 dB, 180 degrees)" in said.words
    assert "damping is that of the deck" in said.words
    data = json.loads(figures.read_text())
    assert "correlation" not in data
    first, second = data["frfs"]["functions"]
    assert first["model"]["magnitude"] == pytest.approx(np.abs(accelerance(2, 2)).tolist(), rel=1e-6)
    assert (second["frac"], second["level_db"]) == pytest.approx((1.0, -6.0206), abs=1e-4)
    assert second["coherence"] == pytest.approx([0.98] * FREQ.size)
    assert (first["quantity"], first["coherence"]) == ("accelerance", None)
    assert data["frfs"]["error"] < 1e-6
    text = page.read_text(encoding="utf-8")
    assert data["frfs"]["sentence"] in " ".join(text.split())
    spec = json.loads(re.search(r'id="specs">(.*?)</script>', text, re.S)[1])["frfs"]
    (drawn,) = (t for t in spec["data"] if t["name"] == "model" and t["visible"] and t["yaxis"] == "y")
    assert drawn["y"] == pytest.approx((20.0 * np.log10(np.abs(accelerance(2, 2)))).tolist(), abs=1e-3)
    assert {t["meta"] for t in spec["data"]} == {0, 1}
    assert len(re.findall(r'<option value="\d" data-title="dB re 1 m/s²/N">', text)) == 2


def test_functions_end_where_the_modes_do(creak, deck, tmp_path):
    test, figures = tmp_path / "test.unv", tmp_path / "c.json"
    test.write_bytes(good())
    assert creak("modes", deck, "--test", test, "--f-max", "20", "--json", figures).status == 0
    ends = [f["frequency"][-1] for f in json.loads(figures.read_text())["frfs"]["functions"]]
    assert ends == [20.0, 20.0]


def test_from_python(deck, tmp_path):
    import creak

    (tmp_path / "test.unv").write_bytes(good())
    found = creak.compare_frfs(deck, tmp_path / "test.unv", f_max=40.0)
    assert isinstance(found, creak.FrfComparison)
    assert [p.frac for p in found.pairs] == pytest.approx([1.0, 1.0])
    with pytest.raises(creak.InputError, match=r"no modes in it.*compare_frfs"):
        creak.correlate(deck, tmp_path / "test.unv")


def text(*parts) -> bytes:
    return b"".join(p.encode() if isinstance(p, str) else p for p in parts)


H = accelerance(3, 2)
M = units(1.0) + points(1e-3)
WRONG = {
    "no partner node": (text(units(1.0), function(H, (7, 1))), ["sensor 7 has no place, and no node", "--sensors"]),
    "off the model": (
        text(units(1.0), points(2e-3).replace(f"{3:10d}", f"{9:10d}", 1), function(H, (9, 1))),
        ["sensor 9 at", "from its nearest node"],
    ),
    "points in inches": (
        text(points(1.0 / 25.4).replace(f"{3:10d}", f"{9:10d}", 1), function(H, (9, 1))),
        ["all sensors are on one spot", "--test-units in"],
    ),
    "inches beside metres": (
        text(M, function(H, labels=("in/s^2", "N"))),
        ["a function in in/s^2, where data set 164 tells 1 units in 1 m", "test.unv:"],
    ),
    "pounds beside newtons": (text(M, function(H, labels=("m/s^2", "lbf"))), ["a function in lbf"]),
    "a unit of another kind": (text(M, function(H, labels=("m", "N"))), ["of kind 12 in m"]),
    "kind and unit unknown": (text(M, function(H, quantity=0)), ["does not tell what was measured"]),
    "cut": (text(M, function(H))[:-400], ["a function is cut short", "test.unv:"]),
    "fewer values": (
        text(M, function(H[:50], freq=FREQ[:50])).replace(b"        50  ", b"        90  "),
        ["cut short"],
    ),
    "binary, cut": (text(M, function(H, binary="<"))[:-300], ["a function is cut short"]),
    "binary, of VMS": (
        text(M, function(H, binary="<")).replace(b"58b     1     2", b"58b     1     1"),
        ["byte order 1 and format 1", "IEEE"],
    ),
    "binary, its head cut": (text(M, b"    -1\n    58b     1\n    -1\n"), ["head of a binary function"]),
    "a spectrum": (text(M, function(np.abs(H), kind=2, data=4)), ["none of its 1 functions", "an auto spectrum"]),
    "a transmissibility": (text(M, function(H, over=12)), ["kind 12 over kind 12", "over force"]),
    "real values": (text(M, function(np.abs(H), data=4)), ["with real values"]),
    "no direction": (text(M, function(H, (3, 0))), ["without direction"]),
    "a moment": (text(M, function(H, (3, 1), (2, 4))), ["rotations or moments"]),
    "of time": (text(M, function(H, abscissa=17)), ["not over frequency"]),
    "a node that is held": (text(M, function(H, (1, 1))), ["node 1 of sensor 1 cannot move", "test.unv:"]),
    "frequencies in weeks": (
        text(M, function(H, over_unit="weeks")),
        ["the frequencies of the function 3 X / 2 X are in weeks", "one of Hz, kHz", "test.unv:"],
    ),
    "across the springs": (text(M, function(H, (3, 2))), ["node 3 of sensor 3 cannot move"]),
    "coherence elsewhere": (
        text(M, function(H), function(np.ones(9), kind=6, data=4, freq=FREQ[:9])),
        ["a coherence at other frequencies"],
    ),
    "frequencies that fall": (text(M, function(H, freq=FREQ[::-1], even=False)), ["abscissa does not rise"]),
    "a frame that is not there": (
        text(
            units(1.0),
            points(1e-3, frame=5),
            "    -1\n  2420\n         1\nP\n         2         0         8\nC\n"
            + "".join("".join(f"{v:25.16E}" for v in row) + "\n" for row in np.vstack([np.eye(3), np.zeros(3)]))
            + "    -1\n",
            function(H),
        ),
        ["frame 5 is not in the file"],
    ),
    "a word among numbers": (text(M, function(H)).replace(b"E-01", b"Exxx", 1), ["is no number", "test.unv:"]),
    "above all modes": (text(M, function(H)), ["no function has two frequencies between 0 and 0.5 Hz"]),
}


@pytest.mark.parametrize("name", WRONG)
def test_wrong_input(creak, deck, tmp_path, name):
    data, words = WRONG[name]
    test, page = tmp_path / "test.unv", tmp_path / "page.html"
    test.write_bytes(data)
    options = ["--f-max", "0.5"] if name == "above all modes" else []
    said = creak("modes", deck, "--test", test, "--page", page, "--json", tmp_path / "c.json", *options)
    said.refuses(*words)
    assert not page.exists()
    assert not (tmp_path / "c.json").exists()


def test_undamped_decks_say_so(creak, deck, tmp_path):
    bare = tmp_path / "bare.bdf"
    bare.write_text("".join(line for line in deck.read_text().splitlines(True) if "CDAMP" not in line))
    test = tmp_path / "test.unv"
    test.write_bytes(text(M, function(receptance(3, 2, damped=False), quantity=8)))
    said = creak("modes", bare, "--test", test).done()
    assert "neither test nor deck tells damping" in said.words
    assert "1 of 1 frequency response function fit" in said.words
