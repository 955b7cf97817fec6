"""The health report of one superelement."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from typing import Any

import numpy as np

from creak.assembly.system import System
from creak.errors import InputError
from creak.model.dofs import AXES
from creak.model.mesh import Nodes
from creak.progress import Progress
from creak.reduction.health.fixed import FixedModes, fixed_modes
from creak.reduction.health.free import GOOD, FreeModes, free_modes
from creak.reduction.health.rigid import GROUNDING, RigidCheck, needs_physical, rigid_check, rigid_motion
from creak.reduction.health.verdict import Energies, Findings, energies, findings, hz
from creak.reduction.inside import Inside
from creak.words import percent

Row = tuple[str, str, str]
"""(label, value, remark)"""


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
        name=full.name,
        retained=n.retained,
        modes=n.modes,
        internal=n.internal,
        rigid=rigid,
        energy=energy,
        fixed=fixed,
        free=free,
        f_excitation=f_excitation,
        findings=findings(rigid, energy, fixed, free, f_excitation),
    )


def health_rows(health: Health) -> list[Row]:
    """Rows (label, value, remark) of one superelement; the verdict's sentences are the last ones."""
    return [
        ("part", health.name, ""),
        ("retained dofs + modes", f"{health.retained:,} + {health.modes:,}", f"for {health.internal:,} internal dofs"),
        *_rigid_rows(health),
        *_fixed_rows(health),
        *_free_rows(health),
        *(("verdict", "warning", text) for text in health.findings.warnings),
        *(("verdict", "good", text) for text in health.findings.good),
    ]


def _rigid_rows(health: Health) -> list[Row]:
    r = health.rigid
    rows = [
        ("mass", f"{r.mass:.6g}", _off(r.mass_error)),
        ("centre of gravity", _list(r.cog), f"off by {percent(r.cog_error)} of the radius of gyration"),
        ("inertia xx, yy, zz", _list(r.inertia[:3]), _off(r.inertia_error)),
        ("inertia xy, yz, zx", _list(r.inertia[3:]), ""),
        (
            "ground check",
            "pass" if r.passes_grounding else "FAIL",
            f"strain energy of rigid motion {max(r.strain_energy):.1e}, at most {GROUNDING:.1e}",
        ),
    ]
    energy = health.energy
    apart = f"kinetic {energy.kinetic:.1e}, strain {energy.strain:.1e}"
    rows.append(("energies of random motions", apart, "off those of the full part, relative"))
    if r.boundary_misfit > 0.0:
        rows.append(("rigid motion of the reduced boundary", percent(r.boundary_misfit), "missing"))
    return rows


def _fixed_rows(health: Health) -> list[Row]:
    fixed = health.fixed
    rows = [("fixed-interface modes", _list(fixed.frequencies, "none"), "Hz")]
    left = hz(fixed.first_left_out) if np.isfinite(fixed.first_left_out) else "none"
    ratio = fixed.first_left_out / health.f_excitation if health.f_excitation else np.inf
    rows.append(("first mode left out", left, f"{ratio:.2g} x the excitation" if np.isfinite(ratio) else ""))
    shares = ", ".join(f"{a} {100.0 * s:.1f} %" for a, s in zip(AXES, fixed.effective_mass, strict=True))
    return [*rows, ("effective mass of kept modes", shares, "of what fixed-interface modes can carry")]


def _free_rows(health: Health) -> list[Row]:
    free = health.free
    if free.full:
        rows = [
            (f"free mode {k + 1}", hz(f), f"{percent(e)} high")
            for k, (f, e) in enumerate(zip(free.full, free.error, strict=True))
        ]
    else:
        rows = [
            (f"free mode {k + 1}", hz(f), f"{percent(e)} estimated")
            for k, (f, e) in enumerate(zip(free.reduced[:10], free.estimate, strict=False))
        ]
    return [*rows, ("usable to", hz(free.usable), f"estimated frequency error below {percent(GOOD)}")]


def _off(error: float) -> str:
    return f"off by {percent(error)}"


def _list(values: tuple[float, ...], nothing: str = "") -> str:
    return ", ".join(f"{v:.4g}" for v in values) or nothing
