"""What of a model its deck damps."""

from __future__ import annotations

import numpy as np

from creak.model.constraints import KinematicCoupling, RigidLink
from creak.model.materials import Discrete, Section, Structural, has_dashpot, rayleigh
from creak.model.mesh import Model

MOSTLY = 0.5
"""Share of the elements from which on a structure counts as undamped although some of it is damped."""


def is_damped(model: Model) -> bool:
    """Whether a material, a point mass, a spring or a dashpot of the model damps anything."""
    return any(_damps(block.section) for block in model.blocks)


def undamped_words(model: Model) -> str:
    """`900 of 1,000 shells, solids and beams`: those that no material damps where something else of the model is
    damped; empty where these are few. Elements that move as rigid bodies do not count."""
    if not is_damped(model):
        return ""
    rigid = np.zeros(model.nodes.count, dtype=bool)
    for c in model.constraints:
        if isinstance(c, KinematicCoupling | RigidLink):
            rigid[c.nodes] = True
    bare = every = 0
    for b in model.blocks:
        if isinstance(b.section, Structural):
            elastic = int((~rigid[b.nodes_idx].all(axis=1)).sum())
            every += elastic
            bare += 0 if _damps(b.section) else elastic
    return f"{bare:,} of {every:,} shells, solids and beams" if bare > MOSTLY * every else ""


def _damps(section: Section) -> bool:
    return any(rayleigh(section)) or (isinstance(section, Discrete) and has_dashpot(section))
