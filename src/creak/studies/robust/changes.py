"""Draws on a model that was reduced once: what other numbers make of its channels, loads and damping."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from itertools import combinations, product
from typing import Any

import numpy as np

from creak.assembly.part import damps_by_itself
from creak.assembly.system import System
from creak.errors import InputError
from creak.progress import silent
from creak.studies.file.changes import row_of, with_changes
from creak.studies.file.contact_tables import ClipTable
from creak.studies.models.reference import ReferenceModel
from creak.studies.prepare.setup import Setup
from creak.studies.prepare.structure import Structure
from creak.studies.prepare.varied import varied
from creak.studies.robust.draws import Draw, Drawn
from creak.studies.run.static_start import started

OF_CONTACT = ("clearance", "friction", "stiffness", "damping")
OF_CONNECTOR = ("lower", "upper", "stiffness", "damping", "preload", "friction")
OF_CLIP = ("stiffness", "table", "damping", "lower", "upper", "gap", "pull_out", "ageing")
"""Numbers that leave nodes and directions as they are."""
TOUCHING = ("contact", "connector", "clip")
TABLES = ("contact", "connector", "clip", "excitation", "damping", "static")
OF_SIGNAL = ("amplitude", "seed", "mean")
"""Numbers of a signal that change neither its length nor its frequencies."""


def keeps_model(clips: Sequence[ClipTable], key: str, *, modal: bool) -> bool:
    """Whether another value leaves the reduced model, its channels and the steps of the run as they are.

    Parameters
    ----------
    clips : of the study, with the values that they take from the library. modal : as `damped_by_modes`.
    """
    words = key.split(".")
    if words[0] == "contact" and len(words) > 2:
        return words[2] in OF_CONTACT and (len(words) == 3 or words[2] == "friction")
    if words[0] == "clip" and len(words) > 2:
        row = row_of([{"name": clip.name} for clip in clips], words[1])
        return row is not None and clips[row].type not in ("bushing", None) and words[2] in OF_CLIP
    if words[0] == "connector":
        return words[-1] in OF_CONNECTOR
    if words[0] == "excitation":
        return len(words) == 4 and words[2] == "signal" and words[3] in OF_SIGNAL
    if key == "damping.modal":
        return modal
    return words[0] == "static"


def damped_by_modes(structure: Structure, share: float | None) -> bool:
    """Whether all damping is the share of critical that the study gives: another one multiplies all of it."""
    own = damps_by_itself(structure.model, structure.rayleigh, structure.override_damping)
    return bool(share) and not own and all(part.damping.extra is None for part in structure.superelements)


def check_ends(setup: Setup, drawn: Drawn) -> None:
    """Raise InputError where draws may reach what a study may not say.

    That is tried with the lowest and highest numbers of each two of a table, and of each alone, all others in their
    middle, and with all of them lowest, or highest.
    """

    def check(values: Mapping[str, Any], *keys: str) -> None:
        try:
            varied(setup, with_changes(setup.study, values).tables(TOUCHING))
        except InputError as error:
            together = " beside ".join(f"{key} = {values[key]:.4g}" for key in keys)
            raise InputError(
                f"draws may reach {together or 'what no study may say'}: {error.what}",
                where=setup.study.places.where("scatter", "vary", *(keys if len(keys) == 1 else ())),
                expected=error.expected or "distributions of which each draw is a study",
                fix="Give them ends, low and high, or make them narrower.",
            ) from error

    pairs = zip(drawn.causes, drawn.numbers, strict=True)
    numbers = [(c, v) for c, v in pairs if v is not None and not c.is_factor]
    low, middle, high = ({c.key: c.number(at(v)) for c, v in numbers} for at in (np.min, np.median, np.max))
    for one, other in combinations(middle, 2):
        if one.split(".")[:2] == other.split(".")[:2]:
            for a, b in product((low, high), repeat=2):
                check({**middle, one: a[one], other: b[other]}, one, other)
    for key in middle:
        for end in (low, high):
            check({**middle, key: end[key]}, key)
    for end in (low, high):
        check(end)


def drawn_setup(setup: Setup, draw: Draw) -> Setup:
    """The setup, before its static start, by the numbers and fields of a draw.

    Raises
    ------
    InputError : connectors or clips that lie elsewhere, or look in another direction: numbers that change the model.
    """
    changed = varied(setup, with_changes(setup.study, draw.values).tables(TABLES), draw.fields, draw.factors)
    if not changed.connectors.moves_as(setup.connectors):
        raise InputError(
            f"draw {draw.number} moves a connector or clip, or turns it round, on a model reduced without that",
            where=setup.study.places.where("scatter"),
            expected=f"of a clip {', '.join(OF_CLIP)}, of a connector {', '.join(OF_CONNECTOR)}",
        )
    zeta = changed.study.config.damping.modal
    return changed if zeta is None else replace(changed, structure=replace(changed.structure, modal=zeta))


def at_start(setup: Setup, reference: ReferenceModel, draw: Draw) -> Setup:
    """The setup by the numbers and fields of a draw, at its static start."""
    return started(drawn_setup(setup, draw), reference, silent)


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
