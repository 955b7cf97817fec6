"""How many modes the draws of a study have where its f_max is "auto": as many as its own run ends with."""

from __future__ import annotations

from dataclasses import replace
from functools import partial

from creak.progress import Progress, Sentence
from creak.studies.converge.auto_band import settle
from creak.studies.models.saved import Store
from creak.studies.prepare.setup import Setup
from creak.studies.run.job import run_study
from creak.studies.warned import Warned


def with_band_of_run(setup: Setup, progress: Progress, store: Store) -> tuple[Setup, list[str]]:
    """The study with f_max raised as `creak run` would raise it, but that no unreduced model is asked; and a note.

    Draws are the study by other numbers: what more modes change in its own run they change in theirs.
    """
    c = setup.study.config
    if not setup.band.auto or c.reduction.method in ("none", "guyan") or not c.time.exact:
        return setup, []
    progress(Sentence('f_max = "auto": the run of the study itself, to see how far its modes need to go'), 1, 1)
    found = run_study(setup.unproven, progress, store, settle=partial(settle, store=store)).band
    if found is None:
        return setup, []
    setup = replace(setup, raised=found.reduction.band.raised)
    upto = "all modes" if found.reduced.every_mode else f"modes up to {setup.band.f_max:,.0f} Hz"
    said = f'the draws have {upto}, where f_max = "auto" ends in the run of the study itself'
    if not (found.reduced.every_mode or found.run.history.force.any()):
        return setup, [Warned(f"{said}: nothing touches in it, so set f_max where draws that touch need more modes")]
    return setup, [said]
