"""A study in inches, pounds and seconds finds what the same one in millimetres and tonnes does."""

from __future__ import annotations

import re

import pytest

import creak
from creak.errors import InputError
from helpers_decks import STUDY, two_strips, write_study

MM, N = 1.0 / 25.4, 1.0 / 4.4482216152605
"""in and lbf"""
STEEL = ("210000., 0.3", "7.85e-9"), (f"{210000.0 * N / MM**2:.12g}, 0.3", f"{7.85e-9 * N / MM**4:.12g}")
"""In mm-t-s and in in-lbf-s: psi, lbf s^2/in^4."""
LISTENER = '[listener.ear]\nposition = [{}, {}, {}]\nwall = true\n[limit]\nforce = "0.2 N"\n'
HEARD = re.sub(r"step = \S+\nperiods = 2", "end = 0.15", STUDY) + '[reference]\nrun = "none"\n'


def in_inches() -> str:
    """The deck of the strips: nodes, thicknesses, material."""

    def scaled(match: re.Match[str]) -> str:
        return match[1] + ", ".join(f"{float(v) * MM:.12g}" for v in match[2].split(","))

    text = re.sub(r"(?m)^(\d+, )(-?\d+\.\d{6}, -?\d+\.\d{6}, -?\d+\.\d{6})$", scaled, two_strips())
    text = text.replace("STEEL\n1.0,", f"STEEL\n{MM:.12g},").replace("STEEL\n1.5,", f"STEEL\n{1.5 * MM:.12g},")
    for old, new in zip(*STEEL, strict=True):
        assert old in text
        text = text.replace(old, new)
    return text


def test_a_study_in_inches_finds_what_the_same_one_in_millimetres_does(tmp_path):
    (tmp_path / "mm").mkdir()
    (tmp_path / "in").mkdir()
    metric = write_study(tmp_path / "mm", HEARD + LISTENER.format(60, 10, 300), {"strips.inp": two_strips()})
    study = HEARD.replace("[contact", 'units = "in-lbf-s"\n[contact', 1).replace("0.05", f"{0.05 * MM:.12g}")
    at = [f"{x * MM:.12g}" for x in (60.0, 10.0, 300.0)]
    inches = write_study(tmp_path / "in", study + LISTENER.format(*at), {"strips.inp": in_inches()})
    of = [creak.run(path, converge=False, record=False, changes="predicted") for path in (metric, inches)]
    a, b = (one.summary for one in of)
    assert b["units"] == "in-lbf-s"
    (first, *rest), (same, *others) = (s["runs"]["reduced"]["events"] for s in (a, b))
    assert len(rest) == len(others) > 3
    assert same["t_start"] == pytest.approx(first["t_start"], rel=1e-6)
    # A modulus that is 5e-12 off moves force and impulse by .03 and .2 %: the stiff contact's steps fall otherwise.
    assert same["force_place"] == pytest.approx(first["force_place"] * N, rel=1e-2)
    assert same["impulse"] == pytest.approx(first["impulse"] * N, rel=1e-2)
    heard, now = (s["sound"]["listeners"][0]["places"][0] for s in (a, b))
    assert now["n5"] == pytest.approx(heard["n5"], rel=1e-2)
    metric_limit, limit = a["limits"][0], b["limits"][0]
    assert (metric_limit["unit"], limit["unit"]) == ("N", "lbf")
    assert limit["allowed"] == pytest.approx(0.2 * N)
    assert len(limit["failed"]) == len(metric_limit["failed"]) == 1
    told = re.sub(r"(?s)<script.*?</script>|<pre.*?</pre>", "", of[1].page(animation_mb=0.0))
    assert " lbf" in told
    assert re.search(r"\d\s(N|mm|mJ|MPa)\b", told) is None


def test_inches_called_millimetres_are_refused_with_their_name(tmp_path):
    path = write_study(tmp_path, HEARD, {"strips.inp": in_inches()})
    with pytest.raises(
        InputError, match=r"in mm-t-s, but material STEEL .* is in in-lbf-s.* set .model. units = .in-lbf-s."
    ):
        creak.run(path)
