"""What a study takes of memory, stage by stage, told before it is run."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import partial

from creak.assembly.system import entries_of
from creak.dynamics.condensed import COLUMNS, RESPONSE_MEMORY
from creak.dynamics.flight.contact_steps import fewest_parts
from creak.dynamics.flight.step import choose
from creak.formats.stored.superelement import MAPPED
from creak.linalg.lanczos import BESIDE, basis_bytes
from creak.linalg.memory import ENTRY, GB, MADE, PRODUCT, ROOM, SHARE, SPARE, free_bytes, held_bytes, left_beside
from creak.linalg.modes import BAND, dense_bytes, dense_is_faster, with_further
from creak.studies.advise.size import Counted, PartSize
from creak.studies.models.health import OWN_MODES_LIMIT
from creak.studies.models.of_parts import SPREAD
from creak.studies.models.reduced import DENSE, WHOLE
from creak.studies.models.reference import ReferenceModel, modal_band
from creak.studies.models.superelements import KEPT
from creak.studies.prepare.marching import Marching, output_every
from creak.studies.prepare.reduction import Band, Reduction

STARTED, KERNELS = 310e6, 150e6
"""Bytes of the interpreter with its libraries once they have solved something, and of the kernels of a run."""
UPPER = 6.0
"""Bytes of a stored entry in what PARDISO is handed of it."""
STREAMED = 4 * 128
"""Columns of constraint modes that are on their way at a time."""
CHECKED = 250
"""Vectors of a part that its health check takes at a time."""
MARCHED = 60
"""Vectors of an unreduced run in flight: its motion and stages with their products."""
UNRETURNED = 1.07
"""Resident memory over what is asked for: freed pieces that the system does not get back at once."""


@dataclass(frozen=True)
class Stage:
    """A stretch of the work."""

    what: str
    gb: float
    """Largest resident memory of the process in it."""
    why: str
    """The largest pieces."""


@dataclass(frozen=True)
class Memory:
    """Stage by stage; `creak run` keeps the factors of small parts for the check of their superelements."""

    reduce: tuple[Stage, ...]
    run: tuple[Stage, ...]
    free_gb: float
    """Free here now, and what this process holds."""

    @property
    def reduce_peak(self) -> Stage:
        """The stage that needs most of `creak reduce`."""
        return max(self.reduce, key=lambda s: s.gb)

    @property
    def run_peak(self) -> Stage:
        """The same of `creak run`."""
        return max(self.run, key=lambda s: s.gb)


@dataclass(frozen=True)
class Runs:
    """What the runs of a study hold beside their models."""

    rows: int
    """Channel rows of the contact."""
    history: float
    """Bytes of what is kept of a run."""
    factors: Callable[[float, float], int] | None
    """How many factors of the whole an unreduced run holds: of the bytes of one, and of those that others may take
    beside it; None: there is no such run."""


def runs_of(marching: Marching, nodes: int, rows: int, *, unreduced: bool) -> Runs:
    """The runs of a study.

    Parameters
    ----------
    nodes : whose motion is kept. rows : of the contact's channels. unreduced : the unreduced model is run from rest.
    """
    instants = marching.loads.time.size / output_every(marching.course)
    factors = partial(_factors, marching.compared) if unreduced else None
    return Runs(rows, 8.0 * instants * (6.0 * nodes + 4.0 * rows), factors)


def memory(
    reduction: Reduction,
    reference: ReferenceModel,
    whole: Counted | None,
    parts: Sequence[PartSize],
    unknowns: int,
    runs: Runs,
) -> Memory:
    """Peak memory of the study as it stands; held to measured peaks of the door (docs/benchmarks_modes.md).

    Parameters
    ----------
    whole : modes of the assembly counted, with the memory of a factor of it; None where memory does not hold that.
    unknowns : of the reduced model.
    """
    method, band = reduction.table.method, reduction.band
    if whole is None:
        stages, held = _before_by_parts(band, reference, parts)
    else:
        stages, held = _before(reduction, reference, whole, runs.rows)
    reduced = [p for p in parts if not p.unreduced] if method not in (WHOLE, "none") else []
    counts = [0 if method == "guyan" else _computed(band, p.modes) for p in reduced]
    alone, _ = _reductions(reduced, counts, held, unknowns, factors=False)
    kept_too, left = _reductions(reduced, counts, held, unknowns, factors=True)
    marched = _runs(runs, reference, whole, reduced, unknowns, left)
    return Memory((*stages, *alone), (*stages, *kept_too, *marched), (free_bytes() + held_bytes()) / GB)


def _before_by_parts(band: Band, reference: ReferenceModel, parts: Sequence[PartSize]) -> tuple[list[Stage], float]:
    """Parts reduced to what joins them, one after the other; matrices, modes and answers lie in files then."""
    matrices = ENTRY * sum(p.K.nnz + p.M.nnz for p in reference.parts)
    stages = [_stage("assemble", STARTED + matrices, K_and_M=matrices)]
    f_max = SPREAD * modal_band(band, sum(p.n for p in reference.parts))
    for part in parts:
        stage = _reduction(part, round(modes_below(part.modes, f_max)), STARTED)
        stages.append(replace(stage, what=f"{part.name}: what joins it"))
    return stages, STARTED


def _before(reduction: Reduction, reference: ReferenceModel, whole: Counted, rows: int) -> tuple[list[Stage], float]:
    """What comes before parts are reduced, and what is held then."""
    system = reference.system
    n, (of_K, of_M) = system.n, map(entries_of, (system.K, system.M))
    count = reference.modes.omega2.size
    shapes = 8.0 * n * (count + system.supports.count)
    matrices = ENTRY * (of_K + of_M + sum(p.K.nnz + p.M.nnz for p in reference.parts))
    held, product = STARTED + matrices, PRODUCT * of_M

    def found(what: str, modes: int, before: float) -> Stage:
        needed = _lanczos(n, of_K, whole.memory, modes, before + product)
        name = "two factors" if needed.factors > whole.memory else "factor"
        pieces = {name: needed.factors, "modes": needed.basis}
        return _stage(what, before + product + needed.total, K_and_M=matrices, **pieces)

    stages = [
        _stage("assemble", held + whole.memory, K_and_M=matrices, factor=whole.memory),
        found("modes of the assembly", count, held),
    ]
    held += shapes
    if reduction.table.method == WHOLE:
        kept = whole.below.get(reduction.band.f_max, 0)
        stages.append(found("modes for the reduction", kept, held))
        held += whole.memory + 8.0 * n * (kept + 2 * rows)
    return stages, held


def _reductions(
    parts: Sequence[PartSize], counts: Sequence[int], held: float, unknowns: int, *, factors: bool
) -> tuple[list[Stage], float]:
    """The parts one after the other, and what is held after them; `factors`: with those of small parts."""
    stages = []
    for part, modes in zip(parts, counts, strict=True):
        stages.append(_reduction(part, modes, held))
        if not factors:  # checked and saved at once
            kept = held + _inside(part, held) + part.factor + _dense(part, modes)
            vectors = _checked(part, kept)
            stages.append(_stage(f"{part.name}: check", kept + vectors, vectors=vectors, before=held))
        held += _kept(part, modes, held, factors=factors)
    if parts:
        dense = DENSE * 8.0 * unknowns**2
        stages.append(_stage("couple and diagonalise", held + dense, dense_matrices=dense, parts=held))
    return stages, held


def _computed(band: Band, counted: Counted) -> int:
    """Fixed-interface modes that a reduction computes of a part."""
    kept, next_band = (round(modes_below(counted, f)) for f in (band.f_max, BAND * band.f_max))
    return with_further(kept, next_band) if band.further else kept


def modes_below(counted: Counted, f: float) -> float:
    """Modes below f Hz; beyond the frequencies that were counted, by the power law of the last two."""
    known = sorted((g, k) for g, k in counted.below.items() if k > 0)
    if f in counted.below or not known:
        return float(counted.below.get(f, 0))
    (f_1, k_1), (f_2, k_2) = known[-2:] if len(known) > 1 else [(known[0][0] / 2.0, known[0][1] / 2.0), known[0]]
    power = math.log(k_2 / k_1) / math.log(f_2 / f_1)
    return float(k_2 * (f / f_2) ** power)


@dataclass(frozen=True)
class _Lanczos:
    """What modes take beside K and M and the product with M: as the work does where memory is short."""

    factors: float
    """Of K and of K - s M, or one after the other."""
    basis: float
    """Vectors, or the blocks of work where these lie in a file."""
    held: bool
    """They lie in memory."""
    total: float


def _lanczos(n: int, entries: int, factor: float, modes: int, held: float, *, pieces: bool = False) -> _Lanczos:
    """Two factors, the entries of K - s M and Lanczos' vectors; the second factor as it is made where one is held.

    Parameters
    ----------
    entries : of K. factor : bytes. held : bytes that are held beside. pieces : the factor is of as many as fit.
    """
    made = 0.0 if pieces else MADE * entries
    basis = dense_bytes(n) if dense_is_faster(n, modes) else basis_bytes(n, modes)
    two = not pieces and factor + made <= left_beside(held + factor) and basis <= left_beside(held + 2.0 * factor)
    factors = (2.0 if two else 1.0) * factor
    whole = BESIDE * basis <= left_beside(held + factors)
    basis = basis if whole else basis_bytes(n, 0)
    shifted = ENTRY * entries if SPARE * ENTRY * entries <= left_beside(held + factors) else 0.0
    return _Lanczos(factors, basis, whole, max(factors + shifted + basis, 0.0 if two else factor + made))


def _reduction(part: PartSize, modes: int, held: float) -> Stage:
    """Modes, or constraint modes on their way; writing takes a copy of the modes.

    Where memory is short there are pieces of a factor, matrices in files, and fewer constraint modes at a time.
    """
    n, factor, beside = part.inner, part.factor, held + _inside(part, held)
    found = _lanczos(n, part.entries_K, factor, modes, beside, pieces=part.cut > 0.0)
    shapes = 8.0 * n * modes if found.held else 0.0
    streamed = factor + shapes + min(8.0 * n * STREAMED, SHARE * max(left_beside(beside + factor), 0.0))
    written = 2.0 * shapes + _small(part) + _dense(part, modes)
    what = "pieces of a factor" if part.cut else "two factors" if found.factors > factor else "factor"
    return _stage(
        f"{part.name}: reduction",
        beside + max(found.total, streamed, written),
        modes=max(found.basis, 2.0 * shapes),
        before=held,
        **{what: found.factors},
    )


def _inside(part: PartSize, held: float) -> float:
    """Inner matrices, in files where they are large against what is left, and the product with the mass."""
    entries = (part.entries_K, part.entries_M)
    return sum(ENTRY * k for k in entries if SPARE * ENTRY * k <= left_beside(held)) + PRODUCT * part.entries_M


def _kept(part: PartSize, modes: int, held: float, *, factors: bool) -> float:
    """What stays of a reduced part: modes, read from the part's file where they are large, the reduced matrices, and
    for its check in a run a factor that is not too large, with the inner matrices."""
    shapes = 8.0 * part.inner * modes
    shapes = shapes if shapes < MAPPED and ROOM * shapes <= left_beside(held) else 0.0
    small = _small(part) if factors else 0.0
    return (_inside(part, held) + small if small else 0.0) + shapes + _dense(part, modes)


def _small(part: PartSize) -> float:
    return part.factor if part.factor <= KEPT else 0.0


def _dense(part: PartSize, modes: int) -> float:
    return 3.0 * 8.0 * (part.boundary + modes) ** 2


def _runs(
    runs: Runs,
    reference: ReferenceModel,
    whole: Counted | None,
    parts: Sequence[PartSize],
    unknowns: int,
    held: float,
) -> Iterator[Stage]:
    """The reduced run, the check of the parts, and the unreduced run beside it where the study has one."""
    system, rows, history = reference.system, runs.rows, runs.history
    held += KERNELS + history
    yield _stage("run", held + DENSE * 8.0 * unknowns**2 + 8.0 * unknowns * rows, histories=history, before=held)
    if parts:
        vectors = max(_checked(p, held) for p in parts)
        yield _stage("check of the superelements", held + vectors, vectors_of_the_largest=vectors, before=held)
    if whole is not None and runs.factors is not None:
        held -= sum(_small(p) for p in parts)
        answers = 8.0 * system.n * rows
        answers = answers if answers <= RESPONSE_MEMORY else 8.0 * system.n * COLUMNS
        count = runs.factors(whole.memory, left_beside(held + whole.memory))
        of_K, of_M = map(entries_of, (system.K, system.M))
        made = (ENTRY + UPPER) * (1 if count < 3 else 2) * of_K
        step = made + PRODUCT * (of_K + of_M) + 8.0 * MARCHED * system.n
        total = held + count * whole.memory + step + answers + history
        pieces = {f"{count} factors" if count > 1 else "factor": count * whole.memory, "answers of channels": answers}
        yield _stage("reference run", total, **pieces, before=held)


def _checked(part: PartSize, held: float) -> float:
    """What the health check of a part takes: vectors, the product with K, and for a small part's free modes a factor
    of all of it."""
    own = part.modes.memory if part.dofs <= OWN_MODES_LIMIT else 0.0
    return min(8.0 * part.inner * CHECKED, SHARE * max(left_beside(held), 0.0)) + PRODUCT * part.entries_K + own


def _factors(marching: Marching, factor_bytes: float, free: float) -> int:
    """What an unreduced run holds, in real ones: that of its steps, and those of its flights, or of divided steps.

    Parameters
    ----------
    factor_bytes : of a real one. free : bytes that those beside the first may take.
    """
    if not marching.table.exact:
        return min(marching.table.substeps, 2)
    parts = fewest_parts(marching.resolution.stepped)
    rule, _, _ = choose(marching.divided(parts), parts, factor_bytes, free)
    return 1 + rule.factors


def _stage(what: str, total: float, **pieces: float) -> Stage:
    largest = sorted(pieces.items(), key=lambda piece: -piece[1])
    words = ", ".join(f"{name.replace('_', ' ')} {size / GB:.2g} GB" for name, size in largest)
    return Stage(what, (STARTED + UNRETURNED * (total - STARTED)) / GB, words)
