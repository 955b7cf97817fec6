"""Robustness of a study against scatter."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from creak.api.study import read_study
from creak.given import path_of, whole
from creak.progress import Progress, told_to
from creak.studies.file.reader import Study

if TYPE_CHECKING:
    from creak.studies.robust.findings import Robustness
    from creak.studies.tasks.queue import Runner

DRAWS = (4, 1_000_000)
"""Fewest and most."""


def robust(
    study: Study | str | Path,
    n: int = 256,
    *,
    out: str | Path | None = None,
    indices: bool = True,
    threads: int | None = None,
    runner: Runner | None = None,
    progress: Progress | None = None,
) -> Robustness:
    """Draw what the study's [scatter] says, march each draw on the model reduced once, and sum it up.

    Parameters
    ----------
    study : a Study, or the path of a study file.
    n : draws behind probabilities and spreads, 4 to a million, made a power of two; Sobol indices take half as many
        more per cause.
    out : folder of the draws: each is kept as soon as it is finished, and never marched again.
    indices : whether to find Sobol indices. threads : default: the cores of this process.
    runner : marches batches of draws on other machines instead, as `creak.studies.tasks.cluster.running_cluster` gives
        one; all of them see the study, its deck and `out`.
    progress : called with (stage, done, total).

    Returns
    -------
    Robustness. `rattle` (anywhere) and `places` have probabilities with bounds of 95 %, spreads, the needed gap and
    odds over the load; `indices` and `tornado` tell what it hangs on; `as_dict()` is plain data.

    Raises
    ------
    InputError : anything wrong in the study, the deck or [scatter]; n or threads that cannot be.
    NumericalError : a reduction failed.
    """
    from creak.studies.robust.findings import find
    from creak.studies.robust.job import run_draws

    whole(n, "n", *DRAWS)
    if threads is not None:
        whole(threads, "threads", 1)
    report, folder = told_to(progress), None if out is None else path_of(out, "out", "a folder")
    read = study if isinstance(study, Study) else read_study(study)
    return find(run_draws(read, n, report, folder, indices=indices, threads=threads, runner=runner))
