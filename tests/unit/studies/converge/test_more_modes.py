"""The run with more modes has modes that the base run lacks, whatever their frequency; a complete part has none left."""

from __future__ import annotations

import re
from dataclasses import replace

import pytest

from creak.api.study import run
from creak.studies.converge.settling import BASE, MORE_MODES, UNREDUCED
from creak.studies.converge.words import REMEDIES, remedy_of
from creak.studies.file.reader import read_study
from helpers_bar import FIRST, LENGTH, WAVE, bar
from helpers_decks import STUDY, two_strips, write_strips

NO_SPOTS = '\n[reference]\nrun = "none"'
"""Where the runs of the reduced model alone are looked at."""


def verdict(found):
    main = found.summary["runs"]["reduced"]
    return main["verdict"], " ".join(main["reasons"])


def told(found):
    """Modes and the length of the blow, in every run."""
    runs = found.summary["convergence"]["runs"]
    ends = {name: o.events[0].t_end - o.events[0].t_start for name, o in found.convergence.outcomes.items()}
    return {name: runs[name]["modes"] for name in (BASE, MORE_MODES)}, ends


def test_a_stiff_bar_whose_first_mode_lies_far_above_f_max_has_not_settled(tmp_path):
    """Its first mode lies at 6.5 kHz: up to 1.5 kHz it is rigid, and its blow a spring's."""
    found = run(bar(tmp_path, "f_max = 1500"), converge=True)
    modes, lasts = told(found)
    assert modes == {BASE: 0, MORE_MODES: 3}
    assert lasts[BASE] < 0.1 * 2.0 * LENGTH / WAVE < lasts[MORE_MODES]
    word, why = verdict(found)
    assert word == "unsettled"
    assert "the reduction" in why
    assert "f_max" in remedy_of(UNREDUCED, found.convergence)[1]


@pytest.mark.parametrize("step", ["", "step = 1e-7\n"])
def test_a_part_without_modes_between_f_max_and_half_again_gets_those_above(tmp_path, step):
    """Two modes lie below 4 times the first, the third at 5 times, which no run to 1.5 f_max = 4.5 times has."""
    found = run(bar(tmp_path, f"f_max = {3.0 * FIRST!r}", time=f"{step}end = 1e-4{NO_SPOTS}"), converge=True)
    assert told(found)[0] == {BASE: 1, MORE_MODES: 4}


@pytest.mark.parametrize("step", ["", "step = 2e-7\n"])
def test_a_complete_part_leaves_nothing_out(tmp_path, step):
    """Four elements have four modes, the highest far below 100 times the first: there is no run to make."""
    found = run(bar(tmp_path, f"f_max = {100.0 * FIRST!r}", n=4, time=f"{step}end = 1e-4{NO_SPOTS}"), converge=True)
    c = found.convergence
    assert told(found)[0] == {BASE: 4, MORE_MODES: 4}
    assert c.outcomes[MORE_MODES].steps == 0
    assert all(f.changes["modes"] == 0.0 for e in c.events for f in e.figures.values())
    assert any("every part is complete" in text for text in found.summary["convergence"]["findings"])
    assert not c.unlooked
    assert not any("f_max" in remedy_of(family, c)[1] for family in REMEDIES)
    assert remedy_of("modes", c) == REMEDIES["tolerance"]
    assert "finest" in remedy_of("modes", replace(c, fine=True))[1]


def test_where_every_dof_stays_no_modes_are_told_to_be_missing(tmp_path):
    """Nodes follow others, so nothing is complete, and none is left inside to have a mode: f_max changes nothing."""
    deck, f_max = two_strips(), "[reduction]\nf_max = 3000\n"
    blocks = re.findall(r"\*NODE(?:,[^\n]*)?\n((?:\s*\d[^\n]*\n)+)", deck)
    labels = [int(line.split(",")[0]) for block in blocks for line in block.splitlines()]
    study = STUDY.replace(f_max, f'{f_max}interface = {{ type = "interpolation", n = 2 }}\n')
    study = study.replace("periods = 2", "end = 0.05").replace("amplitude = 0.05", "amplitude = 1.0")
    every = f'[nodes.EVERY]\nlabels = {labels}\n[output]\nnodes = "EVERY"\n'
    found = run(read_study(write_strips(tmp_path, deck, f"{study}\n{every}{NO_SPOTS}\n")), converge=True)
    assert told(found)[0] == {BASE: 0, MORE_MODES: 0}
    word, why = verdict(found)
    assert word == "unsettled"
    assert "interpolation" in why
    assert "f_max" not in why


def test_what_a_guyan_reduction_leaves_out_has_not_settled(tmp_path):
    word, why = verdict(run(bar(tmp_path, 'method = "guyan"', n=40, time=f"end = 2e-4{NO_SPOTS}"), converge=True))
    assert word == "unsettled"
    assert "Guyan" in why
    assert "not looked at" in why


def test_an_assembly_that_is_reduced_as_a_whole_gets_more_of_its_modes(tmp_path):
    """The free bar has its rigid mode below 2 kHz, and vibrates from 13 kHz on; four elements have five modes."""
    time = f"end = 1e-4{NO_SPOTS}"
    found = run(bar(tmp_path, 'method = "gap-modes"\nf_max = 2000', time=time), converge=True)
    assert told(found)[0] == {BASE: 1, MORE_MODES: 4}
    whole = tmp_path / "whole"
    whole.mkdir()
    found = run(bar(whole, f'method = "gap-modes"\nf_max = {100.0 * FIRST!r}', n=4, time=time), converge=True)
    assert told(found)[0] == {BASE: 5, MORE_MODES: 5}
    assert found.convergence.outcomes[MORE_MODES].steps == 0
