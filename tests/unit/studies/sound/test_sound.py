"""The sound of a run: two strips with listeners, from the contact forces to WAV files."""

from __future__ import annotations

import json
from dataclasses import replace

import numpy as np
import pytest
import scipy.linalg as sla

import creak
from creak.errors import InputError
from creak.formats.stored_sound import read_sound
from creak.formats.wav import read_wav
from creak.model.skin import skin_of
from creak.sound.forced import faded
from creak.sound.rayleigh import AIR
from creak.studies.results.places import find_places
from creak.studies.sound.heard import Sound, hear
from creak.studies.sound.listeners import listeners_of
from creak.studies.sound.source import source_of
from helpers_cli import caller
from helpers_decks import STUDY, write_strips

LISTENER = '[listener.driver]\nposition = [60, 200, 500]\nparts = "LOWER"\n'
BASE = STUDY.replace("step = 5e-4\nperiods = 2", "end = 0.2\n[reference]\nrun = false\n").replace("0.05,", "0.1,")


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    folder = tmp_path_factory.mktemp("sound")
    write_strips(folder, study=BASE + LISTENER)
    return folder


@pytest.fixture(scope="module")
def result(folder):
    result = creak.run(creak.read_study(folder / "study.toml"), converge=False)
    result.save(folder / "out")
    return result


def own_sound(result) -> np.ndarray:
    """All contact at the listener: modes marched sample by sample with their exponential, nodes summed with delays."""
    run, model = result.main, result.found.setup.model
    source = source_of(run.system, result.found.gaps, run.history)
    rate, modes = 48_000.0, source.modes
    load = source.force @ modes.push
    acceleration = np.empty_like(load)
    A = np.zeros((modes.m.size, 4, 4))
    A[:, 0, 1] = A[:, 2, 3] = 1.0
    A[:, 1, :3] = np.column_stack([-modes.k, -modes.c, np.ones_like(modes.m)]) / modes.m[:, None]
    step, x = sla.expm(A / rate)[:, :2], np.zeros((modes.m.size, 2))
    slope = np.diff(load, axis=0, append=load[-1:]) * rate
    for i, f in enumerate(load):
        acceleration[i] = (f - modes.c * x[:, 1] - modes.k * x[:, 0]) / modes.m
        x = np.einsum("mij,mj->mi", step, np.column_stack([x, f, slope[i]]))
    skin = skin_of(model)
    skin = skin.select(skin.part == [p.name for p in model.parts].index("LOWER"))
    listener, time = np.array([60.0, 200.0, 500.0]), np.arange(load.shape[0]) / rate
    found = np.zeros(time.size)
    for corners, nodes, area in zip(skin.corners, skin.nodes_idx, skin.areas, strict=True):
        normal = area * np.sign(area @ (listener - corners.mean(axis=0))) * 1e-6
        for x, node in zip(corners, nodes, strict=True):
            labels = 6 * int(node) + np.arange(3)
            if not np.isin(labels, run.system.labels).all():
                continue
            moved = acceleration @ (normal @ run.system.rows(labels)[0]) * 1e-3 / 4
            r = np.linalg.norm(listener - x) * 1e-3
            found += AIR.density / (2 * np.pi * r) * np.interp(time - r / AIR.speed, time, moved, left=0.0)
    n = 4 * time.size
    gain = faded(np.fft.rfftfreq(n, 1 / rate), result.sound.band.high)
    return np.fft.irfft(np.fft.rfft(found, n) * gain, n)[: time.size]


def test_sound_against_a_march_of_the_modes_and_a_sum_over_nodes(result):
    assert isinstance(result.sound, Sound)
    found = result.sound.pressure[0, -1]
    exact = own_sound(result)
    middle = slice(0, int(0.9 * found.size))  # the other way ends with a jump, which its fades spread
    assert np.abs(exact).max() > 0.01
    assert np.abs(found - exact)[middle].max() < 0.03 * np.abs(exact).max()  # straight lines between delayed samples


def test_places_have_what_they_sound_like(result):
    sound = result.summary["sound"]
    places = result.summary["runs"]["reduced"]["places"]
    assert sound["listener"] == "driver"
    assert sound["parts"] == ["LOWER"]
    assert [p["n5"] for p in places] == [p["n5"] for p in sound["listeners"][0]["places"]]
    assert all(p["n_max"] >= p["n5"] > 0.0 for p in places)
    assert sum(p["sound_share"] for p in places) == pytest.approx(1.0)
    assert len(sound["third_octaves"]) == 28
    assert sound["level"] > 30.0
    assert result.summary["warnings"] == []
    own = result.sound.pressure[0]
    np.testing.assert_allclose(own[:-1].sum(axis=0), own[-1], atol=1e-3 * np.abs(own[-1]).max())


def test_the_band_is_the_least_of_its_limits_and_nothing_is_outside(result):
    band = result.summary["sound"]["band"]
    assert band["high"] == min(band["modes"], band["mesh"], band["step"], 19_200.0) == band[band["limit"]]
    # Six elements of 10 mm a wave: pi^2 / 1800 mm^-2 sqrt(D / m) of the 1 mm strip.
    waves = np.sqrt(210000.0 / (12 * 0.91 * 7.85e-9))
    assert band["mesh"] == pytest.approx(2 * np.pi / 60.0**2 * waves, rel=1e-6)
    spectrum = np.abs(np.fft.rfft(result.sound.pressure[0, -1] * np.hanning(result.sound.pressure.shape[2])))
    freq = np.fft.rfftfreq(result.sound.pressure.shape[2], 1 / 48_000.0)
    assert spectrum[freq > 1.05 * band["high"]].max() < 1e-3 * spectrum.max()


def test_no_contact_is_silence(folder):
    far = creak.change_study(creak.read_study(folder / "study.toml"), {"contact.tip.clearance": 50.0})
    result = creak.run(far, converge=False, record=False)
    assert isinstance(result.sound, Sound)
    assert not result.sound.pressure.any()
    assert result.summary["sound"]["n5"] == 0.0


def test_without_a_listener_an_ear_off_the_loudest_panel(result):
    study = result.found.setup.study
    none = replace(study, config=study.config.model_copy(update={"listener": {}}))
    found = replace(result.found, setup=replace(result.found.setup, study=none))
    places = [p.channels for p in find_places(found, result.main)]
    sound = hear(found, places)
    assert isinstance(sound, Sound)
    ear = sound.listeners[0]
    assert not ear.given
    assert ear.position == pytest.approx([60.0, 10.0, 601.75], abs=1.0)  # above the upper strip
    assert "loudest panel" in sound.notes[0]


@pytest.mark.parametrize(
    ("table", "says"),
    [
        ("position = [60, 10, 1.0]", r"is on the structure, at node \d+ \(.*study.toml:\d+ .*\).*10 or more away"),
        ('position = [0, 0, 600]\nparts = "DOOR"', "unknown part 'DOOR'"),
    ],
)
def test_listeners_that_cannot_hear_are_refused_before_the_run(tmp_path, table, says, monkeypatch, capsys):
    path = write_strips(tmp_path, study=f"{BASE}[listener.driver]\n{table}\n")
    said = caller(monkeypatch, capsys)("run", path)
    assert said.status == 2
    assert "listener 'driver'" in said.words
    assert says.split(r" \(")[0].split(r"\d")[0] in said.words
    assert not (tmp_path / "results").exists()


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("[listener.driver]\nparts = []\n", "'listener.driver.position' is missing"),
        ("[listener]\nposition = [0, 0, 600]\n", "Write [listener.NAME]"),
    ],
)
def test_a_listener_without_a_position_or_name_is_refused(tmp_path, text, says, monkeypatch, capsys):
    path = write_strips(tmp_path, study=BASE + text)
    said = caller(monkeypatch, capsys)("run", path)
    assert said.status == 2
    assert says in said.words


def test_a_model_without_a_face_radiates_nothing(result):
    setup = result.found.setup
    bare = replace(setup.model, blocks=())
    with pytest.raises(InputError, match="no shell and no solid of LOWER radiates"):
        listeners_of(bare, setup.study)


def test_listen_writes_what_the_run_kept(result, folder, monkeypatch, capsys):
    said = caller(monkeypatch, capsys)("listen", folder / "out", "--out", folder / "wav", "--json")
    assert said.status == 0, said.err
    told = json.loads(said.out)
    stored = read_sound(folder / "out")
    assert len(told["written"]) == len(stored.places)
    heard = read_wav(folder / "wav" / "driver_all.wav")
    assert heard.rate == 48_000
    assert heard.full_scale == pytest.approx(told["full_scale_pa"])
    np.testing.assert_allclose(heard.samples, result.sound.pressure[0, -1], atol=2 * heard.full_scale / 2**23)


def test_listen_says_why_there_is_nothing_to_hear(tmp_path, monkeypatch, capsys):
    path = write_strips(tmp_path, study=BASE)
    call = caller(monkeypatch, capsys)
    assert call("run", path, "--set", "contact.tip.clearance=50", "--quiet", "--out", tmp_path / "out").status == 0
    said = call("listen", tmp_path / "out")
    assert said.status == 2
    assert "nothing touches in the window" in said.words
    assert call("listen", tmp_path / "nowhere").status == 2
