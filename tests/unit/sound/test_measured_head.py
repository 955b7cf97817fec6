"""Measured heads: a rigid sphere by its exact series, written as a SOFA file, heard again at its ears."""

from __future__ import annotations

import numpy as np
import pytest

from creak.errors import InputError
from creak.formats.measured.sofa import head_responses
from creak.sound.head import RADIUS, Ears, surrounding
from creak.sound.rayleigh import AIR
from helpers_hrtf import exact, grid, responses, unit, write_sofa

RECORDED = {"section": "sound"}

AHEAD, LEFT = np.array([1.0, 0.0, 0.0]), np.array([0.0, 1.0, 0.0])


@pytest.fixture(scope="module")
def sphere() -> tuple[np.ndarray, np.ndarray]:
    angles = grid()
    return angles, responses(unit(angles))


def ears(path) -> Ears:
    found = head_responses(path, "study.toml:1")
    around = surrounding(found.directions)
    assert around is not None
    return Ears(around, found.responses, found.rate, found.delay)


@pytest.fixture(scope="module")
def heard(tmp_path_factory, sphere) -> Ears:
    path = tmp_path_factory.mktemp("sofa") / "sphere.sofa"
    write_sofa(path, *sphere)
    return ears(path)


def between(count: int = 40) -> np.ndarray:
    """Directions that were not measured."""
    rng = np.random.default_rng(4)
    found = rng.normal(size=(count, 3))
    found[:, 2] = np.abs(found[:, 2])
    return found / np.linalg.norm(found, axis=1)[:, None]


def test_third_octaves_at_the_ear_are_those_of_the_exact_sphere(heard, measured):
    """Equalised for sound from the front, in directions between those that were measured."""
    some, errors = between(), []
    for middle in (125.0, 500.0, 1000.0, 2000.0, 4000.0, 8000.0):
        freq = middle * 2 ** np.linspace(-1 / 6, 1 / 6, 9)
        front = np.abs(exact(freq, np.zeros(1)))[0]
        for side in (1, -1):
            head = heard.head(AHEAD, LEFT, side)
            true = np.mean(np.abs(exact(freq, side * some[:, 1]) / front) ** 2, axis=1)
            found = [np.mean(np.abs(head.gain(freq, 2.0 * d)) ** 2) for d in some]
            errors.append(10 * np.log10(found / true))
    error = np.array(errors).reshape(-1, 2, len(some))
    sees = np.array([some[:, 1] > 0.0, some[:, 1] < 0.0])
    assert np.sqrt(np.mean(error**2)) < 0.75
    measured(
        "third octaves at the ear of a measured head that sees the source: largest error, dB",
        float(np.abs(error[:, sees]).max()),
        at_most=1.0,
        source="rigid sphere, exact series (Morse and Ingard)",
    )


def test_delays_between_the_ears_are_those_of_short_and_of_long_waves(heard):
    """Woodworth's a / c (theta + sin theta) of what comes first, and 3 a / c sin(theta) of long waves (Kuhn)."""
    left, right = heard.head(AHEAD, LEFT, 1), heard.head(AHEAD, LEFT, -1)
    for degrees in (0.0, 35.0, 65.0, 90.0):
        theta = np.radians(degrees)
        at = 2.0 * np.array([np.cos(theta), np.sin(theta), 0.0])
        path = (right.path(at[None]) - left.path(at[None]))[0] / RADIUS
        assert path == pytest.approx(theta + np.sin(theta), abs=0.25)
        freq = np.array([300.0])
        turn = (
            float(np.angle(left.gain(freq, at) / right.gain(freq, at))[0]) / (2 * np.pi * freq[0]) * AIR.speed / RADIUS
        )
        assert path + turn == pytest.approx(3 * np.sin(theta), abs=0.25)
    assert left.path(2.0 * AHEAD[None])[0] == pytest.approx(2.0, abs=0.005)


def test_a_head_turns_with_where_it_looks(heard):
    """Looking along -y, its left is +x."""
    turned = heard.head(np.array([0.0, -1.0, 0.0]), np.array([1.0, 0.0, 0.0]), 1)
    plain, some, freq = heard.head(AHEAD, LEFT, 1), between(5), np.array([500.0, 3000.0])
    for d in some:
        other = d[0] * np.array([0.0, -1.0, 0.0]) + d[1] * np.array([1.0, 0.0, 0.0]) + d[2] * np.array([0.0, 0.0, 1.0])
        np.testing.assert_allclose(turned.gain(freq, other), plain.gain(freq, d), rtol=1e-9)
        np.testing.assert_allclose(turned.path(other[None]), plain.path(d[None]), rtol=1e-9)


def test_other_ways_to_write_the_same_measurement(tmp_path, sphere, heard):
    """Cartesian; a head that looks elsewhere; the right ear first; delays apart; a chair that is not at 0."""
    angles, ir = sphere
    turn = np.array([[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])
    at, none = 1.5 * unit(angles), {"kinds": {"SourcePosition": "cartesian"}}
    ways = {
        "cartesian": {"SourcePosition": at, **none},
        "turned": {
            "SourcePosition": at @ turn.T + [3.0, 0.0, 1.0],
            "ListenerPosition": np.array([[3.0, 0.0, 1.0]]),
            "ListenerView": np.array([[90.0, 0.0, 1.0]]),
            "ListenerUp": np.array([[0.0, 0.0, 1.0]]),
            "kinds": {"SourcePosition": "cartesian", "ListenerView": "spherical", "ListenerUp": "cartesian"},
        },
        "right first": {
            "Data_IR": ir[:, ::-1],
            "ReceiverPosition": np.array([[0.0, -0.09, 0.0], [0.0, 0.09, 0.0]])[:, :, None],
        },
        "later": {"Data_IR": np.roll(ir, -20, axis=2), "Data_Delay": np.full((len(ir), 2), 20.0)},
    }
    freq = np.array([300.0, 2000.0, 7000.0])
    for name, changes in ways.items():
        write_sofa(tmp_path / "one.sofa", angles, ir, **changes)
        found = ears(tmp_path / "one.sofa")
        for side in (1, -1):
            one, other = (e.head(AHEAD, LEFT, side) for e in (found, heard))
            for d in between(6):
                np.testing.assert_allclose(one.gain(freq, d), other.gain(freq, d), atol=0.02, err_msg=name)
                np.testing.assert_allclose(one.path(d[None]), other.path(d[None]), atol=1e-3, err_msg=name)


def test_the_top_of_a_head_is_in_the_coordinates_of_where_it_looks(tmp_path, sphere):
    """AES69 gives Type and Units to ListenerView alone; a Type of its own counts."""
    angles, ir = sphere
    turn = np.array([[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])
    looks = {
        "SourcePosition": 1.5 * unit(angles) @ turn.T,
        "ListenerView": np.array([[90.0, 0.0, 1.0]]),
        "units": {"ListenerView": "degree, degree, metre", "SourcePosition": "meters"},
    }
    kinds = {"SourcePosition": "cartesian", "ListenerView": "spherical"}
    for up, more in (([123.0, 90.0, 1.0], {}), ([0.0, 0.0, 1.0], {"ListenerUp": "cartesian"})):
        write_sofa(tmp_path / "one.sofa", angles, ir, **looks, ListenerUp=np.array([up]), kinds=kinds | more)
        found = head_responses(tmp_path / "one.sofa", "study.toml:1")
        np.testing.assert_allclose(found.directions, unit(angles), atol=1e-12)


WRONG = {
    "no SOFA": ({"attributes": {"Conventions": "other"}}, "is no SOFA file"),
    "transfer functions": ({"attributes": {"DataType": "TF"}}, "data of type TF"),
    "one ear": ({"Data_IR": np.ones((505, 1, 8))}, "Data.IR of shape"),
    "silence": ({"Data_IR": np.zeros((505, 2, 8))}, "all zero"),
    "no number": ({"Data_IR": np.full((505, 2, 8), np.nan)}, "no number"),
    "no data": ({"Data_IR": None}, "has no numbers Data.IR"),
    "rate": ({"Data_SamplingRate": np.array([0.0])}, "sampling rates of 0"),
    "rates": ({"Data_SamplingRate": np.array([1.0, 2.0])}, "sampling rates of 1 to 2"),
    "delays": ({"Data_Delay": np.zeros((3, 2))}, "Data.Delay of shape"),
    "sources": ({"SourcePosition": np.ones((3, 3))}, "SourcePosition of shape"),
    "middle": ({"SourcePosition": np.zeros((505, 3))}, "in the middle of the head"),
    "up": ({"ListenerUp": np.array([[1.0, 0.0, 0.0]])}, "along its own top"),
    "up, nearly": ({"ListenerUp": np.array([[1.0, 0.0, 0.05]])}, "along its own top"),
    "up as the view": (
        {
            "ListenerView": np.array([[0.0, 0.0, 1.0]]),
            "ListenerUp": np.array([[0.0, 0.0, 1.0]]),
            "kinds": {"ListenerView": "spherical"},
        },
        "along its own top",
    ),
    "view": ({"ListenerView": np.zeros((1, 3))}, "looks nowhere"),
    "radians": ({"units": {"SourcePosition": "radian, radian, metre"}}, "SourcePosition in radian, radian, metre"),
    "kilohertz": ({"units": {"Data.SamplingRate": "kilohertz"}}, "a sampling rate in kilohertz"),
    "coordinates": ({"kinds": {"SourcePosition": "polar"}}, "'polar' coordinates"),
    "three ears": ({"ReceiverPosition": np.zeros((3, 3))}, "ReceiverPosition of shape"),
}


@pytest.mark.parametrize("what", WRONG)
def test_what_is_no_head_is_refused(what, tmp_path, sphere):
    changes, words = WRONG[what]
    assert len(sphere[0]) == 505
    write_sofa(
        tmp_path / "head.sofa",
        *sphere,
        **{k: dict(v) if k in ("kinds", "attributes", "units") else v for k, v in changes.items()},
    )
    with pytest.raises(InputError, match=r"head\.sofa") as told:
        head_responses(tmp_path / "head.sofa", "study.toml:1")
    assert words in str(told.value)


def test_files_that_are_none_are_refused(tmp_path):
    (tmp_path / "text.sofa").write_text("azimuth,elevation\n")
    with pytest.raises(InputError, match="is no HDF5 file, as SOFA files are"):
        head_responses(tmp_path / "text.sofa", "study.toml:1")
    with pytest.raises(InputError, match="no such file"):
        head_responses(tmp_path / "none.sofa", "study.toml:1")


def test_directions_must_go_around_the_head():
    flat = np.array([(a, 0.0) for a in np.arange(0.0, 360.0, 10.0)])
    above = np.array([(a, e) for a in np.arange(0.0, 360.0, 10.0) for e in (10.0, 50.0)])
    assert surrounding(unit(flat)) is None
    assert surrounding(unit(above)) is None
    assert surrounding(unit(grid())) is not None
