"""How stiff the spring of a hard contact is: hard against the structure behind its channel, not against the clock.

A blow on a channel sets the modes going by their mobilities p_a. Held at that channel the structure has other modes,
and each of them pulls on what holds it as a spring of k_b would, the channel itself as one of k_0; all together they
resist a blow as k_0 + sum k_b = sum(p_a w_a^2) / sum(p_a)^2. A spring of stiffness k in place of the rigid contact
makes the period of held mode b too long by the share k_b / (2 k), and with it what is made of such modes: a wave that
runs through a bar and back takes 2 L / c (1 + EA / (k L)). So k is `HARD` times the largest of them. Where a single one
is all that there is, a mass on its spring, no wave carries the blow away: the mass turns round on the contact itself,
which is to be short against its period (`SHORT`) and against the course of the loads (`LOADS`).

The modes that are held come from the Lanczos process on the squares of the frequencies that starts with the blow: its
tridiagonal matrix without the first row is the structure held. Source: Golub, Meurant, Matrices, Moments and
Quadrature, 2010, chapter 4.
"""

from __future__ import annotations

import numpy as np
import scipy.linalg as sla

from creak.arrays import FloatArray

HARD = 100.0
"""Spring over the largest that a held mode is: its period is then .5 % too long."""
SHORT = 200.0
"""Contact frequency over that of a mass on its spring: contact lasts .25 % of its period."""
ALONE = 10
"""Power of the share of the largest held mode by which a channel counts as such a mass: from half on. The highest modes
of a plate at one of its nodes have up to .4."""
LOADS = 400.0
"""Contact frequency of a mass times the flight step: contact lasts .8 % of it."""
STEPS = 64
"""Of the Lanczos process at most: finer structure counts as one mode, which makes the spring stiffer."""
ROUND_OFF = 1e-12
"""Of the largest square of a frequency."""


def hard_springs(omega2: FloatArray, mobility: FloatArray, H: float) -> FloatArray:
    """(m,) stiffness that stands for a rigid contact; 0 where nothing can move.

    Parameters
    ----------
    omega2 : (n,) squares of the frequencies. mobility : (m, n) of each channel in each mode, 1 / mass. H : flight step.
    """
    springs = np.zeros(len(mobility))
    for i, p in enumerate(mobility):
        total = float(p.sum())
        if total > 0.0:
            local, largest = held(omega2, p / total)
            mass = largest**ALONE * max(SHORT**2 * local, (LOADS / H) ** 2)
            springs[i] = max(HARD * largest * local, mass) / total
    return springs


def held(omega2: FloatArray, share: FloatArray) -> tuple[float, float]:
    """What resists a blow, over the mass at the channel (1 / time^2), and the share of the largest held mode in it."""
    q, before, along, beside = np.sqrt(share), np.zeros(share.size), [], []
    basis = np.empty((min(STEPS, share.size), share.size))
    tiny = ROUND_OFF * float(omega2.max(initial=0.0))
    for j in range(len(basis)):
        basis[j] = q
        r = omega2 * q
        along.append(float(q @ r))
        r -= along[-1] * q + before
        r -= basis[: j + 1].T @ (basis[: j + 1] @ r)
        size = float(np.linalg.norm(r))
        if size <= tiny:
            break
        beside.append(size)
        before, q = size * q, r / size
    local = along[0]
    if local <= tiny:
        return 0.0, 1.0
    if len(along) == 1:
        return local, 1.0
    squares, shapes = sla.eigh_tridiagonal(np.array(along[1:]), np.array(beside[1 : len(along) - 1]))
    moves = squares > tiny
    springs = (beside[0] * shapes[0, moves]) ** 2 / squares[moves] / local
    return local, float(min(1.0, max(springs.max(initial=0.0), 1.0 - springs.sum())))
