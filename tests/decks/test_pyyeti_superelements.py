"""Craig-Bampton superelements of NX Nastran 9: read, coupled, and compared with NX's own coupled frequencies.

Files of pyYeti (BSD-3): two trusses with four common grids, one of which (11) has a displacement frame of its own.
"""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from scipy.linalg import eigh

from creak.errors import InputError
from creak.formats.matrices.superelements import read_superelement, write_superelement
from creak.model.superelement import Superelement
from helpers_matrices import assert_same

RECORDED = {"section": "decks"}

DECKS = Path(__file__).resolve().parents[3] / "shared" / "decks"
FOLDER = DECKS / "pyyeti_cb"
pytestmark = pytest.mark.skipif(not FOLDER.is_dir(), reason=f"third-party decks are not at {FOLDER}")
BOUNDARY = [3, 11, 19, 27]
PLACES = {3: [600.0, 0.0, 300.0], 11: [600.0, 300.0, 300.0], 19: [600.0, 300.0, 0.0], 27: [600.0, 0.0, 0.0]}


@pytest.fixture(scope="module")
def parts() -> list[Superelement]:
    return [read_superelement(FOLDER / f"{name}.op4") for name in ("inboard", "outboard")]


def frequencies(parts: list[Superelement]) -> np.ndarray:
    """Free frequencies (Hz) of the parts with their common nodes joined."""
    rows = [
        [
            (node, dof) if node else (k, i, 0)
            for i, (node, dof) in enumerate(zip(p.node_ids.tolist(), p.dofs.tolist(), strict=True))
        ]
        for k, p in enumerate(parts)
    ]
    index = {row: i for i, row in enumerate(dict.fromkeys(row for part in rows for row in part))}
    K, M = np.zeros((2, len(index), len(index)))
    for part, of_part in zip(parts, rows, strict=True):
        at = np.ix_([index[r] for r in of_part], [index[r] for r in of_part])
        K[at] += part.K
        M[at] += part.M
    return np.sqrt(np.abs(eigh(K, M, eigvals_only=True))) / (2.0 * np.pi)


def test_points(parts):
    assert [p.n for p in parts] == [24 + 8, 24 + 22]
    for part in parts:
        np.testing.assert_array_equal(part.node_ids[:24], np.repeat(BOUNDARY, 6))
        np.testing.assert_array_equal(part.dofs[:24], np.tile(np.arange(1, 7), 4))
        assert not np.any(part.node_ids[24:])
        assert {n: x.tolist() for n, x in part.positions.items()} == PLACES
        assert part.C is None


def test_rigid_motion_needs_no_force(parts, measured):
    """K_bb times rigid motions is zero in the basic frame only: 1e-9 of the rows' absolute sums is rounding.

    Left in the frame of grid 11 the same residual is of order one.
    """
    for part in parts:
        motion = np.zeros((24, 6))
        for k, node in enumerate(BOUNDARY):
            x, y, z = part.positions[node]
            motion[6 * k : 6 * k + 6] = np.eye(6)
            motion[6 * k : 6 * k + 3, 3:] = [[0.0, z, -y], [-z, 0.0, x], [y, -x, 0.0]]
        boundary = part.K[:24, :24]
        force = np.abs(boundary @ motion) / (np.abs(boundary) @ np.abs(motion)).max(axis=0)
        measured(
            "superelements of NX: force of rigid motion, relative", force.max(), at_most=1e-9, source="equilibrium"
        )


def test_coupled_frequencies(parts, measured):
    """48 elastic frequencies as NX prints them, to 1e-5; the first six are rigid (NX: 3e-5 Hz at most)."""
    printed = np.array(json.loads((DECKS / "refs.json").read_text())["pyyeti_cb_assembled"]["tables_hz"][0])
    computed = frequencies(parts)
    assert computed.size == printed.size == 54
    assert computed[:6].max() < 1e-4
    measured(
        "superelements of NX, coupled: 48 elastic frequencies, worst",
        computed[6:],
        printed[6:],
        rel=1e-5,
        unit="Hz",
        source="NX Nastran",
    )


def test_written_again(parts, tmp_path):
    """Our own .op4 and .asm hold the same superelement."""
    again = read_superelement(write_superelement(parts[1], tmp_path, "op4")[0])
    assert_same(again, parts[1])


def test_the_map_of_the_other_part(parts):
    with pytest.raises(InputError, match=r"46 rows, the map inboard\.asm 32: 24 dofs of 4 grids and 8 scalar points"):
        read_superelement(FOLDER / "outboard.op4", FOLDER / "inboard.asm")
