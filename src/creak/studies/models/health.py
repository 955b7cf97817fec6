"""Health of the superelements of a study."""

from __future__ import annotations

from creak.progress import Progress
from creak.reduction.health import Health, health
from creak.studies.models.reduced import ReducedModel
from creak.studies.models.superelements import Reduced
from creak.studies.prepare.excitation import highest_frequency
from creak.studies.prepare.setup import Setup

OWN_MODES_LIMIT = 40_000
"""Parts with more dofs are not solved again for their own free modes unless asked: a factorisation of the part,
and as long a search as a small reduction."""


def checked(
    setup: Setup, model: ReducedModel, progress: Progress, *, own_modes: bool | None = None
) -> dict[str, Health]:
    """The health of every superelement by name.

    Parameters
    ----------
    own_modes : compare free modes with those of the unreduced part; default: for parts up to `OWN_MODES_LIMIT` dofs.
    """
    out = {}
    count = len(model.superelements)
    for k, r in enumerate(model.superelements):
        progress("check superelements", k, count)
        out[r.system.name] = check(setup, r, own_modes=own_modes)
        r.inside.release()
    progress("check superelements", count, count)
    return out


def check(setup: Setup, reduced: Reduced, *, own_modes: bool | None = None) -> Health:
    """The health of one superelement, see `checked`; with the factor that made it where that is still there."""
    part = reduced.substructure.part
    return health(
        part,
        reduced.system,
        reduced.inside,
        setup.model.nodes.coords,
        f_excitation=highest_frequency(setup.study) or None,
        own_modes=part.n <= OWN_MODES_LIMIT if own_modes is None else own_modes,
    )
