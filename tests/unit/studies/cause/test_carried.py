"""What the supports carry along is told apart from the modes and parts that swing: against one mass on two springs."""

from __future__ import annotations

import numpy as np
import pytest
import scipy.linalg as sla
from scipy.signal import lsim

import creak
from creak.studies.cause.decompose import CARRIED, EXCITATION, find_causes
from creak.studies.cause.effects import cause_dict, try_changes
from creak.studies.findings.sound import heard_places
from helpers_contact_studies import blows, play, points, push, solved, switched
from helpers_decks import STUDY as STRIPS
from helpers_decks import write_strips, write_study

RECORDED = {"section": "verdicts"}

M, LEFT, RIGHT, SHARE = 1e-3, 30.0, 10.0, 0.02
OMEGA = np.sqrt((LEFT + RIGHT) / M)
ROAD, OTHER = (20.0, 20000.0), (13.0, 5000.0)
"""Hz and mm/s^2."""
DECK = f"""*NODE
1, 0., 0., 0.
2, 0., 0., 10.
3, 0., 0., 5.
4, 0., 0., 6.
*NSET, NSET=RIGHT
2
*NSET, NSET=BODY
3
*NSET, NSET=STOP
4
*NSET, NSET=ENDS
1, 2, 4
*ELEMENT, TYPE=MASS, ELSET=M
1, 3
*MASS, ELSET=M
{M}
*ELEMENT, TYPE=SPRING2, ELSET=KL
2, 1, 3
*SPRING, ELSET=KL
3, 3
{LEFT}
*ELEMENT, TYPE=SPRING2, ELSET=KR
3, 2, 3
*SPRING, ELSET=KR
3, 3
{RIGHT}
*BOUNDARY
ENDS, 1, 6
BODY, 1, 2
"""
STUDY = f"""[model]
deck = "mass.inp"
units = "mm-t-s"
[[connector]]
type = "play"
name = "stop"
nodes = ["STOP", "BODY"]
dof = "z"
lower = -0.5
stiffness = 50
[nodes.ROAD]
labels = [ROADS]
[support.freed]
nodes = "ENDS"
free = ["z"]
[damping]
modal = {SHARE}
[excitation.road]
node_set = "ROAD"
dof = "z"
kind = "acceleration"
signal = {{ type = "sine", frequency = {ROAD[0]}, amplitude = {ROAD[1]} }}
[excitation.other]
node_set = "RIGHT"
dof = "z"
kind = "acceleration"
signal = {{ type = "sine", frequency = {OTHER[0]}, amplitude = {OTHER[1]} }}
[time]
end = 0.2
"""


ALIKE = STUDY.replace("ROADS", '"1", "2", "4"').split("[excitation.other]")[0] + "[time]\nend = 0.2\n"
"""All supports move as one."""


def _cause(folder, study):
    run = creak.run(creak.read_study(write_study(folder, study, {"mass.inp": DECK})), converge=False, record=False)
    found, places = run.found, heard_places(run.found.scope, run.main, run.sound)
    cause = find_causes(found.setup.marching, found.setup.reduction, run.main, places)[0]
    return run, cause, cause_dict(cause, run.found.setup.loads, run.found.gaps, "mm")


def _driven(frequency, amplitude, until):
    """Displacement of a base that starts from rest at a(t) = A sin(w t), and the mass's beyond that of the base."""
    w, time = 2 * np.pi * frequency, np.linspace(0.0, until, 40_001)
    base = amplitude * (time / w - np.sin(w * time) / w**2)
    system = [[0.0, 1.0], [-(OMEGA**2), -2 * SHARE * OMEGA]], [[0.0], [-1.0]], [[1.0, 0.0]], [[0.0]]
    return base[-1], lsim(system, amplitude * np.sin(w * time), time)[1][-1]


def test_modes_are_told_beyond_the_static_ride_of_each_excitation(tmp_path):
    """The static ride of the mass is (k_1 s_1 + k_2 s_2) / (k_1 + k_2); the stop rides with s_1."""
    _, cause, told = _cause(tmp_path, STUDY.replace("ROADS", '"1", "4"'))
    found = {s.name: s for s in cause.sources if s.kind == EXCITATION}
    sign = 1.0 if found["other"].direct > 0.0 else -1.0
    carried = 0.0
    for name, sizes, share, stop in (("road", ROAD, 0.75, 1.0), ("other", OTHER, 0.25, 0.0)):
        base, beyond = _driven(*sizes, cause.time)
        assert found[name].direct == pytest.approx(sign * (share - stop) * base, rel=1e-6)
        assert found[name].modes.sum() == pytest.approx(sign * share * beyond, rel=1e-4)
        carried += sign * (share - stop) * base
    parts = dict(cause.parts)
    assert parts[CARRIED] == pytest.approx(carried, rel=1e-6)
    assert sum(parts.values()) == pytest.approx(cause.gap - cause.gap0, abs=1e-10)
    assert told["with_supports"] == -parts[CARRIED]
    assert sum(p["closing"] for p in told["parts"]) + told["with_supports"] == pytest.approx(told["closing"], abs=1e-9)
    assert f"{told['with_supports']:.3g} mm is {CARRIED}" in told["words"]


def test_a_stop_that_rides_with_all_supports_is_told_of_the_swing_alone(tmp_path):
    """All supports drift by millimetres alike: neither the mode nor a part is told to move by that."""
    _, cause, told = _cause(tmp_path, ALIKE)
    base, beyond = _driven(*ROAD, cause.time)
    assert base > 10.0
    road = next(s for s in cause.sources if s.kind == EXCITATION)
    assert abs(road.direct) < 1e-9 * base
    assert abs(road.modes.sum()) == pytest.approx(abs(beyond), rel=1e-4)
    closing = sum(m["closing"] for m in told["modes"])
    assert closing == pytest.approx(told["closing"], abs=1e-9)
    assert sum(p["closing"] for p in told["parts"]) == pytest.approx(told["closing"], abs=1e-9)
    assert CARRIED not in told["words"]


def test_a_cause_is_taken_where_the_channel_presses(tmp_path):
    """Under preload, with events shorter than a flight step: force = preload + stiffness closing, so none is open."""
    study = ALIKE.replace("lower = -0.5", "lower = 0.0\npreload = 2").replace("stiffness = 50", "stiffness = 1.5e6")
    run, cause, told = _cause(tmp_path, study.replace("amplitude = 20000.0", "amplitude = 10000.0"))
    row = int(np.abs(run.history.time - cause.time).argmin())
    assert told["closing"] > 0.0
    assert run.history.force[row, cause.channel] == pytest.approx(2.0 + 1.5e6 * told["closing"], rel=1e-6)
    assert cause.total == pytest.approx(cause.gap - cause.gap0, abs=1e-10)


def test_a_contact_within_a_flight_step_is_told_of_beside_it(tmp_path):
    """At the end of a flight step beside it, that with the smaller gap; the excitation has the free swing there."""
    study = ALIKE.replace("stiffness = 50", "stiffness = 2e9").replace("end = 0.2", "end = 0.0131")
    run, cause, told = _cause(tmp_path, study)
    touch, step = run.main.events[0].t_start, run.found.setup.loads.time[3]
    assert abs(cause.time - touch) <= step
    free = abs(_driven(*ROAD, cause.time)[1])
    assert sum(-s.total for s in cause.sources if s.kind == EXCITATION) == pytest.approx(free, rel=1e-4)
    assert told["closing"] == pytest.approx(0.5 - cause.gap, rel=1e-9)
    history = run.main.history
    near = np.abs(history.time - touch) <= step * (1.0 + 1e-9)
    ends = near & np.isin(history.time, run.found.setup.loads.time[::3])
    assert 0.0 < cause.gap == pytest.approx(history.gap[ends, cause.channel].min(), rel=1e-9)


def test_changes_of_a_model_on_a_shaken_base(tmp_path, measured):
    """Damping by modes acts on the motion relative to the base: twice of it, or with more mass, against an integration
    of the full matrices."""
    f, way, zeta, hard, room, end = 12.0, 1.5e-3, 0.03, 1e5, 1e-3, 0.5
    deck = points([1.0, 1.0, 0.5], between=[1e4, 4e3])
    moved = push("P1", f'type = "sine", frequency = {f}, amplitude = {way}', kind="displacement")
    tables = play("P1, P2", hard, f"lower = {-room}") + moved + f"[damping]\nmodal = {zeta}\n[reduction]\nf_max = 200\n"
    found = solved(tmp_path, deck, tables, end)
    (place,) = heard_places(found.scope, found.main, None)
    (cause,) = find_causes(found.setup.marching, found.setup.reduction, found.main, [place])
    now, every = try_changes(found, None, place, cause)
    omega, mass = 2.0 * np.pi * f, np.array([1.0, 0.5])
    K = np.array([[14e3, -4e3], [-4e3, 4e3]])

    def exact(more: float, share: float) -> float:
        M = np.diag(mass + [more, 0.0])
        omega2, shapes = sla.eigh(K, M)
        C = M @ shapes @ np.diag(2.0 * share * np.sqrt(omega2)) @ shapes.T @ M
        load = lambda t: np.outer(way * omega**2 * np.sin(omega * t), np.diag(M))  # noqa: E731
        stop = [(np.array([1.0, 0.0]), room, hard)]
        time, gap, force = switched(M, C, K, stop, load, np.full(2, -way * omega), 2e-6, end)
        inside = blows(time, gap[:, 0], force[:, 0])
        return float(inside[inside[:, 0] + inside[:, 1] >= found.scope.window[0], 2].sum())

    effects = {change.kind: effect for change, effect in every}
    cases = (("nothing", now, 0.0, zeta), ("mass", effects["mass"], 0.025, zeta))
    for kind, effect, more, share in (*cases, ("damping", effects["damping"], 0.0, 2.0 * zeta)):
        measured(
            f"impulse of a mass on a shaken base, changed: {kind}",
            effect.impulse,
            exact(more, share),
            rel=1e-3,
            source="exponentials of the full matrices",
        )


def test_shares_sum_to_the_gap_where_soft_contact_does_not_see_the_fast_modes(tmp_path):
    """Steps of a soft spring take the fastest modes off the gap, but not what these are carried along by the supports."""
    soft = STRIPS.replace("step = 5e-4\nperiods = 2", "end = 0.2").replace('"OVER"', '"OVER"\nstiffness = 0.3')
    soft = soft.replace("f_max = 3000", 'f_max = "auto"')  # all modes
    run = creak.run(creak.read_study(write_strips(tmp_path, study=soft)), converge=False, record=False)
    places = heard_places(run.found.scope, run.main, run.sound)
    for cause in find_causes(run.found.setup.marching, run.found.setup.reduction, run.main, places):
        assert cause.total == pytest.approx(cause.gap - cause.gap0, abs=1e-9)


def test_motion_that_nothing_holds_is_told_as_such(tmp_path):
    """A body of two masses flies to and fro between stops: its way is that of a rigid body, and swings at one frequency.

    omega^2 = k (1 / m_1 + 1 / m_2), elsewhere and in the deck.
    """
    deck = points([1.0, 0.5], between=[1e5])
    tables = play("P1", 1e4, "lower = -1e-3\nupper = 1e-3")
    found = solved(tmp_path, deck, tables + push("P1", 'type = "sine", frequency = 20, amplitude = 10'), 0.2)
    (place,) = heard_places(found.scope, found.main, None)
    (cause,) = find_causes(found.setup.marching, found.setup.reduction, found.main, [place])
    assert cause.frequencies == pytest.approx([0.0, np.sqrt(1e5 * 3.0) / (2.0 * np.pi)], rel=1e-9)
    told = cause_dict(cause, found.setup.loads, found.gaps, "m")
    drift = next(m["closing"] for m in told["modes"] if not m["frequency"])
    assert f"most through the modes at 0 Hz ({drift:.3g} m, rigid-body motion), 87.17 Hz" in told["words"]
