"""Quadrature of the solids whose stiffness is the integral of B' D B, by kind of element."""

from __future__ import annotations

from creak.elements.solids import hex20, pyramid5, tet4, tet10, wedge6, wedge15
from creak.elements.solids.common import Reference

SOLID_RULES: dict[str, Reference] = {
    "wedge6": wedge6.GAUSS,
    "pyramid5": pyramid5.TWO,
    "tet4": tet4.CENTRE,
    "tet10": tet10.FOUR,
    "hex20": hex20.TWENTY_SEVEN,
    "hex20r": hex20.EIGHT,
    "wedge15": wedge15.NINE,
}
