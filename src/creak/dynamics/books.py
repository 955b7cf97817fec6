"""The book of energies that every march keeps: its columns, what channels store, and how the balance is closed.

A march brings what is stored in its coordinates and the works of a step, by the quadrature of its own scheme:
trapezoidal where that is the scheme's (`energy`, `modal.books`), by the stages of a flight (`flight.course`), exact
between kicks (`flow.books`). Everything else is here, once, for compiled and general marches.
"""

from __future__ import annotations

import numpy as np

from creak.arrays import FloatArray
from creak.contact.step_problem import contact_energy, spring_energy
from creak.dynamics.history import ENERGIES
from creak.linalg.compiled import either

KINETIC, STRAIN, CONTACT, DAMPING, CONTACT_DAMPING, FRICTION, EXTERNAL, SCHEME = range(len(ENERGIES))
"""Columns of the table, as `ENERGIES` has them."""
BEGUN, GIVEN = 8, 9
"""Behind them: the whole energy at t = 0, and what exact flow had at t = 0 and was given since by loads and kicks."""
SIZE = 10


def new_book() -> FloatArray:
    """(SIZE,) nothing stored, nothing done."""
    return np.zeros(SIZE)


@either
def in_channels(laws, preload, gap0, gap):  # type: ignore[no-untyped-def]
    """Energy of the springs of the channels, and potential of the forces (m,) that balance their preload.

    Of a channel with a preload it counts from its rest, where both together are least.
    """
    energy = contact_energy(laws, gap)
    for i in range(gap.size):
        if preload[i] != 0.0:
            energy += preload[i] * (gap[i] - gap0[i]) - spring_energy(laws, i, gap0[i])
    return energy


@either
def open_book(e):  # type: ignore[no-untyped-def]
    """Take the stored energies of the first instant as given."""
    e[BEGUN] = e[KINETIC] + e[STRAIN] + e[CONTACT]


@either
def balance(e):  # type: ignore[no-untyped-def]
    """What stored energies and works leave over is the scheme's own: dissipation, or energy created where negative."""
    spent = e[DAMPING] + e[CONTACT_DAMPING] + e[FRICTION]
    e[SCHEME] = e[EXTERNAL] + e[BEGUN] - (e[KINETIC] + e[STRAIN] + e[CONTACT]) - spent
