"""Quadrature of the solids whose stiffness is the integral of B' D B, by kind of element."""

from __future__ import annotations

from creak.elements import solid_hex20, solid_pyramid5, solid_tet4, solid_tet10, solid_wedge6, solid_wedge15
from creak.elements.solid_common import Reference

SOLID_RULES: dict[str, Reference] = {
    "wedge6": solid_wedge6.GAUSS,
    "pyramid5": solid_pyramid5.TWO,
    "tet4": solid_tet4.CENTRE,
    "tet10": solid_tet10.FOUR,
    "hex20": solid_hex20.TWENTY_SEVEN,
    "hex20r": solid_hex20.EIGHT,
    "wedge15": solid_wedge15.NINE,
}
