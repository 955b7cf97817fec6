"""Whether a study fits into memory, told before anything is factorised: of the whole model, or of its parts."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from creak.arrays import FloatArray
from creak.assembly.system import System
from creak.linalg.factor import factor_bytes
from creak.linalg.memory import ENTRY, GB, OVERRIDE, OutOfMemory, free_bytes
from creak.linalg.pieces.factor import Pieces
from creak.reduction.room import beside_factor, beside_pieces, pieces_of, plenty
from creak.studies.solved import solved

JOIN = 1.2
"""Memory of joining the parts over that of K and M of the whole."""


@dataclass(frozen=True)
class Room:
    """Least memory that the work takes beyond what is held now, modes window by window and stored on disk; bytes."""

    whole: float
    """With a factor of the whole model."""
    part: float
    """With factors of one part at a time."""
    largest: str
    """The part that takes most."""
    pieces: Pieces | None = None
    """Those that it is cut into, where memory does not hold its factor."""


def room(parts: Sequence[System], store: Path | None = None, key: str = "") -> Room | None:
    """None where there is plainly enough. Costs the analysis of the parts, a third of the time of their factors.

    Parameters
    ----------
    store : folder of saved superelements, beside which the analysis is kept. key : digest of all that the parts are.
    """
    if plenty(*(part.n for part in parts)):
        return None
    sizes = solved(store if key else None, "room", [key], lambda: {"sizes": _sizes(parts)})["sizes"]
    n, K, M, factors = sizes.sum(axis=0).tolist()
    whole = JOIN * ENTRY * (K + M) + factors + beside_factor(int(n), K, M)
    back = ENTRY * (K + M)  # the matrices of the parts go to disk then
    each = [(*_of_part(part, own, back), part.name) for part, own in zip(parts, sizes.tolist(), strict=True)]
    most, pieces, name = max(each, key=lambda part: part[0])
    return Room(whole, most, name, pieces)


def _sizes(parts: Sequence[System]) -> FloatArray:
    """(n_part, 4) dofs, entries of K and M, bytes of a factor of K."""
    return np.array([[p.n, p.K.nnz, p.M.nnz, factor_bytes(p.K)] for p in parts], dtype=np.float64)


def _of_part(part: System, sizes: Sequence[float], back: float) -> tuple[float, Pieces | None]:
    """With its factor, or with that of the pieces that it is cut into."""
    _, K, M, factor = sizes
    matrices, free = ENTRY * (K + M) - back, free_bytes()
    whole = matrices + factor + beside_factor(part.n, K, M)
    cut = None if whole <= free else pieces_of(part.K, part.M, free - matrices)
    return (whole, None) if cut is None else (matrices + cut.bytes + beside_pieces(part.n, M), cut)


def only_parts_fit(
    takes: Sequence[tuple[str, str]], parts: Sequence[System], store: Path | None = None, key: str = ""
) -> bool:
    """Whether memory holds the factors of the parts, one at a time, but not that of the whole.

    Parameters
    ----------
    takes : what of the study needs the unreduced model, as `Setup.takes_whole`.

    Raises
    ------
    OutOfMemory : it does not hold what the study takes.
    """
    needed, free = room(parts, store, key), free_bytes()
    if needed is None or needed.whole <= free:
        return False
    if not takes and needed.part <= free:
        return True
    if takes:
        words, ways = zip(*takes, strict=True)
        what, least = (
            f"a factor of the whole model, which {' and '.join(words)} {'takes' if len(words) == 1 else 'take'}",
            needed.whole,
        )
        alone = f"parts alone take {needed.part / GB:.3g} GB"
        fix = f"Use a coarser mesh or a machine with more memory, or do without it: {', '.join(ways)}; {alone}."
    else:
        what, least = f"the reduction of part {needed.largest}{_cut(needed)}", needed.part
        fix = (
            "Cut it into element sets by [reduction] substructures, use a coarser mesh, or a machine with more memory."
        )
    raise OutOfMemory(
        f"memory does not hold {what}: at least {least / GB:.3g} GB are needed, {free / GB:.3g} GB are free. {fix} To "
        f"try all the same, set {OVERRIDE}={least / GB * 1.01:.3g} in the environment."
    )


def _cut(needed: Room) -> str:
    return "" if needed.pieces is None else f", cut into {needed.pieces.count} pieces"
