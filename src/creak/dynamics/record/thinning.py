"""Fewer instants where contact changes too often for all of them to be kept, with the same impulses.

Parts that touch all over chatter: some channel opens or closes in every step, so that every step would be kept, and a
table of all channels at all of them fills memory. From `FREE` of the `BUDGET` on, instants stay that are a spacing
apart, and all ends of whole steps. A force there is the mean over the intervals on both sides of it,

    f_k = (J_k + J_k+1) / (t_k+1 - t_k-1),

with J the impulse in an interval: the trapezoidal rule over what stays gives the impulse of what was there. Where
instants that all stay begin again, the last interval is one of theirs. Gaps, sliding and energies are of the instant.
"""

from __future__ import annotations

import numpy as np

from creak.arrays import FloatArray, IntArray

BUDGET = 2.5e8
"""Bytes of the table of a run, where that leaves instants no further apart than `LONGEST` of a step."""
FREE = 0.25
"""Share of the budget that may be taken at any time; of the rest a run has the share that its time has of the whole."""
LONGEST = 0.05
"""Of a step of the run, between two instants, at most: half of what is promised of the start of an event."""
HALVINGS = 8
"""Of `LONGEST`, that are tried."""


def room_for(width: int, share: float) -> int:
    """Rows of so many numbers that the budget has for a share of the run."""
    return int(BUDGET * (FREE + (1.0 - FREE) * share) / (8.0 * width))


def spacing_for(time: FloatArray, room: int, step: float) -> float:
    """The shortest spacing (s) that leaves at most `room` of the instants (n,), `LONGEST` steps where none does."""
    longest = LONGEST * step
    tried = (longest / 2**k for k in range(HALVINGS, 0, -1))
    return next((s for s in tried if np.count_nonzero(np.diff(np.floor(time / s))) <= room), longest)


def thin(table: FloatArray, used: int, first: int, at: IntArray, forces: slice, spacing: float) -> tuple[int, IntArray]:
    """Thin rows `first` to `at[-1]` of a table, in place; returns the rows then used, and where those `at` are.

    The last one and that before it stay, the last with its own force, for the next time.

    Parameters
    ----------
    table : (n, width) time, then all else. first : 1 or more. at : (k,) rising rows that stay. forces : columns that
        become means. spacing : s.
    """
    start, behind = first - 1, int(at[-1]) + 1
    rows = table[start:behind]
    time = rows[:, 0]
    cell = np.floor(time / spacing)
    stays = np.concatenate([[True], cell[1:] != cell[:-1]])
    stays[at - start] = stays[-2:] = True
    kept = np.flatnonzero(stays)
    if kept.size == stays.size:
        return used, at
    impulse = 0.5 * np.diff(time)[:, None] * (rows[1:, forces] + rows[:-1, forces])
    J, apart = np.add.reduceat(impulse, kept[:-1], axis=0), np.diff(time[kept])[:, None]
    before = table[start, 0] - table[start - 1, 0] if start else 0.0
    J[-1] = apart[-1] * rows[-2, forces]
    mean = np.empty((kept.size - 1, J.shape[1]))
    mean[0] = (before * rows[0, forces] + J[0]) / (before + apart[0])
    mean[1:] = (J[:-1] + J[1:]) / (apart[:-1] + apart[1:])
    end = start + kept.size
    table[start:end] = rows[kept]
    table[start : end - 1, forces] = mean
    table[end : end + used - behind] = table[behind:used]
    return end + used - behind, start + np.searchsorted(kept, at - start)


def spacing_words(spacing: float) -> tuple[str, ...]:
    """What the user should know of it; nothing where all is kept (0)."""
    if not spacing > 0.0:
        return ()
    return (
        "contact opens and closes too often for all instants to be kept: from some time on they are "
        f"{1e6 * spacing:.2g} us apart, and forces means over that; impulses are those of all instants",
    )
