"""The health report of one superelement."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from typing import Any

import numpy as np

from creak.assembly.system import System
from creak.errors import InputError
from creak.model.mesh import Nodes
from creak.progress import Progress
from creak.reduction.health.energies import Energies, energies
from creak.reduction.health.fixed import FixedModes, fixed_modes
from creak.reduction.health.free import FreeModes, free_modes
from creak.reduction.health.rigid import RigidCheck, needs_physical, rigid_check, rigid_motion
from creak.reduction.health.verdict import Findings, findings
from creak.reduction.inside import Inside


@dataclass(frozen=True)
class Health:
    """What an engineer asks of a superelement. Units: those of the model, and Hz."""

    name: str
    retained: int
    modes: int
    internal: int
    rigid: RigidCheck
    energy: Energies
    fixed: FixedModes
    free: FreeModes
    f_excitation: float | None
    findings: Findings

    @property
    def verdict(self) -> tuple[str, ...]:
        """Short sentences: warnings first, then what is good."""
        return (*self.findings.warnings, *self.findings.good)

    @property
    def good(self) -> bool:
        """No warnings."""
        return not self.findings.warnings

    def as_dict(self) -> dict[str, Any]:
        """Flat: group_figure -> number, text or (nested) list, for JSON and HDF5 attributes.

        Figures that do not exist (no excitation given, nothing left out: infinite) and empty lists are left out.
        """
        flat: dict[str, Any] = {}
        for key, value in asdict(self).items():
            if isinstance(value, dict):
                flat |= {f"{key}_{k}": v for k, v in value.items()}
            else:
                flat[key] = value
        del flat["findings_warnings"], flat["findings_good"]
        flat |= {"verdict": self.verdict, "good": self.good}
        return {k: _plain(v) for k, v in flat.items() if _exists(v)}


def _exists(value: Any) -> bool:
    if value is None or (isinstance(value, tuple) and not value):
        return False
    return not isinstance(value, float) or bool(np.isfinite(value))


def _plain(value: Any) -> Any:
    if isinstance(value, tuple):
        return [_plain(v) for v in value]
    return value


def health(
    full: System,
    reduced: System,
    inside: Inside,
    nodes: Nodes,
    *,
    f_excitation: float | None = None,
    count: int = 10,
    own_modes: bool = True,
    progress: Progress | None = None,
) -> Health:
    """Check a superelement against the part that it was made of.

    Parameters
    ----------
    full, reduced, inside : the part, `craig_bampton(full, ...)` of it, and the blocks they share.
    nodes : all of the model.
    f_excitation : highest frequency of interest, Hz.
    count : fixed-interface and free modes to list.
    own_modes : also compute the free modes of the full part: a factorisation and count + 6 vectors, the only expensive
        step. Without it the errors are estimates, which need a recovery and a back-substitution per mode, at most
        MOST_CHECKED of them, up to the first that is off by more than 1 %.

    Raises
    ------
    InputError : the full part has generalised coordinates, or `f_excitation` is not positive.

    Valid for Craig-Bampton and Guyan models. A reduced boundary (interface modes) shows in `boundary_misfit` and in
    the measured errors of the free modes, not in the estimated ones.
    """
    needs_physical(full)
    if f_excitation is not None and not f_excitation > 0.0:
        raise InputError(f"excitation up to {f_excitation} Hz", expected="a positive frequency")
    motions = rigid_motion(full, reduced, nodes)
    rigid, energy = rigid_check(full, reduced, inside, motions), energies(full, reduced)
    free, cut = free_modes(full, reduced, inside, count, own_modes, progress)
    fixed = fixed_modes(full, reduced, inside, motions, cut, count)
    n = reduced.stats
    return Health(
        full.name,
        n.retained,
        n.modes,
        n.internal,
        rigid,
        energy,
        fixed,
        free,
        f_excitation,
        findings(rigid, energy, fixed, free, f_excitation),
    )
