"""Beam sections by shape: properties by formula, a cantilever of each, offsets, mistakes."""

from __future__ import annotations

import math

import numpy as np
import pytest

from creak.arrays import to_dense
from creak.assembly.part import Rayleigh, part_system
from creak.formats.abaqus.reader import read_deck
from creak.formats.abaqus.sections.beam_shapes import thin_walled
from creak.formats.abaqus.writer import write_deck
from creak.formats.deck.cross_section import rectangle_torsion, trapezoid_torsion
from creak.model.comparison import difference
from creak.model.materials import BeamSection
from helpers_refusal import refusal

YOUNG, SHEAR = 210000.0, 210000.0 / 2.6
STEEL = f"*MATERIAL, NAME=STEEL\n*ELASTIC\n {YOUNG}, 0.3\n*DENSITY\n 7.85e-9\n"
BEAM = "*NODE\n 1, 0.\n 2, 40.\n*ELEMENT, TYPE=B31, ELSET=B\n 1, 1, 2\n"


def read(tmp_path, shape: str, data: str, more: str = "", also: str = ""):
    path = tmp_path / "d.inp"
    head = f"*BEAM SECTION, ELSET=B, MATERIAL=STEEL, SECTION={shape}{also}"
    path.write_text(f"{BEAM}{head}\n{data}\n 0., 1., 0.\n{more}{STEEL}")
    return read_deck(path)


def section(tmp_path, shape: str, data: str, more: str = "", also: str = "") -> BeamSection:
    found = read(tmp_path, shape, data, more, also).blocks[0].section
    assert isinstance(found, BeamSection)
    return found


ROOT = math.sqrt(3.0)
A, B, C, D = 3.0, 4.0, 2.0, 1.5
LOW = B * (A + 2 * C) / (3 * (A + C)) - D
SHAPES = {
    # area, I11, I22 about the centroid, centroid, shear centre
    "HEX": (
        "3., .2",
        1.5 * ROOT * (9.0 - (3.0 - 0.4 / ROOT) ** 2),
        *(5 * ROOT / 16 * (81.0 - (3.0 - 0.4 / ROOT) ** 4),) * 2,
        (0.0, 0.0),
        (0.0, 0.0),
    ),
    "TRAPEZOID": (
        f"{A}, {B}, {C}, {D}",
        0.5 * (A + C) * B,
        B**3 * (A * A + 4 * A * C + C * C) / (36 * (A + C)),
        (A**4 - C**4) * B / (48 * (A - C)),
        (0.0, LOW),
        (0.0, LOW),
    ),
    # a channel of width 2 and height 4, walls of .1: e = 3 b^2/(h + 6 b) behind the web
    "ARBITRARY": (
        "3, 2., -2., 0., -2., .1\n 0., 2., .1\n 2., 2., .1",
        0.8,
        0.1 * 64.0 / 12.0 + 2 * 0.2 * 4.0,
        0.1 * (2 * 8.0 / 3.0) - 0.8 * 0.25,
        (0.5, 0.0),
        (-0.75, 0.0),
    ),
}


@pytest.mark.parametrize("shape", SHAPES)
def test_properties_by_formula(tmp_path, shape):
    data, area, i11, i22, centroid, centre = SHAPES[shape]
    found = section(tmp_path, shape, data)
    assert (found.area, found.i11, found.i22) == pytest.approx((area, i11, i22), rel=1e-12)
    assert found.angle == 0.0
    assert found.centroid == pytest.approx(centroid, abs=1e-12)
    assert found.shear_centre == pytest.approx(centre, abs=1e-12)


def test_an_angle_is_two_rectangles_about_turned_axes(tmp_path):
    """Leg of 5 x .4 along axis 1, 3 x .2 along axis 2, which share the corner; their middle lines cross in the node."""
    found = section(tmp_path, "L", "5., 3., .4, .2")
    legs = [(-0.1, 4.9, -0.2, 0.2), (-0.1, 0.1, 0.2, 2.8)]
    x, y, area = (np.zeros(2) for _ in range(3))
    for k, (left, right, low, high) in enumerate(legs):
        area[k], x[k], y[k] = (right - left) * (high - low), 0.5 * (left + right), 0.5 * (low + high)
    centre = np.array([(area * x).sum(), (area * y).sum()]) / area.sum()
    own11 = [(r - le) * (h - lo) ** 3 / 12 for le, r, lo, h in legs]
    own22 = [(h - lo) * (r - le) ** 3 / 12 for le, r, lo, h in legs]
    i11 = sum(own11) + (area * (y - centre[1]) ** 2).sum()
    i22 = sum(own22) + (area * (x - centre[0]) ** 2).sum()
    i12 = (area * (x - centre[0]) * (y - centre[1])).sum()
    values = np.linalg.eigvalsh([[i11, -i12], [-i12, i22]])
    assert sorted((found.i11, found.i22)) == pytest.approx(values, rel=1e-12)
    assert found.centroid == pytest.approx(centre, rel=1e-12)
    assert found.shear_centre == (0.0, 0.0)
    assert found.torsion == pytest.approx((4.9 * 0.4**3 + 2.8 * 0.2**3) / 3.0, rel=1e-12)
    assert (found.shear_area1, found.shear_area2) == (found.area, found.area)


def test_torsion_of_trapezoids():
    """Rectangles by the series, to 1e-5; the equilateral triangle, sqrt(3)/80 a^4."""
    for a, b in ((1.0, 1.0), (4.0, 1.0), (1.0, 10.0)):
        assert trapezoid_torsion(a, b, a) == pytest.approx(rectangle_torsion(a, b), rel=1e-5)
    assert trapezoid_torsion(1.0, ROOT / 2, 1e-6) == pytest.approx(ROOT / 80, rel=1e-5)
    assert trapezoid_torsion(1.0, 2.0, 3.0) == pytest.approx(trapezoid_torsion(3.0, 2.0, 1.0), rel=1e-4)


def test_a_cell_and_a_slit_tube_of_thin_walls():
    """Bredt's 4 A^2/oint ds/t of a box; a tube with a slit has its shear centre 2 R from the middle, J = 2 pi R t^3/3."""
    box = thin_walled([(-1, -2), (1, -2), (1, 2), (-1, 2), (-1, -2)], [0.1, 0.2, 0.1, 0.2], 1.0)
    assert box.torsion == pytest.approx(4 * 64 / (2 * 2 / 0.1 + 2 * 4 / 0.2) + (4 * 0.1**3 + 8 * 0.2**3) / 3, rel=1e-12)
    assert box.shear_centre == pytest.approx((0.0, 0.0), abs=1e-12)
    turn = np.linspace(-np.pi + 1e-4, np.pi - 1e-4, 721)
    tube = thin_walled([(math.cos(a), math.sin(a)) for a in turn], [0.01] * 720, 1.0)
    assert tube.shear_centre == pytest.approx((2.0, 0.0), abs=1e-3)
    assert tube.torsion == pytest.approx(2 * np.pi * 1e-6 / 3, rel=1e-4)


@pytest.mark.parametrize(
    ("element", "numbers", "radius", "told"),
    [
        ("B32R", "6.", 6.0, True),
        ("B32R", "6., 6.", 3.0, False),
        ("B32", "6.", 6.0, False),
        ("B32", "6., 6.", 3.0, False),
    ],
)
def test_circ_is_a_radius_in_abaqus_and_diameters_in_calculix(tmp_path, element, numbers, radius, told):
    """CalculiX, to which alone B32R belongs, takes one number for the diameter as well."""
    path = tmp_path / "deck.inp"
    text = f"*NODE\n1, 0.\n2, 5.\n3, 10.\n*ELEMENT, TYPE={element}, ELSET=B\n1, 1, 2, 3\n"
    text += "*MATERIAL, NAME=M\n*ELASTIC\n2.E5, .3\n*DENSITY\n1.\n"
    path.write_text(f"{text}*BEAM SECTION, ELSET=B, MATERIAL=M, SECTION=CIRC\n{numbers}\n0., 1., 0.\n")
    model = read_deck(path)
    assert model.blocks[0].section.area == pytest.approx(np.pi * radius**2)
    assert any(u.changes_answer for u in model.unread) == told


@pytest.mark.parametrize(("shape", "factor"), [("HEX", 0.53), ("TRAPEZOID", 0.822), ("ARBITRARY", 1.0)])
def test_a_cantilever_bends_as_timoshenko_says(tmp_path, shape, factor):
    """Force along axis 2 (global z) through the shear centre: F L^3/3 E I11 + F L/k G A, no twist."""
    data, area, i11, *_ = SHAPES[shape]
    model = read(tmp_path, shape, data)
    centre = np.array(model.blocks[0].section.shear_centre)
    K = to_dense(part_system(model, 0, Rayleigh(0.0, 0.0)).K)[6:, 6:]
    force = np.zeros(6)
    force[2], force[3] = 1.0, centre[0]
    u = np.linalg.solve(K, force)
    at_centre = u[2] + u[3] * centre[0]
    assert at_centre == pytest.approx(40.0**3 / (3 * YOUNG * i11) + 40.0 / (factor * SHEAR * area), rel=1e-9)
    assert abs(u[3]) < 1e-9 * abs(u[4])


@pytest.mark.parametrize(
    ("more", "also", "place"),
    [("*BEAM SECTION OFFSET\n .5, -.25\n", "", (0.5, -0.25)), ("", ", OFFSET1=.5, OFFSET2=-1.", (1.0, -2.0))],
)
def test_offset_of_a_section(tmp_path, more, also, place):
    """As lengths along axes 1 and 2, or (CalculiX) in widths of the section."""
    found = section(tmp_path, "RECT", "2., 2.", more, also)
    assert found.centroid == found.shear_centre == place


@pytest.mark.parametrize("shape", [*SHAPES, "L"])
def test_sections_are_written_as_they_were_read(tmp_path, shape):
    data = SHAPES[shape][0] if shape in SHAPES else "5., 3., .4, .2"
    model = read(tmp_path, shape, data, "*BEAM SECTION OFFSET\n .5, -.25\n")
    write_deck(model, tmp_path / "copy.inp")
    assert difference(model, read_deck(tmp_path / "copy.inp"), names=False) == ""


@pytest.mark.parametrize(
    ("shape", "data", "also", "words"),
    [
        ("HEX", "3., 3.", "", "HEX with wall 3 that leaves no hole"),
        ("L", "5., 3., .4, 6.", "", "L of 5 x 3 has legs thicker than they are long"),
        ("TRAPEZOID", "3., 4., -2., 0.", "", "dimension of the TRAPEZOID section"),
        ("ARBITRARY", "5, 2., -2., 0., -2., .1\n 0., 2., .1", "", "has 5 walls and 3 data lines"),
        ("ARBITRARY", "1, 2., -2., 0., -2., .1", "", "walls of the section lie on one line"),
        ("ARBITRARY", "2, 2., -2., 0., -2., .1\n 0., 2., 0.", "", "a wall of the section is 0 thick"),
        ("L", "5., 3., .4, .2", ", OFFSET1=.5", "OFFSET1 and OFFSET2 of a beam section L"),
    ],
)
def test_mistakes_are_named(tmp_path, shape, data, also, words):
    error = refusal(read, tmp_path, shape, data, also=also)
    assert words in error.what
    assert f"{tmp_path / 'd.inp'}:" in error.where
    assert error.expected
