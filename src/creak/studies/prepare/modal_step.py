"""A deck's own *MODAL DYNAMIC step: the tables of its study, and damping that differs from mode to mode."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from creak.assembly.part import Rayleigh, loose_system
from creak.linalg.factor import regular_factor
from creak.linalg.modes import modes
from creak.model.steps import BASE, DynamicStep, InModes
from creak.reduction.modal import ModalShares
from creak.studies.prepare.structure import Structure


def tables_in_modes(step: DynamicStep, of: InModes, notes: list[str]) -> dict[str, Any]:
    """The tables of a study that runs a step in modes: reduced, moving exactly between contacts, damped as it says."""
    notes.append(
        f"step {step.name}: a step in modes is run in as many modes as the answer takes, exact between contacts, "
        "without the increments of the deck; contact and gaps act in it, which other programs leave out there"
    )
    if any(m.name == BASE for m in step.moved):
        notes.append("base motion: motion is that in space (TU of Abaqus), not that relative to the base (U)")
    damping: dict[str, Any] = {}
    if of.rayleigh is not None:
        damping["rayleigh"] = dict(zip(("alpha", "beta"), of.rayleigh, strict=True))
    elif of.by_number:
        damping["modal"] = of.by_number[-1][2]
    elif of.by_frequency:
        damping["modal"] = _middle(of.by_frequency)
    else:
        notes.append("the step has no *MODAL DAMPING: what damps the rest of the deck acts, which Abaqus leaves out")
    return {
        "time": {"end": step.period},
        "damping": damping,
        "reduction": {"method": "craig-bampton"},
        "precheck": {},
        "verification": {},
    }


def damped_in(structure: Structure, of: InModes) -> Structure:
    """The structure with the shares of critical damping that a step gives its modes.

    Raises
    ------
    NumericalError : the modes, which have them by number, could not be found.
    """
    if of.by_number:
        return damped_by_number(structure, of.by_number)
    if of.by_frequency:
        freq, shares = np.array(of.by_frequency).T
        return replace(structure, modal=ModalShares(freq, shares, _middle(of.by_frequency), curve=True))
    return structure


def _middle(points: Sequence[tuple[float, float]]) -> float:
    """One share for all modes, where one is asked for: the ends of a curve are often far above what moves."""
    return points[len(points) // 2][1]


def damped_by_number(structure: Structure, ranges: Sequence[tuple[int, int, float]]) -> Structure:
    """The structure with shares of critical damping by the number of its modes, contact left out.

    Parameters
    ----------
    ranges : first and last mode, from 1 on, and share of each range; modes after the last have its share.

    Raises
    ------
    NumericalError : the modes could not be found.
    """
    last = ranges[-1][2]
    if all(share == last for _, _, share in ranges):
        return structure
    loose = loose_system(structure.model, Rayleigh(0.0, 0.0))
    system = structure.joined([structure.part(k) for k in range(len(structure.model.parts))], loose)
    regular = regular_factor(system.K)
    count = min(max(end for _, end, _ in ranges), system.n)
    found = modes(system.K, system.M, count=count, free=regular is None, stiffness_factor=regular)
    freq = np.sqrt(np.maximum(found.omega2, 0.0)) / (2.0 * np.pi)
    shares, number = np.zeros(freq.size), np.arange(1, freq.size + 1)
    for first, end, share in ranges:
        shares[(number >= first) & (number <= end)] = share
    moving = freq > 0.0
    return replace(structure, modal=ModalShares(freq[moving], shares[moving], last))
