"""Recordings beside what a run computed: two strips that hit each other, and the run's own sound as a recording."""

from __future__ import annotations

import json

import numpy as np
import pytest

import creak
from creak.errors import InputError
from creak.formats.stored.sound import read_sound
from creak.formats.wav import write_wav
from creak.report.sounds_beside import reasons, rows
from creak.sound.quality import FIGURES
from helpers_cli import caller
from helpers_decks import STUDY, write_strips

BASE = STUDY.replace("step = 5e-4\nperiods = 2", 'end = 0.5\naccuracy = "quick"\n[reference]\nrun = false\n')
BASE = BASE.replace("0.05,", "0.1,") + '[listener.driver]\nposition = [60, 200, 500]\nparts = "LOWER"\n'
LIMITS = """
[limit]
n10 = "1e4 sone"
sharpness = "0.1 acum"
sharp_time = "10 s"
roughness = "0.01 asper"
prominence = 1
impulse_adjustment = "100 dB"
"""


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    folder = tmp_path_factory.mktemp("beside")
    write_strips(folder, study=BASE + LIMITS)
    result = creak.run(creak.read_study(folder / "study.toml"), converge=False, record=False)
    result.save(folder / "results")
    result.report(folder / "report.html")
    sound = read_sound(folder / "results")
    write_wav(folder / "again.wav", sound.pressure[0, -1].astype(float), samples="float")
    write_wav(folder / "louder.wav", 3.0 * sound.pressure[0, -1].astype(float), samples="float")
    hiss = 0.02 * np.random.default_rng(5).standard_normal(24_000)
    write_wav(folder / "hiss.wav", hiss)
    return folder


@pytest.fixture(scope="module")
def summary(folder):
    return json.loads((folder / "results" / "summary.json").read_text())


def test_figures_of_each_place_stand_in_summary_and_page(folder, summary):
    place = summary["runs"]["reduced"]["places"][0]
    own = summary["sound"]["listeners"][0]["places"][0]
    assert [place[name] for name in FIGURES] == [own[name] for name in FIGURES]
    assert place["n5"] >= place["n10"] > 0.0
    assert place["sharpness"] > 0.2
    assert place["prominence"] > 3.0
    assert place["impulse_adjustment"] == pytest.approx(max(0.0, 1.8 * (place["prominence"] - 5.0)))
    assert all((place[name] is None) == (name in place["figures_missing"]) for name in FIGURES)
    page = (folder / "report.html").read_text(encoding="utf-8")
    assert "Every figure of what is heard" in page
    assert "sharpness, acum; roughness, asper; prominence P" in page


def test_limits_take_each_of_them(summary):
    found = {one["limit"]: one for one in summary["limits"]}
    assert list(found) == ["n10", "sharpness", "sharp_time", "roughness", "prominence", "impulse_adjustment"]
    assert [bool(one["failed"]) for one in found.values()] == [False, True, False, True, True, False]
    assert all(one["missing"] is None for one in found.values())
    place = summary["runs"]["reduced"]["places"][0]
    assert found["prominence"]["failed"][0] == {"name": place["name"], "value": place["prominence"]}


def test_a_recording_of_the_runs_own_sound_is_found_beside_it(folder):
    """But for the window of the run, which begins later, and what it was silent before."""
    recordings = [r for name in ("again", "louder", "hiss") for r in creak.read_recordings(folder / f"{name}.wav")]
    found = creak.compare_sounds(folder / "results", recordings)
    named = {s.name: s for s in found.sounds}
    high = f"{found.band[1]:.0f} Hz"
    assert list(found.as_dict()) == ["listener", "band", "bands", "sounds", "notes", "warnings"]
    assert {f"again.wav to {high}", "hiss.wav", "hiss.wav to " + high, "all", "tip 1"} <= set(named)
    n5 = [s.figures["n5"] for s in found.sounds]
    assert n5 == sorted(n5, reverse=True)
    again, own = named["again.wav"], named["all"]
    assert again.loudness == pytest.approx(own.loudness, rel=1e-3, abs=1e-3)
    assert named["louder.wav"].figures["n5"] > again.figures["n5"]
    assert named["hiss.wav"].figures["level"] > named["hiss.wav to " + high].figures["level"] + 6.0
    assert named["hiss.wav"].figures["sharpness"] > 2.0 * named["hiss.wav to " + high].figures["sharpness"]
    text = rows(found)
    assert max(len(row[0]) for row in text) <= 22
    assert len(text) == 1 + len(found.sounds)
    assert reasons(found)[0] == f"+ is a recording cut to what is below {high}"


def test_figures_of_a_recording_are_those_of_its_sound(folder):
    """Half a second of two steady tones, 60 dB at 50 Hz and at 1 kHz, at another sampling rate."""
    time = np.arange(22_050) / 44_100
    tones = np.sin(2 * np.pi * 1000 * time) + np.sin(2 * np.pi * 50 * time)
    write_wav(folder / "tones.wav", 0.02 * 2**0.5 * tones, 44_100)
    found = creak.compare_sounds(folder / "results", creak.read_recordings(folder / "tones.wav"), listener="driver")
    whole = next(s for s in found.sounds if s.recorded and s.highest is None)
    steady = creak.steady_loudness(0.02 * 2**0.5 * tones, 44_100)
    assert whole.third_octaves[[3, 16]] == pytest.approx([60.0, 60.0], abs=0.3)
    assert whole.figures["level"] == pytest.approx(60.0, abs=0.1)
    assert whole.figures["n5"] == pytest.approx(steady.total, rel=0.03)
    assert whole.figures["sharpness"] == pytest.approx(steady.sharpness, rel=0.1)
    assert whole.figures["roughness"] < 0.1  # the model takes some of the 50 Hz for modulation
    assert whole.time[-1] == pytest.approx(0.5, abs=0.003)


def test_the_command_ranks_them_in_80_columns_and_draws_them(folder, monkeypatch, capsys):
    monkeypatch.setenv("COLUMNS", "80")
    words = "listen", folder / "results", "--out", folder / "wav", "--beside", folder / "hiss.wav"
    assert caller(monkeypatch, capsys)(*words).status == 0
    said = caller(monkeypatch, capsys)(*words)  # what an earlier one wrote is replaced
    assert said.status == 0
    table = [line for line in said.out.splitlines() if line[:1] in "\u2502\u2503\u250f\u2514\u2521"]
    assert max(map(len, table)) <= 80
    assert [line.split()[1:3] for line in table if "hiss" in line] == [["*", "hiss.wav"], ["+", "hiss.wav"]]
    assert any("tip 1" in line for line in table)
    assert (folder / "wav" / "beside.png").read_bytes()[:4] == b"\x89PNG"
    assert (folder / "wav" / "driver_all.wav").is_file()


def test_the_command_gives_all_of_it_as_json(folder, monkeypatch, capsys):
    call = caller(monkeypatch, capsys)
    said = call("listen", folder / "results", "--out", folder / "j", "--beside", folder / "hiss.wav", "--json")
    found = json.loads(said.out)["compared"]
    assert found["listener"] == "driver"
    assert len(found["sounds"][0]["third_octaves"]) == len(found["bands"]) == 28
    assert {"n5", "n10", "n_max", "level", *FIGURES} <= found["sounds"][0].keys()
    assert max(found["sounds"][0]["loudness"]["sone"]) == pytest.approx(found["sounds"][0]["n_max"], rel=0.02)


def test_wrong_input_gets_one_clear_message_and_writes_nothing(folder, monkeypatch, capsys):
    call = caller(monkeypatch, capsys)
    said = call("listen", folder / "results", "--out", folder / "no", "--calibration", "2")
    assert (said.status, "without a recording" in said.err) == (2, True)
    said = call("listen", folder / "results", "--out", folder / "no", "--beside", folder / "gone.wav")
    assert (said.status, "gone.wav" in said.err) == (2, True)
    assert not (folder / "no").exists()
    hiss = creak.read_recordings(folder / "hiss.wav")
    with pytest.raises(InputError, match="no listener 'drivr'"):
        creak.compare_sounds(folder / "results", hiss, listener="drivr")
    with pytest.raises(InputError, match="no recording"):
        creak.compare_sounds(folder / "results", [])
