"""Third-party Nastran decks: frequencies, shapes, superelements and RBE3 matrices against NX's and MSC's own answers."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
import scipy.io
from scipy.linalg import eigh

from creak.arrays import to_dense
from creak.assembly.coupling import Driven
from creak.assembly.elimination import linear_equations
from creak.assembly.part import Rayleigh, part_system
from creak.formats.matrices.superelements import read_superelement
from creak.formats.nastran.mesh.grids import Grids, read_grids, read_systems
from creak.formats.nastran.reader import read_nastran
from creak.formats.nastran.text.bulk_data import Card
from creak.formats.nastran.text.deck_file import read_deck_file
from creak.model.dofs import node_dofs
from creak.model.mesh import Model
from creak.reduction.craig_bampton import craig_bampton
from creak.studies.models.deck_modes import model_modes

RECORDED = {"section": "decks", "source": "NX Nastran"}

DECKS = Path(__file__).resolve().parents[3] / "shared" / "decks"
pytestmark = pytest.mark.skipif(not DECKS.is_dir(), reason=f"third-party decks are not at {DECKS}")
NO_DAMPING = Rayleigh(0.0, 0.0)
PRINTED = 1e-5
"""The references are printed with seven digits; bars are the same theory."""


def references(name: str, table: int | None = None) -> np.ndarray:
    found = json.loads((DECKS / "refs.json").read_text())[name]
    return np.array(found["freq_hz"] if table is None else found["tables_hz"][table])


def grids_of(path: Path) -> Grids:
    cards = read_deck_file(path).cards
    by_name: dict[str, list[Card]] = {}
    for card in cards:
        by_name.setdefault(card.name, []).append(card)
    return read_grids(by_name, read_systems(cards))[0]


def mac(shapes: np.ndarray, path: Path, stored: Path) -> np.ndarray:
    """MAC (k, k) of the translations; the stored shapes are in each grid's displacement frame."""
    data, grids = np.load(stored), grids_of(path)
    rows = [grids.row_of[int(i)] for i in data["node_id"]]
    phi = data["phi"][:, :, :3].copy()
    for k, row in enumerate(rows):
        if row in grids.axes:
            phi[:, k] = phi[:, k] @ grids.axes[row].T
    A = shapes.reshape(-1, 6, shapes.shape[1])[rows, :3].reshape(-1, shapes.shape[1])
    B = phi.reshape(len(phi), -1).T
    return (A.T @ B) ** 2 / np.outer((A**2).sum(axis=0), (B**2).sum(axis=0))


@pytest.mark.parametrize(
    ("deck", "free", "compared", "tolerance"),
    [("plate_py.dat", 6, 4, 1e-3), ("dakota_cylinder.bdf", 6, 14, 5e-3), ("femap_exhaust.bdf", 0, 10, 3e-3)],
)
def test_shells(deck, free, compared, tolerance, measured):
    """Within .5 %, where 1 % was asked; the elements differ. Shapes MAC > .95; the modes come in the same order."""
    path = DECKS / deck
    wanted = references(path.stem)
    model = read_nastran(path)
    assert not any(u.changes_answer for u in model.unread)
    system, found = model_modes(model, Driven({}), count=free + compared)
    assert found.sturm_ok
    np.testing.assert_array_equal(found.frequencies[:free], 0.0)
    names = {"plate_py.dat": "plate of CQUAD4", "dakota_cylinder.bdf": "cylinder", "femap_exhaust.bdf": "exhaust"}
    source, wanted_here = "NX and MSC Nastran", wanted[free : free + compared]
    measured(
        f"{names[deck]}: frequency {{}}", found.frequencies[free:], wanted_here, rel=tolerance, unit="Hz", source=source
    )
    stored = DECKS / f"{path.stem}_modes.npz"
    if stored.exists():
        R, _ = system.rows(np.arange(6 * model.nodes.count))
        lowest = np.diag(mac(R @ found.shapes, path, stored))[free:].min()
        measured(f"{names[deck]}: lowest MAC", lowest, 1.0, between=(0.95, 1.0), source=source)


@pytest.mark.parametrize(
    ("name", "deck", "free"),
    [("cofe3_full", "cofe_cb/noReduction-000.dat", 0), ("pyyeti_full", "pyyeti_cb/full.dat", 6)],
)
def test_bars(name, deck, free, measured):
    """Lumped mass with shear flexible bars and beams and rods in torsion; coupled mass (COUPMASS) of 117 bars."""
    wanted = references(name, 0)
    _, found = model_modes(read_nastran(DECKS / deck), Driven({}), count=wanted.size)
    assert found.frequencies[:free].max(initial=0.0) < 1e-4
    title = "bars and beams, lumped mass" if name == "cofe3_full" else "truss of 117 bars, coupled mass"
    measured(f"{title}: frequency, worst", found.frequencies[free:], wanted[free:], rel=PRINTED, unit="Hz")


class Piece:
    """A part reduced to grids: matrices whose rows are (grid, dof) or (piece, mode)."""

    def __init__(self, model: Model, kept: list[int], held: tuple[int, ...], modes: int) -> None:
        row_of = {int(i): k for k, i in enumerate(model.nodes.ids)}
        system = part_system(model, 0, NO_DAMPING)
        labels = node_dofs(np.array([row_of[i] for i in (*kept, *held)]))
        boundary = np.flatnonzero(np.isin(system.coordinates, labels))
        self.reduced = craig_bampton(system, boundary, count=modes)
        id_of = {6 * row_of[i] + d: (i, d) for i in (*kept, *held) for d in range(6)}
        names = [id_of[c] for c in system.coordinates[np.sort(boundary)].tolist()]
        self.rows = [*names, *((id(self), k) for k in range(modes))]
        free = [k for k, row in enumerate(self.rows) if row[0] not in held]
        self.rows = [self.rows[k] for k in free]
        self.K, self.M = (to_dense(A)[np.ix_(free, free)] for A in (self.reduced.K, self.reduced.M))


def joined(pieces: list[Piece]) -> np.ndarray:
    """Frequencies (Hz) of the pieces with their common grids joined."""
    index = {row: i for i, row in enumerate(dict.fromkeys(row for piece in pieces for row in piece.rows))}
    K, M = np.zeros((2, len(index), len(index)))
    for piece in pieces:
        at = np.ix_([index[row] for row in piece.rows], [index[row] for row in piece.rows])
        K[at] += piece.K
        M[at] += piece.M
    mu = eigh(M, K, eigvals_only=True)
    return 1.0 / np.sqrt(mu[::-1][mu[::-1] > 1e-12 * mu.max()]) / (2.0 * np.pi)


def test_guyan(measured):
    """ASET of two grids; SPC grids are kept in creak and held afterwards, which is the same."""
    wanted = references("cofe3_guyan", 0)
    model = read_nastran(DECKS / "cofe_cb" / "guyanReduction-000.dat")
    kept = model.nodes.ids[model.node_set("ASET")].tolist()
    assert kept == [11, 25]
    found = joined([Piece(model, kept, (15, 27), 0)])[: wanted.size]
    measured("Guyan reduction: frequency, worst", found, wanted, rel=PRINTED, unit="Hz")


def test_craig_bampton(measured):
    """Two superelements with three fixed-interface modes each, read from their bulk data."""
    one, two = (read_nastran(DECKS / "cofe_cb" / f"se{k}.dat") for k in (1, 2))
    pieces = [Piece(one, [11, 25], (), 3), Piece(two, [11, 25], (15, 27), 3)]
    for table, piece in enumerate(pieces):
        fixed = np.sqrt(np.diag(piece.K)[-3:]) / (2.0 * np.pi)
        np.testing.assert_allclose(fixed, references("cofe3_cb", table), rtol=PRINTED)
    wanted = references("cofe3_cb", 2)
    found = joined(pieces)[: wanted.size]
    measured("Craig-Bampton, two superelements: frequency, worst", found, wanted, rel=PRINTED, unit="Hz")


@pytest.mark.parametrize(("name", "modes"), [("inboard", 3), ("outboard", 16)])
def test_external_superelements(name, modes, measured):
    """NX's boundary matrices KAA, MAA (OP4) and fixed-interface frequencies from the deck that made them."""
    nx = read_superelement(DECKS / "pyyeti_cb" / f"{name}.op4")
    model = read_nastran(DECKS / "pyyeti_cb" / f"{name}.dat")
    kept = sorted(model.nodes.ids[model.node_set("BSET")].tolist())
    piece = Piece(model, kept, (), modes)
    fixed = np.sqrt(np.diag(piece.K)[24:]) / (2.0 * np.pi)
    np.testing.assert_allclose(fixed, references(f"pyyeti_{name}_fixed", 0), rtol=PRINTED)
    order = [piece.rows.index((i, d)) for i in kept for d in range(6)]
    for ours, theirs in ((piece.K, nx.K), (piece.M, nx.M)):
        theirs = np.asarray(theirs)[:24, :24]
        error = np.abs(ours[np.ix_(order, order)] - theirs).max() / np.abs(theirs).max()
        measured(f"external superelement {name}: KAA, MAA, relative error", error, at_most=PRINTED)


@pytest.mark.parametrize("case", ["1", "2", "3", "4", "um_1", "um_2", "um_3", "um_5", "um_6"])
def test_rbe3(case, measured):
    """GM of NX: u_m = GM u_n in displacement frames, with and without UM, rotations weighted, REFC in part."""
    path = DECKS / "rbe3_gm" / f"make_gm_nx9_rbe3_{case}.dat"
    data = scipy.io.loadmat(path.with_suffix(".mat"), squeeze_me=True, struct_as_record=False)
    uset, gm = data["uset"].k0, data["gm"].k0
    grids, model = grids_of(path), read_nastran(path)
    row_of = {int(i): k for k, i in enumerate(model.nodes.ids)}
    local = np.zeros((6 * model.nodes.count, len(uset)))
    for k, (identifier, dof) in enumerate(uset[:, :2].astype(int)):
        row = row_of[identifier]
        if dof:
            first = 6 * row + (3 if dof > 3 else 0)
            local[first : first + 3, k] = grids.direction(row, dof)
    equations = [e for c in model.constraints for e in linear_equations(c, model.nodes.coords)]
    E = np.zeros((len(equations), local.shape[0]))
    for k, equation in enumerate(equations):
        np.add.at(E[k], list(equation.labels), list(equation.coefficients))
    E = E @ local
    m = uset[:, 2].astype(int) == 1
    ours = -np.linalg.solve(E[:, m], E[:, ~m])
    error = np.abs(ours - np.atleast_2d(gm)).max() / np.abs(gm).max()
    measured("RBE3, nine kinds: GM, worst relative error", error, at_most=PRINTED)
