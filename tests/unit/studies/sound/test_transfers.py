"""Measured ways from part to ear: what a run's sound is by them, in three kinds of files, and what is refused."""

from __future__ import annotations

import re
from dataclasses import replace

import numpy as np
import pytest

import creak
from creak.formats.decks import read_model
from creak.formats.wav import write_wav
from creak.model.dofs import TRANSLATIONS, node_dofs
from creak.model.skin import skin_of
from creak.studies.file.paths import map_paths
from creak.studies.file.sound_tables import TransferTable
from creak.studies.sound.beyond import hearing
from creak.studies.sound.heard import Sound
from creak.studies.sound.listeners import Listener
from creak.studies.sound.plates_heard import plate_heard
from creak.studies.sound.sheets import PartPlates, Push
from creak.studies.sound.transfers import Transfer, transfer_of, words_of
from creak.studies.warned import Warned
from helpers_cli import caller
from helpers_core import assembled, block, model_of, shell
from helpers_decks import STUDY, write_strips
from helpers_frfs import function, units

RECORDED = {"section": "sound"}

BASE = STUDY.replace("step = 5e-4\nperiods = 2", "end = 0.2\n[reference]\nrun = false\n").replace("0.05,", "0.1,")
POSITION = [60.0, 400.0, 500.0]
OPEN = f"[listener.open]\nposition = {POSITION}\n"
MEASURED = OPEN.replace("open", "NAME") + "".join(
    f'[listener.NAME.transfer.{part}]\nfile = "NAME_{part}.csv"\n' for part in ("UPPER", "LOWER")
)
DENSITY, SPEED, AWAY = 1.204, 343.2, 0.6


def in_the_open(freq, r: float) -> np.ndarray:
    """Pa per m^3/s^2 of a small source in a wall."""
    return DENSITY / (2 * np.pi * r) * np.exp(-2j * np.pi * freq * r / SPEED)


def table(freq, response) -> str:
    rows = (f"{f!r},{z.real!r},{z.imag!r}" for f, z in zip(freq.tolist(), response.tolist(), strict=True))
    return "frequency,real,imag\n" + "\n".join(rows) + "\n"


def test_parts_are_heard_as_they_were_measured(tmp_path, measured):
    """A way as in the open changes nothing; another one makes a part twice as loud and late."""
    names = ("same", "late")
    path = write_strips(tmp_path, study=BASE + OPEN + "".join(MEASURED.replace("NAME", name) for name in names))
    model = read_model(tmp_path / "strips.inp")
    skin, freq, delay = skin_of(model), np.arange(2.0, 8000.0, 2.0), 0.005
    for k, part in enumerate(model.parts):
        if not (own := skin.select(skin.part == k)).count:
            continue
        size = np.linalg.norm(own.areas, axis=1)
        r = 1e-3 * float(np.linalg.norm(size @ own.centres / size.sum() - POSITION))
        (tmp_path / f"same_{part.name}.csv").write_text(table(freq, in_the_open(freq, r)))
        turned = 2 * in_the_open(freq, r) * np.exp(-2j * np.pi * freq * delay)
        (tmp_path / f"late_{part.name}.csv").write_text(
            table(freq, turned if part.name == "UPPER" else 0.0 * turned + 1e-12)
        )
    result = creak.run(creak.read_study(path), converge=False, record=False)
    assert isinstance(result.sound, Sound), result.sound
    air, same, late = result.sound.pressure[:, -1].astype(float)
    np.testing.assert_allclose(same, air, atol=1e-6 * np.abs(air).max())
    said = " ".join(result.sound.notes)
    assert "late hears UPPER by late_UPPER.csv (2 to 7998 Hz), LOWER by late_LOWER.csv" in said
    assert "open hears" not in said
    only = creak.run(
        creak.read_study(write_strips(tmp_path, study=BASE + OPEN + 'parts = "UPPER"\n')), converge=False, record=False
    )
    upper, shift = only.sound.pressure[0, -1].astype(float), round(delay * 48_000)
    inside = slice(2000, 7000)  # where neither record fades
    expected = 2 * np.roll(upper, shift)[inside]
    measured(
        "a part by a measured way, twice as loud and 5 ms late: largest error over the peak",
        np.abs(late[inside] - expected).max() / np.abs(expected).max(),
        at_most=1e-3,
        source="the same part in the open",
    )


def files(folder) -> list[tuple[str, TransferTable]]:
    """One way in six files: 40 mm^2 of a room, of which all but CSV tell no phase in degrees."""
    n, rate = 4096, 48_000
    echo = np.zeros(n)
    echo[[90, 150]] = 0.3, -0.1
    freq = np.arange(4.0, 12_000.0, 4.0)
    z = (echo[[90, 150]][:, None] * np.exp(-2j * np.pi * np.array([[90], [150]]) / rate * freq)).sum(axis=0)
    (folder / "a.csv").write_text(table(freq, z))
    rows = zip(freq.tolist(), np.abs(z).tolist(), np.degrees(np.angle(z)).tolist(), strict=True)
    (folder / "b.csv").write_text("frequency,amplitude,phase\n" + "\n".join(",".join(map(repr, row)) for row in rows))
    (folder / "c.csv").write_text(table(freq, 2j * np.pi * freq * z))
    kinds = {"quantity": 0, "over": 0, "freq": freq}
    one = function(z, **kinds, labels=("Pa", "m^3/s^2"))
    (folder / "d.uff").write_bytes(one)
    other = function(2j * np.pi * freq * z, (9, 1), **kinds, labels=("Pa/(m^3/s)", "NONE"), binary="<")
    (folder / "e.unv").write_bytes(one + other)
    write_wav(folder / "f.wav", echo, rate, samples="float", full_scale=0.5)
    raw = (folder / "f.wav").read_bytes().replace(b"full scale", b"top of all")
    (folder / "f.wav").write_bytes(raw)
    return [
        ("a.csv", TransferTable(file="a.csv")),
        ("b.csv", TransferTable(file="b.csv", per="volume acceleration")),
        ("c.csv", TransferTable(file="c.csv", per="volume velocity")),
        ("d.uff", TransferTable(file="d.uff")),
        ("e.unv", TransferTable(file="e.unv", function=2)),
        ("f.wav", TransferTable(file="f.wav", full_scale=0.5)),
    ]


def test_six_files_are_one_way(tmp_path):
    at = np.linspace(50.0, 9000.0, 777)
    z = 0.3 * np.exp(-2j * np.pi * at * 90 / 48_000) - 0.1 * np.exp(-2j * np.pi * at * 150 / 48_000)
    exact = z / in_the_open(at, AWAY)
    for name, given in files(tmp_path):
        found = transfer_of(given, tmp_path / name, 3, AWAY, "")
        assert (found.part, found.file) == (3, name)
        np.testing.assert_allclose(found.gain(at), exact, atol=1e-3, err_msg=name)
        assert found.square(1000.0) == pytest.approx(
            float(np.mean(np.abs(exact[(at > 891) & (at < 1122)]) ** 2)), rel=0.1
        )


@pytest.mark.parametrize(("unit", "each"), [("Hz", 1.0), ("kHz", 1e-3), ("rad/s", 2 * np.pi), ("rpm", 60.0)])
@pytest.mark.parametrize("kind", [18, 0])
def test_frequencies_of_universal_files_are_in_the_unit_of_their_axis(tmp_path, unit, each, kind):
    """That of a small source in a wall, written over other units, is heard as in the open."""
    freq = np.arange(4.0, 4000.0, 4.0)
    told = {"freq": each * freq, "over_unit": unit, "abscissa": kind, "labels": ("Pa", "m^3/s^2")}
    (tmp_path / "a.uff").write_bytes(function(in_the_open(freq, AWAY), quantity=0, over=0, **told))
    found = transfer_of(TransferTable(file="a.uff"), tmp_path / "a.uff", 0, AWAY, "")
    assert found.freq == pytest.approx(freq, rel=1e-5)
    np.testing.assert_allclose(found.gain(np.linspace(20.0, 3900.0, 333)), 1.0, atol=2e-3)


def test_units_of_data_set_164_are_not_passed_over(tmp_path):
    """Without labels a file in mm is none in Pa, m and s; labels are by themselves, and m and N are as none."""
    freq, path = np.arange(4.0, 4000.0, 4.0), tmp_path / "a.uff"

    def gain(head: str, labels: tuple[str, str]):
        one = function(in_the_open(freq, AWAY), quantity=0, over=0, freq=freq, labels=labels)
        path.write_bytes(head.encode() + one)
        return transfer_of(TransferTable(file="a.uff"), path, 0, AWAY, "").gain(np.linspace(20.0, 3900.0, 99))

    both = ("Pa", "m^3/s^2")
    for head, labels in ((units(1000.0), both), (units(1.0), ("NONE", "NONE")), (units(1.0), both), ("", ("", ""))):
        np.testing.assert_allclose(gain(head, labels), 1.0, atol=1e-3)
    for labels in (("NONE", "NONE"), ("Pa", "NONE"), ("NONE", "m^3/s^2")):
        with pytest.raises(creak.InputError, match=r"where data set 164 tells 1000 units in 1 m and 1 in 1 N"):
            gain(units(1000.0), labels)


def test_amplitudes_alone_are_late_as_in_the_open_and_nothing_is_known_outside(tmp_path):
    (tmp_path / "a.csv").write_text("frequency,amplitude\n100,0.5\n1000,0.5\n")
    found = transfer_of(TransferTable(file="a.csv"), tmp_path / "a.csv", 0, AWAY, "")
    louder = 0.5 * 2 * np.pi * AWAY / DENSITY
    np.testing.assert_allclose(found.gain(np.array([100.0, 345.0, 1000.0])), louder)
    np.testing.assert_allclose(found.gain(np.array([1.0, 79.0, 1260.0, 9000.0])), 1.0)
    between = found.gain(np.array([90.0, 1100.0])).real
    assert (between > 1.0).all()
    assert (between < louder).all()


@pytest.mark.parametrize("head", ["frequency [kHz]", "Frequency (kHz)", "frequency[khz]"])
def test_frequencies_of_a_table_are_in_the_unit_of_its_head(tmp_path, head):
    found = []
    for name, first, unit in (("a.csv", "frequency", 1.0), ("b.csv", head, 1e-3)):
        rows = [f"{unit * f!r},{0.5 + f / 1e3!r},{-f / 2e3!r}" for f in (100.0, 400.0, 1000.0)]
        (tmp_path / name).write_text("\n".join([f"{first},real,imag", *rows]))
        found.append(transfer_of(TransferTable(file=name), tmp_path / name, 0, AWAY, ""))
    np.testing.assert_allclose(found[1].freq, [100.0, 400.0, 1000.0])
    np.testing.assert_allclose(found[1].ratio, found[0].ratio)
    (tmp_path / "c.csv").write_text("frequency [mm],real,imag\n1,1,1\n2,1,1\n")
    with pytest.raises(creak.InputError, match="the frequencies are in mm; expected one of Hz, kHz"):
        transfer_of(TransferTable(file="c.csv"), tmp_path / "c.csv", 0, AWAY, "")


def test_between_measured_frequencies_it_stays_between_what_was_measured(tmp_path):
    """A spline made 3600 of amplitudes about 1 where the last stood far off. A row at 0 Hz says nothing."""
    freq = np.concatenate([np.arange(0.0, 1001.0, 10.0), [4000.0, 10_000.0]])
    size = 1.0 + 0.2 * np.sin(freq / 30.0)
    (tmp_path / "b.csv").write_text(
        "frequency,amplitude\n" + "".join(f"{f},{a}\n" for f, a in zip(freq, size, strict=True))
    )
    found = transfer_of(TransferTable(file="b.csv"), tmp_path / "b.csv", 0, AWAY, "")
    open_air = 2 * np.pi * AWAY / DENSITY
    gain = found.gain(np.geomspace(10.0, 10_000.0, 2000)).real / open_air
    assert gain.min() > size.min() - 1e-9
    assert gain.max() < size.max() + 1e-9
    np.testing.assert_allclose(found.gain(freq[1:]).real / open_air, size[1:])


THIRDS = 1000.0 * 10.0 ** (0.1 * np.arange(-17, 14))


@pytest.mark.parametrize(
    ("freq", "delay"), [(THIRDS, 0.004), (np.arange(20.0, 20_001.0, 20.0), 0.027), (np.array([100.0, 4000.0]), 0.0018)]
)
def test_a_late_way_loses_nothing_of_its_level_between_its_lines(tmp_path, freq, delay):
    """5 Pa per m^3/s^2, late by many turns from line to line: |H| is constant, and so is what is heard."""
    (tmp_path / "a.csv").write_text(table(freq, 5.0 * np.exp(-2j * np.pi * freq * delay)))
    found = transfer_of(TransferTable(file="a.csv"), tmp_path / "a.csv", 0, AWAY, "")
    at = np.geomspace(freq[0], freq[-1], 999)
    exact = 5.0 * np.exp(-2j * np.pi * at * delay) / in_the_open(at, AWAY)
    np.testing.assert_allclose(found.gain(at), exact, rtol=1e-6)
    assert found.square(1000.0) == pytest.approx(float(np.abs(exact[0]) ** 2), rel=1e-6)
    (heard,) = words_of([found], ["P"], "ear", (20.0, 8000.0))
    assert not isinstance(heard, Warned)


def test_lines_that_do_not_tell_the_way_of_their_phase_warn(tmp_path):
    """A resonance of 5 % damping at 1 kHz between lines 150 Hz apart, and between such as the warning asks for."""

    def notes(apart: float) -> list[str]:
        freq = np.arange(50.0, 4000.0, apart)
        own = 1000.0**2 / (1000.0**2 - freq**2 + 100j * freq)
        (tmp_path / "a.csv").write_text(table(freq, own * np.exp(-2j * np.pi * freq * 0.005)))
        found = transfer_of(TransferTable(file="a.csv"), tmp_path / "a.csv", 0, AWAY, "")
        return words_of([found], ["P"], "ear", (20.0, 8000.0))

    heard, warning = notes(150.0)
    assert isinstance(warning, Warned)
    assert "P by a.csv (50 to 3950 Hz" in heard
    assert "the phase of a.csv turns by up to " in warning
    assert "from 950 to 1100 Hz" in warning
    assert len(notes(float(re.search(r"Measure lines (\S+) Hz apart", warning)[1]))) == 1


def test_beyond_the_modes_and_the_mesh_it_counts_alike(measured):
    """By reciprocity a part weighs what its way lets pass; its mean square in statistics goes with the square of it."""
    square = np.array([[0.0, 0, 0], [0.02, 0, 0], [0.02, 0.02, 0], [0, 0.02, 0]])
    coords = np.vstack([square, square + [0.1, 0, 0]])
    blocks = [block("quad4", np.arange(4)[None] + 4 * k, shell(0.001), part=k, first=k + 1) for k in range(2)]
    model = model_of(coords, blocks, [("A", range(4)), ("B", range(4, 8))])
    system, skin, freq = assembled(model), skin_of(model), np.array([200.0, 2000.0])
    way = Transfer(1, "b.csv", freq, np.array([2.0, 1j]))
    plain = Listener("ear", np.array([0.0, 0, 0.5]), skin, ("A", "B"), given=True)
    with_it = replace(plain, transfers=(way,))
    is_b = np.isin(system.labels, node_dofs(np.arange(4, 8), TRANSLATIONS))
    for f, gain in zip(freq, (2.0, 1j), strict=True):
        without, found = hearing(system, plain, 1.0)(f), hearing(system, with_it, 1.0)(f)
        np.testing.assert_allclose(found, np.where(is_b, gain, 1.0) * without, atol=1e-12 * np.abs(without).max())
    flat = Transfer(1, "b.csv", freq, np.array([3.0, 3.0]))
    nothing = np.zeros(0)
    push = Push(
        PartPlates(1, (), nothing), nothing.astype(int), nothing, np.zeros((0, 3)), nothing, nothing, np.zeros((0, 3))
    )
    reach = [plate_heard(push, replace(plain, transfers=ways), 1.0).reach(700.0) for ways in ((), (flat,))]
    measured("square of a way in statistical energy", reach[1] / reach[0], 9.0, rel=1e-12, source="its own gain")


@pytest.mark.parametrize(
    ("keys", "content", "says"),
    [
        ("", None, "no such table"),
        ("", "frequency,level\n1,2\n", "the table starts with frequency,level"),
        ("", "frequency,real,imag\n100,1,0\n", "a transfer function of 1 frequencies"),
        ("", "frequency,real,imag\n100,1,0\n90,1,0\n", "two or more above 0, upwards"),
        ("", "frequency,real,imag\n100,1,0\n200,x,0\n", "got '200,x,0'; expected 3 finite numbers"),
        ("", "frequency,amplitude\n100,1\n200,-3\n", "an amplitude of -3"),
        ("", "frequency,amplitude\n100,0\n200,0\n", "that is zero"),
        ("full_scale = 2\n", "frequency,amplitude\n100,1\n200,1\n", "full_scale of way.csv"),
        ('per = "pressure"\n', "frequency,amplitude\n100,1\n200,1\n", "volume acceleration"),
        ("faces = [1, 0, 0]\n", "frequency,amplitude\n100,1\n200,1\n", "leave faces out"),
        ("[room]\nvolume = 3\nreverberation = 0.1\n", "frequency,amplitude\n100,1\n200,1\n", "has the room in it"),
        ('[listener.ear.transfer.UPER]\nfile = "way.csv"\n', "frequency,amplitude\n1,1\n2,1\n", "unknown part 'UPER'"),
        ('[listener.ear.transfer.LOWER]\nfile = "way.csv"\n', "frequency,amplitude\n1,1\n2,1\n", "does not hear"),
        (
            '[listener.ear.transfer.upper]\nfile = "way.csv"\n',
            "frequency,amplitude\n1,1\n2,1\n",
            "two transfer functions",
        ),
    ],
)
def test_wrong_input_gets_one_message_with_its_line(tmp_path, keys, content, says, monkeypatch, capsys):
    own, others = (keys, "") if "[" not in keys or keys.startswith("faces") else ("", keys)
    head, own = (own, "") if own.startswith("faces") else ("", own)
    listener = f'[listener.ear]\nposition = {POSITION}\nparts = ["UPPER"]\n{head}'
    path = write_strips(
        tmp_path, study=f'{BASE}{listener}[listener.ear.transfer.UPPER]\nfile = "way.csv"\n{own}{others}'
    )
    if content is not None:
        (tmp_path / "way.csv").write_text(content)
    said = caller(monkeypatch, capsys)("run", path)
    said.refuses(says)
    assert ("study.toml:" in said.words) or ("way.csv" in said.words)
    assert not (tmp_path / "results").exists()


@pytest.mark.parametrize(
    ("table", "says"),
    [
        (TransferTable(file="a.mat"), r"a file that ends in .csv, .wav"),
        (TransferTable(file="f.wav"), "f.wav has no calibration"),
        (TransferTable(file="f.wav", full_scale=1.0, function=2), "has 1 function, none of them 2"),
        (TransferTable(file="e.unv"), "e.unv has 2 functions"),
        (TransferTable(file="e.unv", function=3), "none of them 3"),
        (TransferTable(file="d.uff", per="volume velocity"), "where d.uff tells volume acceleration"),
        (TransferTable(file="force.uff"), "in Pa over N"),
        (TransferTable(file="time.uff"), r"the frequencies of the function 3 X / 2 X are in ms; expected one of Hz"),
    ],
)
def test_files_that_are_no_way_are_told(tmp_path, table, says):
    files(tmp_path)
    (tmp_path / "force.uff").write_bytes(function(np.ones(9), freq=np.arange(1.0, 10), labels=("Pa", "N")))
    (tmp_path / "time.uff").write_bytes(function(np.ones(9), freq=np.arange(1.0, 10), over_unit="ms"))
    with pytest.raises(creak.InputError, match=says):
        transfer_of(table, tmp_path / table.file, 0, AWAY, "")


def test_its_file_is_among_the_paths_of_a_study():
    table = {"listener": {"ear": {"transfer": {"P": {"file": "a.csv"}}}}, "room": {"reverberation": "t.csv"}}
    moved = map_paths(table, lambda _, path: f"there/{path}")
    assert moved["listener"]["ear"]["transfer"]["P"]["file"] == "there/a.csv"
    assert moved["room"]["reverberation"] == "there/t.csv"
