"""Contact from the study file, with neither step nor stiffness chosen for it: closed forms and references not creak's."""

from __future__ import annotations

import numpy as np
import pytest
import scipy.linalg as sla

import creak
from creak.studies.run.job import StudyResult
from creak.verify.events import Event
from creak.verify.reliability import created_of_contact
from helpers_contact_studies import beam, blows, floor, play, points, push, rods, solved, step, switched
from helpers_decks import write_study

pytestmark = pytest.mark.slow


def events(result: StudyResult) -> list[Event]:
    run = result.runs["reduced"]
    assert run.integrator.startswith("exact flow")
    assert created_of_contact(run.history) < 1e-3
    return list(run.events)


def pulse(result: StudyResult, begin: float = 0.0, end: float = np.inf) -> tuple[float, float]:
    """Impulse of all channels in a time, and where its middle lies."""
    h = result.runs["reduced"].history
    force = np.where((h.time >= begin) & (h.time <= end), h.weights * h.force.sum(axis=1), 0.0)
    return float(force.sum()), float(force @ h.time / force.sum())


# --- one mass -------------------------------------------------------------------------------------------------------


def test_mass_on_a_penalty_stop(tmp_path):
    result = solved(tmp_path, points([100.0], [1e4], velocity=[1.0]), play("P1", 1e6, "upper = 0.0"), 0.05)
    first = events(result)[0]
    assert first.force_peak == pytest.approx(9950.3719, rel=1e-5)
    assert first.t_end - first.t_start == pytest.approx(0.0312600153, rel=1e-5)
    assert first.impulse == pytest.approx(198.01980, rel=1e-5)


def test_bilinear_oscillator_without_gap(tmp_path):
    """T = pi (1 / w1 + 1 / w2)."""
    m, k, stop = 2.0, 800.0, 7200.0
    period = np.pi * (np.sqrt(m / k) + np.sqrt(m / (k + stop)))
    result = solved(tmp_path, points([m], [k], velocity=[-1.0]), play("P1", stop, "upper = 0.0"), 4.5 * period)
    starts = [e.t_start for e in events(result)]
    assert len(starts) == 4
    np.testing.assert_allclose(np.diff(starts), period, rtol=1e-5)


def test_mass_with_gravity_on_a_spring_stop(tmp_path):
    deck = points([1.0], velocity=[-1.0])
    result = solved(tmp_path, deck, play("P1", 1e4, "lower = 0.0") + push("P1", step(-9.81)), 0.06)
    first = events(result)[0]
    assert first.t_end - first.t_start == pytest.approx(0.0333717, rel=1e-5)
    assert first.force_peak == pytest.approx(110.290, rel=1e-5)


def test_ball_under_gravity_comes_to_rest(tmp_path):
    """Bounces without end in finite time, then the weight alone presses."""
    m, k, zeta = 0.2, 1e6, 0.1
    stop = play("P1", k, "lower = -0.01", more=f"damping = {2.0 * zeta * np.sqrt(k * m)}\n")
    result = solved(tmp_path, points([m]), stop + push("P1", step(-m * 9.81)), 1.0)
    bounces, h = events(result), result.runs["reduced"].history
    assert bounces[0].t_start == pytest.approx(np.sqrt(2 * 0.01 / 9.81), rel=1e-5)
    assert bounces[0].closing_speed == pytest.approx(np.sqrt(2 * 0.01 * 9.81), rel=1e-3)
    assert len(bounces) > 5
    np.testing.assert_allclose(h.force[h.time > 0.9].sum(axis=1), m * 9.81, rtol=1e-3)


def test_a_ball_on_a_hard_floor_bounces_as_one_on_a_rigid_floor(tmp_path):
    """Every 2 sqrt(2 h / g), by 2 m v: the bars cover it, and none of them is laid at the door of the steps."""
    m, height = 1.0, 0.01
    stop = play("P1", '"hard"', f"lower = {-height}")
    (tmp_path / "deck.inp").write_text(points([m]), encoding="utf-8")
    text = '[model]\ndeck = "deck.inp"\nunits = "m-kg-s"\n' + stop + push("P1", step(-9.81 * m)) + "[time]\nend = 0.5\n"
    (tmp_path / "study.toml").write_text(text, encoding="utf-8")
    result = creak.run(tmp_path / "study.toml")
    told, first = result.summary["runs"]["reduced"], np.sqrt(2.0 * height / 9.81)
    assert (told["verdict"], len(told["events"])) == ("settled", 6)
    for k, e in enumerate(told["events"]):
        bars = e["settled_to"]
        assert abs(e["t_start"] - (2 * k + 1) * first) <= bars["t_start"]
        assert abs(e["impulse"] / (2.0 * m * 9.81 * first) - 1.0) <= bars["impulse"] < 0.003
    for e in result.convergence.events:
        assert abs(e.figures["start"].changes["tolerance"]) < 0.02 * e.figures["start"].settled_to


@pytest.mark.parametrize("short_of", [1e-7, 1.25e-7], ids=["by 0.1 um", "for a tenth of the output step"])
def test_a_short_touch_is_found(tmp_path, short_of):
    """A mass swings to v / w = 10 mm against a stop short of it: every period touches, and none is missed.

    In contact it moves on an arc about the place where spring and stop balance.
    """
    m, k, v, stop = 1.0, 1e4, 1.0, 1e5
    w, w_c = np.sqrt(k / m), np.sqrt((k + stop) / m)
    limit = v / w - short_of
    speed, away = v * np.sqrt(1.0 - (limit * w / v) ** 2), k * limit / (k + stop)
    duration = 2.0 * np.arctan2(speed / w_c, away) / w_c
    result = solved(tmp_path, points([m], [k], velocity=[v]), play("P1", stop, f"upper = {float(limit)!r}"), 0.25)
    found = events(result)
    assert duration < 1.01e-4
    assert len(found) == 4
    for e in found:
        assert e.closing_speed == pytest.approx(speed, rel=0.01)
        assert e.t_end - e.t_start == pytest.approx(duration, rel=0.01)
        assert e.impulse == pytest.approx(stop * (2.0 * speed / w_c**2 - away * duration), rel=0.01)
    assert found[0].t_start == pytest.approx(np.arcsin(limit * w / v) / w, abs=1e-6)


# --- rods -----------------------------------------------------------------------------------------------------------

E, RHO, LENGTH, SPEED, N = 900.0, 1.0, 10.0, 10.0, 100
ELEMENT = E * N / LENGTH
"""Stiffness of an element: a stiffer stop makes an undamped mesh chatter at its own highest frequency."""


def test_bar_on_a_rigid_wall(tmp_path):
    deck = rods([LENGTH], [N], [-SPEED], E, RHO, 1.0)
    (event,) = events(solved(tmp_path, deck, play("A_FOOT", 10.0 * ELEMENT, "lower = -5.0"), 1.4))
    assert event.t_start == pytest.approx(0.5, abs=1e-5)
    # The end of the pulse is smeared over a few elements of 100.
    assert event.t_end == pytest.approx(7.0 / 6.0, rel=0.01)
    assert event.impulse == pytest.approx(200.0, rel=0.01)
    assert event.closing_speed == pytest.approx(SPEED, rel=1e-3)


def test_bouncing_bar(tmp_path):
    """Doyen, Ern, Piperno 2011: contact on [1, 5/3], 300 to 500, and on [11/3, 13/3], 500 to 300; 266.667 each."""
    deck = rods([LENGTH], [N], [0.0], E, RHO, 1.0)
    weight = -10.0 * RHO * LENGTH / N
    pull = push("A_INSIDE", step(weight)) + push("A_FOOT", step(weight / 2)) + push("A_HEAD", step(weight / 2))
    stop = play("A_FOOT", ELEMENT, "lower = -5.0")
    result = solved(tmp_path, deck, stop + pull, 4.6, '[output]\nnodes = "A_FOOT"\n')
    assert events(result)[0].t_start == pytest.approx(1.0, abs=1e-4)
    for begin, end, middle in ((0.0, 2.5, 1.0 + 13.0 / 36.0), (2.5, 4.6, 11.0 / 3.0 + 11.0 / 36.0)):
        taken, at = pulse(result, begin, end)
        assert taken == pytest.approx(800.0 / 3.0, rel=0.01)
        assert at == pytest.approx(middle, rel=0.01)
    h = result.runs["reduced"].history
    points_of = {0.5: 3.75, 1.8: 0.533333, 2.0: 1.666667, 2.5: 4.027778, 3.0: 4.444444, 3.5: 0.694444, 4.5: 1.527778}
    height = 5.0 + np.interp(list(points_of), h.time[h.output_index], h.displacement[:, 0])
    # Fronts of the waves are smeared, corners of the way rounded.
    np.testing.assert_allclose(height, list(points_of.values()), atol=0.15)


def test_two_bars(tmp_path):
    """A short one hits one twice as long: contact 2 L1 / c, impulse m1 V, after which it stands still."""
    deck = rods([LENGTH / 2, LENGTH], [N // 2, N], [SPEED, 0.0], E, RHO, 1.0)
    result = solved(tmp_path, deck, play("A_HEAD, B_FOOT", ELEMENT, "lower = -1.0"), 0.6)
    first = events(result)[0]
    assert first.t_start == pytest.approx(0.1, abs=1e-5)
    assert first.t_end - first.t_start == pytest.approx(LENGTH / 30.0, rel=0.05)
    assert first.impulse == pytest.approx(LENGTH / 2 * SPEED, rel=0.01)


def test_steel_bar_in_si(tmp_path):
    """100 mm at 1 m/s: 2 L / c = 38.7 us, a 25th of the output step; impulse 2 m v."""
    steel, dense, L, n = 210e9, 7850.0, 0.1, 50
    deck = rods([L], [n], [-1.0], steel, dense, 1e-4)
    stop = play("A_FOOT", steel * 1e-4 * n / L, "lower = -1e-3")
    (event,) = events(solved(tmp_path, deck, stop + "[reduction]\nf_max = 2e6\n", 0.002))
    assert event.t_start == pytest.approx(1e-3, abs=1e-7)
    # Fronts over some elements of 50, the spring as an element more.
    assert event.t_end - event.t_start == pytest.approx(2.0 * L / np.sqrt(steel / dense), rel=0.05)
    assert event.impulse == pytest.approx(2.0 * dense * 1e-4 * L, rel=0.01)


# --- against matrix exponentials that change over at the closing of a gap ---------------------------------------------


def alike(found: list[Event], exact: np.ndarray, channel: str) -> None:
    """Start within .1 ms, duration and impulse of each event of a channel within 1 %."""
    own = [e for e in found if e.channel == channel][: len(exact)]
    assert len(own) == len(exact) > 2
    ours = np.array([(e.t_start, e.t_end - e.t_start, e.impulse) for e in own])
    np.testing.assert_allclose(ours[:, 0], exact[:, 0], atol=1e-4)
    np.testing.assert_allclose(ours[:, 1:], exact[:, 1:], rtol=0.01)


def test_two_masses_with_two_sided_play(tmp_path):
    m, k, stop, amplitude, f = np.array([2.0, 1.0]), np.array([2e4, 5e3]), 2e5, 60.0, 12.0
    deck = points(m.tolist(), [k[0]], [k[1]])
    tables = play("P1, P2", stop, "lower = -2e-3\nupper = 3e-3")
    tables += push("P1", f'type = "sine", frequency = {f}, amplitude = {amplitude}')
    K = np.array([[k[0] + k[1], -k[1]], [-k[1], k[1]]])
    stops = [(np.array([1.0, -1.0]), 3e-3, stop), (np.array([-1.0, 1.0]), 2e-3, stop)]

    def force(t: np.ndarray) -> np.ndarray:
        return np.stack([amplitude * np.sin(2.0 * np.pi * f * t), 0.0 * t], axis=1)

    time, gaps, forces = switched(np.diag(m), np.zeros((2, 2)), K, stops, force, np.zeros(2), 2e-5, 0.4)
    found = events(solved(tmp_path, deck, tables, 0.4, "[verification]\nmerge = 0.0\n"))
    for j, side in enumerate(("upper", "lower")):
        exact = blows(time, gaps[:, j], forces[:, j])
        alike(found, exact, f"p1_p2:{side}")


def ringing(clearance: float) -> tuple[str, str]:
    """Deck and tables of a mass of 25 Hz that meets a stop; what sits on it rings at 9 kHz against a plate of it.

    The run without contact leaves that gap open, and so do both ends of every flight step: within a cycle it is still.
    """
    lid = "\n".join(f"2\n{node}, 3, 1., 1, 3, -1." for node in range(9001, 9005))
    deck = points(*RINGING, free="z").replace("2, 0.1, 0., 0.", f"2, 0., 0., {clearance}")
    deck += floor(0.02, free="z") + f"*EQUATION\n{lid}\n"
    tables = play("P1", STOPS[0], "lower = -1e-3", dof="z")
    tables += push("P1", 'type = "sine", frequency = 20, amplitude = 20.0', dof="z")
    tables += f'[contact.lid]\nsecondary = "P2"\nmain = "TABLE"\nmethod = "node-to-surface"\nstiffness = {STOPS[1]}\n'
    tables += f"clearance = {clearance}\n[damping]\nmodal = {ZETA}\n"
    return deck, tables + "[reduction]\nf_max = 2e4\n"


RINGING = [1.0, 0.05], [24674.0], [0.05 * (2.0 * np.pi * 9000.0) ** 2]
STOPS, ZETA = (4e9, 1e8), 0.04


@pytest.mark.parametrize(("clearance", "f_max"), [(4e-6, "2e4"), (5e-6, '"auto"'), (6e-6, "2e4")])
def test_a_dropped_gap_that_a_blow_rings_shut_within_a_flight_step(tmp_path, clearance, f_max):
    """Where f_max is raised, in the model at which it ends: the first one has no mode that rings."""
    deck, tables = ringing(clearance)
    result = solved(tmp_path, deck, tables.replace("2e4", f_max), 0.2, 'accuracy = "fine"\n')
    assert result.closed_later == 1
    m, k, between = map(np.array, RINGING)
    M = np.diag(m + [7850.0 * 1e-3 * 0.04**2, 0.0])
    K = np.array([[k[0] + between[0], -between[0]], [-between[0], between[0]]])
    omega2, shapes = sla.eigh(K, M)
    C = M @ shapes @ np.diag(2.0 * ZETA * np.sqrt(omega2)) @ shapes.T @ M
    ways = [(np.array([1.0, 0.0]), 1e-3, STOPS[0]), (np.array([-1.0, 1.0]), clearance, STOPS[1])]
    time, gap, force = switched(
        M, C, K, ways, lambda t: np.outer(20.0 * np.sin(40.0 * np.pi * t), [1.0, 0.0]), np.zeros(2), 2e-7, 0.2
    )
    for j, group in enumerate(("p1", "lid")):
        exact = blows(time, gap[:, j], force[:, j])
        found = [e for e in events(result) if e.group == group]
        assert len(exact) >= len(found) > 0
        assert sum(e.impulse for e in found) == pytest.approx(exact[:, 2].sum(), rel=6e-3)


def test_draws_in_which_a_dropped_gap_rings_shut_are_counted(tmp_path):
    deck, tables = ringing(4e-6)
    (tmp_path / "deck.inp").write_text(deck, encoding="utf-8")
    varied = '[scatter.vary]\n"excitation.p1_z_force.signal.amplitude" = { type = "normal", sigma = 0.1 }\n'
    text = f'[model]\ndeck = "deck.inp"\nunits = "m-kg-s"\n{tables}[time]\nend = 0.1\n{varied}'
    (tmp_path / "study.toml").write_text(text, encoding="utf-8")
    found = creak.robust(tmp_path / "study.toml", n=4, indices=False)
    assert any("in 4 of 4 runs a channel closed that the pre-check had left out" in note for note in found.notes)


def test_preload_that_opens(tmp_path):
    """A clip presses with 5 N at rest; a force of 25 N in the other direction opens it in every period."""
    m, k, clip, preload, amplitude, f = 0.5, 2e3, 2e4, 5.0, 25.0, 20.0
    tables = play("P1", clip, "upper = 0", more=f"preload = {preload}\n")
    tables += push("P1", f'type = "sine", frequency = {f}, amplitude = {-amplitude}')
    stops = [(np.array([-1.0]), -preload / clip, clip)]

    def force(t: np.ndarray) -> np.ndarray:
        return (preload - amplitude * np.sin(2.0 * np.pi * f * t))[:, None]

    time, gaps, forces = switched(np.eye(1) * m, np.zeros((1, 1)), np.eye(1) * k, stops, force, np.zeros(1), 2e-5, 0.5)
    result = solved(tmp_path, points([m], [k]), tables, 0.5)
    h = result.runs["reduced"].history
    assert h.force[0].sum() == pytest.approx(preload, rel=1e-9)
    alike(events(result), blows(time, gaps[:, 0], forces[:, 0]), "p1:upper")


def test_draws_of_a_press_fit(tmp_path):
    """A mass on a spring overlaps the floor by as much as is drawn; a force lifts it off in every period."""
    k, alpha, pull, f, end, hard = 2e4, 20.0, 12.0, 20.0, 0.3, 2e5
    deck = points([1.0], [k], free="z") + floor(0.05)
    tables = '[contact.floor]\nsecondary = "P1"\nmain = "TABLE"\nmethod = "node-to-surface"\nclearance = -1e-4\n'
    tables += f"stiffness = {hard}\n[[static]]\npress_fit = true\n"
    tables += push("P1", f'type = "sine", frequency = {f}, amplitude = {pull}', dof="z")
    tables += f"[damping.rayleigh]\nalpha = {alpha}\nbeta = 0.0\n[scatter.vary]\n"
    tables += '"contact.floor.clearance" = { type = "uniform", low = -1.5e-4, high = -0.5e-4 }\n'
    text = f'[model]\ndeck = "deck.inp"\nunits = "m-kg-s"\n{tables}[reference]\nrun = false\n[time]\nend = {end}\n'
    draws = creak.robust(write_study(tmp_path, text, {"deck.inp": deck}), n=4, indices=False).draws
    begin = draws.setup.marching.window[0]
    for overlap, found in zip(-draws.drawn.numbers[0], draws.impulse.sum(axis=1), strict=True):
        pressed = k * hard / (k + hard) * overlap
        load = lambda t, p=pressed: (pull * np.sin(2.0 * np.pi * f * t) - p)[:, None]  # noqa: E731
        stop, one = [(np.ones(1), -pressed / hard, hard)], np.eye(1)
        time, _, force = switched(one, alpha * one, k * one, stop, load, np.zeros(1), 1e-5, end)
        open_at = np.flatnonzero(force[:, 0] == 0.0)
        first = open_at[np.searchsorted(time[open_at], begin) - 1]  # a blow that lasts into the window counts in whole
        assert found == pytest.approx(np.trapezoid(force[first:, 0], time[first:]), rel=2e-3)


def test_beam_with_a_stop_at_mid_span(tmp_path):
    """A simply supported beam under a sweep from 1 to 100 Hz, which runs through its first mode at 65 Hz."""
    n, L, side, young, dense, alpha, stop, gap = 12, 0.6, 0.01, 2.1e11, 7850.0, 20.0, 2e5, 2e-4
    amplitude, end = 20.0, 0.4
    x, EI, mass = L / n, young * side**4 / 12.0, dense * side**2
    stiff = [[12, 6 * x, -12, 6 * x], [6 * x, 4 * x * x, -6 * x, 2 * x * x]]
    stiff += [[-12, -6 * x, 12, -6 * x], [6 * x, 2 * x * x, -6 * x, 4 * x * x]]
    heavy = [[156, 22 * x, 54, -13 * x], [22 * x, 4 * x * x, 13 * x, -3 * x * x]]
    heavy += [[54, 13 * x, 156, -22 * x], [-13 * x, -3 * x * x, -22 * x, 4 * x * x]]
    M, K = np.zeros((2 * n + 2, 2 * n + 2)), np.zeros((2 * n + 2, 2 * n + 2))
    for e in range(0, 2 * n, 2):
        K[e : e + 4, e : e + 4] += EI / x**3 * np.array(stiff)
        M[e : e + 4, e : e + 4] += mass * x / 420.0 * np.array(heavy)
    free = np.delete(np.arange(2 * n + 2), [0, 2 * n])
    M, K = M[np.ix_(free, free)], K[np.ix_(free, free)]
    middle, pushed = (np.eye(2 * n + 2)[2 * j][free] for j in (n // 2, n // 4))

    def force(t: np.ndarray) -> np.ndarray:
        return amplitude * np.sin(2.0 * np.pi * (t + 99.0 / (2.0 * end) * t**2))[:, None] * pushed

    found = events(
        solved(
            tmp_path,
            beam(n, L, side, young, dense, alpha),
            f"""
{play("MIDDLE", stop, f"lower = {-gap}", "z")}
{push("QUARTER", f'type = "sweep", f_start = 1, f_end = 100, amplitude = {amplitude}, duration = {end}', "z")}
[reduction]
f_max = 20000
""",
            end,
            "[verification]\nmerge = 0.0\n",
        )
    )
    time, gaps, forces = switched(M, alpha * M, K, [(middle, gap, stop)], force, np.zeros(2 * n), 2e-5, end)
    alike(found, blows(time, gaps[:, 0], forces[:, 0]), "middle:lower")


# --- friction -------------------------------------------------------------------------------------------------------

RUBS = """[contact.floor]
secondary = "P1"
main = "TABLE"
method = "node-to-surface"
stiffness = {stiffness}
clearance = {clearance}
friction = {friction}
"""


HELD = "*ELEMENT, TYPE=SPRING1, ELSET=WEAK\n301, 1\n*SPRING, ELSET=WEAK\n3\n1.\n"
"""What a static load asks for."""


def test_oblique_impact_with_friction(tmp_path):
    """At 30 degrees on a floor with mu = .2: the tangential impulse is mu times the normal one."""
    v, mu, m = np.array([np.sin(np.pi / 3), 0.0, -np.cos(np.pi / 3)]), 0.2, 0.3
    deck = points([m], velocity=v.tolist(), free="xyz") + floor(0.05)
    contact = RUBS.format(stiffness=1e5, clearance=1e-3, friction=mu)
    result = solved(tmp_path, deck, contact, 0.02, '[output]\nnodes = "P1"\n')
    (event,) = events(result)
    h = result.runs["reduced"].history
    after = np.diff(h.displacement[-2:, :3], axis=0)[0] / np.diff(h.time[h.output_index[-2:]])
    np.testing.assert_allclose(after, [v[0] - mu * 2.0 * 0.5, 0.0, 0.5], atol=1e-3)
    assert event.t_start == pytest.approx(1e-3 / 0.5, abs=1e-6)
    assert event.impulse == pytest.approx(m * 2.0 * 0.5, rel=1e-3)


def test_coulomb_decay(tmp_path):
    """m = 1, k = 1e4, mu N = 1, let go .85 mm from where its spring rests: turns at -.65, .45, -.25, .05 mm, sticks."""
    deck = points([1.0], [1e4], free="xz") + HELD + floor(0.05)
    load = '[[static]]\nforce = -2.0\nnode_set = "P1"\ndof = "z"\n' + RUBS.format(
        stiffness=1e6, clearance=0.0, friction=0.5
    )
    # From rest the place where the spring rests jumps by .85 mm.
    pull = push("P1", step(-1e4 * 0.85e-3))
    result = solved(tmp_path, deck, load + pull, 0.16, '[output]\nnodes = "P1"\n')
    h = result.runs["reduced"].history
    x = h.displacement[:, 0] + 0.85e-3
    for n, exact in enumerate((-0.65e-3, 0.45e-3, -0.25e-3, 0.05e-3), start=1):
        near = np.abs(h.time[h.output_index] - n * np.pi / 100.0) < 1e-3
        assert float(x[near][np.abs(x[near]).argmax()]) == pytest.approx(exact, abs=3e-6)
    assert h.time[np.flatnonzero(h.sliding.any(axis=1))[-1]] == pytest.approx(0.1256637, abs=1e-4)
    assert not events(result)  # it lies on the floor throughout


def test_belt_squeak(tmp_path):
    """m = 1, k = 1e4, N = 10, mu .5 / .3 on a belt of .01 m/s: stick .04 s, slip .04068888 s, 12.3932817 Hz."""
    deck = points([1.0], [1e4], free="xz") + HELD + floor(0.05, free="x")
    load = '[[static]]\nforce = -10.0\nnode_set = "P1"\ndof = "z"\n'
    load += RUBS.format(stiffness=1e6, clearance=0.0, friction="{ static = 0.5, kinetic = 0.3 }")
    belt = push("FLOOR", 'type = "table", values = [[0.0, 0.0], [0.4, 0.004]]', kind="displacement")
    result = solved(tmp_path, deck, load + belt, 0.4)
    h = result.runs["reduced"].history
    slides = h.sliding.any(axis=1)
    starts, ends = (h.time[np.flatnonzero(np.diff(slides.astype(int)) == s) + 1] for s in (1, -1))
    assert len(starts) >= 4
    np.testing.assert_allclose(np.diff(starts)[1:], 1.0 / 12.3932817, rtol=1e-3)
    np.testing.assert_allclose((ends - starts[: ends.size])[1:], 0.04068888, rtol=2e-3)


def test_what_friction_holds_rests(tmp_path):
    """3 N along the floor, less than mu N = 5: nothing creeps, and no event begins."""
    deck = points([1.0], [1e4], free="xz") + HELD + floor(0.05)
    load = "".join(
        f'[[static]]\nforce = {f}\nnode_set = "P1"\ndof = "{dof}"\n' for f, dof in ((-10.0, "z"), (3.0, "x"))
    )
    contact = RUBS.format(stiffness=1e6, clearance=0.0, friction=0.5)
    result = solved(tmp_path, deck, load + contact, 0.05, '[output]\nnodes = "P1"\n')
    h = result.runs["reduced"].history
    assert np.abs(h.displacement - h.displacement[0]).max() < 1e-12
    np.testing.assert_allclose(np.hypot(h.tangential[:, 0], h.tangential[:, 1]), 3.0, rtol=1e-6)
    assert not events(result)


# --- what is left to a rigid contact ----------------------------------------------------------------------------------


def rigid_blow(mass, springs, beta, speed, end) -> float:
    """Impulse of a chain thrown at a wall, by leapfrog with a contact spring of 1e5 times its first one: within .15 %.

    A spring of 1e6 times and steps of a fourth change it by so much.
    """
    n, hard = mass.size, 1e5 * springs[0]
    K = np.diag(np.append(springs, 0.0)) + np.diag(np.append(0.0, springs))
    K -= np.diag(springs, 1) + np.diag(springs, -1)
    h = 0.05 * np.sqrt(mass[0] / hard)
    M, x, v, impulse = mass, np.zeros(n), np.full(n, -speed), 0.0
    step, damp = h * K / M[:, None], h * beta * K / M[:, None]
    for _ in range(int(end / h)):
        v -= step @ x + damp @ v
        if x[0] < 0.0:
            impulse -= h * hard * x[0]
            v[0] -= h * hard * x[0] / M[0]
        x += h * v
    return impulse


@pytest.mark.parametrize(
    ("mass", "springs"),
    [
        ((0.21174, 0.40316, 0.31608, 0.18245), (765752.7, 636791.6, 111226.3)),
        ((0.113972, 0.245023, 0.36685), (258497.9, 293727.4)),
    ],
)
def test_bars_of_hard_contact_reach_a_rigid_one(tmp_path, mass, springs):
    """Two chains whose impulse hangs much on the spring in place of hard contact: 3 and 4 % from 1e3 to 1e5 times one."""
    beta, speed = 1e-4, 0.1
    lines = ["*NODE, NSET=CHAIN", *(f"{i + 1}, 0., 0., {0.001 + 0.0005 + 0.1 * i}" for i in range(len(mass)))]
    lines += ["*NSET, NSET=P1", "1"]
    for i, m in enumerate(mass):
        lines += [f"*ELEMENT, TYPE=MASS, ELSET=M{i}", f"{101 + i}, {i + 1}", f"*MASS, ELSET=M{i}", f"{m}"]
    for i, k in enumerate(springs):
        lines += [f"*ELEMENT, TYPE=SPRING2, ELSET=K{i}", f"{201 + i}, {i + 1}, {i + 2}"]
        lines += [f"*SPRING, ELSET=K{i}", "3, 3", f"{k}"]
    lines += ["*BOUNDARY", "CHAIN, 1, 2", "CHAIN, 4, 6"]
    lines += ["*INITIAL CONDITIONS, TYPE=VELOCITY", f"CHAIN, 3, {-speed}"]
    study_path = write_study(
        tmp_path,
        '[model]\ndeck = "deck.inp"\nunits = "m-kg-s"\n'
        f"[damping.rayleigh]\nalpha = 0.0\nbeta = {beta}\n"
        '[contact.wall]\nsecondary = "P1"\nmain = "TABLE"\nmethod = "node-to-surface"\nclearance = 0.001\n'
        'stiffness = "hard"\n[time]\nend = 0.05\n',
        {"deck.inp": "\n".join(lines) + "\n" + floor(0.05)},
    )
    told = creak.run(study_path).summary
    exact = rigid_blow(np.array(mass), np.array(springs), beta, speed, 0.03)
    bar = told["convergence"]["totals"]["impulse"]["settled_to"]
    assert abs(told["runs"]["reduced"]["impulse_total"] / exact - 1.0) < bar < 0.12
