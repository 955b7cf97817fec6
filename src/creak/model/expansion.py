"""Thermal expansion of materials and shells."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from creak.arrays import FloatArray

IN_PLANE = np.array([0, 1, 3])
"""xx, yy, xy among the six strains."""


@dataclass(frozen=True)
class Expansion:
    """Strain per degree above the temperature without strain, in the material axes of the element."""

    strain: tuple[float, float, float, float, float, float]
    """1/degree: exx, eyy, ezz, 2 exy, 2 eyz, 2 ezx."""
    reference: float | None = None
    """Temperature without strain; None: the load, or the deck's initial temperature, says it."""
    flaw: str = ""
    """Why creak cannot use it, such as one that depends on temperature; empty: it can."""


@dataclass(frozen=True, eq=False)
class ShellExpansion:
    """What holds a shell as it is against one degree: N = force, M = moment, about the surface of the nodes."""

    force: FloatArray
    """(3,) N11, N22, N12, force / length / degree, in the material axes of the element."""
    moment: FloatArray
    """(3,) M11, M22, M12, force / degree."""
    reference: float | None = None
    """As of `Expansion`."""
    flaw: str = ""


def isotropic_expansion(alpha: float, flaw: str = "") -> Expansion:
    """alpha in all directions."""
    return Expansion((alpha, alpha, alpha, 0.0, 0.0, 0.0), flaw=flaw)


def joined(expansions: Sequence[Expansion | None]) -> tuple[float | None, str]:
    """Reference and flaw of layers that expand together; what does not expand has neither."""
    some = [e for e in expansions if e is not None]
    references = {e.reference for e in some}
    flaw = next((e.flaw for e in some if e.flaw), "")
    if len(references) > 1:
        flaw = flaw or "its layers have different reference temperatures"
    return next(iter(references), None), flaw
