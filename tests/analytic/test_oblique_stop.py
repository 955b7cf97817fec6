"""A mass meets an oblique, hard stop with friction, in both engines: v_n turns round, v_t loses mu times that."""

from __future__ import annotations

import numpy as np
import pytest

from creak.progress import silent
from creak.studies.file.reader import read_study
from creak.studies.prepare.setup import set_up
from creak.studies.run.job import run_study
from helpers_decks import write_study

SPRING = "*ELEMENT, TYPE=SPRING1, ELSET=K{0}\n1{0}, 1\n*SPRING, ELSET=K{0}\n{0}\n1.E-3\n"
DECK = (
    "*NODE\n1, 0., 0., 0.\n*NSET, NSET=BALL\n1\n*ELEMENT, TYPE=MASS, ELSET=M\n1, 1\n*MASS, ELSET=M\n1.,\n"
    + SPRING.format(1)
    + SPRING.format(3)
    + "*BOUNDARY\nBALL, 2, 2\n*INITIAL CONDITIONS, TYPE=VELOCITY\nBALL, 1, 2.\nBALL, 3, -1.\n"
)
STUDY = """
[model]
deck = "ball.inp"
units = "m-kg-s"
[damping]
modal = 0.0
[[connector]]
type = "play"
nodes = ["BALL"]
axis = [0.7, 0, 2.4]
lower = -0.1
stiffness = "hard"
friction = {friction}
[reduction]
method = "{method}"
[time]
end = 0.5
accuracy = "fine"
[output]
nodes = ["BALL"]
"""


@pytest.mark.parametrize("method", ["none", "craig-bampton"])
@pytest.mark.parametrize(
    ("friction", "sliding"), [("0.2", 0.2), ("{ static = 0.4, kinetic = 0.3, decay = 0.0 }", 0.3), ("0.0", 0.0)]
)
def test_momentum_along_and_across_the_stop(tmp_path, method, friction, sliding):
    """n = (.28, 0, .96): v_n = -.4 m/s becomes .4, and 2.2 m/s across lose mu 2 v_n, for it slides all the time."""
    study_path = write_study(tmp_path, STUDY.format(friction=friction, method=method), {"ball.inp": DECK})
    result = run_study(set_up(read_study(study_path)), silent)
    (history,) = (run.history for run in result.runs.values())
    n, v = np.array([0.28, 0.0, 0.96]), np.array([2.0, 0.0, -1.0])
    across = v - (v @ n) * n
    after = across * (1.0 + 2.0 * sliding * (v @ n) / np.linalg.norm(across)) - (v @ n) * n
    time = history.time[history.output_index]
    late = time > 0.4  # the stop is met after .25 s
    found = np.polyfit(time[late], history.displacement[late, :3], 1)[0]
    # The springs of 1e-3 N/m, which hold the mass, take 1e-3 N/kg times half a second and metre of the speed
    np.testing.assert_allclose(found, after, atol=5e-4)
