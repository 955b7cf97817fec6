"""How long a run by exact flow and its repeats will take, told before them."""

from __future__ import annotations

import math
import time
from collections.abc import Callable

import numpy as np

from creak.arrays import FloatArray
from creak.assembly.system import System
from creak.contact.gap_operator import GapOperator
from creak.dynamics.channels import channel_matrices
from creak.dynamics.flow.march import SAMPLES, form_of
from creak.dynamics.flow.resolution import Resolution, flow_steps
from creak.dynamics.loads import Loads
from creak.dynamics.state import LinearTerms
from creak.linalg.threads import one_blas_thread
from creak.studies.prepare.marching import Marching, Observed, output_every
from creak.studies.run.elines import line_steps
from creak.studies.run.integrate import flowing, linear_gaps
from creak.verify.elines import measure
from creak.words import duration

TOLD = 60.0
"""s from which it is told."""
REPEATS = 7.0
"""Cost of a run and its repeats (contact twice as fine, half and twice as stiff, more modes) over that of the run."""
QUICK = 0.5
"""Cost of a run of quick accuracy over that of a settled one."""
LOOKED = 0.4
"""Share of the channels that a step near contact looks at, at most: .26 and .62 where all of two plates may touch, and
of a door without gaps."""
LASTS = 0.3
"""Share of the time, closed without contact, from which contact is what costs."""
READS = 2.2
"""Step of a diagonal model over the time that reading its channel rows and ten vectors takes (measured on the door)."""
SOLVED = 3.0
"""Solutions in a step with friction (a tray that slides on two bars)."""
SHORTEST = 1e-6
"""s of a step of two or three modes; calls of NumPy take as long, and are left out of the timing."""
TRIALS = 25
BATCH = 64
"""Instants whose output is recovered at a time in the timing."""


def closed_in(gap: FloatArray) -> FloatArray:
    """(2,) of gaps (n_time, m): share of the instants at which any is closed, and how many of them are then closed."""
    closed = gap <= 0.0
    some = closed.any(axis=1)
    return np.array([some.mean(), closed[some].sum(axis=1).mean() if some.any() else 0.0])


def foretold(
    marching: Marching, system: System, gaps: GapOperator, observed: Observed, closed: FloatArray | None
) -> str:
    """What a run of a reduced model will take, where that is long; empty of a forced step, whose progress tells it.

    Parameters
    ----------
    observed : what is looked at in the run. closed : as for `run_s`; None: there was no linear run, so that the gaps of
        this model without contact tell it.
    """
    table = marching.table
    modal = flowing(system)[0] if table.exact and gaps.presses else None
    if modal is None:
        return ""
    if closed is None:
        closed = closed_in(linear_gaps(marching, gaps, modal).at)
    began = time.process_time()
    seconds = run_s(modal, gaps, marching.loads, marching.resolution, closed)
    seconds += time.process_time() - began  # what the run sets up was set up for this, too
    seconds += kept_s(marching, observed, gaps, modal.n)
    return words(seconds, table.accuracy != "quick", closed)


def run_s(system: System, gaps: GapOperator, loads: Loads, resolution: Resolution, closed: FloatArray) -> float:
    """Seconds of a run by exact flow here, from a step that is timed and from where the linear run closes gaps.

    Parameters
    ----------
    system : with the modes that it is marched in. closed : (2,) of a run without contact (`closed_in`).

    Of the march alone, in processor time: neither what it keeps (`kept_s`) nor the making of the model, and no share
    of the machine that others take.

    Contact throws parts apart: where gaps would be closed for a share of the time it presses for some square of it,
    and in few channels at once. Expect a factor of two.
    """
    form = form_of(system, channel_matrices(system, gaps), LinearTerms(system, loads), gaps)
    n, levels = loads.n_step // SAMPLES, flow_steps(form, gaps.laws, SAMPLES * loads.step, resolution).levels
    share, rows = closed.tolist()
    looked = math.ceil(min(rows, LOOKED * gaps.m))
    step = step_s(system.n, looked) if form.pairs is None else step_s(2 * system.n, 2 * looked)
    return n * (step + share**2 * 2.0**levels * (step + (solve_s(3 * looked) if gaps.rubbing else 0.0)))


def kept_s(marching: Marching, observed: Observed, gaps: GapOperator, n: int) -> float:
    """Seconds of what a run of n coordinates keeps: its outputs, what is watched at every flight step, its E-lines."""
    rows, seen, points = 6 * observed.nodes.size / output_every(marching.course), observed.seen, observed.lines.points.m
    if seen is not None:
        rows += seen.silent.m + seen.turns.shape[0] + 2 * gaps.m * seen.slip
    steps = line_steps(marching, n).size if points else 0
    whole = marching.ends.size * written_s(n, rows) + steps * written_s(n, 3 * points)
    if not steps:
        return whole
    swing = np.tile(np.sin(np.arange(steps))[:, None, None], (1, 1, 3))
    return whole + points * median_s(lambda: measure(swing, observed.lines.percentile))


def words(seconds: float, repeated: bool, closed: FloatArray) -> str:
    """What is told of a run of so many seconds, and of its repeats; empty where both are short."""
    whole = (REPEATS if repeated else 1.0) * seconds
    if whole < TOLD:
        return ""
    said = f"the reduced run will take about {duration(seconds)} of processor time"
    if repeated:
        said += (
            f', {duration(whole)} with the repeats that tell how far it has settled, and more where f_max = "auto" '
            "adds modes; models and the check against the unreduced one come on top; a first look, creak run --quick, "
            f"about {duration(QUICK * seconds)}"
        )
    if closed[0] >= LASTS:
        said += (
            f". Without contact parts would overlap in some {100 * closed[0]:.0f} % of the time, and contact is what "
            "costs: a joint that never opens is cheaper tied, and parts that are not to touch at rest want a clearance"
        )
    return said


def step_s(unknowns: int, rows: int, observed: float = 0.0) -> float:
    """A step of a diagonal model: its (rows, unknowns) channel rows read, and the motion that it writes; timed here.

    Parameters
    ----------
    observed : physical dofs whose motion is kept, divided by the steps between two outputs.
    """

    def reading(n: int) -> float:
        G, vectors, x = np.ones((max(rows, 1), n)), np.ones((10, n)), np.ones(n)
        return median_s(lambda: (G @ x, vectors @ x))

    n = max(unknowns, 1)
    with one_blas_thread():
        step = SHORTEST + READS * max(reading(n) - reading(1), 0.0)
    return step + written_s(n, observed)


def written_s(unknowns: int, rows: float) -> float:
    """Recovering so many dofs at an instant, one of a batch; timed here."""
    if not rows:
        return 0.0
    G, X = np.ones((min(math.ceil(rows), BATCH), unknowns)), np.ones((unknowns, BATCH))
    with one_blas_thread():
        return rows / len(G) * median_s(lambda: G @ X) / BATCH


def solve_s(unknowns: int) -> float:
    """What the forces of channels that rub take in a step: a few solutions of so many equations, timed here."""
    A, b = np.eye(max(unknowns, 1)) + 0.1, np.ones(max(unknowns, 1))
    with one_blas_thread():
        return SOLVED * median_s(lambda: np.linalg.solve(A, b))


def median_s(work: Callable[[], object]) -> float:
    """Median time of a piece of work, s."""
    work()
    seconds = []
    for _ in range(TRIALS):
        started = time.perf_counter()
        work()
        seconds.append(time.perf_counter() - started)
    return float(np.median(seconds))
