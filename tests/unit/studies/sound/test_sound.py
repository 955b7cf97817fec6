"""The sound of a run: two strips with listeners, from the contact forces to WAV files."""

from __future__ import annotations

import base64
import io
import json
import re
from dataclasses import replace

import numpy as np
import pytest
import scipy.linalg as sla
from scipy.io import wavfile

import creak
from creak.errors import InputError
from creak.formats.stored.sound import read_sound
from creak.formats.wav import read_wav
from creak.model.materials import SolidSection
from creak.model.mesh import Nodes, Part
from creak.model.skin import skin_of
from creak.report.sound_parts import loudness_figure, players
from creak.sound.rayleigh import AIR
from creak.sound.third_octave import a_weighted_level
from creak.sound.zwicker_tables import BANDS
from creak.studies.findings.places import find_places
from creak.studies.sound import beyond as module
from creak.studies.sound.ear import n5_of
from creak.studies.sound.heard import Sound
from creak.studies.sound.listeners import listeners_of
from creak.studies.sound.radiation import source_of
from helpers_cli import caller
from helpers_core import STEEL, block
from helpers_decks import STUDY, strip, two_strips, write_strips
from helpers_findings import sound_of
from helpers_solids import solid_mesh
from helpers_sound import faded

RECORDED = {"section": "sound"}

LISTENER = '[listener.driver]\nposition = [60, 200, 500]\nparts = "LOWER"\n'
BASE = STUDY.replace("step = 5e-4\nperiods = 2", "end = 0.2\n[reference]\nrun = false\n").replace("0.05,", "0.1,")


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    folder = tmp_path_factory.mktemp("sound")
    write_strips(folder, study=BASE + LISTENER)
    return folder


def marched(result) -> tuple[np.ndarray, np.ndarray]:
    """Velocity and acceleration (n, n_mode) of the modes at 48 kHz, sample by sample with their exponential."""
    run = result.main
    source = source_of(run.system, result.found.gaps, run.history)
    rate, modes = 48_000.0, source.modes
    load = source.force @ modes.push
    velocity, acceleration = np.empty_like(load), np.empty_like(load)
    A = np.zeros((modes.m.size, 4, 4))
    A[:, 0, 1] = A[:, 2, 3] = 1.0
    A[:, 1, :3] = np.column_stack([-modes.k, -modes.c, np.ones_like(modes.m)]) / modes.m[:, None]
    step, x = sla.expm(A / rate)[:, :2], np.zeros((modes.m.size, 2))
    slope = np.diff(load, axis=0, append=load[-1:]) * rate
    for i, f in enumerate(load):
        velocity[i], acceleration[i] = x[:, 1], (f - modes.c * x[:, 1] - modes.k * x[:, 0]) / modes.m
        x = np.einsum("mij,mj->mi", step, np.column_stack([x, f, slope[i]]))
    return velocity, acceleration


def in_band(x: np.ndarray, result) -> np.ndarray:
    """(n, ...) without what the fades take."""
    n = 4 * x.shape[0]
    gain = faded(np.fft.rfftfreq(n, 1 / 48_000.0), result.sound.band.high)
    return np.fft.irfft((np.fft.rfft(x, n, axis=0).T * gain).T, n, axis=0)[: x.shape[0]]


@pytest.fixture(scope="module")
def modal(result):
    return marched(result)


def own_sound(result, acceleration) -> np.ndarray:
    """All contact at the listener: nodes summed with delays."""
    run, model = result.main, result.found.setup.model
    skin = skin_of(model)
    skin = skin.select(skin.part == [p.name for p in model.parts].index("LOWER"))
    listener, time = np.array([60.0, 200.0, 500.0]), np.arange(acceleration.shape[0]) / 48_000.0
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
    return in_band(found, result)


def test_sound_against_a_march_of_the_modes_and_a_sum_over_nodes(result, modal):
    assert isinstance(result.sound, Sound)
    found = result.sound.pressure[0, -1]
    exact = own_sound(result, modal[1])
    middle = slice(0, int(0.9 * found.size))  # the other way ends with a jump, which its fades spread
    assert np.abs(exact).max() > 0.01
    assert np.abs(found - exact)[middle].max() < 0.03 * np.abs(exact).max()  # straight lines between delayed samples


def test_equivalent_power_against_all_facets_of_the_march(result, modal, measured):
    """rho c sum of A v^2 over the window, of every facet by its nodes: some facets stand for all within 1 dB."""
    run, setup = result.main, result.found.setup
    skin, velocity = skin_of(setup.model), in_band(modal[0], result)
    first, last = (round(48_000 * t) for t in result.found.window)
    found = result.summary["sound"]["equivalent_power"]
    assert list(found) == sorted(found, key=lambda name: -found[name])
    for k, part in enumerate(setup.model.parts):
        power, own = 0.0, skin.select(skin.part == k)
        for nodes, area in zip(own.nodes_idx, own.areas, strict=True):
            size = np.linalg.norm(area)
            labels = 6 * np.repeat(nodes, 3) + np.tile(np.arange(3), 4)
            there = np.isin(labels, run.system.labels)
            row = (np.tile(area / size, 4) / 4)[there] @ run.system.rows(labels[there])[0]
            speed = 1e-3 * velocity[first:last:8] @ row
            power += AIR.density * AIR.speed * size * 1e-6 * (speed**2).mean()
        level = 10 * np.log10(power / 1e-12)
        measured(
            "equivalent radiated power of a part by 24 facets: level off that of all",
            abs(found[part.name] - level),
            at_most=1.0,
            unit="dB",
            source="march of the modes, every facet",
        )


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


@pytest.mark.parametrize("time", ["end = 0.2", "step = 5e-4\nperiods = 2"], ids=["all of the run", "its last period"])
def test_a_band_that_ends_at_76_hz_has_nothing_above(tmp_path, time):
    """Two elements a strip. No band above has anything, whether the window is all of the run or cuts it."""
    study = BASE.replace("end = 0.2", time).split("[verification]")[0] + LISTENER
    deck = strip(1, 1, "UPPER", 1.75, 2) + strip(1001, 1001, "LOWER", 0.0, 2)
    deck = "*HEADING\ntwo strips\n" + deck + two_strips().split(strip(1001, 1001, "LOWER", 0.0))[1]
    path = write_strips(tmp_path, deck.replace("1039, 39, 1013, 13", "1009, 9, 1003, 3"), study)
    result = creak.run(creak.read_study(path), converge=False, record=False)
    band, heard = result.sound.band, result.sound.heard[0][-1]
    assert band.high == band.mesh == pytest.approx(75.9, abs=0.1)
    outside = band.high < BANDS * 10**-0.05
    assert (heard.third_octaves[outside] < 0.0).all()
    assert heard.third_octaves.max() > 25.0
    weights = (
        np.array([a_weighted_level(np.sin(2 * np.pi * f * np.arange(48_000) / 48e3), 48e3) for f in BANDS]) - 90.97
    )
    # The sum of the bands; across one of them, the weighting rises by 3 dB.
    assert heard.level == pytest.approx(10 * np.log10((10 ** ((heard.third_octaves + weights) / 10)).sum()), abs=1.5)
    pressure = result.sound.pressure[0, -1]
    assert abs(pressure[[0, -1]]).max() < 1e-3 * abs(pressure).max()


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
    places = [p.channels for p in find_places(found.scope, result.main)]
    sound = sound_of(found, places)
    assert isinstance(sound, Sound)
    ear = sound.listeners[0]
    assert not ear.given
    assert ear.position == pytest.approx([60.0, 10.0, 601.75], abs=1.0)  # above the upper strip
    assert "loudest panel" in sound.notes[0]


@pytest.mark.parametrize("parts", [("LOWER",), ()], ids=["the strip", "both strips"])
def test_a_listener_in_the_plane_of_a_strip_hears_it(result, parts):
    """Level in its plane and a thousandth to either side: the same within .01 dB."""
    setup = result.found.setup
    tables = {
        f"at{k}": setup.study.config.listener["driver"].model_copy(
            update={"position": (300.0, 5.0, z), "parts": list(parts)}
        )
        for k, z in enumerate((-1e-3, -1e-6, 0.0, 1e-6, 1e-3))
    }
    study = replace(setup.study, config=setup.study.config.model_copy(update={"listener": tables}))
    found = replace(result.found, setup=replace(setup, study=study))
    sound = sound_of(found, [p.channels for p in find_places(found.scope, result.main)])
    assert isinstance(sound, Sound)
    levels = [one[-1].level for one in sound.heard]
    assert levels[2] > 60.0
    np.testing.assert_allclose(levels, levels[2], atol=0.01)
    np.testing.assert_allclose([one[-1].n5 for one in sound.heard], sound.heard[2][-1].n5, rtol=1e-3)


def test_a_compact_part_is_told_and_is_no_panel(result):
    """A cube beside the strips that nothing moves: named, and all else sounds as it did."""
    setup = result.found.setup
    model = setup.model
    coords, elements = solid_mesh((1, 1, 1), (8.0, 8.0, 8.0))
    first = model.nodes.count
    nodes = Nodes(np.arange(1, first + 9), np.vstack([model.nodes.coords, coords + [300.0, 0.0, 0.0]]))
    cube = block("hex8", elements + first, SolidSection("STEEL", STEEL), len(model.parts), 10_000)
    parts = (*model.parts, Part("CUBE", np.arange(first, first + 8)))
    more = replace(model, nodes=nodes, blocks=(*model.blocks, cube), parts=parts)
    tables = result.found.setup.study.config.model_copy(update={"listener": {}})
    study = replace(result.found.setup.study, config=tables)
    places = [p.channels for p in find_places(result.found.scope, result.main)]
    alone, beside = (
        sound_of(
            replace(result.found, setup=replace(setup, structure=replace(setup.structure, model=m), study=study)),
            places,
        )
        for m in (model, more)
    )
    assert isinstance(alone, Sound)
    assert isinstance(beside, Sound)
    assert alone.compact == ((),)
    assert beside.compact == (("CUBE",),)
    assert any("CUBE compact" in note for note in beside.notes)
    assert list(beside.equivalent_power) == list(alone.equivalent_power)  # at rest: none
    np.testing.assert_array_equal(beside.listeners[0].position, alone.listeners[0].position)
    np.testing.assert_allclose(beside.pressure, alone.pressure, atol=1e-6 * np.abs(alone.pressure).max())


@pytest.mark.parametrize(
    ("table", "says"),
    [
        ("position = [60, 10, 1.0]", r"is on the structure, at node \d+ \(.*study.toml:\d+ .*\).*0.01 m or more away"),
        ('position = [0, 0, 600]\nparts = "DOOR"', "unknown part 'DOOR'"),
    ],
)
def test_listeners_that_cannot_hear_are_refused_before_the_run(tmp_path, table, says, monkeypatch, capsys):
    path = write_strips(tmp_path, study=f"{BASE}[listener.driver]\n{table}\n")
    said = caller(monkeypatch, capsys)("run", path)
    said.refuses("listener 'driver'")
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
    said.refuses(says)


def test_a_model_without_a_face_radiates_nothing(result):
    setup = result.found.setup
    bare = replace(setup.model, blocks=())
    with pytest.raises(InputError, match="no shell and no solid of LOWER radiates"):
        listeners_of(bare, setup.study.config.listener, setup.study.places, 1e-3)


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


def test_the_page_plays_each_place_and_draws_its_loudness(result, folder):
    text = result.page(0.0)
    count = len(result.summary["runs"]["reduced"]["places"])
    files = [base64.b64decode(x) for x in re.findall(r'src="data:audio/wav;base64,([^"]+)"', text)]
    assert len(files) == min(count, 8) + 1
    first, last = result.found.window
    heard = [wavfile.read(io.BytesIO(f)) for f in files]
    rate, samples = heard[0]
    assert rate == 8_000  # twice the band and more
    assert samples.size == pytest.approx((last - first) * rate, abs=2)
    assert 0.5 * 32767 < max(np.abs(x.astype(int)).max() for _, x in heard) <= 32767
    assert 'id="plot-loudness"' in text
    again = creak.open_result(folder / "out")
    assert len(re.findall("data:audio/wav", "".join(players(again.findings)))) == len(files)


def test_a_silent_run_has_no_player(result):
    view = replace(result.findings, sound=None)
    assert players(view) == []
    assert loudness_figure(view).spec is None


def test_listen_says_why_there_is_nothing_to_hear(tmp_path, monkeypatch, capsys):
    path = write_strips(tmp_path, study=BASE)
    call = caller(monkeypatch, capsys)
    assert call("run", path, "--set", "contact.tip.clearance=50", "--quiet", "--out", tmp_path / "out").status == 0
    said = call("listen", tmp_path / "out")
    said.refuses("nothing touches in the window")
    assert call("listen", tmp_path / "nowhere").status == 2


@pytest.fixture(scope="module")
def beyond(tmp_path_factory):
    """The strips with the modes of the whole up to 3 kHz: they end at 1.5 kHz, the mesh at 2.7 kHz."""
    folder = tmp_path_factory.mktemp("beyond")
    study = (BASE + LISTENER).replace("f_max = 3000", 'method = "gap-modes"\nf_max = 3000')
    write_strips(folder, study=study)
    return creak.run(creak.read_study(folder / "study.toml"), converge=False)


def test_the_unreduced_model_goes_on_where_the_modes_end(beyond):
    sound, told = beyond.sound, beyond.summary["sound"]
    assert isinstance(sound, Sound)
    assert told["band"]["handover"] == told["band"]["modes"] == 1500.0
    assert told["band"]["high"] == told["band"]["mesh"] > 2700.0
    assert told["band"]["limit"] == "mesh"
    assert 0.0 < told["n5_modes"] < told["n5"]
    assert max(sound.ways) < 0.01  # both ways agree where they overlap
    assert f"{told['n5_modes']:.3g} sone by the modes alone, {told['n5']:.3g} with both" in " ".join(sound.notes)
    assert told["third_octaves"][19] > 0.0  # 2 kHz, beyond the modes


def test_a_repeated_run_is_heard_by_both_ways_as_well(beyond):
    run, found = beyond.main, beyond.found
    groups = [p.channels for p in find_places(found.scope, run)]
    ear = beyond.sound.ear
    *single, together = n5_of(found.window, run.system, found.gaps, run.history, groups, ear)
    order = beyond.sound.order
    assert [single[k] for k in order] == pytest.approx([h.n5 for h in beyond.sound.heard[0][:-1]])
    assert together == pytest.approx(beyond.sound.heard[0][-1].n5)
    lower = n5_of(found.window, run.system, found.gaps, run.history, groups, replace(ear, beyond=None))
    assert lower[-1] == pytest.approx(beyond.sound.heard[0][-1].n5_modes)


def test_where_the_share_of_the_cost_is_used_up_the_band_ends_there(beyond, monkeypatch):
    """With few frequencies it goes as far as these, with fewer not at all, and says what it would take."""
    places = [p.channels for p in find_places(beyond.found.scope, beyond.main)]
    monkeypatch.setattr(module, "FLOOR", 14)
    less = sound_of(beyond.found, places)
    assert isinstance(less, Sound)
    assert 1.1 * 1500.0 < less.band.high < beyond.sound.band.high
    assert less.band.limit == "unreduced"
    monkeypatch.setattr(module, "FLOOR", 3)
    none = sound_of(beyond.found, places)
    assert isinstance(none, Sound)
    assert (none.band.high, none.band.limit, none.band.handover) == (1500.0, "modes", None)
    assert "no further than the modes: to 2732 Hz it would take" in " ".join(none.notes)
    assert none.heard[0][-1].n5 == pytest.approx(beyond.sound.heard[0][-1].n5_modes)
