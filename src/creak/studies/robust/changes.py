"""Draws on a model that was reduced once: what other numbers make of its channels, loads and damping."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from creak.assembly.part import damps_by_itself
from creak.assembly.system import System
from creak.errors import InputError
from creak.studies.file.changes import with_changes
from creak.studies.file.design.clip_tables import ClipTable
from creak.studies.file.reader import Study
from creak.studies.prepare.setup import Setup
from creak.studies.prepare.varied import varied
from creak.studies.robust.draws import Draw, Drawn

OF_CONTACT = ("clearance", "friction", "stiffness", "damping")
OF_CONNECTOR = ("lower", "upper", "stiffness", "damping", "preload")
OF_CLIP = ("stiffness", "table", "damping", "lower", "upper", "gap", "pull_out", "ageing")
"""Numbers that leave nodes and directions as they are."""
TABLES = ("contact", "connector", "clip", "excitation", "damping", "static")
OF_SIGNAL = ("amplitude", "seed", "mean")
"""Numbers of a signal that change neither its length nor its frequencies."""


def keeps_model(setup: Setup, clips: Sequence[ClipTable], key: str) -> bool:
    """Whether another value leaves the reduced model, its channels and the steps of the run as they are.

    Parameters
    ----------
    clips : of the study, with the values that they take from the library.
    """
    words = key.split(".")
    if words[0] == "contact" and len(words) > 2:
        return words[2] in OF_CONTACT and (len(words) == 3 or words[2] == "friction")
    if words[0] == "clip" and len(words) > 2 and words[1].isdigit():
        held = int(words[1]) < len(clips) and clips[int(words[1])].type not in ("bushing", None)
        return held and words[2] in OF_CLIP
    if words[0] == "connector":
        return words[-1] in OF_CONNECTOR
    if words[0] == "excitation":
        return len(words) == 4 and words[2] == "signal" and words[3] in OF_SIGNAL
    if key == "damping.modal":
        return _has_modal_damping(setup)
    return words[0] == "static"


def _has_modal_damping(setup: Setup) -> bool:
    """Whether all damping of the study is the share of critical that it gives: another one multiplies all of it."""
    own = damps_by_itself(setup.model, setup.rayleigh, setup.override_damping)
    dashpots = own or any(part.damping.extra is not None for part in setup.superelements)
    return bool(setup.study.config.damping.modal) and not dashpots


def tables_of(study: Study) -> dict[str, Any]:
    """The tables that such a value may be in."""
    return {name: getattr(study.config, name) for name in TABLES}


def drawn_study(study: Study, values: Mapping[str, Any]) -> Study:
    """The study with drawn numbers, checked as any change is."""
    return with_changes(study, values) if values else study


def check_ends(study: Study, drawn: Drawn) -> None:
    """Raise InputError where the lowest or highest numbers of draws are what a study may not say."""
    pairs = zip(drawn.causes, drawn.numbers, strict=True)
    numbers = [(c, v) for c, v in pairs if v is not None and not c.is_factor]
    for end in (np.min, np.max):
        drawn_study(study, {c.key: c.number(end(v)) for c, v in numbers})


def drawn_setup(setup: Setup, draw: Draw) -> Setup:
    """The setup, before its static start, by the numbers and fields of a draw.

    Raises
    ------
    InputError : connectors or clips that lie elsewhere, or look in another direction: numbers that change the model.
    """
    changed = varied(setup, tables_of(drawn_study(setup.study, draw.values)), draw.fields, draw.factors)
    if not changed.connectors.moves_as(setup.connectors):
        raise InputError(
            f"draw {draw.number} moves a connector or clip, or turns it round, on a model reduced without that",
            where=setup.study.places.where("scatter"),
            expected=f"of a clip {', '.join(OF_CLIP)}, of a connector {', '.join(OF_CONNECTOR)}",
        )
    zeta = changed.study.config.damping.modal
    return changed if zeta is None else replace(changed, modal=zeta)


def with_damping(system: System, zeta: float, before: float) -> System:
    """A reduced System all of whose damping is modal, with another share of critical.

    Parameters
    ----------
    before : the share that it has, above 0.
    """
    by, sup, d = zeta / before, system.supports, system.damping
    assert d.modal_values is not None
    assert d.extra is None
    damping = replace(d, beta=by * d.beta, modal_values=by * d.modal_values)
    return replace(system, damping=damping, supports=replace(sup, C_qs=by * sup.C_qs, C_ss=by * sup.C_ss))
