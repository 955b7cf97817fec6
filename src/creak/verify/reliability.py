"""Whether a run can be relied on at all: finite figures, and no energy out of nothing."""

from __future__ import annotations

import numpy as np

from creak.dynamics.history import ENERGIES, History
from creak.signals.spectra import blocks
from creak.words import percent

ENERGY_BAR = 0.005
"""Share of the work of the loads (`History.energy_created`) up to which a scheme may create energy."""
CONTACT_BAR = 0.1
"""Share of the energy that went into contact up to which it may come out of nothing: 5 % of its forces."""
FLOOR = 1e-9
"""Share of the energy scale of a run, or of what its springs hold, below which energy that went into contact counts as
that much."""
UNRELIABLE = "unreliable"
"""Verdict on such a run."""
FORCED = "shorten the step, soften the contact or dissipate more"
CHOSEN = 'soften the contact, or take accuracy = "fine"'
"""What to do about created energy, where the step was forced and where it was not."""
UNTOUCHED = "nothing touches, so it is round-off: look whether lengths, moduli and densities are in one system of units"
"""The same of a run that creak chose the step of and in which no contact acts: it is exact."""


def created_of_contact(history: History) -> float:
    """Largest energy created at any time, as a share of what contact took up in the whole run.

    Contact takes energy up while it is pressed together and gives it back while it opens: the work of the normal
    forces over the gaps, 1/2 (f0 + f1) (g1 - g0) in each step, exact for the average acceleration method. Of a channel
    with a preload it is that of the force beyond it, as the rest of the structure balances the preload. What it gave
    back, and lost in its dampers, beyond what it took and what its springs held at the start came out of nothing. That
    counts as far as the balance of the whole run has it too: a scheme that dissipates it again passes. Unlike
    `History.energy_created` it sees a light part that rattles on a heavy one whose motion takes nearly all the work.

    Returns
    -------
    The share; not a number where the history is not finite.
    """
    if not is_finite(history):
        return float("nan")
    held, lost, made = (history.energy[:, ENERGIES.index(k)] for k in ("contact", "contact_damping", "scheme"))
    given, taken, worst = 0.0, float(held[0]), 0.0
    start = given - taken
    for part in blocks(history.time.size - 1, history.gap.shape[1]):
        after = slice(part.start + 1, part.stop + 1)
        force = 0.5 * (history.force[part] + history.force[after])
        if history.preload.size:
            force -= history.preload
        work = force * (history.gap[after] - history.gap[part])
        taken -= float(np.minimum(work, 0.0).sum())
        net = start + np.cumsum(work.sum(axis=1))
        start = float(net[-1])
        worst = max(worst, float(np.minimum(net + lost[after], -made[after]).max()))
    return worst / max(taken, FLOOR * max(history.energy_scale, history.energy_held))


def is_finite(history: History) -> bool:
    """Whether forces, gaps, kept motion and energies are finite numbers throughout."""
    tables = (history.force, history.gap, history.displacement, history.energy)
    return all(bool(np.isfinite(t).all()) for t in tables)


def reasons_against(history: History, *, forced: bool = True, unit: str = "") -> list[str]:
    """Why the figures of a run are worth nothing, a sentence each; empty where nothing speaks against them.

    forced: its step was; else creak chose it.
    """
    remedy = FORCED if forced else CHOSEN if history.force.any() else UNTOUCHED
    if not is_finite(history):
        return [f"its results are not finite numbers: {remedy}"]
    found = (
        (history.energy_created, ENERGY_BAR, "the work of the loads"),
        (created_of_contact(history), CONTACT_BAR, "the energy that contact took up"),
        (_given_by_damping(history), CONTACT_BAR, "the work of the loads by what damps the structure"),
    )
    shares = [
        f"{percent(value, 3)} of {what} (at most {percent(bar, 3)} is sound)"
        for value, bar, what in found
        if value > bar
    ]
    created = [f"the time integration created energy, {' and '.join(shares)}: {remedy}"] if shares else []
    return [*created, *_passed_through(history, unit)]


def _given_by_damping(history: History) -> float:
    """Largest energy that the damping of the structure, which can only take, has given so far: a share of the work."""
    return max(0.0, -float(history.energy[:, ENERGIES.index("damping")].min())) / history.energy_scale


def _passed_through(history: History, unit: str) -> list[str]:
    """Channels without force that closed."""
    seen = history.extremes
    if seen is None or not seen.silent or seen.gap.min() > 0.0:
        return []
    k = int(seen.gap.argmin())
    return [
        f"parts pass through each other: {int((seen.gap <= 0.0).sum())} channel(s) that the pre-check dropped closed, "
        f"farthest {seen.silent[k]}, by {-seen.gap[k]:.3g} {unit} at t = {seen.gap_at[k]:.4g} s; set [precheck] "
        "enabled = false"
    ]
