"""Two plates one over the other, for tests of contact."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from creak.contact.node_to_surface import node_to_surface
from creak.contact.pair import ContactPair
from creak.contact.surface_to_surface import surface_to_surface
from creak.model.contact_law import ContactLaw, Coulomb
from creak.model.mesh import Model
from helpers_core import block, model_of, plate, shell, whole_block

METHODS = {"surface-to-surface": surface_to_surface, "node-to-surface": node_to_surface}
both = pytest.mark.parametrize("method", sorted(METHODS))
HEIGHT, T_LOW, T_HIGH = 0.01, 1e-3, 2e-3


def stacked(
    n_low: tuple[int, int] = (5, 4),
    n_high: tuple[int, int] = (3, 7),
    *,
    kinds: tuple[str, str] = ("quad4", "quad4"),
    sides: tuple[int, int] = (0, 0),
    height: float = HEIGHT,
    rotation: np.ndarray | None = None,
    size: tuple[float, float] = (0.3, 0.2),
    offset: tuple[float, float] = (0.0, 0.0),
    flip_low: bool = False,
) -> Model:
    """Plate TOP (part 1) over plate LOW (part 0), meshes that do not match; normals along +z."""
    low, e_low = plate(*n_low, size, 0.0, kinds[0])
    high, e_high = plate(*n_high, size, height, kinds[1])
    high[:, :2] += offset
    n = low.shape[0]
    if flip_low:
        e_low = e_low[:, ::-1]
    coords = np.vstack([low, high])
    if rotation is not None:
        coords = coords @ rotation.T + np.array([0.3, -2.0, 0.7])
    return model_of(
        coords,
        [block(kinds[0], e_low, shell(T_LOW), 0), block(kinds[1], e_high + n, shell(T_HIGH), 1, 1000)],
        [("LOW", range(n)), ("TOP", range(n, coords.shape[0]))],
        node_sets={"TOP_NODES": range(n, coords.shape[0])},
        surfaces=[
            whole_block(0, e_low.shape[0], sides[0], "LOW"),
            whole_block(1, e_high.shape[0], sides[1], "TOP"),
        ],
    )


LAW = ("stiffness", "curve", "damping", "friction")


def pair(**changes: Any) -> ContactPair:
    """Plates of `stacked`; what is of the law goes into its law."""
    if "friction" in changes:
        changes["friction"] = Coulomb(*changes["friction"])
    law = ContactLaw(**{key: changes.pop(key) for key in LAW if key in changes}, where="[contact.stack]")
    return ContactPair(**{"name": "stack", "secondary": "TOP", "main": "LOW", "law": law, **changes})
