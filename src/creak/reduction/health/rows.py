"""A health report as rows of text, for the terminal and for HTML."""

from __future__ import annotations

import numpy as np

from creak.model.dofs import AXES
from creak.reduction.health.free import GOOD
from creak.reduction.health.report import Health
from creak.reduction.health.rigid import GROUNDING
from creak.reduction.health.verdict import hz
from creak.words import percent

Row = tuple[str, str, str]
"""(label, value, remark)"""


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
