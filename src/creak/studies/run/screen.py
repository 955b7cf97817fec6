"""E-lines of a study from modes alone: no reduction, no contact, no run of the model itself."""

from __future__ import annotations

from dataclasses import replace

from creak.errors import InputError
from creak.studies.models.reference import build_reference
from creak.studies.prepare.setup import Setup
from creak.studies.run.elines import LineFindings, Progress, findings, modal_measures
from creak.studies.run.motion import NO_STEPS
from creak.studies.run.static_start import started


def left_out(setup: Setup) -> list[str]:
    """What may touch and is on no line: stops, which hold two nodes or sets apart in one direction."""
    tables = setup.study.config.connector
    if not tables:
        return []
    one = len(tables) == 1
    said = "is on no line, so it is" if one else "are on no line, so they are"
    return [f"{len(tables)} [[connector]] of the study {said} not ranked here: creak run has {'it' if one else 'them'}"]


def screen(setup: Setup, progress: Progress) -> LineFindings:
    """Measures of all E-lines over the whole run, of the assembly's modes without contact.

    A gap that closes before the verification window closes too. Modes up to three times the highest frequency of the
    excitation ride on the quasi-static motion of supports and loads, as in the pre-check.

    Raises
    ------
    InputError : there are no lines; only contact holds the structure.
    """
    study = setup.study
    if not setup.watch.lines.points.m:
        raise InputError(
            "there is nothing to screen: the study has neither a contact nor an [eline.NAME]",
            where=study.path,
            expected="points between two parts",
            fix="Add a [contact.NAME], or an [eline.NAME] with main and secondary.",
        )
    checked = study.config.precheck.model_copy(update={"enabled": True})
    setup = setup.with_tables(precheck=checked)
    reference = build_reference(setup.structure, setup.band, progress)
    if reference.stiffness is None:
        raise InputError(
            "only contact holds the structure: without it nothing can be told from modes",
            where=study.path,
            expected="supports that hold it without contact",
            fix="Run it with contact: creak run.",
        )
    bare = replace(setup, contacts=setup.contacts.select(NO_STEPS), connectors=setup.connectors.select(NO_STEPS))
    setup = replace(setup, watch=started(bare, reference, progress).watch)
    marching = setup.marching
    whole = replace(marching, course=replace(marching.course, repeats=None, until=None))
    linear = modal_measures(whole, setup.watch.lines, setup.reduction, reference, progress)
    highest = reference.modes.frequencies.max(initial=0.0)
    if linear is None:
        raise InputError(
            "the run is too long for the modes to be kept",
            where=study.places.where("time"),
            fix="Shorten the run.",
        )
    return findings(setup.watch.lines, linear, None, None, f"modes up to {highest:.4g} Hz", "")
