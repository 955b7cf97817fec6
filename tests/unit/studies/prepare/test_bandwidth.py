"""The low-pass that run and mesh can tell, and contact with what is held: no number of the study is asked for."""

from __future__ import annotations

import numpy as np
import pytest

import creak
from creak.contact.facets import facets_of
from creak.formats.decks import read_model
from creak.studies.file.reader import read_study
from creak.studies.prepare.flight_steps import IN_A_RUN, PER_WAVE, carried
from creak.studies.prepare.setup import set_up
from helpers_decks import write_study


def deck(n: int, length: float, young: float, density: float, speed: float, gap: float, wall: float = 1.0) -> str:
    """A bar of one C3D8 across and n along x, which flies at a held shell of one element."""
    lines = ["*NODE, NSET=A"]
    for i in range(n + 1):
        lines += [
            f"{4 * i + j + 1}, {gap + length * i / n}, {y}, {z}"
            for j, (y, z) in enumerate(((-0.1, -0.1), (0.1, -0.1), (0.1, 0.1), (-0.1, 0.1)))
        ]
    lines.append("*ELEMENT, TYPE=C3D8, ELSET=BAR")
    lines += [", ".join(str(m) for m in (4 * i - 3, *range(4 * i - 3, 4 * i + 5))) for i in range(1, n + 1)]
    lines += ["*NODE, NSET=FLOOR", *(f"{9001 + j}, 0., {y * wall}, {z * wall}" for j, (y, z) in enumerate(CORNERS))]
    lines += ["*ELEMENT, TYPE=S4, ELSET=PLATE", "9001, 9001, 9002, 9003, 9004"]
    lines += ["*SURFACE, NAME=TABLE", "PLATE, SPOS", "*SHELL SECTION, ELSET=PLATE, MATERIAL=STEEL", "1e-3"]
    lines += ["*SOLID SECTION, ELSET=BAR, MATERIAL=OWN", "*MATERIAL, NAME=OWN", "*ELASTIC", f"{young}, 0."]
    lines += ["*DENSITY", f"{density}", "*MATERIAL, NAME=STEEL", "*ELASTIC", "2.1e11, 0.3", "*DENSITY", "7850."]
    # a spring that is next to nothing: a study asks for something that holds each part
    lines += ["*ELEMENT, TYPE=SPRING1, ELSET=WEAK", "8001, 1", "*SPRING, ELSET=WEAK", "1", f"{1e-9 * young}"]
    lines += ["*BOUNDARY", "FLOOR, 1, 6", "A, 2, 3", "*INITIAL CONDITIONS, TYPE=VELOCITY", f"A, 1, {-speed}"]
    return "\n".join(lines) + "\n"


CORNERS = ((-1, -1), (1, -1), (1, 1), (-1, 1))


def written(folder, end: float, more: str = "", time: str = "", clearance: float = 5.0, **of_deck):
    bar = {"n": 20, "length": 10.0, "young": 900.0, "density": 1.0, "speed": 10.0, "gap": 0.05, **of_deck}
    return write_study(
        folder,
        '[model]\ndeck = "deck.inp"\nunits = "m-kg-s"\n[damping]\nmodal = 0.0\n'
        f'[contact.touch]\nsecondary = "BAR"\nmain = "TABLE"\nclearance = {clearance!r}\n[time]\nend = {end!r}\n{time}\n{more}',
        {"deck.inp": deck(**bar)},
    )


def low_pass_of(path) -> tuple[float, list[str]]:
    setup = set_up(read_study(path))
    return setup.study.config.verification.f_max, [n for n in setup.notes if "low-passed" in n]


def test_of_an_ordinary_run_it_is_what_the_page_says(tmp_path):
    assert low_pass_of(written(tmp_path, 0.1, young=2.1e11, density=7850.0)) == (500.0, [])


def test_a_short_run_has_ten_periods_of_it(tmp_path):
    f_max, notes = low_pass_of(written(tmp_path, 2e-4, young=2.1e11, density=7850.0, length=0.2, clearance=0.5))
    assert f_max == pytest.approx(IN_A_RUN / 2e-4)
    assert len(notes) == 1
    assert "the run is 0.0002 s long" in notes[0]


def test_a_coarse_mesh_of_something_slow_carries_less(tmp_path):
    f_max, notes = low_pass_of(written(tmp_path, 1.4))
    assert f_max == pytest.approx(30.0 / (PER_WAVE * 0.2))  # the bar is .2 wide and .5 from node to node
    assert "too coarse" in notes[0]
    assert low_pass_of(written(tmp_path, 1.4, "[verification]\nf_max = 300.0\n")) == (300.0, [])
    tables = set_up(read_study(written(tmp_path, 1.4))).study.config.verification
    assert tables.event_tolerance == pytest.approx(5.0 / f_max)


def test_a_forced_step_keeps_it(tmp_path):
    forced = 'integrator = "hht"\nstep = 1e-3\n'
    assert low_pass_of(written(tmp_path, 1.4, time=forced, more="[precheck]\nenabled = false\n"))[0] == 500.0


@pytest.mark.parametrize(("kind", "steps"), [("C3D8", 1.0), ("C3D20", 2.0), ("C3D4", np.nan)])
def test_steps_of_the_mesh_count_not_elements(tmp_path, kind, steps):
    """A cube of side 1: a second-order one has nodes half-way, the height of a tetrahedron is 3 V / A of its slope."""
    corners = [(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0), (0, 0, 1), (1, 0, 1), (1, 1, 1), (0, 1, 1)]
    edges = [(0, 1), (1, 2), (2, 3), (3, 0), (4, 5), (5, 6), (6, 7), (7, 4), (0, 4), (1, 5), (2, 6), (3, 7)]
    points = np.array(corners, dtype=float)
    if kind == "C3D20":
        points = np.concatenate([points, [(points[a] + points[b]) / 2.0 for a, b in edges]])
    if kind == "C3D4":
        points = points[[0, 1, 3, 4]]
    lines = ["*NODE", *(f"{i + 1}, {x}, {y}, {z}" for i, (x, y, z) in enumerate(points))]
    labels = [str(i + 1) for i in range(len(points))]
    lines += [f"*ELEMENT, TYPE={kind}, ELSET=E", ", ".join(["1", *labels[:15]]) + ("," if len(labels) > 15 else "")]
    lines += [", ".join(labels[15:])] if len(labels) > 15 else []
    lines += ["*SOLID SECTION, ELSET=E, MATERIAL=M", "*MATERIAL, NAME=M", "*ELASTIC", "900., 0.", "*DENSITY", "1."]
    path = tmp_path / "one.inp"
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")
    model = read_model(path)
    height = 1.0 / steps if np.isfinite(steps) else (1.0 / 6.0) / (np.sqrt(3.0) / 2.0)
    assert carried(model, np.array([0])) == pytest.approx(30.0 / (PER_WAVE * height))
    assert carried(model, np.zeros(0, dtype=np.int64)) == np.inf


def test_what_is_held_is_rigid_at_any_mesh(tmp_path):
    """A stop of one element, ten times as wide: contact is as stiff as the bar is."""
    found = []
    for wall in (1.0, 10.0):
        path = written(tmp_path, 0.1, young=2.1e11, density=7850.0, wall=wall)
        setup = set_up(read_study(path))
        assert np.isinf(facets_of(setup.model, "TABLE", where="").normal_stiffness).all()
        found.append(np.sort(setup.contacts.stiffness))
    np.testing.assert_allclose(found[0], found[1], rtol=1e-12)
    # 10 E A / h of the bar's end in all, and of its sides what lies beside it
    assert found[0].sum() >= 10.0 * 2.1e11 * 0.04 / 0.5 * (1.0 - 1e-12)


def test_bar_on_a_rigid_wall_is_one_blow_that_settles(tmp_path):
    """Contact for 2 L / c = 2/3 s, impulse 2 m v: the foot of an undamped mesh hops, which is no event of the bar."""
    run = creak.run(written(tmp_path, 1.4)).summary["runs"]["reduced"]
    assert run["verdict"] == "settled"
    (blow,) = run["events"]
    assert blow["t_start"] == pytest.approx(0.5, rel=1e-4)
    assert blow["t_end"] - blow["t_start"] == pytest.approx(2.0 / 3.0, rel=0.05)
    assert blow["impulse"] == pytest.approx(2.0 * 0.04 * 10.0 * 10.0, rel=0.03)
