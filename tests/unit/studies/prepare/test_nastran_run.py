"""The transient analysis of a Nastran deck, SOL 109 and 112, against closed solutions of one mass on one spring.

m = 100, k = 1e4, w = 10. HHT with alpha = 0 has a period that is longer by (w h)^2 / 12 of itself.
"""

from __future__ import annotations

import math

import numpy as np
import pytest

from creak.errors import InputError
from creak.formats.nastran.reader import read_nastran, read_nastran_run
from creak.studies.prepare.deck_step import set_up_deck
from creak.studies.run.job import run_study
from helpers_cli import say

W, K, H = 10.0, 1.0e4, 1.0e-3
PERIOD_ERROR = (W * H) ** 2 / 12.0
MASS = "GRID,1,,,,,,12456\nGRID,2,,,,-1.,,123456\nCONM2,1,1,,100.\n"
SPRING = "CELAS2,2,1.+4,1,3,2,3\n"
BULK = MASS + SPRING + "TSTEP,5,500,1.-3\n"


def deck(tmp_path, bulk: str, case: str, solution: str = "109"):
    path = tmp_path / "deck.bdf"
    head = f"SOL {solution}\nCEND\nTSTEP = 5\nDISPLACEMENT = 1\nSET 1 = 1\n"
    path.write_text(f"{head}{case}BEGIN BULK\n{bulk}ENDDATA\n", encoding="utf-8")
    return path


@pytest.fixture
def motion(tmp_path):
    """Time and displacement of grid 1 along z."""

    def run(bulk: str, case: str = "DLOAD = 7\n", solution: str = "109"):
        result = run_study(set_up_deck(deck(tmp_path, bulk, case, solution), units="m-kg-s"), lambda *_: None)
        history = result.runs["reference"].history
        return history.time, history.displacement[:, 2]

    return run


def constant(card: str = "DAREA,6,1,3,50.\n", kind: str = "") -> str:
    return f"TLOAD1,7,6,,{kind},8\nTABLED1,8\n,0.,1.,1.,1.,ENDT\n{card}"


@pytest.mark.parametrize("solution", ["109", "112"])
def test_a_force_that_stays(motion, solution):
    """u = F/k (1 - cos w t)."""
    t, u = motion(BULK + constant(), solution=solution)
    assert t.size == 501
    np.testing.assert_allclose(u, 50.0 / K * (1.0 - np.cos(W * t)), atol=50.0 / K * (W * t[-1] + 1.0) * PERIOD_ERROR)


def test_a_nonlinear_transient_runs_linear_but_for_its_gaps(tmp_path):
    """SOL 129 with TSTEPNL: the run of SOL 109, and what is left out is said."""
    bulk = BULK.replace("TSTEP,5,500,1.-3", "TSTEPNL,5,500,1.-3,1") + constant() + "PARAM,LGDISP,-1\n"
    path = deck(tmp_path, bulk, "DLOAD = 7\n", "129")
    path.write_text(path.read_text().replace("TSTEP = 5", "TSTEPNL = 5"))
    model, run = read_nastran_run(path)
    assert (run.step.increment, run.step.period) == pytest.approx((1e-3, 0.5))
    told = {u.keyword: u.changes_answer for u in model.unread}
    assert told["SOL 129"] is False
    assert told["PARAM,LGDISP"] is False
    history = run_study(set_up_deck(path, units="m-kg-s"), lambda *_: None).runs["reference"].history
    t, u = history.time, history.displacement[:, 2]
    np.testing.assert_allclose(u, 50.0 / K * (1.0 - np.cos(W * t)), atol=50.0 / K * (W * t[-1] + 1.0) * PERIOD_ERROR)


def test_output_of_all_grids_keeps_the_motion_of_each(tmp_path):
    """DISPLACEMENT = ALL: grid 1 moves, grid 2 is held."""
    path = deck(tmp_path, BULK + constant(), "DLOAD = 7\n")
    path.write_text(path.read_text().replace("DISPLACEMENT = 1", "DISPLACEMENT(PLOT) = ALL"))
    setup = set_up_deck(path, units="m-kg-s")
    assert not any("output" in note for note in setup.notes)
    u = run_study(setup, lambda *_: None).runs["reference"].history.displacement
    assert u.shape[1] == 12
    assert np.abs(u[:, 2]).max() == pytest.approx(2.0 * 50.0 / K, rel=1e-4)
    assert not u[:, 6:].any()


IN_TURN = "SUBCASE 1\nTSTEPNL = 5\nDLOAD = 7\nSUBCASE 2\nTSTEPNL = {}\nDLOAD = {}\n"


def sequence(tmp_path, second: int, load: int, solution: str = "129", extra: str = ""):
    """Two subcases of .3 and .2 s."""
    kind = "TSTEPNL" if solution == "129" else "TSTEP"
    bulk = MASS + SPRING + f"{kind},5,300,1.-3\n{kind},6,200,1.-3\n{kind},8,200,5.-4\n" + constant("DAREA,6,1,3,50.\n")
    bulk += "TLOAD1,9,6,,,8\nTLOAD1,10,6,,,8\n" + extra
    path = deck(tmp_path, bulk, IN_TURN.format(second, load).replace("TSTEPNL", kind), solution)
    path.write_text(path.read_text().replace("CEND\nTSTEP = 5\n", "CEND\n"))
    return path


def test_subcases_of_a_nonlinear_transient_follow_each_other(tmp_path):
    """SOL 129 goes on from where the subcase before ends: .3 + .2 s under one force, as one run."""
    path = sequence(tmp_path, 6, 7)
    assert [u.keyword for u in read_nastran_run(path)[0].unread if "SUBCASE" in u.keyword] == []
    history = run_study(set_up_deck(path, units="m-kg-s"), lambda *_: None).runs["reference"].history
    t, u = history.time, history.displacement[:, 2]
    assert t[-1] == pytest.approx(0.5)
    np.testing.assert_allclose(u, 50.0 / K * (1.0 - np.cos(W * t)), atol=50.0 / K * (W * t[-1] + 1.0) * PERIOD_ERROR)


MATS1 = "MATS1,1,,PLASTIC,0.,1,1,200.\n"


@pytest.mark.parametrize(
    ("second", "load", "solution", "extra", "told"),
    [
        (6, 9, "129", "", "SUBCASE 2 .* goes on with it, but not under the same DLOAD"),
        (8, 7, "129", "", "steps of 0.0005, 0.001 s"),
        (6, 7, "109", "", "SUBCASE 2 .* analysis of its own"),
        (6, 9, "112", "", "SUBCASE 2 .* analysis of its own"),
        (6, 7, "129", "PARAM,LGDISP,1\n", "LGDISP .*creak's structure is linear"),
        (6, 7, "129", MATS1, "MATS1 .*large strain"),
        (6, 7, "129", "PARAM,TSTATIC,1\n", "TSTATIC"),
    ],
)
def test_what_a_run_leaves_out_is_no_matter_of_course(tmp_path, second, load, solution, extra, told):
    with pytest.raises(InputError, match=told):
        set_up_deck(sequence(tmp_path, second, load, solution, extra), units="m-kg-s")


def test_a_look_at_the_deck_tells_what_its_own_run_asks_for(tmp_path):
    """The study that it is read for is elastic: there the same card changes nothing."""
    path = sequence(tmp_path, 6, 7, "129", MATS1)
    (law,) = [u for u in read_nastran(path).unread if u.keyword == "MATS1"]
    assert not law.changes_answer
    assert "own SOL 129 asks for --ignore 'MATS1'" in law.why
    assert set_up_deck(path, ["MATS1"], "m-kg-s").loads.time[-1] > 0.0


@pytest.mark.parametrize(
    ("solution", "told"),
    [("109", "linear: the elastic constants hold, as in Nastran"), ("400", "SOL 400 follows material laws at large")],
)
def test_a_material_law_is_told_by_the_solution_that_the_deck_has(tmp_path, solution, told):
    (law,) = [u for u in read_nastran(sequence(tmp_path, 6, 7, solution, MATS1)).unread if u.keyword == "MATS1"]
    assert (law.changes_answer, told in law.why) == (False, True)


def test_a_subcase_may_be_left_out_where_that_is_said(tmp_path):
    setup = set_up_deck(sequence(tmp_path, 6, 9, "109"), ["SUBCASE 2"], "m-kg-s")
    assert setup.loads.time[-1] == pytest.approx(0.3)


FORCES = {
    "FORCE": "FORCE,6,1,,25.,0.,0.,2.\n",
    "in a turned system": "CORD2R,9,,0.,0.,0.,1.,0.,0.\n,0.,0.,1.\nFORCE,6,1,9,25.,2.\n",
    "LOAD": "LOAD,6,2.,.5,61,.5,62\nFORCE,61,1,,25.,0.,0.,1.\nFORCE,62,1,,25.,0.,0.,1.\n",
    "two": "FORCE,6,1,,30.,0.,0.,1.\nDAREA,6,1,3,20.\n",
}


@pytest.mark.parametrize("name", FORCES)
def test_ways_to_say_a_force(tmp_path, name):
    _, run = read_nastran_run(deck(tmp_path, BULK + constant(FORCES[name]), "DLOAD = 7\n"))
    (load,) = [p for p in run.step.loads if abs(p.value) > 1e-12]
    assert (load.nodes_idx.tolist(), load.dof, load.value) == ([0], 3, pytest.approx(50.0))


def test_a_displacement_frame_of_a_load(tmp_path):
    """Component 1 of a grid that moves along z."""
    bulk = BULK.replace("GRID,1,,,,,,12456", "CORD2R,9,,0.,0.,0.,1.,0.,0.\n,0.,0.,1.\nGRID,1,,,,,9")
    _, run = read_nastran_run(deck(tmp_path, bulk + constant("DAREA,6,1,1,50.\n"), "DLOAD = 7\n"))
    assert [(p.dof, p.value) for p in run.step.loads if abs(p.value) > 1e-12] == [(3, pytest.approx(50.0))]


def test_loads_together(motion):
    """DLOAD: 2 (1.5 F1 + .5 F2), the second delayed beyond the run by its table."""
    late = "TLOAD1,17,6,10.,,18\nTABLED1,18\n,0.,0.,1.,0.,ENDT\n"
    t, u = motion(BULK + constant() + late + "DLOAD,70,2.,1.5,7,.5,17\n", "DLOAD = 70\n")
    np.testing.assert_allclose(u, 150.0 / K * (1.0 - np.cos(W * t)), atol=150.0 / K * 6.0 * PERIOD_ERROR)


def test_a_table_goes_on_beyond_its_ends(motion):
    """F = a t from two points within the run: u = a/k (t - sin(w t)/w)."""
    t, u = motion(BULK + "TLOAD1,7,6,,,8\nTABLED1,8\n,.2,20.,.3,30.,ENDT\nDAREA,6,1,3,1.\n")
    wanted = 100.0 / K * (t - np.sin(W * t) / W)
    np.testing.assert_allclose(u, wanted, atol=100.0 / K / W * 6.0 * PERIOD_ERROR)


@pytest.mark.parametrize(
    "table", ["TABLED1,8,,,1\n,0.,0.,.1,1.", "TABLED2,8,.05,FLAT\n,-.05,0.,.05,1.", "TABLED3,8,.1,-.1,1\n,0.,1.,1.,0."]
)
def test_a_table_that_is_flat_beyond_its_ends(motion, table):
    """A ramp of .1 s, then constant: u = F/k (1 - (sin w t - sin w(t - .1)) / (.1 w))."""
    t, u = motion(BULK + f"TLOAD1,7,6,,,8\n{table},ENDT\nDAREA,6,1,3,50.\n")
    late = t > 0.1
    wanted = 50.0 / K * (1.0 - (np.sin(W * t) - np.sin(W * (t - 0.1))) / (0.1 * W))
    np.testing.assert_allclose(u[late], wanted[late], atol=50.0 / K * 6.0 * PERIOD_ERROR)


@pytest.mark.parametrize("table", ["TABLED1,8\n,1.,10.,0.,0.", "TABLED3,8,1.,-1.\n,0.,10.,1.,0."])
def test_a_table_against_the_order_of_time(motion, table):
    """F = a t from points that fall, and from a scale below zero."""
    t, u = motion(BULK + f"TLOAD1,7,6,,,8\n{table},ENDT\nDAREA,6,1,3,1.\n")
    np.testing.assert_allclose(u, 10.0 / K * (t - np.sin(W * t) / W), atol=10.0 / K / W * 6.0 * PERIOD_ERROR)


def test_a_table_jumps_on_a_step(motion):
    """The mean holds there, as in Nastran: the error is of second order, where either side leaves w h / 2 = 1.6 %."""
    t, u = motion(BULK + "TLOAD1,7,6,,,8\nTABLED1,8\n,0.,0.,.1,0.,.1,1.,1.,1.,ENDT\nDAREA,6,1,3,50.\n")
    wanted = np.where(t > 0.1, 50.0 / K * (1.0 - np.cos(W * (t - 0.1))), 0.0)
    np.testing.assert_allclose(u, wanted, atol=50.0 / K * (6.0 * PERIOD_ERROR + (W * H) ** 2))


def test_a_number_for_a_table_is_constant(motion):
    t, u = motion(BULK + "TLOAD1,7,6,,,1.\nDAREA,6,1,3,50.\n")
    np.testing.assert_allclose(u, 50.0 / K * (1.0 - np.cos(W * t)), atol=50.0 / K * (W * t[-1] + 1.0) * PERIOD_ERROR)


@pytest.mark.parametrize(
    ("table", "words"),
    [
        ("TABLED1,8\n,0.,0.,.2,1.,.1,0.,ENDT", "rise and fall"),
        ("TABLED3,8,1.,0.\n,0.,0.,.2,1.,ENDT", "stand still"),
        ("TABLED1,8,,,2\n,0.,0.,.2,1.,ENDT", "has 2 for what lies beyond its ends"),
        ("TABLED4,8,0.,1.,0.,1.\n,0.,1.,ENDT", "TABLED4 8 gives its function by a power series"),
        ("TABLED1,8\n,0.,0.,.1,1.,.1,0.,ENDT", "jumps at an end"),
    ],
)
def test_wrong_tables(motion, table, words):
    with pytest.raises(InputError, match=words):
        motion(BULK + f"TLOAD1,7,6,,,8\n{table}\nDAREA,6,1,3,50.\n")


def test_an_analytic_load(motion):
    """F cos(2 pi f t - 90) over the run: u = F/m (sin(v t) - v/w sin(w t)) / (w^2 - v^2), v = 2 pi f."""
    t, u = motion(BULK + "TLOAD2,7,6,,,0.,9.,3.,-90.\nDAREA,6,1,3,50.\n")
    v = 2.0 * math.pi * 3.0
    wanted = 0.5 * (np.sin(v * t) - v / W * np.sin(W * t)) / (W**2 - v**2)
    np.testing.assert_allclose(u, wanted, atol=2.0 * np.abs(wanted).max() * 6.0 * (v * H) ** 2 / 12.0)


def test_an_analytic_load_that_ends(motion):
    """A constant from 0 to .1 s; then free: u = F/k (cos w(t - .1) - cos w t). The step at .1 s lies within an increment,
    whose mean moves it by half a step: w h / 2 of the force."""
    t, u = motion(BULK + "TLOAD2,7,6,,,0.,.1\nDAREA,6,1,3,50.\n")
    free = t > 0.11
    wanted = 50.0 / K * (np.cos(W * (t - 0.1)) - np.cos(W * t))
    np.testing.assert_allclose(u[free], wanted[free], atol=50.0 / K * W * H)


@pytest.mark.parametrize(("kind", "table"), [("DISP", "0.,0.,1.,2."), ("2", "0.,2.,1.,2.")])
def test_moved_supports(motion, kind, table):
    """The ground end of the spring moves with 2 m/s: u = v (t - sin(w t)/w)."""
    bulk = BULK.replace("GRID,2,,,,-1.,,123456", "GRID,2,,,,-1.,,12456") + "SPC1,4,3,2\n"
    load = f"TLOAD1,7,6,,{kind},8\nTABLED1,8\n,{table},ENDT\nSPCD,6,2,3,1.\n"
    t, u = motion(bulk + load, "SPC = 4\nDLOAD = 7\n")
    # A velocity that starts with a jump is carried by the first step: at most half a step of the motion.
    np.testing.assert_allclose(u, 2.0 * (t - np.sin(W * t) / W), atol=0.5 * H * 2.0)


def test_a_gap_closes(tmp_path):
    """1 m/s against a stop of 1e6 N/m beside the spring, w^2 = (1e4 + 1e6) / 100: force 1e6 v / w, contact pi / w."""
    bulk = MASS + SPRING + "GRID,3,,,,1.,,123456\nTIC,3,1,3,,1.\nCGAP,4,4,1,3\nPGAP,4,0.,,1.+6\nTSTEP,5,2000,2.-5\n"
    path = deck(tmp_path, bulk, "IC = 3\n")
    result = run_study(set_up_deck(path, units="m-kg-s"), lambda *_: None)
    (event,) = result.runs["reference"].events
    w = math.sqrt(1.01e6 / 100.0)
    # HHT with alpha = -.05 errs by (w h)^2 = 4e-6 in period and by less in amplitude
    assert event.force_peak == pytest.approx(1.0e6 / w, rel=1e-5)
    assert event.t_end - event.t_start == pytest.approx(math.pi / w, rel=1e-5)


@pytest.mark.parametrize(
    "table",
    [
        "TABDMP1,9,CRIT\n,0.,.05,99.,.05,ENDT\n",
        "TABDMP1,9\n,0.,.1,99.,.1,ENDT\n",
        "TABDMP1,9,G\n,0.,.1,ENDT\n",
        "TABDMP1,9,Q\n,0.,10.,99.,10.,ENDT\n",
    ],
)
def test_one_damping_of_all_modes(tmp_path, table):
    """SOL 112 with SDAMPING: u = F/k (1 - exp(-zeta w t) (cos w_d t + zeta w / w_d sin w_d t)), zeta = .05 = g / 2 = 1 / 2Q."""
    path = deck(tmp_path, BULK + constant() + table, "DLOAD = 7\nSDAMPING = 9\n", "112")
    history = run_study(set_up_deck(path, units="m-kg-s"), lambda *_: None).runs["reduced"].history
    t, zeta = history.time[history.output_index], 0.05
    wd = W * math.sqrt(1.0 - zeta**2)
    exact = 50.0 / K * (1.0 - np.exp(-zeta * W * t) * (np.cos(wd * t) + zeta * W / wd * np.sin(wd * t)))
    np.testing.assert_allclose(history.displacement[:, 2], exact, atol=1e-9 * 50.0 / K)
    (found,) = [u for u in read_nastran(path).unread if u.keyword == "TABDMP1"]
    assert found.share == pytest.approx(0.05)


@pytest.mark.parametrize(
    ("table", "zeta"),
    [
        ("TABDMP1,9,CRIT\n,0.,.02,{f2},.08,ENDT\n", 0.05),
        ("TABDMP1,9,G\n,{f2},.16,{f4},.28,ENDT\n", 0.05),
        ("TABDMP1,9,CRIT\n,{f2},.08,{f4},.14,ENDT\n", 0.05),
        ("TABDMP1,9,CRIT\n,{f8},.05,0.,.05,ENDT\n", 0.05),
        ("TABDMP1,9,CRIT\n,0.,.04,{f8},.0,SKIP,SKIP,ENDT\n", 0.035),
    ],
)
def test_damping_that_depends_on_the_frequency_of_the_mode(tmp_path, table, zeta):
    """zeta = .02 + .06 f / 2 f_1 is .05 at f_1, between its points and on the line before the first of them."""
    f1 = W / (2.0 * math.pi)
    table = table.format(**{f"f{k}": f"{k * f1:.5f}" for k in (2, 4, 8)})
    path = deck(tmp_path, BULK + constant() + table, "DLOAD = 7\nSDAMPING = 9\n", "112")
    history = run_study(set_up_deck(path, units="m-kg-s"), lambda *_: None).runs["reduced"].history
    t, wd = history.time[history.output_index], W * math.sqrt(1.0 - zeta**2)
    exact = 50.0 / K * (1.0 - np.exp(-zeta * W * t) * (np.cos(wd * t) + zeta * W / wd * np.sin(wd * t)))
    # Frequencies of the table have eight digits
    np.testing.assert_allclose(history.displacement[:, 2], exact, atol=1e-6 * 50.0 / K)


def test_lines_of_a_damping_table_go_on_to_no_damping_and_to_critical(tmp_path):
    table = "TABDMP1,9,CRIT\n,10.,.05,20.,.03,ENDT\n"
    path = deck(tmp_path, BULK + constant() + table, "DLOAD = 7\nSDAMPING = 9\n", "112")
    of = read_nastran_run(path)[1].step.modes.by_frequency
    np.testing.assert_allclose(of, [(0.0, 0.07), (10.0, 0.05), (20.0, 0.03), (35.0, 0.0)])
    path.write_text(path.read_text().replace(",10.,.05,20.,.03", ",10.,.03,20.,.05"))
    low, *_, high = read_nastran_run(path)[1].step.modes.by_frequency
    np.testing.assert_allclose([low, high], [(0.0, 0.01), (495.0, 1.0)], rtol=1e-5)


@pytest.mark.parametrize(
    ("table", "solution"),
    [
        ("TABDMP1,9,Q\n,0.,10.,99.,20.,ENDT\n", "112"),
        ("TABDMP1,9,CRIT\n,0.,.05,50.,.05,50.,.02,99.,.02,ENDT\n", "112"),
        ("TABDMP1,9,CRIT\n,0.,2.,ENDT\n", "112"),
        ("TABDMP1,9,CRIT\n,0.,.05,ENDT\n", "109"),
    ],
)
def test_other_modal_damping_stops_the_run(tmp_path, table, solution):
    path = deck(tmp_path, BULK + constant() + table, "DLOAD = 7\nSDAMPING = 9\n", solution)
    with pytest.raises(InputError, match="TABDMP1 is not read by creak"):
        set_up_deck(path, units="m-kg-s")


def test_a_mass_slides_on_an_oblique_gap(tmp_path):
    """1 N holds a mass against a gap along (1, 0, 1) and 1 N pushes it across it, with friction .3 of the gap's 1e6 N/m.

    The sudden load presses with 1 - cos w t, w^2 = k/m, so that across it m u'' = 1 - .3 (1 - cos w t).
    """
    push = f"{1.0 / math.sqrt(2.0)!r}"
    bulk = (
        "GRID,1,,,,,,2456\nGRID,3,,1.,,1.,,123456\nCONM2,1,1,,100.\nCGAP,4,4,3,1\nPGAP,4,0.,,1.+6,,,.3\n"
        "TSTEP,5,2000,1.-4\nTLOAD1,7,6,,,8\nTABLED1,8\n,0.,1.,1.,1.,ENDT\n"
        f"FORCE,6,1,,{push},1.,0.,1.\nFORCE,6,1,,{push},1.,0.,-1.\n"
    )
    path = deck(tmp_path, bulk, "DLOAD = 7\n")
    history = run_study(set_up_deck(path, units="m-kg-s"), lambda *_: None).runs["reference"].history
    t, across = history.time, (history.displacement[:, 0] - history.displacement[:, 2]) / math.sqrt(2.0)
    w = math.sqrt(1.0e6 / 100.0)
    exact = 0.7 * t * t / 200.0 + 0.3 / 100.0 * (1.0 - np.cos(w * t)) / w**2
    # HHT with alpha = -.05 turns the phase of the press by about (w h)^2 w t / 12 and takes a little of its amplitude
    np.testing.assert_allclose(across, exact, atol=2e-3 * exact[-1])


GAP = "GRID,3,,,,1.,,123456\nCGAP,4,4,3,1\nPGAP,4,.02,,1.+6\n"


def test_gaps_in_a_study_are_named(tmp_path):
    """From GA (3, above) to GB (1): u_1 - u_3 <= .02 along z."""
    model = read_nastran(deck(tmp_path, BULK + GAP, ""))
    (found,) = [u for u in model.unread if u.keyword == "CGAP"]
    assert found.changes_answer
    assert 'nodes = ["GAP_4.A", "GAP_4.B"], dof = "z", upper = 0.02, stiffness = 1e+06' in found.why
    assert [model.node_sets[f"GAP_4.{end}"].tolist() for end in "AB"] == [[2], [0]]


def test_gaps_of_several_directions_and_by_a_system(tmp_path):
    more = "CORD2R,9,,0.,0.,0.,1.,0.,0.\n,0.,1.,0.\nCGAP,5,4,1,2,,,,9\nCGAP,6,4,3,1\n"
    _, run = read_nastran_run(deck(tmp_path, BULK + GAP + more, ""))
    found = {s.name: (s.first.tolist(), s.second.tolist(), s.dof, s.lower, s.upper) for s in run.stops}
    assert found == {"GAP_4_1": ([2, 2], [0, 0], 3, None, 0.02), "GAP_4_2": ([0], [1], 2, -0.02, None)}


REFUSED = {
    "another solution": (BULK, "", "103", "SOL 103"),
    "frequency response": (BULK, "", "111", "SOL 111.*`creak modes` finds the modes of a frequency response"),
    "no such TSTEP": (BULK.replace("TSTEP,5", "TSTEP,6"), "", "109", "TSTEP = 5"),
    "two lengths": (BULK.replace("1.-3\n", "1.-3\n,,20,1.-4\n"), "", "109", "0.0001, 0.001"),
    "no such load": (BULK, "DLOAD = 7\n", "109", "dynamic load 7"),
    "no such table": (BULK + "TLOAD1,7,6,,,8\nDAREA,6,1,3,1.\n", "DLOAD = 7\n", "109", "table 8"),
    "no such set": (BULK + constant(""), "DLOAD = 7\n", "109", "load set 6"),
    "pressure": (BULK + constant("DAREA,6,1,3,1.\nPLOAD4,6,1,1.\n"), "DLOAD = 7\n", "109", "PLOAD4"),
    "motion without SPCD": (BULK + constant(kind="DISP"), "DLOAD = 7\n", "109", "forces"),
    "delay card": (BULK + constant().replace("TLOAD1,7,6,,", "TLOAD1,7,6,3,"), "DLOAD = 7\n", "109", "DELAY"),
    "start of a function": (
        BULK + "TLOAD2,7,6,,DISP,0.,9.,2.\n,,,.1\nSPCD,6,2,3,1.\n",
        "DLOAD = 7\n",
        "109",
        "TLOAD2 7 has initial values",
    ),
    "rising friction": (BULK + GAP.replace("1.+6", "1.+6,,,.3,.4"), "", "109", "MU1 = 0.3 and MU2 = 0.4"),
    "friction by side": (BULK + GAP.replace("1.+6", "1.+6,,,.3,.2\n,-1."), "", "109", "TMAX below 0"),
    "preload": (BULK + GAP.replace(",.02,,", ",.02,5.,"), "", "109", "preload"),
    "open stiffness": (BULK + GAP.replace("1.+6", "1.+6,10."), "", "109", "KB"),
}


@pytest.mark.parametrize("name", REFUSED)
def test_what_cannot_be_run_is_named(tmp_path, name):
    bulk, case, solution, word = REFUSED[name]
    with pytest.raises(InputError, match=word):
        read_nastran_run(deck(tmp_path, bulk, case, solution))


def test_creak_run(tmp_path):
    path = deck(tmp_path, BULK.replace("500", "50") + constant(), "DLOAD = 7\n")
    say("run", path, "--quiet", "--units", "m-kg-s").done()
    assert (tmp_path / "results" / "summary.json").exists()
