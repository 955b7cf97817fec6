"""Short features of a load between points that lie far apart, against the closed form of a blow."""

from __future__ import annotations

import math
import re

import numpy as np
import pytest

import creak
from creak.errors import InputError
from creak.studies.file.changes import with_changes
from creak.studies.prepare.flight_steps import _between_points
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


@pytest.mark.parametrize(
    ("shock", "told"),
    [
        ('type = "trapezoid", amplitude = 3000, rise = 1e-6, hold = 4e-5, fall = 1e-6', True),
        ('type = "trapezoid", amplitude = 300, rise = 1e-6, hold = 4e-4, fall = 1e-6', False),
        ('type = "half-sine", amplitude = 1e5, duration = 3e-6', True),
        ('type = "half-sine", amplitude = 1e3, duration = 3e-4', False),
    ],
)
def test_a_shock_shorter_than_steps_follow_is_told(tmp_path, shock, told):
    """Where nothing is told the mass has the whole impulse, I / (m omega), within 1 %."""
    (tmp_path / "mass.inp").write_text(DECK)
    text = re.sub(
        r"signal = .*", f"signal = {{ {shock}, start = 0.1 }}", STUDY.format("table", [[0.0, 0.0], [1.0, 1.0]])
    )
    (tmp_path / "study.toml").write_text(text)
    study = creak.read_study(tmp_path / "study.toml")
    assert any("changes within" in note for note in set_up(study).notes) == told
    if not told:
        x = creak.run(study, converge=False).runs["reduced"].history.displacement[:, 0]
        impulse = {"trapezoid": 300 * 4.01e-4, "half-sine": 1e3 * 3e-4 * 2.0 / np.pi}[shock.split('"')[1]]
        assert x.max() == pytest.approx(impulse / (0.01 * OMEGA), rel=0.01)


@pytest.mark.parametrize(("width", "allowed"), [(1e-7, 5e-3), (1e-4, 2e-3)])
def test_the_flank_between_plateaus_is_followed(tmp_path, width, allowed):
    """The mass swings about 5 / k from where the flank's middle lies: 5 / k (1 - cos(omega t) sinc(omega width / 2))."""
    study = study_of(tmp_path, "table", [(0.1103, 0.0), (0.1103 + width, 5.0), (0.15 - 1e-3, 5.0)])
    assert not any("changes within" in note for note in set_up(study).notes)
    history = creak.run(study, converge=False).runs["reduced"].history
    time, k = history.time[history.output_index], 1e-2 * OMEGA**2
    x = time - 0.1103 - 0.5 * width
    after = (x > width) & (time < 0.149)
    half = 0.5 * OMEGA * width
    exact = 5.0 / k * (1.0 - np.cos(OMEGA * x) * np.sin(half) / half)
    assert np.abs(history.displacement[:, 0] - exact)[after].max() < allowed * 5.0 / k


def test_many_uneven_samples_are_those_of_a_record():
    """Their spacing differs by up to a half; few points that draw a shape are followed by their steepest flank."""
    rng = np.random.default_rng(5)
    time = np.cumsum(1e-3 * (1.0 + rng.uniform(-0.5, 0.5, 500)))
    wanted = _between_points(time, rng.standard_normal(500)).step
    assert wanted == pytest.approx(np.median(np.diff(time)))
    assert _between_points(np.array([0.0, 0.1, 0.101, 0.3]), np.array([0.0, 0.0, 2.0, 2.0])).step == pytest.approx(2e-4)
    assert _between_points(np.array([0.0, 0.1]), np.array([3.0, 3.0])).step == math.inf
    at_random = np.sort(rng.uniform(0.0, 1.0, 1000))
    assert _between_points(at_random, rng.standard_normal(1000)).step == pytest.approx(np.median(np.diff(at_random)))
    pulses = np.add.outer(0.1 * np.arange(40), [0.0, 1e-4, 0.05, 0.0501]).ravel()
    assert _between_points(pulses, np.tile([0.0, 1.0, 1.0, 0.0], 40)).step == pytest.approx(2e-5)


def test_fine_steps_are_shorter(tmp_path):
    """Four times, for what is driven as well."""
    study = study_of(tmp_path, "table", [(0.11, 0.0), (0.1101, 5.0)])
    fine = with_changes(study, {"time.accuracy": "fine"})
    steps = [set_up(one).study.config.time.step for one in (study, fine)]
    assert steps[1] == pytest.approx(0.25 * steps[0], rel=0.1)


def test_a_sine_far_above_what_is_compared_is_followed(tmp_path):
    """A sin(w t) of a force: the mass swings by A / (m w^2 (1 - O^2 / w^2)) (O / w sin(w t) - O^2 / w^2 sin(O t))."""
    (tmp_path / "mass.inp").write_text(DECK)
    text = STUDY.replace('type = "{}", values = {}', 'type = "sine", frequency = 1.1e5, amplitude = 1e3')
    (tmp_path / "study.toml").write_text(text.replace("end = 0.3", "end = 0.02").replace("{{", "{").replace("}}", "}"))
    study = with_changes(creak.read_study(tmp_path / "study.toml"), {"verification.f_max": 500.0})
    x = creak.run(study, converge=False).runs["reduced"].history.displacement[:, 0]
    assert np.abs(x).max() == pytest.approx(1e3 / (0.01 * OMEGA * 2.0 * np.pi * 1.1e5), rel=0.01)


def test_more_steps_than_fit_are_told_of_the_frequency_that_was_given(tmp_path):
    (tmp_path / "mass.inp").write_text(DECK)
    text = STUDY.replace('type = "{}", values = {}', 'type = "sine", frequency = 2e8, amplitude = 1e3')
    (tmp_path / "study.toml").write_text(text.replace("{{", "{").replace("}}", "}"))
    with pytest.raises(InputError, match=r"\[time\]: .* flight steps .* the highest frequency that its excitations"):
        set_up(creak.read_study(tmp_path / "study.toml"))
