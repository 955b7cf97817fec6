"""Natural frequencies and modes of a deck, or of what a study makes of it, parts joined, contact left out; its
matrices, and those of a superelement, for other programs."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from pathlib import Path

import numpy as np

from creak.arrays import FloatArray, IntArray, Matrix, to_dense
from creak.assembly.coupling import Driven, couple
from creak.assembly.damping import is_damped
from creak.assembly.part import Rayleigh, assemble_blocks, common_rayleigh, loose_system, part_system
from creak.assembly.system import System, by_node, recovered, row_names
from creak.elements.registry import FORMULATIONS, unstressed
from creak.errors import InputError, NumericalError
from creak.formats.deck.catalogue import (
    stop_on_unread,
    with_open_stops,
    without_unread_damping,
    without_unread_motion,
)
from creak.formats.decks import read_model
from creak.given import positive, whole
from creak.linalg.factor import Factor, SingularMatrixError, regular_factor
from creak.linalg.modes import Modes, modes
from creak.model.constraints import Equation, Tie
from creak.model.dofs import PER_NODE, dofs_of, node_dofs, nodes_of
from creak.model.mesh import Model, Unread
from creak.model.steps import StaticStep
from creak.model.superelement import Superelement
from creak.progress import Progress, silent
from creak.reduction.modal import EffectiveMass, effective_mass
from creak.studies.prepare.structure import Structure

DEFAULT_COUNT = 20
UNDAMPED = Rayleigh(0.0, 0.0)


@dataclass(frozen=True)
class DeckModes:
    """Frequencies in Hz, rigid-body modes first (0), shapes, effective mass, and checks."""

    frequencies: list[float]
    mass: float
    """Of the whole model, held nodes included."""
    rigid: int
    """Number of rigid-body modes."""
    residual: float
    """Largest |K x - omega^2 M x| / |K x| over the elastic modes."""
    sturm_ok: bool
    """The inertia of K - omega^2 M above the last mode counts as many modes as were found."""
    effective: EffectiveMass
    model: Model = field(repr=False)
    system: System = field(repr=False)
    """The assembly, free dofs only."""
    shapes: FloatArray = field(repr=False)
    """(n, n_mode) in the coordinates of `system`, mass-normalised."""
    structure: Structure = field(repr=False)
    """With the damping that it tells."""
    prestress: StaticStep | None = None
    """The static step of the deck whose stress stiffens the structure in these modes."""

    @cached_property
    def damped(self) -> System | None:
        """`system` with the damping that deck or study tell; None: they tell none, or some that was not read, or a
        stress stiffens it."""
        model, told = self.model, is_damped(self.model) or self.structure.override_damping
        if not told or self.prestress is not None or any(u.damps for u in model.unread):
            return None
        parts = [self.structure.part(i) for i in range(len(model.parts))]
        return self.structure.joined(parts, loose_system(model, self.structure.rayleigh))

    def translations(self) -> Iterator[FloatArray]:
        """(n_node, 3) motion of all nodes, mode by mode, dependent and held nodes included; mass-normalised."""
        return self._motion(3)

    def motion(self) -> Iterator[FloatArray]:
        """(n_node, 6) the same with rotations, rad."""
        return self._motion(6)

    def _motion(self, dofs: int) -> Iterator[FloatArray]:
        nothing = np.zeros((self.system.supports.count, self.shapes.shape[1]))
        for _, u in recovered(self.system, self.shapes, nothing):
            yield from by_node(u, self.system.labels, self.model.nodes.count, dofs)


def deck_modes(
    path: Path,
    *,
    f_max: float | None = None,
    count: int | None = None,
    about: Sequence[float] = (0.0, 0.0, 0.0),
    ignore: Sequence[str] = (),
    progress: Progress = silent,
) -> DeckModes:
    """Undamped modes K x = omega^2 M x of the structure as the deck's supports hold it.

    Parameters
    ----------
    path : an Abaqus (.inp) or Nastran (.bdf, .dat, .nas, .fem) deck; or a study (.toml), whose supports, materials,
        sections and clips then stand, and which holds what its excitations move.
    f_max : all modes up to this frequency, Hz. count : the lowest ones (default 20); all there are where the model
        has fewer.
    about : point of the rotations of the effective mass, in the deck's units.
    ignore : keywords or cards that may go unread although they change the answer.

    Contact, loads and damping are left out; parts that touch are not joined. Where the deck's modes start from a static
    step (Abaqus: NLGEOM) of forces and displacements, its linear stress stiffens the structure.

    Raises
    ------
    InputError : the deck is wrong, or holds something unread that changes the answer.
    NumericalError : the modes could not be found.
    """
    if f_max is not None and count is not None:
        raise InputError("both f_max and count", expected="one of them")
    f_max = None if f_max is None else positive(f_max, "f_max")
    count = None if count is None else whole(count, "count", 1)
    count = DEFAULT_COUNT if f_max is None and count is None else count
    if Path(path).suffix.lower() == ".toml":
        structure, parts = _of_study(Path(path), ignore, progress)
        system, found = _joined_modes(parts, structure.model, structure.driven, f_max, count, progress)
        return structure_modes(structure, parts, system, found, about)
    progress("read the deck", 0, 1)
    model = read_model(Path(path))
    progress("read the deck", 1, 1)
    step = model.prestress if model.prestress and not is_ignored(model.prestress, ignore) else None
    model = model if step is None else noted(model, step)
    model = with_open_stops(without_unread_motion(without_unread_damping(model, "modes have no damping")))
    stop_on_unread(model, ignore)
    progress("assemble", 0, 1)
    parts = _parts(model)
    driven = Driven({}) if step is None else driven_by(step)
    if step is not None:
        parts = _parts(model, _static(parts, model, step, driven))
    progress("assemble", 1, 1)
    system, found = _joined_modes(parts, model, driven, f_max, count, progress, stressed=step is not None)
    structure = Structure(model, driven, common_rayleigh(model), False, (), None)
    return structure_modes(structure, parts, system, found, about, step)


def _of_study(path: Path, ignore: Sequence[str], progress: Progress) -> tuple[Structure, list[System]]:
    """The linear structure of a study, and its parts without damping."""
    from creak.studies.file.reader import read_study  # what reads studies takes as long to import as a deck has modes
    from creak.studies.prepare.linear_model import linear_structure

    study = read_study(path)
    if study.config.superelement:
        raise InputError(
            "the study has parts that are given by matrices, of which effective masses are not known",
            expected="a study without [superelement.NAME]",
            where=study.places.where("superelement"),
        )
    progress("read the deck", 0, 1)
    model = read_model(study.places.sibling(study.config.model.deck))
    progress("read the deck", 1, 1)
    structure = linear_structure(study, model, ignore)
    progress("assemble", 0, 1)
    parts = _parts(structure.model)
    progress("assemble", 1, 1)
    return structure, parts


def structure_modes(
    structure: Structure,
    parts: Sequence[System],
    system: System,
    found: Modes,
    about: Sequence[float] = (0.0, 0.0, 0.0),
    prestress: StaticStep | None = None,
) -> DeckModes:
    """The modes `found` of `system`, to which the parts of a structure are joined, with effective masses."""
    model = structure.model
    effective = effective_mass(
        system, found.shapes, _carriers(parts, model), model.nodes, np.asarray(about, dtype=np.float64)
    )
    return DeckModes(
        frequencies=found.frequencies.tolist(),
        mass=float(effective.rigid_mass[0, 0]),
        rigid=int((found.omega2 == 0.0).sum()),
        residual=found.residual,
        sturm_ok=found.sturm_ok,
        effective=effective,
        model=model,
        system=system,
        shapes=found.shapes,
        structure=structure,
        prestress=prestress,
    )


def model_modes(
    model: Model, driven: Driven, *, f_max: float | None = None, count: int | None = None
) -> tuple[System, Modes]:
    """The undamped assembly, held at its supports and driven dofs, and its modes."""
    return _joined_modes(_parts(model), model, driven, f_max, count)


def undamped_system(model: Model) -> System:
    """The undamped assembly as the model's supports hold it."""
    return couple(_parts(model), model, Driven({}), UNDAMPED, override=True)


def _parts(model: Model, u: FloatArray | None = None) -> list[System]:
    parts = [part_system(model, i, UNDAMPED, override=True, u=u) for i in range(len(model.parts))]
    loose = loose_system(model, UNDAMPED)
    return [*parts, loose] if loose else parts


def _static(parts: list[System], model: Model, step: StaticStep, driven: Driven) -> FloatArray:
    """(n_node, 6) displacements of the step."""
    require_known(model, step)
    system = couple(parts, model, driven, UNDAMPED, override=True)
    return displacements(system, regular_factor(system.K), model, step)


def _joined_modes(
    parts: list[System],
    model: Model,
    driven: Driven,
    f_max: float | None,
    count: int | None,
    progress: Progress = silent,
    *,
    stressed: bool = False,
) -> tuple[System, Modes]:
    progress("join the parts and factorise", 0, 1)
    system = couple(parts, model, driven, UNDAMPED, override=True)
    stiffness = regular_factor(system.K)
    progress("join the parts and factorise", 1, 1)
    if stressed and (stiffness is None or stiffness.n_negative):
        raise NumericalError("the structure buckles under the load of the static step before the modes")
    try:
        found = modes(
            system.K,
            system.M,
            f_max=f_max,
            count=count,
            free=stiffness is None,
            stiffness_factor=stiffness,
            progress=lambda done, total: progress("modes", done, total),
        )
    except SingularMatrixError as error:
        if error.row < 0 or system.coordinates[error.row] < 0:
            raise
        at = model.dof_name(int(system.coordinates[error.row]))
        raise NumericalError(f"{at} moves freely and has no mass: hold it, or join it to what is held") from error
    return system, found


def _carriers(parts: Sequence[System], model: Model) -> Iterator[tuple[IntArray, Matrix]]:
    """Labels and mass of every part, and of the elements that belong to none."""
    yield from ((part.coordinates, part.M) for part in parts)
    blocks = [b for b in model.blocks if b.part < 0]
    if blocks:
        labels = node_dofs(np.unique(np.concatenate([b.nodes_idx.ravel() for b in blocks])))
        yield labels, assemble_blocks(model, blocks, labels, UNDAMPED, override=True).M


def is_ignored(step: StaticStep, ignore: Iterable[str]) -> bool:
    """Whether `ignore` names the step: modes without its stress."""
    return step.keyword.lstrip("*") in {k.upper().lstrip("*") for k in ignore}


def require_known(model: Model, step: StaticStep) -> None:
    """Raise InputError for elements and couplings that stress changes in a way that creak does not know."""
    for block in model.blocks:
        geometric = FORMULATIONS[block.kind].geometric
        if geometric is unstressed:
            continue
        arms = block.own.arms is not None
        if arms or geometric is None or block.part < 0:
            raise _unknown(
                step,
                f"element {block.ids[0]}" + (", which is off its nodes" if arms else f" ({block.kind})"),
                block.where,
            )
    for constraint in model.constraints:
        if not isinstance(constraint, Equation | Tie):
            raise _unknown(step, f"a {type(constraint).__name__} with arms", constraint.where)


def _unknown(step: StaticStep, what: str, where: str) -> InputError:
    return InputError(
        f"the stress of {step.keyword} ({step.where}) stiffens {what} in a way that creak does not know",
        expected="shells, solids, beams and trusses, joined by equations and ties",
        where=where,
        fix=f"Run with --ignore {step.keyword.lstrip('*')} for the modes without stress.",
    )


def driven_by(step: StaticStep) -> Driven:
    """The dofs that the step moves; the modes hold them."""
    return Driven({f"{m.name}.{m.dof} at {m.where}": node_dofs(m.nodes_idx, (m.dof,)) for m in step.moved})


def displacements(system: System, factor: Factor | None, model: Model, step: StaticStep) -> FloatArray:
    """(n_node, 6) of K q = f - K_s s, at held drilling rotations those of the shells.

    Raises
    ------
    InputError : supports and links do not hold the structure.
    """
    if factor is None:
        raise InputError(
            f"the structure can move freely under {step.keyword}",
            where=step.where,
            expected="supports, links or springs that hold it",
            fix=f"Hold it, or run with --ignore {step.keyword.lstrip('*')}.",
        )
    f = np.zeros(system.n)
    for load in step.loads:
        f += load.value * np.asarray(system.rows(node_dofs(load.nodes_idx, (load.dof,)))[0].sum(axis=0)).ravel()
    s = np.array([m.value for m in step.moved])
    if s.size:
        f -= to_dense(system.supports.K_qs) @ s
    u = np.zeros((model.nodes.count, PER_NODE))
    u[nodes_of(system.labels), dofs_of(system.labels) - 1] = system.displacement(~system.labels, factor.solve(f), s)
    return u


def noted(model: Model, step: StaticStep) -> Model:
    """The model whose unread parts say that the step is used."""
    why = "its stress, linear and at the undeformed shape, stiffens the structure in these modes"
    used = [Unread(u.keyword, u.where, False, why) if u.keyword == step.keyword else u for u in model.unread]
    return replace(model, unread=tuple(used))


def deck_matrices(model: Model) -> tuple[Superelement, str]:
    """K, M and C (None without damping) of all independent, free dofs, with node label, dof and place of each row, and
    a note of numbers that nodes get where instances share labels.

    Raises
    ------
    InputError : nothing is free to move.
    """
    common = common_rayleigh(model)
    parts = [part_system(model, i, common) for i in range(len(model.parts))]
    loose = loose_system(model, common)
    system = couple([*parts, loose] if loose else parts, model, Driven({}), common)
    if not system.n:
        raise InputError("nothing is free to move: the matrices are empty", where=model.source, fix="Free some dofs.")
    numbered, note = model, ""
    if np.unique(model.nodes.ids).size < model.nodes.count:
        nodes = model.nodes
        block = 10 ** len(str(int(nodes.ids.max())))
        told = ", ".join(f"{block * (k + 1):,} + label are of {name}" for k, name in enumerate(nodes.instance))
        ids = nodes.ids + block * (nodes.instance_idx + 1)
        numbered = replace(model, nodes=replace(nodes, ids=ids))
        note = f"instances share labels, so nodes have numbers: {told}"
    return named_rows(system, Path(model.source).stem, numbered), note


def named_rows(system: System, name: str, model: Model) -> Superelement:
    """A System for other programs: matrices with all damping, node labels and places."""
    ids, dofs = row_names(system, model.nodes.ids)
    d, C = system.damping, system.damping.extra
    if d.alpha or d.beta:
        rayleigh = d.alpha * system.M + d.beta * system.K
        C = rayleigh if C is None else C + rayleigh
    nodes = np.unique(nodes_of(system.coordinates[system.coordinates >= 0]))
    places = {int(model.nodes.ids[k]): model.nodes.coords[k] for k in nodes}
    return Superelement(name, ids, dofs, system.K, system.M, C, places, model.source)
