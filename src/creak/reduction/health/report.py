"""The health report of one superelement: what is good about it and what is not, in plain sentences; its energies
against the full part."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np

from creak.arrays import FloatArray, Matrix
from creak.assembly.system import System
from creak.errors import InputError
from creak.model.dofs import AXES
from creak.model.mesh import Nodes
from creak.progress import Progress
from creak.reduction.health.fixed import FixedModes, fixed_modes
from creak.reduction.health.free import GOOD, VERY_GOOD, FreeModes, free_modes
from creak.reduction.health.rigid import GROUNDING, RigidCheck, motion, needs_physical, rigid_check, rigid_motion
from creak.reduction.inside import Inside
from creak.words import percent

RULE, RULE_CONTACT = 3.0, 5.0
"""First mode left out over the highest frequency of interest: rule of thumb, and where contact excites more."""
MASS_ERROR = 1e-4
"""Mass properties and energies are exact but for the round-off of K_ii^-1 K_ib, some 1e-16 times the condition of
K_ii."""
MISFIT = 1e-4
"""Boundary shapes that miss rigid motion by more cannot carry the part's mass."""
RESIDUAL = 1e-3
"""Residual of a fixed-interface mode; its frequency is off by the square."""
Line = tuple[bool, str]
"""(is a warning, sentence)"""
ROUND_OFF = 1e-9
"""Of the terms of an energy, which they lose to each other: smaller energies are none."""
MOTIONS = 3
"""Random motions that are looked at."""


@dataclass(frozen=True)
class Findings:
    """Sentences."""

    warnings: tuple[str, ...]
    good: tuple[str, ...]


def findings(
    rigid: RigidCheck, energy: Energies, fixed: FixedModes, free: FreeModes, f_excitation: float | None
) -> Findings:
    """Judge the figures against the thresholds of this module."""
    lines = [*_range(free, fixed.first_left_out, f_excitation), *_cut(fixed.first_left_out, f_excitation)]
    lines += [*_mass(rigid), *_ground(rigid), *_energy(energy), *_free(free, f_excitation), *_fixed(fixed)]
    return Findings(tuple(t for bad, t in lines if bad), tuple(t for bad, t in lines if not bad))


def hz(f: float) -> str:
    """`1,512 Hz`, `48.2 Hz`, `0.031 Hz`."""
    if not np.isfinite(f):
        return "any frequency"
    return f"{f:,.0f} Hz" if f >= 100.0 else f"{f:.3g} Hz"


def times(ratio: float) -> str:
    """`0.31`, `4.2`, `312`."""
    return f"{ratio:,.0f}" if ratio >= 10.0 else f"{ratio:.2g}"


def rounded_up(f: float) -> float:
    """To two digits."""
    unit = 10.0 ** (np.floor(np.log10(f)) - 1.0)
    return float(np.ceil(f / unit * (1.0 - 1e-9)) * unit)


def _range(free: FreeModes, cut: float, f_excitation: float | None) -> Iterable[Line]:
    if not free.definite:
        yield True, "the superelement has no modes: its mass or stiffness is not positive"
        return
    if not np.isfinite(free.usable):
        yield False, "good to any frequency: no fixed-interface mode is left out"
        return
    least = "at least " if free.at_least else ""
    if f_excitation is None or free.usable >= f_excitation or free.at_least:
        yield (
            False,
            (
                f"good to {least}{hz(free.usable)} (estimated frequency error below {percent(GOOD)}), "
                f"to {hz(free.usable_tight)} below {percent(VERY_GOOD)}"
            ),
        )
        return
    goal = rounded_up(max(RULE, cut / max(free.usable, 1e-300)) * f_excitation)
    yield (
        True,
        (
            f"not good enough: the excitation reaches {hz(f_excitation)} but the estimated frequency error passes "
            f"{percent(GOOD)} at {hz(free.usable)}; raise f_max to {hz(goal)}"
        ),
    )


def _cut(cut: float, f_excitation: float | None) -> Iterable[Line]:
    if f_excitation is None or not np.isfinite(cut):
        return
    ratio = cut / f_excitation
    said = f"first mode left out at {hz(cut)} is {times(ratio)} x the excitation"
    if ratio < RULE:
        goals = [hz(rounded_up(k * f_excitation)) for k in (RULE, RULE_CONTACT)]
        yield True, f"{said}; the rule of thumb is {RULE:g} x, with contact {RULE_CONTACT:g} x: {' or '.join(goals)}"
    elif ratio < RULE_CONTACT:
        yield False, f"{said}: enough without contact (rule of thumb {RULE:g} x), little with it ({RULE_CONTACT:g} x)"
    else:
        yield False, said


def _mass(rigid: RigidCheck) -> Iterable[Line]:
    if rigid.boundary_misfit > MISFIT:
        missing = percent(rigid.boundary_misfit)
        yield True, f"the reduced boundary cannot move rigidly: it misses rigid motion by {missing}"
    errors = {"mass": rigid.mass_error, "centre of gravity": rigid.cog_error, "inertia": rigid.inertia_error}
    wrong = [f"{name} by {percent(e)}" for name, e in errors.items() if e > MASS_ERROR]
    if not wrong:
        worst = percent(max(errors.values()))
        yield False, f"mass, centre of gravity and inertia agree with the full part ({worst} off at most)"
    elif rigid.grounded:
        yield False, f"{', '.join(wrong)} off: the part's own springs to ground bend it when its boundary moves"
    else:
        yield True, f"rigid-body properties are wrong: {', '.join(wrong)}"


def _ground(rigid: RigidCheck) -> Iterable[Line]:
    if not rigid.passes_grounding:
        yield (
            True,
            (
                f"the reduction ties the part to ground: rigid motion strains it (relative energy "
                f"{max(rigid.strain_energy):.1e}, round-off is below {GROUNDING:.1e}) and would swing at "
                f"{hz(rigid.grounding_frequency)}"
            ),
        )
    elif rigid.grounded:
        yield False, "the part itself is tied to ground; the reduction adds nothing to that"
    else:
        yield False, "not grounded: rigid motion strains nothing"


def _energy(energy: Energies) -> Iterable[Line]:
    wrong = [f"{name} energy by {percent(e)}" for name, e in vars(energy).items() if e > MASS_ERROR]
    if wrong:
        yield True, f"its matrices are not those of its own motion in the full part: {', '.join(wrong)}"


def _free(free: FreeModes, f_excitation: float | None) -> Iterable[Line]:
    if 0 <= free.rigid_full < free.rigid_reduced:
        found = f"{free.rigid_reduced} motions without stiffness, the part {free.rigid_full}"
        yield True, f"the superelement has {found}"
    if not free.full:
        return
    inside = [i for i, f in enumerate(free.full) if f_excitation is None or f <= f_excitation]
    worst = max((abs(free.error[i]) for i in inside), default=0.0)
    if f_excitation is not None and worst > GOOD:
        yield True, f"a free mode of the part below {hz(f_excitation)} is off by {percent(worst)}"
        return
    most = percent(max(abs(e) for e in free.error))
    yield False, f"its first {len(free.full)} free modes, to {hz(free.full[-1])}, are within {most} of the full part's"


def _fixed(fixed: FixedModes) -> Iterable[Line]:
    if fixed.residual > RESIDUAL:
        yield True, f"a fixed-interface mode is no mode of the full part: its residual is {fixed.residual:.1e}"


@dataclass(frozen=True)
class Energies:
    """How far q' M_r q and q' K_r q are off those of the motion u = V q, relative; random q."""

    kinetic: float
    strain: float


def energies(full: System, reduced: System) -> Energies:
    """The reduced matrices are V' M V and V' K V, so that every motion has the energies that it has in the full part.

    Boundary and modes move at random, both with the same kinetic energy: rows between them that belong to other modes,
    or to modes of other signs, show in full.
    """
    boundary, rng = reduced.stats.retained, np.random.default_rng(1968)
    q = rng.standard_normal((reduced.n, MOTIONS))
    mass = np.asarray(reduced.M.diagonal())
    heavy = mass > 0.0
    q *= np.where(heavy, 1.0 / np.sqrt(np.where(heavy, mass, 1.0)), 0.0)[:, None]
    own = [_quadratic(reduced.M, _only(q, some)) for some in (slice(0, boundary), slice(boundary, None))]
    if all((e > 0.0).all() for e in own):
        q[boundary:] *= np.sqrt(own[0] / own[1])
    u = motion(full, reduced, q)
    both = ((reduced.M, full.M), (reduced.K, full.K))
    # (k,) |u|' |A| |u|: what the terms of the energy are, which may cancel, as those of rigid motion do.
    return Energies(*(_apart(_quadratic(A, q), _quadratic(B, u), _quadratic(abs(B), np.abs(u))) for A, B in both))


def _only(q: FloatArray, some: slice) -> FloatArray:
    out = np.zeros_like(q)
    out[some] = q[some]
    return out


def _quadratic(A: Matrix, q: FloatArray) -> FloatArray:
    """(k,) q' A q of each column."""
    return np.asarray(np.einsum("ij,ij->j", q, np.asarray(A @ q)))


def _apart(a: FloatArray, b: FloatArray, terms: FloatArray) -> float:
    size = np.maximum(np.maximum(np.abs(a), np.abs(b)), ROUND_OFF * terms).max(initial=0.0)
    return float(np.abs(a - b).max() / size) if size else 0.0


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
    rows.append(("first mode left out", left, f"{times(ratio)} x the excitation" if np.isfinite(ratio) else ""))
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
