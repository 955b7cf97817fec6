"""Materials without a density, which Nastran takes: what a look at a deck and a study say of them."""

from __future__ import annotations

from dataclasses import replace

from creak.model.mesh import Model
from creak.studies.prepare.unit_check import materials


def massless_words(model: Model) -> list[str]:
    """Materials of many elements without a density, and without a mass per area or length, a sentence each."""
    bare = [b for b in model.blocks if not any(getattr(b.section, k, 0.0) for k in ("area_mass", "line_mass"))]
    many = {m.name for m in materials(model)}
    return [
        f"material {m.name} has no density: {m.elements} element(s) have no mass of their own"
        for m in materials(replace(model, blocks=tuple(bare)))
        if m.name in many and m.modulus > 0.0 and m.density == 0.0
    ]
