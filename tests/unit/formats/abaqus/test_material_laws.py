"""Rubber and foam at zero strain, constants at a temperature, and laws that small strain leaves out."""

from __future__ import annotations

import pytest

from creak.errors import InputError
from creak.formats.abaqus.reader import read_deck
from creak.model.comparison import difference

CUBE = (
    "*NODE\n1,0,0,0\n2,1,0,0\n3,1,1,0\n4,0,1,0\n5,0,0,1\n6,1,0,1\n7,1,1,1\n8,0,1,1\n*NSET,NSET=ALL,GENERATE\n1,8\n"
    "*ELEMENT,TYPE=C3D8I,ELSET=E\n1,1,2,3,4,5,6,7,8\n*SOLID SECTION,ELSET=E,MATERIAL=M\n*MATERIAL,NAME=M{}\n"
)
DENSITY = "*DENSITY\n1.1E-9\n"


def model_of(tmp_path, law, param="", tail=""):
    path = tmp_path / "deck.inp"
    path.write_text(CUBE.format(param) + law + DENSITY + tail, encoding="utf-8")
    return read_deck(path)


def constants(tmp_path, law, tail=""):
    """Shear and bulk modulus."""
    model = model_of(tmp_path, law, tail=tail)
    assert not any(u.changes_answer for u in model.unread)
    m = model.blocks[0].section.material
    return m.shear_modulus, m.youngs_modulus / (3.0 * (1.0 - 2.0 * m.poisson_ratio))


@pytest.mark.parametrize(
    ("law", "shear", "bulk"),
    [
        ("*HYPERELASTIC, NEO HOOKE\n.5, .1\n", 1.0, 20.0),
        ("*HYPERELASTIC, MOONEY-RIVLIN\n.4, .1, .1\n", 1.0, 20.0),
        ("*HYPERELASTIC, POLYNOMIAL, N=2\n.4, .1, .01, .02, .03, .1, 0.\n", 1.0, 20.0),
        ("*HYPERELASTIC, N=1\n.4, .1, .1\n", 1.0, 20.0),
        ("*HYPERELASTIC, REDUCED POLYNOMIAL, N=2\n.5, -.01, .1, 0.\n", 1.0, 20.0),
        ("*HYPERELASTIC, YEOH\n.5, -.01, .001, .1, 0., 0.\n", 1.0, 20.0),
        ("*HYPERELASTIC, OGDEN, N=3\n.6, 2., .3, 4., .1, -2., .1, 0.\n0.\n", 1.0, 20.0),
        ("*HYPERELASTIC, ARRUDA-BOYCE\n1., 1.E6, .1\n", 1.0, 20.0),
        ("*HYPERELASTIC, VAN DER WAALS\n1., 10., .3, 0., .1\n", 1.0, 20.0),
        ("*HYPERFOAM, N=2\n.2, 4., .1, -2., .2, .1\n", 0.3, 0.4 * (1 / 3 + 1 / 3) + 0.2 * (1 / 3 + 0.125)),
        ("*HYPERFOAM, N=1, POISSON=0.\n.2, 4.\n", 0.2, 0.4 / 3.0),
    ],
)
def test_moduli_at_zero_strain(tmp_path, law, shear, bulk):
    assert constants(tmp_path, law) == pytest.approx((shear, bulk), rel=1e-9)


def test_the_locking_stretch(tmp_path):
    """mu (1 + 3/(5 l^2) + ...) at l = 2."""
    wanted = 1.0 + 0.6 / 4 + 99 / 175 / 16 + 513 / 875 / 64 + 42039 / 67375 / 256
    assert constants(tmp_path, "*HYPERELASTIC, ARRUDA-BOYCE\n1., 2., .1\n")[0] == pytest.approx(wanted)


def test_a_rubber_without_compressibility(tmp_path):
    """D = 0: nu just below a half, the shear modulus as it is; and the note says so."""
    shear, bulk = constants(tmp_path, "*HYPERELASTIC, NEO HOOKE\n.5, 0.\n")
    assert shear == pytest.approx(1.0)
    assert bulk > 900.0
    notes = [u.why for u in model_of(tmp_path, "*HYPERELASTIC, NEO HOOKE\n.5, 0.\n").unread]
    assert notes == ["creak takes it at zero strain: E = 2.999, nu = 0.4995"]


@pytest.mark.parametrize(
    ("law", "message"),
    [
        ("*HYPERELASTIC, OGDEN, TEST DATA INPUT\n*UNIAXIAL TEST DATA\n1., 1.\n", "has no constants"),
        ("*HYPERELASTIC, NEO HOOKE\n-.5, .1\n", "shear modulus -1"),
        ("*HYPERFOAM\n.5, 2., .5\n", "has the shear modulus 0.5 and nu = "),
        ("*HYPERELASTIC, MARLOW\n", "has no constants"),
        ("*HYPERELASTIC, OGDEN, N=1000000000\n1.\n", "has N=1000000000; expected 1 to 6"),
        ("*HYPERFOAM\n0., 2., .1\n", "shear modulus 0"),
    ],
)
def test_rubber_that_has_no_moduli(tmp_path, law, message):
    with pytest.raises(InputError, match=message):
        model_of(tmp_path, law)


TABLE = "*ELASTIC\n2000., .3, 0.\n1000., .4, 100.\n"


@pytest.mark.parametrize(
    ("start", "youngs", "nu"), [(25.0, 1750.0, 0.325), (None, 2000.0, 0.3), (-40.0, 2000.0, 0.3), (150.0, 1000.0, 0.4)]
)
def test_constants_at_the_initial_temperature(tmp_path, start, youngs, nu):
    """Linear between the lines, constant beyond; 0 where no temperature is given, as in Abaqus; and it is told."""
    tail = f"*INITIAL CONDITIONS, TYPE=TEMPERATURE\nALL, {start}\n" if start is not None else ""
    model = model_of(tmp_path, TABLE, tail=tail)
    material = model.blocks[0].section.material
    assert (material.youngs_modulus, material.poisson_ratio) == pytest.approx((youngs, nu))
    assert not any(u.changes_answer for u in model.unread)
    assert any(f"creak takes it at {start or 0.0:g}" in u.why for u in model.unread)


def test_nine_constants_at_a_temperature(tmp_path):
    """An entry of two lines: eight constants, then the ninth and the temperature."""
    law = "*ELASTIC, TYPE=ENGINEERING CONSTANTS\n" + "".join(
        f"{e}, {e}, {e}, .3, .3, .3, {e / 2.6}, {e / 2.6}\n{e / 2.6}, {t}\n"
        for e, t in ((2000.0, 0.0), (1000.0, 100.0))
    )
    axes = "*ORIENTATION, NAME=O\n1., 0., 0., 0., 1., 0.\n"
    path = tmp_path / "deck.inp"
    start = "*INITIAL CONDITIONS, TYPE=TEMPERATURE\nALL, 50.\n"
    path.write_text(
        CUBE.format("").replace("MATERIAL=M\n", "MATERIAL=M, ORIENTATION=O\n") + law + DENSITY + axes + start
    )
    C = read_deck(path).blocks[0].section.material.elasticity
    assert C[3, 3] == pytest.approx(1500.0 / 2.6)


@pytest.mark.parametrize(
    ("tail", "message"),
    [
        ("*INITIAL CONDITIONS, TYPE=TEMPERATURE\n1, 10.\n2, 20.\n", "starts at temperatures from 10 to 20"),
        ("*ELASTIC\n1., .3, 100.\n2., .3, 50.\n", "temperatures of .ELASTIC do not rise"),
    ],
)
def test_temperatures_that_say_too_much_or_too_little(tmp_path, tail, message):
    law, after = (tail, "") if tail.startswith("*ELASTIC") else (TABLE, tail)
    with pytest.raises(InputError, match=message):
        model_of(tmp_path, law, tail=after)


def test_laws_of_large_strain_and_drawing_change_nothing(tmp_path):
    laws = "*ELASTIC\n2000., .3\n*PLASTIC\n30., 0.\n40., .1\n*EXPANSION\n1.E-5\n*DAMAGE INITIATION, CRITERION=DUCTILE\n.1\n"
    tail = "*DISPLAY BODY, INSTANCE=X\n*SECTION PRINT, NAME=S\n*SOLVER CONTROLS\n"
    model = model_of(tmp_path, laws, ", RTOL=.02", tail)
    found = {u.keyword: u.changes_answer for u in model.unread}
    assert found == dict.fromkeys(
        ("*PLASTIC", "*DAMAGE INITIATION", "*DISPLAY BODY", "*SECTION PRINT", "*SOLVER CONTROLS"), False
    )


def test_a_keyword_of_steps_is_no_misspelling(tmp_path):
    """The hint beside an error does not take *STATIC for *ELASTIC."""
    with pytest.raises(InputError, match=r"0\.7|CLOAD|load") as error:
        model_of(tmp_path, "*ELASTIC\n2000., .7\n", tail="*STEP\n*STATIC\n*CLOAD\n1, 1, 1.\n*END STEP\n")
    assert "is not a keyword" not in str(error.value)
    with pytest.raises(InputError, match=r"ELASTICC at .* is not a keyword that creak knows. Did you mean 'ELASTIC'"):
        model_of(tmp_path, "*ELASTICC\n2000., .3\n")


@pytest.mark.parametrize(
    ("short", "numbers"),
    [
        ("ISO", "100., .3"),
        ("ORTHO", "100., 20., 100., 20., 20., 100., 40., 40.,\n40."),
        ("ANISO", "100., 20., 100., 20., 20., 100., 0., 0.,\n0., 40., 0., 0., 0., 0., 40., 0.,\n0., 0., 0., 0., 40."),
    ],
)
def test_words_of_calculix_are_short(tmp_path, short, numbers):
    one, other = (model_of(tmp_path, f"*ELASTIC, TYPE={word}\n{numbers}\n") for word in (short, f"{short}TROPIC"))
    assert difference(one, other) == ""
