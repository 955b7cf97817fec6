"""LS-DYNA decks beyond twins: includes that are moved, other ways to write numbers, closed forms."""

from __future__ import annotations

import math

import numpy as np
import pytest
from numpy.testing import assert_allclose

from creak.formats.decks import format_of, read_model
from helpers_lsdyna import RHO, E, fixed_width, frequencies, held, nodes, only, part, plate, read_all, shells, steel

RECORDED = {"section": "decks", "source": "Euler-Bernoulli"}

ROUND_OFF = 1e-8
"""Of a lowest frequency: eps (f_max / f_1)**2, 6e-9 for the plate of .9 mm."""


def deck(*pieces, head=""):
    return f"*KEYWORD{head}\n" + "".join(p if isinstance(p, str) else p.k for p in pieces) + "*END\n"


def write(folder, text, name="deck.k"):
    path = folder / name
    path.write_text(text, encoding="utf-8")
    return path


def moved(places):
    """Turned by 90 degrees about z, then along x and z."""
    return {n + 1000: (300.0 - y, x, z + 40.0) for n, (x, y, z) in places.items()}


def clamped(places):
    return held([n for n, xyz in places.items() if xyz[0] == 0.0])


@pytest.mark.parametrize("nested", [False, True])
def test_an_included_file_is_shifted_and_moved(tmp_path, nested, measured):
    """The same plates written where the transformation puts them."""
    places, quads = plate(4, 3, 20.0)
    inner = deck(nodes(places), shells(quads, 0.9, 2, "TRIM"), steel(), clamped(places))
    write(tmp_path, inner, "trim.k")
    if nested:
        write(tmp_path, "*KEYWORD\n*INCLUDE\ntrim.k\n*END\n", "outer.k")
    turn = f"*DEFINE_TRANSFORMATION\n{fixed_width(7)}{fixed_width('ROTATE', 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 90.0)}"
    turn += fixed_width("TRANSL", 300.0, 0.0, 40.0)
    include = f"*INCLUDE_TRANSFORM\n{'outer' if nested else 'trim'}.k\n{fixed_width(1000, 1000, 10, 10, 10, 0, 0)}"
    include += f"{fixed_width(10)}\n{fixed_width(7)}"
    found = read_model(
        write(tmp_path, deck(nodes(places), shells(quads, 1.2), steel(), clamped(places), include, turn))
    )
    far = moved(places)
    twice = {e + 1000: tuple(n + 1000 for n in row) for e, row in quads.items()}
    supports = held([n for n in places if places[n][0] == 0.0] + [n + 1000 for n in places if places[n][0] == 0.0])
    pieces = (nodes(places | far), shells(quads, 1.2), shells(twice, 0.9, 12, "TRIM"), steel(), supports)
    written = read_model(write(tmp_path, deck(*pieces), "flat.k"))
    assert found.nodes.ids.tolist() == written.nodes.ids.tolist()
    assert_allclose(found.nodes.coords, written.nodes.coords, atol=1e-12 * 300.0)
    assert set(found.element_sets) == {"PART_1", "PLATE", "PART_12", "TRIM"}
    worst = np.abs(frequencies(found) / frequencies(written) - 1.0).max()
    measured("LS-DYNA file, moved: frequencies, relative difference", worst, at_most=ROUND_OFF, source="flat")


def test_a_mirrored_solid_keeps_its_modes(tmp_path):
    places = dict(
        enumerate([(0, 0, 0), (9, 0, 0), (9, 8, 0), (0, 8, 1), (0, 0, 7), (9, 0, 7), (9, 8, 7), (0, 8, 7)], 1)
    )
    places = {n: tuple(map(float, xyz)) for n, xyz in places.items()}
    solid = f"*ELEMENT_SOLID\n{fixed_width(1, 1, *range(1, 9), width=8)}{part(1, 'BODY', 1)}*SECTION_SOLID\n1,2\n"
    body = deck(nodes(places), solid, steel(), held([1, 2, 3, 4], "123"))
    write(tmp_path, body, "body.k")
    mirror = f"*DEFINE_TRANSFORMATION\n1\n{fixed_width('MIRROR', 0.0, 0.0, 0.0, 1.0, 0.0, 0.0)}"
    mirrored = write(tmp_path, f"*KEYWORD\n{mirror}*INCLUDE_TRANSFORM\nbody.k\n\n\n\n1\n*END\n")
    left, right = (frequencies(read_model(p), 6) for p in (mirrored, tmp_path / "body.k"))
    assert_allclose(left, right, rtol=ROUND_OFF)


EIGHT, TEN, NODE = (8,) * 10, (10,) * 8, (8, 16, 16, 16, 8, 8)
FORMS = {
    "fixed": ("*KEYWORD", lambda width: width),
    "long": ("*KEYWORD LONG=Y", lambda width: 20),
    "wide": ("*KEYWORD I10=Y", lambda width: max(width, 10)),
    "free": ("*KEYWORD", None),
}


def laid_out(form, places, quads):
    """A clamped plate in one of the forms of a card; titles stay as they are."""
    head, width_of = FORMS[form]

    def card(widths, *values):
        if width_of is None:
            return ",".join(map(str, values))
        return "".join(f"{v:>{width_of(w)}}" for v, w in zip(values, widths, strict=False))

    lines = [head, "*NODE", *(card(NODE, n, *xyz) for n, xyz in places.items())]
    lines += ["*ELEMENT_SHELL", *(card(EIGHT, e, 1, *row) for e, row in quads.items())]
    lines += ["*PART", "a, title", card(TEN, 1, 1, 1), "*SECTION_SHELL", card(TEN, 1, 16), card(TEN, 1.2)]
    lines += ["*MAT_ELASTIC", card(TEN, 1, RHO, E, 0.3), "*BOUNDARY_SPC_NODE"]
    lines += [card(TEN, n, 0, *[1] * 6) for n, xyz in places.items() if xyz[0] == 0.0]
    return "\n".join([*lines, "*END", "data after the end"])


@pytest.mark.parametrize("form", ["long", "wide", "free"])
def test_fixed_long_wide_and_free_fields_say_the_same(tmp_path, form):
    mesh = plate(3, 2, 20.0)
    found, expected = (
        frequencies(read_model(write(tmp_path, laid_out(f, *mesh), f"{f}.key"))) for f in (form, "fixed")
    )
    assert_allclose(found, expected, rtol=ROUND_OFF)


def test_one_keyword_alone_has_long_fields(tmp_path):
    mesh = plate(3, 2, 20.0)
    long, short = laid_out("long", *mesh), laid_out("fixed", *mesh)
    of_nodes = long[long.index("*NODE") : long.index("*ELEMENT")].replace("*NODE", "*NODE +")
    mixed = short[: short.index("*NODE")] + of_nodes + short[short.index("*ELEMENT") :]
    found, expected = (frequencies(read_model(write(tmp_path, text))) for text in (mixed, short))
    assert_allclose(found, expected, rtol=ROUND_OFF)


def test_first_bending_of_a_cantilever(tmp_path, measured):
    """f = 1.8751^2 / (2 pi L^2) sqrt(E I / (rho A)) of a slender beam (Euler-Bernoulli): 1e-3 for its shear and turn."""
    L, t, n = 400.0, 4.0, 20
    places = {i + 1: (L * i / n, 0.0, 0.0) for i in range(n + 1)} | {99: (0.0, 50.0, 0.0)}
    rows = "".join(fixed_width(i, 1, i, i + 1, 99, width=8) for i in range(1, n + 1))
    beam = f"*ELEMENT_BEAM\n{rows}{part(1, 'ROD', 1)}*SECTION_BEAM\n1,1,.8333,2,0\n2.0,2.0,{t},{t}\n"
    found = frequencies(read_model(write(tmp_path, deck(nodes(places), beam, steel(), held([1])))), 6)
    weak = 1.875104**2 / (2.0 * math.pi * L**2) * math.sqrt(E * 2.0**2 / 12.0 / RHO)
    measured("LS-DYNA cantilever: first bending", found[0], weak, rel=1e-3)
    measured("LS-DYNA cantilever: across", found[1], weak * t / 2.0, rel=1e-3)


@pytest.mark.parametrize(("nloc", "offset"), [(1.0, 0.0), (-1.0, 0.0), (0.0, 0.7), (0.5, 0.7)])
def test_shells_beside_their_nodes_are_those_of_nastran(tmp_path, nloc, offset):
    """NLOC 1: the nodes on the upper face, so the middle half a thickness below; ZOFFS is where the middle lies."""
    places, quads = plate(5, 2, 20.0)
    plain, t = shells(quads, 1.2), 1.2
    k = plain.k.replace(fixed_width(*[t] * 4), fixed_width(*[t] * 4, nloc))
    if offset:
        rows = [fixed_width(e, 1, *row, width=8) + fixed_width(offset, width=16) for e, row in quads.items()]
        k = "*ELEMENT_SHELL_OFFSET\n" + "".join(rows) + k[k.index("*PART") :]
    bdf = "".join(f"CQUAD4,{e},1,{','.join(map(str, row))},,{offset - 0.5 * t * nloc!r}\n" for e, row in quads.items())
    bdf += "PSHELL,1,1,1.2,1,,1\n"
    hinged = held([n for n, xyz in places.items() if xyz[0] in (0.0, 100.0)], "123")
    pieces = [nodes(places), only(plain.inp, bdf, k), steel(), hinged]
    found = read_all(tmp_path, pieces)
    assert_allclose(frequencies(found["k"]), frequencies(found["bdf"]), rtol=ROUND_OFF)
    assert (np.abs(frequencies(found["k"]) / frequencies(found["inp"]) - 1.0) > 1e-3).any()


def test_a_spring_on_a_vector_and_one_along_its_line(tmp_path):
    """omega^2 = k / m of one mass on each."""
    text = "*NODE\n1,0.,0.,0.,7,7\n2,5.,0.,0.,5,7\n3,0.,9.,0.,4,7\n*ELEMENT_MASS\n1,2,3.0\n2,3,3.0\n"
    text += f"*ELEMENT_DISCRETE\n1,1,1,2,0\n2,1,3,0,4,2.0\n{part(1, 'CLIP', 1)}*SECTION_DISCRETE\n1,0\n0.\n"
    text += "*MAT_SPRING_ELASTIC\n1,120.\n*DEFINE_SD_ORIENTATION\n4,0,0.,0.,2.\n"
    found = frequencies(read_model(write(tmp_path, deck(text))), 2)
    expected = [math.sqrt(k / 3.0) / (2.0 * math.pi) for k in (120.0, 240.0)]
    assert_allclose(found, expected, rtol=ROUND_OFF)


def test_a_small_change_of_one_deck_is_seen(tmp_path):
    places, quads = plate(3, 2, 20.0)
    one, other = (
        frequencies(read_model(write(tmp_path, deck(nodes(places), shells(quads, t), steel(), clamped(places)))))
        for t in (1.2, 1.2001)
    )
    assert (np.abs(other / one - 1.0) > 1e-5).any()


def test_decks_of_other_endings_are_known_by_their_first_words(tmp_path):
    places, quads = plate(2, 1, 20.0)
    text = deck(nodes(places), shells(quads, 1.0), steel())
    path = write(tmp_path, "$ a comment\n" + text, "deck.txt")
    assert format_of(path) is format_of(tmp_path / "deck.k")
    assert format_of(write(tmp_path, "*HEADING\n", "abaqus.txt")) is format_of(tmp_path / "deck.inp")


def test_surfaces_of_parts_and_segments(tmp_path):
    places, quads = plate(2, 1, 20.0)
    (first, second) = quads.values()
    segments = f"*SET_SEGMENT_TITLE\ntop side\n{fixed_width(5)}{fixed_width(*first)}{fixed_width(*second[::-1])}"
    model = read_model(write(tmp_path, deck(nodes(places), shells(quads, 1.0), steel(), segments)))
    assert {"PART_1", "PART_1.SPOS", "PART_1.SNEG", "PLATE", "SET_SEGMENT_5", "TOP_SIDE"} <= set(model.surfaces)
    assert model.surfaces["TOP_SIDE"].side.tolist() == [1, -1]
    assert model.mass_form == "consistent"
    assert model.parts[0].name == "PART_1"
