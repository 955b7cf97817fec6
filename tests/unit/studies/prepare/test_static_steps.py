"""*STATIC steps before *DYNAMIC in Abaqus decks: sag, forces and contact against closed forms, and rest that stays rest."""

from __future__ import annotations

import numpy as np
import pytest

from creak.errors import InputError
from creak.studies.prepare.deck_step import set_up_deck
from creak.studies.run.job import run_study

LENGTH, SIDE, MODULUS, DENSITY, GRAVITY, N = 200.0, 2.0, 210000.0, 7.85e-9, 9810.0, 8
EI, WEIGHT = MODULUS * SIDE**4 / 12.0, DENSITY * SIDE**2 * GRAVITY
SAG, GIVE = WEIGHT * LENGTH**4 / (8.0 * EI), LENGTH**3 / (3.0 * EI)
BEAM = (
    "*NODE\n"
    + "".join(f"{i + 1}, {LENGTH * i / N}, 0., 0.\n" for i in range(N + 1))
    + "*ELEMENT, TYPE=B31, ELSET=BEAM\n"
    + "".join(f"{i + 1}, {i + 1}, {i + 2}\n" for i in range(N))
    + f"*NSET, NSET=TIP\n{N + 1}\n*NSET, NSET=ROOT\n1\n*ELSET, ELSET=HALF\n1, 2\n"
    + f"*ELSET, ELSET=REST, GENERATE\n3, {N}, 1\n"
    + f"*MATERIAL, NAME=STEEL\n*ELASTIC\n{MODULUS}, 0.3\n*DENSITY\n{DENSITY},\n*DAMPING, ALPHA=5., BETA=2.e-6\n"
    + f"*BEAM SECTION, SECTION=RECT, ELSET=BEAM, MATERIAL=STEEL\n{SIDE}, {SIDE}\n0., 1., 0.\n*BOUNDARY\nROOT, 1, 6\n"
)
DOWN = f"*DLOAD\nBEAM, GRAV, {GRAVITY}, 0., 0., -1.\n"
SET_BY_SET = DOWN.replace("BEAM", "HALF") + DOWN.replace("BEAM", "REST")
OUTPUT = "*NODE OUTPUT, NSET=TIP\nU\n*END STEP\n"


def static(blocks: str) -> str:
    return f"*STEP\n*STATIC\n0.1, 1.\n{blocks}*OUTPUT, FIELD\n*END STEP\n"


def dynamic(blocks: str = "") -> str:
    return f"*STEP\n*DYNAMIC, DIRECT, ALPHA=-0.05\n1.E-4, 0.01\n{blocks}{OUTPUT}"


def set_up(folder, steps: str):
    path = folder / "beam.inp"
    path.write_text(BEAM + steps, encoding="utf-8")
    return set_up_deck(path)


def tip(folder, steps: str) -> np.ndarray:
    """(n,) motion of the tip along z."""
    return run_study(set_up(folder, steps), lambda *_: None).runs["reference"].history.displacement[:, 2]


@pytest.mark.parametrize(
    ("steps", "place"),
    [
        (static(DOWN) + dynamic(), -SAG),
        (static(DOWN.replace("BEAM,", ",")) + dynamic(DOWN), -SAG),
        (static(SET_BY_SET) + dynamic(), -SAG),
        (static(SET_BY_SET) + dynamic(SET_BY_SET), -SAG),
        (static(DOWN) + "*STEP, PERTURBATION\n*STATIC\n*CLOAD\nTIP, 3, 9.\n*END STEP\n" + dynamic(), -SAG),
        (static(DOWN) + static("*CLOAD\nTIP, 3, 0.2\n") + dynamic(), 0.2 * GIVE - SAG),
        (static("*CLOAD\nTIP, 3, 0.2\n") + static("*CLOAD\nTIP, 3, 0.1\n") + dynamic(), 0.1 * GIVE),
    ],
)
def test_the_run_starts_in_equilibrium_and_stays(tmp_path, steps, place):
    u = tip(tmp_path, steps)
    assert u[0] == pytest.approx(place, rel=1e-3)
    assert np.abs(u - u[0]).max() <= 1e-9 * abs(place)


def test_a_load_of_the_run_acts_about_the_static_place(tmp_path):
    pulse = "*AMPLITUDE, NAME=PULSE\n0., 0., 0.005, 1.\n"
    push = "*CLOAD, AMPLITUDE=PULSE\nTIP, 3, 0.05\n"
    plain = tip(tmp_path, pulse + dynamic(push))
    loaded = tip(tmp_path, pulse + static(DOWN) + dynamic(push))
    assert np.ptp(plain) > 1e-3
    assert loaded == pytest.approx(plain - SAG, abs=2e-3 * SAG)


REFUSED = {
    "other procedure": ("*STEP\n*VISCO\n*END STEP\n" + dynamic(), "a \\*VISCO step comes before"),
    "part of the mass": (static(DOWN.replace("BEAM", "HALF")) + dynamic(), "gravity on HALF alone"),
    "pressure": (static("*DLOAD\nBEAM, PX, 2.\n") + dynamic(), "\\*DLOAD with PX; expected GRAV, P"),
    "other gravity": (static(DOWN) + dynamic(DOWN.replace("-1.", "1.")), "another gravity"),
    "taken away": (static("*CLOAD\nTIP, 3, 1.\n") + dynamic("*CLOAD, OP=NEW\nTIP, 2, 1.\n"), "takes the loads"),
    "other name": (
        static("*CLOAD\nTIP, 3, 1.\n") + static(f"*CLOAD\n{N + 1}, 3, 1.\n") + dynamic(),
        "loads nodes that an earlier step loads as TIP",
    ),
    "replaced": (static("*CLOAD\nTIP, 3, 1.\n") + dynamic("*CLOAD\nTIP, 3, 2.\n"), "replaces that of the \\*STATIC"),
    "moved": (static("*BOUNDARY\nTIP, 3, 3, 0.1\n") + dynamic(), "\\*STATIC step moves TIP"),
    "freed": (static("*BOUNDARY\nTIP, 3, 3\n") + dynamic("*BOUNDARY, OP=NEW\nROOT, 1, 6\n"), "holds other dofs"),
    "no direction": (static("*DLOAD\n, GRAV, 9810.\n") + dynamic(), "without magnitude and direction"),
    "amplitude": (
        "*AMPLITUDE, NAME=RISE\n0., 0., 1., 1.\n" + static("*CLOAD, AMPLITUDE=RISE\nTIP, 3, 1.\n") + dynamic(),
        "has an AMPLITUDE",
    ),
}


@pytest.mark.parametrize("case", REFUSED)
def test_what_the_run_cannot_start_from_is_refused(tmp_path, case):
    steps, match = REFUSED[case]
    with pytest.raises(InputError, match=match):
        set_up(tmp_path, steps)


def test_what_is_not_read_of_a_static_step_is_listed(tmp_path):
    with pytest.raises(InputError, match="FIELD"):
        set_up(tmp_path, static("*FIELD\nTIP, 80.\n") + dynamic())
    with pytest.raises(InputError, match="\\*TEMPERATURE"):
        set_up(tmp_path, static(DOWN) + dynamic("*TEMPERATURE\nTIP, 80.\n"))
    notes = set_up(tmp_path, static("*TEMPERATURE\nTIP, 80.\n") + dynamic()).notes
    assert any("the temperature of the deck strains nothing" in note for note in notes)
    with pytest.raises(InputError, match="NLGEOM"):
        set_up(tmp_path, static(DOWN).replace("*STEP", "*STEP, NLGEOM") + dynamic())
