"""Compact bodies in a run's sound: which they are, and what is heard of them against Koss and Alfredson's sphere."""

from __future__ import annotations

import numpy as np
import pytest

from creak.arrays import to_dense
from creak.dynamics.diagonal import modal_matrices
from creak.model.materials import SolidSection
from creak.model.mesh import Model
from creak.model.skin import skin_of
from creak.reduction.diagonal import diagonalise
from creak.sound.acceleration_noise import acceleration_noise, equivalent_radius
from creak.sound.answering import Modes
from creak.sound.forced import lead
from creak.studies.sound.listeners import Listener
from creak.studies.sound.radiation import Source, compact_bodies, radiation, record_of
from helpers_core import STEEL, assembled, block, model_of, shell
from helpers_solids import solid_mesh
from helpers_sound import faded

RECORDED = {"section": "sound"}

BAND, RATE, SIDE = 500.0, 48_000, 0.04
VOLUME = SIDE**3


def box(size: tuple[float, float, float] = (SIDE, SIDE, SIDE), n: tuple[int, int, int] = (2, 2, 2)) -> Model:
    coords, elements = solid_mesh(n, size)
    return model_of(coords, [block("hex8", elements, SolidSection("STEEL", STEEL))], [("CUBE", range(len(coords)))])


def test_a_cube_is_compact_where_its_sphere_is_small_beside_the_wavelength():
    """Wholly up to ka = 1, not at all from 2 on; a cube of 12 m nowhere in what is heard."""
    (body,) = compact_bodies(skin_of(box()), 1.0)
    assert body.radius == pytest.approx(equivalent_radius(VOLUME))
    assert body.centre == pytest.approx(np.full(3, SIDE / 2))
    one = 343.2 / (2 * np.pi * body.radius)
    assert body.compact(one * np.array([0.01, 0.5, 1.0, 2.0, 5.0])).tolist() == [1.0, 1.0, 1.0, 0.0, 0.0]
    assert body.compact(one * np.linspace(1.0, 2.0, 9)) + body.large(one * np.linspace(1.0, 2.0, 9)) == pytest.approx(1)
    assert compact_bodies(skin_of(box((12.0, 12.0, 12.0))), 1.0) == ()


def test_long_bodies_and_shells_are_not():
    assert compact_bodies(skin_of(box((0.06, 0.012, 0.012))), 1.0) == ()
    coords = np.array([[0.0, 0, 0], [0.02, 0, 0], [0.02, 0.02, 0], [0, 0.02, 0]])
    plate = model_of(coords, [block("quad4", np.array([[0, 1, 2, 3]]), shell(0.001))], [("PLATE", range(4))])
    assert compact_bodies(skin_of(plate), 1.0) == ()


@pytest.mark.parametrize("angle", [0.0, 50.0])
def test_a_free_cube_that_is_struck(angle, measured):
    """Force over mass moves it: the sound of the sphere of its volume with that acceleration, in the band."""
    model = box()
    system = diagonalise(assembled(model))
    nodes = np.arange(model.nodes.count)
    rows = to_dense(system.rows(6 * nodes + 2)[0])
    t = np.arange(9_600) / RATE
    force = np.where((t > 0.1) & (t < 0.103), 30.0 * np.sin(np.pi * (t - 0.1) / 0.003), 0.0)
    source = Source(
        Modes(*modal_matrices(system), rows.mean(axis=0)[None]), force[:, None], np.array([0]), np.array([0])
    )
    centre = np.full(3, SIDE / 2)
    position = centre + 0.6 * np.array([np.sin(np.radians(angle)), 0.0, np.cos(np.radians(angle))])
    listener = Listener("ear", position, skin_of(model), ("CUBE",), given=True)
    to = radiation(system, listener, 1.0, BAND)
    start = lead(RATE, to.band)
    found = record_of(source, [np.array([0])], to)[0, start : start + t.size]
    acceleration = np.zeros((t.size, 3))
    acceleration[:, 2] = force / (STEEL.density * VOLUME)
    exact = acceleration_noise(acceleration, RATE, equivalent_radius(VOLUME), centre, position)
    spectrum = np.fft.rfft(exact, 4 * t.size) * faded(np.fft.rfftfreq(4 * t.size, 1 / RATE), BAND)
    exact = np.fft.irfft(spectrum, 4 * t.size)[: t.size]
    measured(
        "free cube that is struck: largest error over the peak",
        np.abs(found - exact).max() / np.abs(exact).max(),
        at_most=0.01,
        source="acceleration noise of the sphere of its volume",
    )
