"""The unreduced model: parts, their assembly, its modes, and the linear pre-check."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from creak.arrays import FloatArray, IntArray
from creak.assembly.coupling import couple
from creak.assembly.part import loose_system, part_system
from creak.assembly.system import System
from creak.errors import InputError
from creak.linalg.factor import Factor, LaterFactor, factor, regular_factor
from creak.linalg.modes import Modes, modes, small_shift
from creak.model.dofs import node_dofs
from creak.progress import Progress
from creak.reduction.modal import support_motion, with_modal_damping
from creak.studies.models.solved import digest_of, solved
from creak.studies.prepare.excitation import highest_frequency
from creak.studies.prepare.setup import Setup

PRECHECK_BAND = 3.0
"""The linear pre-check uses the modes up to this multiple of the excitation's highest frequency."""
SMALL = 40_000
"""Dofs up to which modes up to [reduction] f_max are computed for the sake of modal damping alone."""


@dataclass(frozen=True)
class ReferenceModel:
    """Unreduced parts and what was computed of their assembly."""

    parts: tuple[System, ...]
    loose: System | None
    """Nodes between parts."""
    system: System
    modes: Modes
    support_shapes: FloatArray
    """R = -K^-1 K_qs; free motions of a structure that is not held do not follow."""
    stiffness: Factor | None
    """A factor of K; None where the structure can move freely, or once it was given back."""
    linear_gaps: FloatArray | None = None
    """(m,) smallest gap of every contact channel in the pre-check; None where there was none."""
    store: Path | None = None
    """Folder in which what was solved is kept (`solved`)."""
    of_parts: int | None = None
    """Free dofs of the whole where memory does not hold that: `system` are its parts, reduced to what joins them."""

    @property
    def free_dof(self) -> int:
        """Dofs of the whole that can move."""
        return self.system.n if self.of_parts is None else self.of_parts

    def without_factor(self) -> ReferenceModel:
        """The same with the memory of the factor given back: only whole-assembly reductions use it again."""
        return replace(self, stiffness=None)


def build_reference(setup: Setup, progress: Progress, store: Path | None = None) -> ReferenceModel:
    """Assemble the parts, join them, and find the modes of the whole, or take them from a run before (`solved`)."""
    return joined_reference(setup, *assembled(setup, progress), progress, store)


def assembled(setup: Setup, progress: Progress) -> tuple[list[System], System | None]:
    """The parts, and the nodes between them."""
    count = len(setup.model.parts)
    parts = []
    for i in range(count):
        progress("assemble", i, count)
        parts.append(part_system(setup.model, i, setup.rayleigh, override=setup.override_damping))
    return parts, loose_system(setup.model, setup.rayleigh)


def joined_reference(
    setup: Setup, parts: list[System], loose: System | None, progress: Progress, store: Path | None = None
) -> ReferenceModel:
    """Join the parts and find the modes of the whole."""
    system = join_parts(setup, parts, loose)
    progress("assemble", len(parts), len(parts))
    stiffness, found, R = _solved(setup, system, progress, store)
    return ReferenceModel(tuple(parts), loose, damped(setup, system, found, R), found, R, stiffness, store=store)


def _solved(
    setup: Setup, system: System, progress: Progress, store: Path | None
) -> tuple[Factor | None, Modes, FloatArray]:
    """A factor of K where it is regular, the modes, and the motion with the supports."""
    f_max, made = modal_band(setup, system.n), list[Factor | None]()

    def again() -> Factor:
        return factor(system.K)

    def solve() -> dict[str, FloatArray]:
        regular = regular_factor(system.K)
        stiffness = None if regular is None else LaterFactor(again, regular)
        del regular
        made.append(stiffness)
        found = modes(
            system.K,
            system.M,
            f_max=f_max,
            free=stiffness is None,
            stiffness_factor=stiffness,
            progress=lambda done, total: progress("modes of the assembly", done, total),
        )
        told = [found.residual, found.sturm_ok, found.next_omega2, found.columns, stiffness is not None]
        R = support_motion(system, stiffness or held_factor(system))
        return {"omega2": found.omega2, "shapes": found.shapes, "R": R, "told": np.array(told, dtype=float)}

    K, M, side = (digest_of(A) for A in (system.K, system.M, system.supports.K_qs))
    kept = solved(store, "assembly", [K, M, side, repr(f_max)], solve)
    residual, sturm_ok, following, columns, held = kept["told"].tolist()
    found = Modes(kept["omega2"], kept["shapes"], residual, bool(sturm_ok), following, int(columns))
    stiffness = made[0] if made else LaterFactor(again) if held else None
    return stiffness, found, kept["R"]


def rejoined(setup: Setup, reference: ReferenceModel, parts: Sequence[int]) -> ReferenceModel:
    """The model joined as another setup has it, with its factor; only some parts are assembled again.

    Modes and shapes stay those of before.
    """
    every = [
        part_system(setup.model, i, setup.rayleigh, override=setup.override_damping) if i in parts else part
        for i, part in enumerate(reference.parts)
    ]
    system = join_parts(setup, every, reference.loose)
    return replace(reference, parts=tuple(every), system=system, stiffness=regular_factor(system.K))


def join_parts(setup: Setup, parts: list[System], loose: System | None) -> System:
    """Couple parts, full or reduced, by the model's links and supports."""
    systems = [*parts, *setup.superelements, *([loose] if loose is not None else [])]
    return couple(systems, setup.model, setup.driven, setup.rayleigh, override=setup.override_damping)


def held_factor(system: System) -> Factor:
    """A factor of K, or of K with a trace of mass where the structure can move freely."""
    return regular_factor(system.K) or factor(system.K + small_shift(system.K, system.M) * system.M)


def damped(setup: Setup, system: System, found: Modes, R: FloatArray, *, every: bool = False) -> System:
    """The System with the study's modal damping, if it asks for any.

    Parameters
    ----------
    every : `found` are all modes of the System. Else what lies beyond them is damped in proportion to its stiffness.
    """
    zeta = setup.study.config.damping.modal
    if zeta is None:
        return system
    return with_modal_damping(system, found, R, zeta, beyond=not every)


def modal_band(setup: Setup, n: int) -> float:
    """Highest frequency of the modes of an assembly of n dofs that the study needs, Hz.

    With modal damping the modes that the reduction keeps need it too, in models where they cost little.
    """
    c = setup.study.config
    driven = PRECHECK_BAND * highest_frequency(setup.study) if c.precheck.enabled else 0.0
    band = max(1.1 * c.verification.mac_f_max, driven)
    if c.damping.modal is None:
        return band
    kept = c.reduction.f_max if n <= SMALL else 0.0
    return max(band, c.verification.f_max, kept)


def static_shapes(setup: Setup, reference: ReferenceModel) -> FloatArray:
    """K^-1 B of the force excitations, (n, n_force).

    Raises
    ------
    InputError : there are forces, and only contact holds the structure.
    """
    B = force_columns(setup, reference.system)
    if not B.shape[1]:
        return B
    if reference.stiffness is None:
        method = setup.study.config.reduction.method
        raise InputError(
            f"method = {method!r} takes the static shape of each force, but only contact holds the structure",
            where=setup.study.where("reduction", "method"),
            expected="supports that hold it without contact",
            fix='Use method = "craig-bampton".',
        )
    return reference.stiffness.solve(np.asfortranarray(B))


def force_columns(setup: Setup, system: System) -> FloatArray:
    """B of the force excitations, (n, n_force)."""
    B = np.zeros((system.n, len(setup.loads.force_labels)))
    for j, labels in enumerate(setup.loads.force_labels):
        B[:, j] = np.asarray(system.rows(labels)[0].sum(axis=0)).ravel()
    return B


def observed_labels(nodes_idx: IntArray) -> IntArray:
    """All six dofs of each node, (6 n_node,)."""
    return node_dofs(nodes_idx)
