"""Plate frequencies against converged Ritz values (NAFEMS FV12, FV16, FV32) and exact Mindlin values.

On 16 x 16 the quads are within 0.5 % in every plate case, and within 3.5 % on 8 x 8.
"""

from __future__ import annotations

import numpy as np
import pytest

from benchmarks_shell import (
    FV12,
    FV16,
    FV32,
    THICK,
    THIN_PLATES,
    cantilever_plate,
    fitted_slope,
    free_plate,
    tapered_membrane,
    thick_plate,
    thin_plate,
)

RECORDED = {"section": "shell modes", "source": "NAFEMS; converged Ritz"}

kinds = pytest.mark.parametrize("kind", ["quad", "tri"])


def rows(case: str, kind: str) -> str:
    """A row for every frequency of quads, one for the worst of triangles."""
    return f"{case}, mode {{}}" if kind == "quad" else f"{case}, triangles, worst mode"


@kinds
def test_free_square_plate_within_one_percent(kind, measured):
    ratio = free_plate(16, kind)
    measured(rows("FV12 free plate, 16 x 16", kind), ratio * FV12, FV12, rel=0.01, unit="Hz")


@kinds
def test_cantilevered_square_plate_within_one_percent(kind, measured):
    ratio = cantilever_plate(16, kind)
    measured(rows("FV16 cantilevered plate, 16 x 16", kind), ratio * FV16, FV16, rel=0.01, unit="Hz")


@pytest.mark.parametrize(
    ("compute", "limit"),
    [(free_plate, 0.005), (cantilever_plate, 0.005), (thick_plate, 0.005)]
    + [(lambda n, edges=edges: thin_plate(edges, n), 0.005) for edges in THIN_PLATES],
    ids=["FV12", "FV16", "thick", *THIN_PLATES],
)
def test_bending_waves_of_quads_are_of_higher_order(compute, limit):
    """Plain MITC4 is off by (kh)^2/12 and more: 1 to 2 % on this mesh."""
    found = compute(16)
    assert found == pytest.approx(np.ones(found.size), abs=limit)


@pytest.mark.parametrize(("kind", "n"), [("quad", 16), ("tri", 20)])
def test_thick_plate_matches_mindlin_theory_within_one_percent(kind, n, measured):
    ratio = thick_plate(n, kind)
    measured(rows(f"thick plate, {n} x {n}", kind), ratio * THICK, THICK, rel=0.01, unit="Hz", source="Mindlin, exact")


@pytest.mark.parametrize("edges", THIN_PLATES)
@pytest.mark.parametrize(("kind", "n"), [("quad", 16), ("tri", 28)])
def test_thin_square_plates_within_one_percent(edges, kind, n, measured):
    """Thickness a / 1000: shear locking would show. Triangles want the finer mesh between clamped edges."""
    ratio = thin_plate(edges, n, kind)
    exact = np.array(THIN_PLATES[edges])
    source = "Navier, exact" if edges == "SSSS" else "Leissa 1973; converged Ritz"
    measured(rows(f"thin plate {edges}, {n} x {n}: lambda", kind), ratio * exact, exact, rel=0.01, source=source)


CASES = {
    "FV12": free_plate,
    "FV16": cantilever_plate,
    "FV32": lambda n, kind: tapered_membrane(2 * n, n, kind),
    "thick": thick_plate,
    **{edges: lambda n, kind, edges=edges: thin_plate(edges, n, kind) for edges in THIN_PLATES},
}


BENT = ["FV12", "FV16", "thick", *THIN_PLATES]


@pytest.mark.parametrize(("kind", "coarsest"), [("quad", 0.007), ("tri", 0.02)])
@pytest.mark.parametrize("case", BENT)
def test_bending_approaches_the_reference(case, kind, coarsest):
    """Errors of (kh)^2 cancel to the most part, those that are left fall at different rates: no one slope can be told.

    Transverse shear takes up to 0.2 % off the thin-plate values of FV12 and FV16.
    """
    coarse, fine = (np.abs(CASES[case](n, kind) - 1.0).max() for n in (12, 27))
    assert coarse < coarsest
    assert fine < 0.0045


@kinds
def test_frequencies_converge_with_the_square_of_the_element_size_to_the_reference(kind, measured):
    """Linear shape functions: h^2. On coarser meshes two modes of FV32 change places."""
    n = np.array([12, 18, 27])
    slope, limit, misfit = fitted_slope(n, [CASES["FV32"](k, kind) for k in n])
    assert misfit < 0.05
    measured(
        f"FV32 tapered membrane, {kind}: slope of convergence",
        slope,
        2.0,
        between=(1.7, 2.4),
        source="linear shape functions",
    )
    measured(
        f"FV32 tapered membrane, {kind}: limit of finer meshes over reference, worst",
        limit,
        1.0,
        abs=0.002,
        source="as above",
    )


@pytest.mark.parametrize(("kind", "limit"), [("quad", 0.01), ("tri", 0.013)])
def test_tapered_membrane_on_32_by_16(kind, limit, measured):
    """Consistent membrane mass overestimates by (kh)^2/24 and more on coarse meshes."""
    ratio = tapered_membrane(32, 16, kind)
    measured(rows("FV32 tapered membrane, 32 x 16", kind), ratio * FV32, FV32, rel=limit, unit="Hz")
