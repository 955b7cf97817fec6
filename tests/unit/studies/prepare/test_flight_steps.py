"""Short features of a load between points that lie far apart, against the closed form of a blow."""

from __future__ import annotations

import math

import pytest

import creak
from creak.studies.prepare.setup import set_up

DECK = """*NODE
1, 0, 0, 0
2, 10, 0, 0
*ELEMENT, TYPE=SPRINGA, ELSET=S
1, 1, 2
*SPRING, ELSET=S

1000.
*ELEMENT, TYPE=MASS, ELSET=M
2, 2
*MASS, ELSET=M
0.01
*NSET, NSET=TIP
2
*BOUNDARY
1, 1, 6
2, 2, 6
"""
STUDY = """[model]
deck = "mass.inp"
[[connector]]
type = "play"
nodes = "TIP"
dof = "x"
upper = 5.0
stiffness = 1e4
[excitation.blow]
node_set = "TIP"
dof = "x"
kind = "force"
signal = {{ type = "{}", values = {} }}
[damping]
modal = 0
[time]
end = 0.3
[output]
nodes = ["TIP"]
"""
OMEGA = math.sqrt(1000.0 / 0.01)
FAR = [(0.0, 0.0), (0.05, 0.0), (0.1, 0.0)], [(0.15, 0.0), (0.2, 0.0), (0.25, 0.0), (0.3, 0.0)]
"""Points before and after, 50 ms apart."""


def study_of(folder, kind, between):
    (folder / "mass.inp").write_text(DECK)
    points = [list(p) for p in (*FAR[0], *between, *FAR[1])]
    (folder / "study.toml").write_text(STUDY.format(kind, points))
    return creak.read_study(folder / "study.toml")


@pytest.mark.parametrize("kind", ["table", "smooth-step"])
def test_a_blow_between_far_points_is_that_of_its_impulse(tmp_path, kind):
    """1000 N on the way up and down over .1 ms each: .1 N s, which moves the mass by I / (m omega)."""
    blow = [(0.1004, 0.0), (0.1005, 1000.0), (0.1006, 0.0)]
    result = creak.run(study_of(tmp_path, kind, blow), converge=False)
    moved = result.runs["reduced"].history.displacement[:, 0].max()
    assert moved == pytest.approx(0.1 / (0.01 * OMEGA), rel=1e-3)
    assert not any("changes within" in note for note in result.notes)


def test_one_that_no_step_follows_is_told(tmp_path):
    setup = set_up(study_of(tmp_path, "table", [(0.1004, 0.0), (0.1004 + 1e-7, 1e6), (0.1004 + 2e-7, 0.0)]))
    (told,) = [note for note in setup.notes if "changes within" in note]
    assert told.startswith("[excitation.blow] changes within 1e-07 s, which flight steps of ")


def test_a_jump_takes_no_shorter_steps(tmp_path):
    """Only when it comes hangs on them."""
    steps = {}
    for name, between in (("jump", [(0.11, 0.0), (0.11 + 1e-7, 5.0), (0.15 - 1e-3, 5.0)]), ("none", [])):
        setup = set_up(study_of(tmp_path, "table", between))
        steps[name] = setup.study.config.time.step
        assert not any("changes within" in note for note in setup.notes)
    assert steps["jump"] == steps["none"]
