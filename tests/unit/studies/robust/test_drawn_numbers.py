"""`creak robust`: what a drawn number makes of a run, against runs of studies that give it."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from benchmarks.odds import DECK, STOPPED_BEAM

import creak
from creak.errors import InputError
from creak.progress import silent
from creak.studies.file.changes import with_changes
from creak.studies.file.reader import read_study
from creak.studies.models.reference import build_reference
from creak.studies.prepare.setup import set_up
from creak.studies.robust import job
from creak.studies.robust.changes import check_ends
from creak.studies.robust.draws import Draw, Drawn, make_causes
from creak.studies.robust.findings import Robustness
from creak.studies.robust.shared_model import lowest_of, shared_model, variant_of
from creak.studies.run.precheck import with_linear_gaps
from helpers_decks import STUDY, write_strips, write_study

DASHPOT = "*ELEMENT, TYPE=DASHPOT1, ELSET=DASH\n9, 3\n*DASHPOT, ELSET=DASH\n3\n0.0003\n"


@pytest.fixture(autouse=True)
def _no_further_draws(monkeypatch):
    """Draws that motion without contact foretells are not looked at here."""
    monkeypatch.setattr("creak.studies.robust.further.TIMES", 0)


def beam(folder: Path, vary: str, *changes: tuple[str, str], deck: str = DECK) -> Path:
    """The stopped beam with other words in its study, and what scatters."""
    text = STOPPED_BEAM
    for before, after in changes:
        assert before in text
        text = text.replace(before, after)
    return write_study(folder, f"{text}[scatter.vary]\n{vary}\n", {"beam.inp": deck})


def impulses(found: Robustness, k: int = 3) -> tuple[float, float]:
    """Of a draw, and of the run of the study that gives its numbers: the impulse of all channels."""
    changed = with_changes(found.draws.setup.study, {**found.draws.drawn.draw(k).values, "reference.run": False})
    run = creak.run(changed, converge=False, record=False).runs["reduced"]
    return float(found.draws.figures[k, :, 1].sum()), sum(event.impulse for event in run.events)


DAMPED = '"damping.modal" = { type = "uniform", low = 0.05, high = 0.4 }'
GIVEN = "[damping]\nmodal = 0.02\n"


@pytest.mark.parametrize(
    ("given", "deck", "again"),
    [
        ("", DECK, True),
        ("[damping]\nmodal = 0.0\n", DECK, True),
        (GIVEN, DECK + DASHPOT, True),
        (GIVEN, DECK, False),
    ],
    ids=["none", "zero", "beside a dashpot", "modal"],
)
def test_drawn_modal_damping_is_that_of_a_run(tmp_path, given, deck, again):
    """Whatever damping the study itself has."""
    path = beam(tmp_path, DAMPED, (GIVEN, given), ("upper = 10.0", "upper = 7.0"), deck=deck)
    found = creak.robust(path, 4, indices=False, threads=1)
    assert found.draws.reduced_again == (("damping.modal",) if again else ())
    drawn, run = impulses(found)
    assert drawn == pytest.approx(run, rel=1e-6)
    assert np.ptp(found.draws.impulse) > 0.1 * found.draws.impulse.max() > 0.0


def test_another_modal_damping_holds_beyond_the_modes_too(tmp_path):
    """Reduced as a whole, what lies beyond the modes is damped in proportion to its stiffness."""
    path = beam(tmp_path, DAMPED, ("f_max = 20000", 'method = "gap-modes"\nf_max = 1000'))
    study, draw = read_study(path), Draw(0, {"damping.modal": 0.1}, {})
    made = shared_model(set_up(study), [draw], silent)
    system, own = (
        variant_of(made, draw).system,
        shared_model(set_up(with_changes(study, draw.values)), [], silent).system,
    )
    assert own.damping.beta > 0.0
    drawn, asked = (s.damping.beta * s.K.diagonal() + s.damping.other(np.ones(s.n)) for s in (system, own))
    assert drawn == pytest.approx(asked, rel=1e-12)


def test_less_damping_brings_gaps_nearer_in_the_pre_check(tmp_path):
    """The draw of least damping is looked at, wherever it stands."""
    text = STUDY.replace("periods = 2", "end = 0.1")
    study = read_study(write_strips(tmp_path, None, f"{text}[damping]\nmodal = 0.1\n"))
    setup, values = set_up(study), [0.1] * 10 + [0.01, 0.1]
    reference = with_linear_gaps(
        setup.study.config.precheck,
        setup.reduction,
        setup.marching,
        build_reference(setup.structure, setup.band, silent),
        silent,
    )
    draws = [Draw(k, {"damping.modal": zeta}, {}) for k, zeta in enumerate(values)]
    other = set_up(with_changes(study, {"damping.modal": 0.01}))
    least = with_linear_gaps(
        other.study.config.precheck,
        other.reduction,
        other.marching,
        build_reference(other.structure, other.band, silent),
        silent,
    ).linear_gaps
    expected = np.minimum(least - reference.linear_gaps, 0.0)
    assert expected.min() < -0.01
    assert lowest_of(setup, reference, draws) == pytest.approx(expected, abs=1e-9)


STOP = '[[clip]]\nname = "seat"\ntype = "stop"\nnodes = "TIP"\naxis = [0.3, 0, 1.0]\ngap = 7.0\nstiffness = 40.0\n'
"""Touches at the load of the beam's study."""
AT_POINT = STOP.replace('nodes = "TIP"', 'at = [[200.0, 0.0, 0.0]]\nparts = "BEAM"\nwithin = 60.0').replace(
    "7.0", "3.0"
)
AT_POINTS = AT_POINT.replace("[[200.0, 0.0, 0.0]]", "[[200.0, 0.0, 0.0], [150.0, 0.0, 0.0]]")
PULL_OUT = STOP.replace('"stop"', '"pull-out"').replace("gap = 7.0", "pull_out = 0.5")
SPAN = '{{ type = "uniform", low = {}, high = {} }}'
OF_CLIPS = {
    "direction": (STOP, "clip.0.axis.1", SPAN.format(-1.0, 1.0), True),
    "place": (AT_POINT, "clip.0.at.0.0", SPAN.format(100.0, 200.0), True),
    "gap": (STOP, "clip.0.gap", SPAN.format(5.0, 8.0), False),
    "stiffness": (STOP, "clip.0.stiffness", SPAN.format(20.0, 80.0), False),
    "damping": (STOP, "clip.0.damping", SPAN.format(0.0, 0.05), False),
    "ageing": (STOP, "clip.0.ageing", SPAN.format(0.5, 2.0), False),
    "table": (
        STOP.replace("stiffness = 40.0", "table = [[0, 0], [1, 40], [2, 120]]"),
        "clip.0.table.1.1",
        SPAN.format(20.0, 60.0),
        False,
    ),
    "limit": (
        STOP.replace('"stop"', '"play"').replace("gap = 7.0", "upper = 7.0\nlower = -1.0"),
        "clip.0.upper",
        SPAN.format(5.0, 8.0),
        False,
    ),
    "pull-out": (PULL_OUT, "clip.0.pull_out", SPAN.format(0.05, 0.9), False),
}


@pytest.mark.parametrize("case", OF_CLIPS)
def test_drawn_numbers_of_a_clip_are_those_of_a_run(tmp_path, case):
    """Those that move it or turn it round have a model of their own."""
    clip, key, of, again = OF_CLIPS[case]
    path = beam(tmp_path, f'"{key}" = {of}', ("upper = 10.0", "upper = 30.0"), ("[reduction]", f"{clip}[reduction]"))
    found = creak.robust(path, 4, indices=False, threads=1)
    assert found.draws.reduced_again == ((key,) if again else ())
    drawn, run = impulses(found)
    assert drawn == pytest.approx(run, rel=1e-6)
    every = found.draws.figures[:, :, 1].sum(axis=1)
    assert np.ptp(every) > 1e-3 * every.max() > 0.0


def test_a_clip_that_moves_to_other_nodes_keeps_its_rows(tmp_path):
    """Its channels are named after their nodes: those of a draw stand for the study's own, in turn."""
    deck = DECK.replace("2, 2, 3\n*NSET", "2, 2, 4\n3, 4, 3\n*NSET").replace("\n3, 200", "\n4, 150., 0., 0.\n3, 200")
    vary, changes = f'"clip.0.at.1.0" = {SPAN.format(60.0, 110.0)}', ("[reduction]", f"{AT_POINTS}[reduction]")
    path = beam(tmp_path, vary, ("upper = 10.0", "upper = 30.0"), changes, deck=deck)
    found = creak.robust(path, 4, indices=False, threads=1)
    assert found.draws.channels.names[-2:] == ("seat:upper:3", "seat:upper:4")
    drawn, run = impulses(found)
    assert drawn == pytest.approx(run, rel=1e-6)
    assert found.draws.impulse[:, -2:].any()


def test_a_clip_turned_round_on_the_model_of_another_is_refused(tmp_path):
    """And channels in another direction share no arrays of a run."""
    path = beam(tmp_path, f'"clip.0.gap" = {SPAN.format(5, 8)}', ("[reduction]", f"{STOP}[reduction]"))
    setup = set_up(read_study(path))
    made, turned = shared_model(setup, [], silent), {"clip.0.axis": [0.3, 1.0, 1.0]}
    with pytest.raises(InputError, match="draw 5 moves a connector or clip, or turns it round"):
        variant_of(made, Draw(5, turned, {}))
    gaps = set_up(with_changes(setup.study, turned)).connectors
    again = made.base.again(gaps, setup.loads)
    assert abs(again.on.rows - made.base.on.rows).max() > 0.1


def test_a_limit_that_the_study_does_not_give_is_no_number_to_draw(tmp_path):
    path = beam(tmp_path, f'"connector.0.lower" = {SPAN.format(-9, -8)}')
    with pytest.raises(InputError, match=r"connector\.0\.lower is not given in the study: without it there is no such"):
        creak.robust(path, 4)


def test_limits_that_may_cross_are_refused_before_any_draw(tmp_path, monkeypatch):
    """The highest lower limit against the lowest upper one; both lowest, or highest, are in order."""
    vary = '"connector.0.upper" = {}\n"connector.0.lower" = {}'
    both = ("upper = 10.0", "upper = 3.0\nlower = -3.0")
    monkeypatch.setattr(job, "shared_model", None)
    with pytest.raises(InputError, match=r"lower = 0\.\d+ lies above upper = -0\.\d+") as found:
        creak.robust(beam(tmp_path, vary.format(SPAN.format(-1, 2), SPAN.format(-2, 1)), both), 16)
    assert "[scatter.vary]: draws may reach connector.0.upper = -0." in str(found.value)
    assert "beside connector.0.lower = 0." in str(found.value)
    alone = '"connector.0.upper" = ' + SPAN.format(-4, 3)
    with pytest.raises(InputError, match=r"lower = -3\.0 lies above upper = -3\.\d+") as found:
        creak.robust(beam(tmp_path, alone, both), 16)
    assert "[scatter.vary.connector.0.upper]: draws may reach connector.0.upper = -3." in str(found.value)


@pytest.mark.parametrize(
    ("static", "kinetic"), [((0.3, 0.9), (0.2, 0.5)), ((0.2, 0.6), (0.3, 0.5))], ids=["across", "lowest"]
)
def test_friction_that_may_be_higher_in_motion_is_refused_before_any_draw(tmp_path, monkeypatch, static, kinetic):
    text = STUDY.replace("step = 5e-4\n", "").replace(
        'method = "surface-to-surface"', "friction = { static = 0.3, kinetic = 0.2, decay = 10.0 }"
    )
    spans = {"static": static, "kinetic": kinetic, "decay": (5.0, 20.0)}
    vary = [f'"contact.tip.friction.{word}" = {SPAN.format(*span)}' for word, span in spans.items()]
    path = write_strips(tmp_path, None, "\n".join([text, "[scatter.vary]", *vary]))
    monkeypatch.setattr(job, "shared_model", None)
    with pytest.raises(InputError, match=r"kinetic = 0\.\d+ is above static = 0\.\d+") as found:
        creak.robust(path, 16)
    assert "[scatter.vary]: draws may reach contact.tip.friction.static = 0." in str(found.value)


def test_numbers_that_go_together_in_every_draw_may_leave_those_of_the_study(tmp_path):
    """Kinetic friction above the study's static one, whose draws lie higher still."""
    text = STUDY.replace("step = 5e-4\n", "").replace(
        'method = "surface-to-surface"', "friction = { static = 0.3, kinetic = 0.2, decay = 10.0 }"
    )
    vary = "\n".join(
        f'"contact.tip.friction.{word}" = {SPAN.format(*span)}'
        for word, span in {"static": (0.8, 0.9), "kinetic": (0.5, 0.6), "decay": (5.0, 20.0)}.items()
    )
    setup = set_up(read_study(write_strips(tmp_path, None, f"{text}\n[scatter.vary]\n{vary}\n")))
    fields = job.fields_of(setup.contacts, setup.model.nodes)
    data = setup.study.config.model_dump(mode="json", by_alias=True)
    causes = make_causes(setup.study.config.scatter, data, {}, fields, setup.study.places, {})
    check_ends(setup, Drawn.at(causes, np.random.default_rng(1).random((16, 3))))
