"""A room, two ears and the road around two strips that hit each other: from the study file to figures and WAV files."""

from __future__ import annotations

import json
from dataclasses import replace

import numpy as np
import pytest

import creak
from creak.dynamics.loads import Loads
from creak.formats.stored.sound import read_sound
from creak.formats.wav import read_wav
from creak.signals.spectra import low_pass
from creak.sound.third_octave import a_weighted_sum, third_octave_levels
from creak.sound.zwicker_tables import REFERENCE_PRESSURE
from creak.studies.findings.places import find_places
from creak.studies.sound.ear import n5_of, records_of
from creak.studies.sound.heard import Sound
from creak.studies.sound.loud import bar_share, heard_of
from creak.studies.sound.radiation import source_of
from creak.studies.sound.road import road_levels
from helpers_cli import caller
from helpers_decks import STUDY, write_strips
from helpers_hrtf import grid, responses, unit, write_sofa

BASE = STUDY.replace("step = 5e-4\nperiods = 2", "end = 0.2\n[reference]\nrun = false\n").replace("0.05,", "0.1,")
LISTENERS = """
[listener.driver]
position = [60, 400, 500]
faces = [1, 0, 0]
[listener.point]
position = [60, 400, 500]
"""
CABIN = """
[room]
volume = 3.0
reverberation = [[100, 0.2], [1000, 0.1]]
[background]
linear = true
"""


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    folder = tmp_path_factory.mktemp("cabin")
    write_strips(folder, study=BASE + LISTENERS + CABIN)
    return folder


@pytest.fixture(scope="module")
def result(folder):
    result = creak.run(creak.read_study(folder / "study.toml"), converge=False, record=False)
    assert isinstance(result.sound, Sound), result.sound
    result.save(folder / "out")
    return result


def test_room_ears_and_road_stand_in_the_summary(result):
    sound = result.summary["sound"]
    driver, point = sound["listeners"]
    assert (driver["ear"], driver["faces"]) == ("right", [1.0, 0.0, 0.0])  # the strips are on its right
    assert (point["ear"], point["faces"]) == (None, None)
    assert sound["room"]["volume"] == 3.0
    assert sound["room"]["reverberation"][0] == sound["room"]["reverberation"][6] == 0.2
    assert sound["room"]["reverberation"][16] == pytest.approx(0.1)
    assert sound["room"]["schroeder"] == pytest.approx(2000 * (0.12 / 3) ** 0.5, rel=0.2)
    for one in (driver, point):
        assert 0.0 < one["n5_direct"] < one["n5"]
        assert 0.0 < one["n5_added"] < one["n5"]
    notes = " ".join(result.sound.notes)
    for words in ("[room] of 3 m^3", "driver hears with two ears", "the right one", "the excitation alone sends"):
        assert words in notes
    road = a_weighted_sum(np.array(point["background"]))
    assert road > 20.0
    assert f"{road:.0f} dB(A) to point" in notes


def test_the_road_is_that_of_whole_periods(tmp_path):
    """As loud as in a run of one period less: of the steady motion that both repeat."""
    study = BASE.replace("end = 0.2", "end = 0.17").replace("period = 0.2", "period = 0.05")
    path = write_strips(
        tmp_path, study=study + "[listener.point]\nposition = [60, 400, 500]\n[background]\nlinear = true\n"
    )
    found = creak.run(creak.read_study(path), converge=False, record=False)
    loads, ear = found.found.setup.marching.loads, found.sound.ear
    n = int(np.searchsorted(loads.time, 0.12 + 1e-9))
    less = Loads(loads.time[:n], loads.support[:, :n], loads.force[:n], loads.force_labels)
    levels = road_levels(found.main.system, less, ear, (0.07, 0.12), 0.05)
    assert levels[2] > 40.0  # 40 Hz, a line of the excitation
    heard = levels > levels.max() - 60.0
    np.testing.assert_allclose(
        np.array(found.summary["sound"]["listeners"][0]["background"])[heard], levels[heard], atol=0.02
    )


def test_a_measured_head_hears_as_it_was_measured(tmp_path, result):
    """A sphere measured in a laboratory hears what that of the formula hears, which is within a decibel of it."""
    angles = grid()
    write_sofa(tmp_path / "sphere.sofa", angles, responses(unit(angles)))
    listener = "[listener.driver]\nposition = [60, 400, 500]\nfaces = [1, 0, 0]\n"
    path = write_strips(tmp_path, study=BASE + listener + 'hrtf = "sphere.sofa"\n[listener.plain]\n' + listener[18:])
    found = creak.run(creak.read_study(path), converge=False, record=False)
    assert isinstance(found.sound, Sound), found.sound
    own, plain = found.summary["sound"]["listeners"]
    assert own["ear"] == plain["ear"] == "right"
    assert own["n5"] == pytest.approx(plain["n5"], rel=0.05)
    assert own["level"] == pytest.approx(plain["level"], abs=1.0)
    assert "driver hears with two ears, as sphere.sofa has them" in " ".join(found.sound.notes)


def test_a_diffuse_field_is_as_loud_as_sabine_says(result):
    """Energies of the room and of the direct sound, of the whole record at a point: 4 rho c P (1 - alpha) / A."""
    ear = next(e for e in (result.sound.ear,) if e.cabin is not None)
    again = read_sound(result_folder(result))
    assert again.pressure.shape[0] == 2
    x = again.of(1, len(again.places) - 1)
    added = ear.cabin.adds(np.pad(x, 24_000)[None])[0]
    level = [third_octave_levels(y, 48_000.0) for y in (np.pad(x, 24_000), added)]
    room = ear.cabin.room
    gain = 8 * np.pi * (1 - room.absorbed) / (room.absorption * ear.cabin.spread)
    bands = slice(14, 20)  # 630 Hz to 2 kHz
    energy = [10 ** (0.1 * y[bands]) * REFERENCE_PRESSURE**2 for y in level]
    assert 10 * np.log10(energy[1].sum() / (gain[bands] * energy[0]).sum()) == pytest.approx(0.0, abs=0.3)


def result_folder(result):
    return result.found.setup.study.path.parent / "out"


def test_a_diffuse_field_is_as_loud_at_both_ears_and_alike_in_long_waves(result):
    """The head shades what comes straight and not what the room sends back."""
    run, found, right = result.main, result.found, result.sound.ear
    source = source_of(run.system, found.gaps, run.history)
    left = replace(right, listener=replace(right.listener, side=1), cabin=replace(right.cabin, side=1), known={})
    every = [np.arange(source.force.shape[1])]
    both = [records_of(source, every, ear, run.system) for ear in (left, right)]
    back = [third_octave_levels(x.whole[0] - x.direct[0], 48_000.0) for x in both]
    straight = [third_octave_levels(x.direct[0], 48_000.0) for x in both]
    bands = slice(13, 20)  # 500 Hz to 2 kHz
    np.testing.assert_allclose(back[0][bands], back[1][bands], atol=1.0)
    apart = (straight[1] - straight[0])[bands]
    assert apart.min() > 1.0
    assert apart[-1] > 6.0
    low = np.stack([low_pass(x.whole[0] - x.direct[0], 1 / 48_000, 150.0) for x in both])
    assert np.corrcoef(low)[0, 1] > 0.8


def test_files_of_a_listener_with_a_head_have_two_channels(result, folder, monkeypatch, capsys):
    said = caller(monkeypatch, capsys)("listen", folder / "out", "--out", folder / "wav", "--json")
    assert said.status == 0, said.err
    told = json.loads(said.out)
    two, one = (read_wav(folder / "wav" / f"{name}_all.wav") for name in ("driver", "point"))
    assert two.samples.ndim == 2
    assert one.samples.ndim == 1
    assert two.full_scale == one.full_scale == pytest.approx(told["full_scale_pa"])
    left, right = two.samples.T
    np.testing.assert_allclose(right, result.sound.pressure[0, -1], atol=2 * two.full_scale / 2**23)
    assert (right**2).sum() > 1.1 * (left**2).sum()
    assert np.argmax(np.correlate(left, right, "full")) - right.size + 1 in range(5, 50)  # the left one hears it later


def test_repeated_runs_are_heard_in_the_same_room_by_the_same_ear(result):
    run, found = result.main, result.found
    groups = [p.channels for p in find_places(found.scope, run)]
    *single, _ = n5_of(found.window, run.system, found.gaps, run.history, groups, result.sound.ear)
    assert [single[k] for k in result.sound.order] == pytest.approx(
        [h.n5_added for h in result.sound.heard[0][:-1]], rel=1e-6
    )


def test_beside_more_than_the_standard_covers_places_have_no_added_loudness(result):
    """130 dB at 31.5 Hz: no figure, no error, and the rank is that of the place alone."""
    loud = np.full(28, 20.0)
    loud[1] = 130.0
    pressure = result.sound.pressure[0, -1].astype(float)
    beside = heard_of(pressure, (0.0, 0.2), loud)
    assert (beside.n5_added, beside.n_max_added) == (None, None)
    assert beside.rank == heard_of(pressure, (0.0, 0.2), None).rank
    assert np.isnan(bar_share(replace(beside, n5_bar=(1.0, 2.0)), (pressure, pressure), (0.0, 0.2), loud, 0))


def test_what_was_kept_is_read_back(result, folder):
    again = creak.open_result(folder / "out")
    assert again.findings.sound.room.volume == 3.0
    assert again.findings.sound.listeners[0].ear == "right"
    assert again.summary["sound"] == json.loads((folder / "out" / "summary.json").read_text())["sound"]


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("[room]\nreverberation = 0.1\n", "'room.volume' is missing"),
        ("[room]\nvolume = 3\n", "'room.reverberation' is missing"),
        ("[room]\nvolume = 3\nreverberation = 0\n", "room.reverberation = 0: input should be greater than 0"),
        ("[room]\nvolume = 3\nreverberation = 0.01\n", "reverberation time of 0.01 s in a room of 3 m^3"),
        ("[room]\nvolume = 3\nreverberation = [[500, 0.1], [250, 0.1]]\n", "do not increase"),
        ('[room]\nvolume = 3\nreverberation = "no.csv"\n', "no such table"),
        ('[room]\nvolume = 3\nreverberation = "zero.csv"\n', "a reverberation time of 0 s"),
        ("[room]\nvolume = 3\nreverberation = 0.1\nabsorbs = 1\n", "unknown key 'room.absorbs'"),
        ("[background]\n", "give file, levels that were measured, or linear = true"),
        ("[listener.ear]\nposition = [60, 400, 500]\nfaces = [0, 0, 0]\n", "its length is 0"),
        ("[listener.ear]\nposition = [60, 400, 500]\nup = [0, 0, 1]\n", "give faces, where it looks, too"),
        ("[listener.ear]\nposition = [60, 400, 500]\nfaces = [0, 0, 2]\n", "along the top of its head"),
        (
            "[listener.ear]\nposition = [60, 10, 60]\nfaces = [1, 0, 0]\n",
            "head of listener 'ear' touches the structure",
        ),
        ("[listener.ear]\nposition = [60, 400, 500]\nface = [1, 0, 0]\n", "unknown key 'listener.ear.face'"),
    ],
)
def test_wrong_input_gets_one_message_with_its_line(tmp_path, text, says, monkeypatch, capsys):
    path = write_strips(tmp_path, study=BASE + text)
    (tmp_path / "zero.csv").write_text("frequency,time\n125,0.1\n250,0\n")
    said = caller(monkeypatch, capsys)("run", path)
    said.refuses(says)
    assert ("study.toml:" in said.words) or ("zero.csv" in said.words)
    assert not (tmp_path / "results").exists()


def test_times_of_a_file_are_those_of_the_table(folder, tmp_path):
    write_strips(tmp_path, study=BASE + LISTENERS + '[room]\nvolume = 3\nreverberation = "times.csv"\n')
    (tmp_path / "times.csv").write_text("frequency,time\n100,0.2\n1000,0.1\n")
    from creak.studies.sound.cabin import room_of

    found = []
    for path in (tmp_path, folder):
        study = creak.read_study(path / "study.toml")
        found.append(room_of(study.config.room, study.places).reverberation)
    np.testing.assert_array_equal(*found)
