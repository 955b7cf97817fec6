"""Modes that a test found without error have themselves as partners, however its file holds them.

Sign, scale, phase, units, frames, labels and places may differ: MAC stays 1 to the square of six digits.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from creak.errors import InputError
from creak.formats.measured.mode_files import read_measured_modes
from creak.formats.measured.uff import write_uff
from creak.report.words.correlation import sentence
from creak.studies.models import correlation
from creak.studies.models.deck_modes import deck_modes
from creak.studies.prepare.sensors import locate, read_sensor_map
from helpers_decks import STEEL, patch
from helpers_modal import (
    COUNT,
    SHELL,
    Test,
    complex_mode,
    csv_text,
    data_set,
    every_mode,
    frames_2420,
    measured_strip,
    normal_mode,
    points_15,
    points_2411,
    strip_deck,
    units_164,
)

SIX_DIGITS = 4.0 * (5e-6) ** 2
"""1 - MAC of numbers that have six digits, of values and of directions."""
TURN = np.array([[0.8, 0.6, 0.0], [-0.6, 0.8, 0.0], [0.0, 0.0, 1.0]]) @ np.array(
    [[1.0, 0.0, 0.0], [0.0, 0.28, 0.96], [0.0, -0.96, 0.28]]
)
"""Rows are the axes of a turned frame."""
PHASES = np.exp(1j * np.array([0.3, 1.4, -2.0, 2.9, 0.0, -1.5]))


@pytest.fixture(scope="module")
def strip(tmp_path_factory):
    """The deck's modes, and the test."""
    return measured_strip(strip_deck(tmp_path_factory.mktemp("strip")))


def scaled(t, factor):
    return replace(t, points=t.points * factor)


def phased(t):
    return "".join(normal_mode(t, k, t.shapes[k] * PHASES[k]) for k in range(COUNT))


def in_frame(t):
    """Motion in a turned frame of data set 2420."""
    t = replace(t, frames={7: np.vstack([TURN, [0.0, 0.0, 0.0]])})
    return (
        frames_2420(t) + points_15(t, moved=7) + "".join(normal_mode(t, k, t.shapes[k] @ TURN.T) for k in range(COUNT))
    )


def defined_in_frame(t):
    """Points in a turned and moved frame."""
    origin = np.array([5.0, -3.0, 11.0])
    t = replace(t, frames={4: np.vstack([TURN, origin])})
    return frames_2420(t) + points_15(t, defined=4, points=(t.points - origin) @ TURN.T) + every_mode(t)


def cylindrical(t):
    """Motion along radius, tangent and axis z about a point beside the strip."""
    origin = np.array([-40.0, 30.0, 0.0])
    t = replace(t, frames={3: np.vstack([np.eye(3), origin])}, kinds={3: 1})
    r = (t.points - origin)[:, :2]
    c, s = (r / np.linalg.norm(r, axis=1)[:, None]).T
    turned = [np.column_stack([c * u[:, 0] + s * u[:, 1], -s * u[:, 0] + c * u[:, 1], u[:, 2]]) for u in t.shapes]
    return frames_2420(t) + points_15(t, moved=3) + "".join(normal_mode(t, k, turned[k]) for k in range(COUNT))


def defined_in_cylinders(t):
    """Points by radius, angle and height of a turned and moved frame."""
    origin = np.array([5.0, -3.0, 11.0])
    x, y, z = ((t.points - origin) @ TURN.T).T
    t = replace(t, frames={4: np.vstack([TURN, origin])}, kinds={4: 1})
    polar = np.column_stack([np.sqrt(x * x + y * y), 180.0 / np.pi * np.arctan2(y, x), z])
    return frames_2420(t) + points_15(t, defined=4, points=polar) + every_mode(t)


def renumbered(t, add):
    return replace(t, labels=[n + add for n in t.labels])


def turned_labels(t):
    """Labels of nodes that lie elsewhere."""
    return replace(t, labels=t.labels[1:] + t.labels[:1])


def flat(t):
    """Nothing but z was measured; modes in the plane were not found."""
    bends = [k for k in range(COUNT) if np.abs(t.shapes[k][:, 2]).max() > 1e-3 * np.abs(t.shapes[k]).max()]
    return "".join(normal_mode(t, k, t.shapes[k] * [0.0, 0.0, 1.0]) for k in bends)


def velocity(t):
    return "".join(normal_mode(t, k, 2j * np.pi * t.frequencies[k] * t.shapes[k], kind=11) for k in range(COUNT))


def acceleration(t):
    return "".join(
        normal_mode(t, k, -((2 * np.pi * t.frequencies[k]) ** 2) * t.shapes[k], kind=12) for k in range(COUNT)
    )


def with_rotations(t, is_complex=False):
    more = [np.hstack([u, 0.01 * u[:, ::-1]]) * (1.0 + 0.0j if is_complex else 1.0) for u in t.shapes]
    return "".join(normal_mode(t, k, more[k]) for k in range(COUNT))


def one_short(t):
    """The first mode has no value at the last point."""
    few = replace(t, labels=t.labels[:-1], points=t.points[:-1], shapes=t.shapes[:, :-1])
    return normal_mode(few, 0) + "".join(normal_mode(t, k) for k in range(1, COUNT))


def both_of_a_pair(t):
    conjugate = "".join(complex_mode(t, k, np.conj(t.shapes[k] * PHASES[k]), sign=-1.0) for k in range(COUNT))
    return conjugate + "".join(complex_mode(t, k, t.shapes[k] * PHASES[k]) for k in range(COUNT))


UNIVERSAL = {
    "as it is": lambda t: points_15(t) + every_mode(t),
    "signs turned": lambda t: points_15(t) + every_mode(replace(t, shapes=-t.shapes)),
    "every other sign turned": lambda t: (
        points_15(t) + every_mode(replace(t, shapes=t.shapes * np.array([1, -1] * 3)[:, None, None]))
    ),
    "large": lambda t: points_15(t) + every_mode(replace(t, shapes=1e30 * t.shapes)),
    "small": lambda t: points_15(t) + every_mode(replace(t, shapes=1e-30 * t.shapes)),
    "complex, phases of their own": lambda t: points_15(t) + phased(t),
    "complex of first order": lambda t: points_15(t) + "".join(complex_mode(t, k) for k in range(COUNT)),
    "complex of second order": lambda t: points_15(t) + "".join(complex_mode(t, k, analysis=7) for k in range(COUNT)),
    "parts counted twice": lambda t: points_15(t) + "".join(complex_mode(t, k, counted=2) for k in range(COUNT)),
    "conjugates too": lambda t: points_15(t) + both_of_a_pair(t),
    "conjugates alone": lambda t: points_15(t) + "".join(complex_mode(t, k, sign=-1.0) for k in range(COUNT)),
    "velocities": lambda t: points_15(t) + velocity(t),
    "accelerations": lambda t: points_15(t) + acceleration(t),
    "rotations too": lambda t: points_15(t) + with_rotations(t),
    "complex rotations too": lambda t: points_15(t) + with_rotations(t, is_complex=True),
    "hysteretic damping": lambda t: points_15(t) + every_mode(t, hysteretic=True),
    "points of 2411": lambda t: points_2411(t) + every_mode(t),
    "points after modes": lambda t: every_mode(t) + points_15(t),
    "points in a frame": defined_in_frame,
    "points in cylinders": defined_in_cylinders,
    "motion in a frame": in_frame,
    "motion in cylinders": cylindrical,
    "frame 1 not told": lambda t: points_15(t, 1, 1) + every_mode(t),
    "frame 9 of no frames": lambda t: points_15(t, 9, 9) + every_mode(t),
    "metres": lambda t: units_164(1.0) + points_15(scaled(t, 1e-3)) + every_mode(t),
    "millimetres told": lambda t: units_164(1000.0) + points_15(t) + every_mode(t),
    "inches": lambda t: units_164(1.0 / 0.0254) + points_15(scaled(t, 1.0 / 25.4)) + every_mode(t),
    "labels of no node": lambda t: points_15(renumbered(t, 5000)) + every_mode(renumbered(t, 5000)),
    "labels of other nodes": lambda t: points_15(turned_labels(t)) + every_mode(turned_labels(t)),
    "no points": every_mode,
    "from high to low": lambda t: points_15(t) + "".join(normal_mode(t, k) for k in reversed(range(COUNT))),
    "a point that one mode lacks": lambda t: points_15(t) + one_short(t),
    "other data sets": lambda t: data_set(151, "NAME") + points_15(t) + every_mode(t) + data_set(2467, "1"),
    "DOS lines": lambda t: (points_15(t) + every_mode(t)).replace("\n", "\r\n"),
    "z alone": lambda t: points_15(t) + flat(t),
}
HEAD_MODE = "frequency_hz,damping,sensor,x,y,z,direction,value"
TABLES = {
    "x, y, z": csv_text,
    "signs in the directions": lambda t: csv_text(t, ("-x", "+y", "z-")),
    "skew directions": lambda t: csv_text(t, ("0.6 0 0.8", "0 1 0", "-8 0 6", "1 2 2")),
    "vectors of any length": lambda t: csv_text(t, ("0 0 -250", "3 0 0", "0 1e-3 0")),
    "semicolons and commas": lambda t: csv_text(t, separator=";").replace(".", ","),
    "tabs": lambda t: csv_text(t, separator="\t"),
    "per cent": lambda t: csv_text(t, head=HEAD_MODE.replace("damping", "damping_percent"), damping=100.0),
    "metres in the head": lambda t: csv_text(scaled(t, 1e-3), head=HEAD_MODE.replace("x,y,z", "x [m],y [m],z [m]")),
    "inches in the head": lambda t: csv_text(
        scaled(t, 1 / 25.4), head=HEAD_MODE.replace("x,y,z", "x (in),y (in),z (in)")
    ),
    "names in capitals": lambda t: csv_text(t, head=HEAD_MODE.upper()),
    "remarks": lambda t: "# a test\n\n" + csv_text(t),
}


@pytest.mark.parametrize("name", UNIVERSAL)
def test_universal_file(strip, tmp_path, name):
    found, t = strip
    path = tmp_path / "test.unv"
    path.write_text(UNIVERSAL[name](t), newline="")
    holds(found, t, path)


@pytest.mark.parametrize("name", TABLES)
def test_table(strip, tmp_path, name):
    found, t = strip
    path = tmp_path / "test.csv"
    path.write_text(TABLES[name](t), encoding="utf-8")
    holds(found, t, path)


def correlate(found, measured, **how):
    return correlation.correlate(found, measured, locate(found.model, measured, **how))


def holds(found, t, path, **options):
    """Every measured mode has its own as partner, with its frequency and damping."""
    c = correlate(found, read_measured_modes(path), **options)
    assert len(c.pairs) == c.measured.frequencies.size >= COUNT - 2
    for p in c.pairs:
        assert 1.0 - p.mac <= SIX_DIGITS
        k = p.model
        assert p.frequency_model == found.frequencies[k]
        assert p.frequency_test == pytest.approx(t.frequencies[k], rel=6e-6)
        assert p.damping_test == pytest.approx(t.damping[k], rel=2e-5)
        assert (
            np.abs(p.scale * c.test_shapes[:, p.test] - c.model_shapes[:, k]).max()
            <= 2e-5 * np.abs(c.model_shapes[:, k]).max()
        )
    assert c.alone_test == []
    np.testing.assert_allclose(c.collinearity, 1.0, atol=1e-10)
    return c


def test_what_creak_writes_comes_back(strip, tmp_path):
    """The whole model as a test."""
    found, _ = strip
    path = tmp_path / "own.unv"
    write_uff(path, found.model, found.frequencies, found.translations())
    c = correlate(found, read_measured_modes(path))
    assert [p.test for p in c.pairs] == [p.model for p in c.pairs] == list(range(COUNT))
    assert max(1.0 - p.mac for p in c.pairs) <= SIX_DIGITS
    assert set(c.sensors.how) == {"label"}
    assert "3 of 39 points are zero in every mode" in " ".join(c.notes)


def test_equal_frequencies_are_told_apart_by_a_column(strip, tmp_path):
    t = strip[1]
    path, bare = tmp_path / "twins.csv", tmp_path / "bare.csv"
    rows = csv_text(replace(t, frequencies=np.repeat(t.frequencies[::2], 2))).splitlines()
    per_mode = (len(rows) - 1) // COUNT
    text = ["mode," + rows[0], *(f"{k // per_mode},{row}" for k, row in enumerate(rows[1:]))]
    path.write_text("\n".join(text))
    bare.write_text("\n".join(",".join(line.split(",")[1:]) for line in text))
    with pytest.raises(InputError, match="second value"):  # without the column the two are one mode
        read_measured_modes(bare)
    assert read_measured_modes(path).frequencies.size == COUNT


def test_sensors_between_nodes_go_to_the_nearest_and_the_distance_is_told(strip, tmp_path):
    found, t = strip
    path = tmp_path / "off.csv"
    path.write_text(csv_text(replace(t, points=t.points + [1.5, 0.0, 2.0], labels=[900 + n for n in t.labels])))
    c = correlate(found, read_measured_modes(path))
    np.testing.assert_allclose(c.sensors.distance, 2.5, rtol=1e-9)
    assert set(c.sensors.how) == {"place"}
    assert "2.5 mm from" in " ".join(c.notes)
    assert min(p.mac for p in c.pairs) == pytest.approx(1.0, abs=1e-9)  # the values are those of the nodes


def test_a_map_goes_before_place_and_label(strip, tmp_path):
    found, t = strip
    far = replace(t, points=t.points + 500.0, labels=[n + 1 for n in t.labels])
    path, table = tmp_path / "far.csv", tmp_path / "map.csv"
    path.write_text(csv_text(far))
    table.write_text("sensor,node\n" + "".join(f"{a},{b}\n" for a, b in zip(far.labels, t.labels, strict=True)))
    measured = read_measured_modes(path)
    with pytest.raises(InputError, match="11 of 11 sensors are not on the model"):
        correlate(found, measured)
    c = correlate(found, measured, mapped=read_sensor_map(table, found.model, measured))
    assert set(c.sensors.how) == {"map"}
    assert min(p.mac for p in c.pairs) == pytest.approx(1.0, abs=1e-9)


def test_damping_of_the_deck_stands_beside_the_measured(strip, tmp_path):
    """Alpha M + beta K of the material: zeta = alpha / (2 omega) + beta omega / 2."""
    found, t = strip
    path = tmp_path / "t.csv"
    path.write_text(csv_text(t))
    for p in correlate(found, read_measured_modes(path)).pairs:
        omega = 2.0 * np.pi * p.frequency_model
        assert p.damping_model == pytest.approx(5.0 / (2.0 * omega) + 2.0e-6 * omega / 2.0, rel=1e-6)


def test_what_has_no_partner_is_told_on_both_sides(strip, tmp_path):
    """Mode 2 was not found; a mode that the model has not was."""
    found, t = strip
    rng = np.random.default_rng(1)
    shapes = t.shapes.copy()
    shapes[1] = rng.normal(size=shapes[1].shape)
    path = tmp_path / "t.csv"
    path.write_text(csv_text(replace(t, shapes=shapes)))
    c = correlate(found, read_measured_modes(path))
    assert c.alone_test == c.alone_model == [1]
    told = c.as_dict()
    assert told["test_without_partner"] == [{"mode": 2, "frequency": pytest.approx(t.frequencies[1])}]
    assert told["model_without_partner"][0]["mode"] == 2


@pytest.mark.parametrize("directions", [("x",), ("x", "y")])
def test_what_the_model_cannot_do_is_no_round_off_that_fits(tmp_path, directions):
    """A flat strip that bends along z moves nothing in its plane: so do its modes but the fifth."""
    deck = strip_deck(tmp_path)
    bending, every = (deck_modes(deck, count=count) for count in (4, COUNT))
    t = measured_strip(deck)[1]
    path = tmp_path / "t.csv"
    path.write_text(csv_text(replace(t, shapes=t.shapes[:, :, [2]] * np.ones(3)), directions))
    with pytest.raises(InputError, match=f"no mode of the model moves any of its {11 * len(directions)} channels"):
        correlate(bending, read_measured_modes(path))
    path.write_text(csv_text(t, directions))
    c = correlate(every, read_measured_modes(path))
    assert np.delete(c.mac, 4, axis=1).max() == 0.0
    assert [(p.test, p.model) for p in c.pairs] == [(4, 4)]


def test_what_looks_wrong_is_named(strip, tmp_path):
    """Sensors mounted head down, and frequencies that are not in Hz, are asked about and left as they are."""
    found, t = strip
    path = tmp_path / "t.csv"
    shapes = t.shapes.copy()
    shapes[:, [2, 5]] *= -1.0
    path.write_text(csv_text(replace(t, shapes=shapes), ("z",)))
    told = correlate(found, read_measured_modes(path)).notes[0]
    assert f"sensors that look reversed: {t.labels[2]} (z), {t.labels[5]} (z)" in told
    path.write_text(csv_text(replace(t, shapes=t.shapes[..., [1, 0, 2]])))
    told = correlate(found, read_measured_modes(path)).notes[0]
    assert "the axes of all sensors look turned, x being y and y being x: so the mean MAC" in told
    for factor, unit in ((2.0 * np.pi, "rad/s"), (60.0, "1/min")):
        path.write_text(csv_text(replace(t, frequencies=t.frequencies * factor)))
        with pytest.raises(
            InputError, match=f"look as if they were in {unit}.*, 6 of its 6 modes fit, and none as Hz:"
        ):
            correlate(found, read_measured_modes(path))
    path.write_text(csv_text(t))
    assert "look" not in " ".join(correlate(found, read_measured_modes(path)).notes)


def square_deck(folder):
    """A plate of 100 x 100 x 1 mm, clamped all round."""
    path, n = folder / "square.inp", 9
    quads = patch(1, "S", (0.0, 0.0, 0.0), (100.0, 0.0, 0.0), (0.0, 100.0, 0.0), (8, 8), 1)
    edge = [1 + i + n * j for i in range(n) for j in range(n) if i in (0, 8) or j in (0, 8)]
    held = "".join(f"{k}, 1, 6\n" for k in edge)
    path.write_text(f"*HEADING\nsquare\n{quads}{STEEL}{SHELL.replace('ROOT_S, 1, 6', held.strip())}")
    return path


def test_modes_of_one_frequency_are_combined_as_the_test_has_them(tmp_path):
    """A square plate's double mode, measured turned in its plane by 30 and by 45 degrees."""
    deck = square_deck(tmp_path)
    found = deck_modes(deck, count=6)
    f = found.frequencies
    k = next(k for k in range(5) if f[k + 1] < f[k] * 1.001)
    for angle in (30.0, 45.0):
        c, s = np.cos(np.radians(angle)), np.sin(np.radians(angle))
        shapes = found.shapes.copy()
        shapes[:, [k, k + 1]] = shapes[:, [k, k + 1]] @ [[c, -s], [s, c]]
        path = tmp_path / "turned.unv"
        write_uff(path, found.model, f, replace(found, shapes=shapes).translations())
        got = correlate(found, read_measured_modes(path))
        assert len(got.pairs) == 6
        assert max(1.0 - p.mac for p in got.pairs) <= SIX_DIGITS
        assert f"modes {k + 1}, {k + 2} of the model, near" in " ".join(got.notes)
        motion = np.array(list(got.found.translations()))[[k, k + 1]].reshape(2, -1)
        wanted = np.array(list(replace(found, shapes=shapes).translations()))[[k, k + 1]].reshape(2, -1)
        np.testing.assert_allclose(np.abs(motion @ wanted.T) / (wanted**2).sum(axis=1), np.eye(2), atol=1e-4)


def test_sensors_at_nodes_of_two_parts_are_named(tmp_path):
    """Two strips end to end, each clamped at its far end, their nodes at the seam not joined: labels tell them apart."""
    deck = tmp_path / "seam.inp"
    one, other = (
        patch(k, "S", (x, 0.0, 0.0), (60.0, 0.0, 0.0), (0.0, 20.0, 0.0), (6, 2), k) for k, x in ((1, 0.0), (101, 60.0))
    )
    held = "1, 1, 6\n8, 1, 6\n15, 1, 6\n107, 1, 6\n114, 1, 6\n121, 1, 6"
    deck.write_text(f"*HEADING\nseam\n{one}{other}{STEEL}{SHELL.replace('ROOT_S, 1, 6', held)}")
    found = deck_modes(deck, count=6)
    labels = [4, 7, 11, 14, 18, 21, 101, 104, 108, 111, 115, 118]
    rows = [int(np.flatnonzero(found.model.nodes.ids == label)[0]) for label in labels]
    shapes = np.stack([u[rows] for u in found.translations()])
    t = Test(labels, found.model.nodes.coords[rows], shapes, np.array(found.frequencies), np.full(6, 0.01))
    path = tmp_path / "t.unv"
    path.write_text(points_15(t) + every_mode(t))
    c = correlate(found, read_measured_modes(path))
    assert max(1.0 - p.mac for p in c.pairs) <= SIX_DIGITS
    assert "two parts" not in " ".join(c.notes)
    path.write_text(points_15(renumbered(t, 5000)) + every_mode(renumbered(t, 5000)))
    measured = read_measured_modes(path)
    try:
        told = " ".join(correlate(found, measured).notes)
    except InputError as error:
        told = str(error)
    assert "ensors that lie at nodes of two parts, of which the first was taken" in told
    assert ", and 1.00 with the better choices: name their nodes" in told
    for label, twin in ((7, 101), (14, 108), (21, 115)):
        assert f"{5000 + label} ({label} or {twin})" in told or f"{5000 + label} ({twin} or {label})" in told


def test_one_channel_tells_no_shape(strip, tmp_path):
    """The fifth mode moves in the plane, which a sensor along z does not see."""
    found, t = strip
    path = tmp_path / "t.csv"
    path.write_text(csv_text(replace(t, points=t.points[-1:], labels=t.labels[-1:], shapes=t.shapes[:, -1:]), ("z",)))
    c = correlate(found, read_measured_modes(path))
    assert c.of_one_channel
    assert [p.model for p in c.pairs] == [0, 1, 2, 3, 5]
    said = sentence(c)
    assert said.startswith("5 of 6 measured modes have a partner by frequency alone (frequency within 5 %)")
    assert "the shapes are not compared" in said


def test_the_units_of_a_deck_in_metres(tmp_path):
    """A test in mm beside a deck in m, kg, s: the materials tell the length of the deck."""
    deck = strip_deck(tmp_path)
    lines = []
    for line in deck.read_text().splitlines():
        cells = line.split(",")
        place = len(cells) == 4 and "." in line and "*" not in line
        lines.append(",".join([cells[0], *(f"{float(c) * 1e-3:.9g}" for c in cells[1:])]) if place else line)
    text = (
        "\n".join(lines)
        .replace("210000., 0.3", "210e9, 0.3")
        .replace("7.85e-9", "7850.")
        .replace("\n1.0,\n", "\n0.001,\n")
    )
    deck.write_text(text + "\n")
    found, t = measured_strip(deck)
    path = tmp_path / "t.unv"
    path.write_text(units_164(1000.0) + points_15(scaled(t, 1e3)) + every_mode(t))
    assert holds(found, t, path).sensors.scale == pytest.approx(1e-3)
