"""Gap elements of a deck -> stops between pairs of nodes, and what a study must say of them."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, replace

import numpy as np

from creak.arrays import FloatArray
from creak.model.mesh import Model
from creak.model.steps import Stop

DOFS = ("x", "y", "z")
ALONG = 1e-6
"""Sine of the angle up to which a gap lies along a global axis."""
DIGITS = 6
"""Decimals in which the directions of gaps of one stop agree."""


@dataclass(frozen=True)
class Gap:
    """One element: (u_b - u_a) . n >= -opening, then `stiffness` pushes back."""

    owner: str
    """Property or set that it has its values from."""
    ends: tuple[int, int]
    """Node rows a, b."""
    line: FloatArray
    """(3,) along n, from a to b, of any length above 0."""
    opening: float
    """length"""
    stiffness: float
    """force / length; inf: hard."""
    where: str
    friction: tuple[float, float, float] = (0.0, 0.0, 0.0)
    """Static and kinetic coefficient, decay speed (length / time, 0: none)."""

    @property
    def direction(self) -> FloatArray:
        """(3,) n, along a global axis exactly where it lies there but for round-off."""
        n = self.line / np.linalg.norm(self.line)
        axis = int(np.argmax(np.abs(n)))
        if np.linalg.norm(np.delete(n, axis)) <= ALONG:
            n = np.sign(n[axis]) * np.eye(3)[axis]
        return np.asarray(n)


def stops_of(gaps: Iterable[Gap]) -> tuple[Stop, ...]:
    """Gaps of one owner and direction together, as GAP_<owner>, with a number where it has several directions."""
    groups: dict[tuple[str, tuple[float, ...]], list[Gap]] = {}
    for gap in gaps:
        groups.setdefault((gap.owner, tuple((gap.direction.round(DIGITS) + 0.0).tolist())), []).append(gap)
    of_owner: dict[str, list[list[Gap]]] = {}
    for (owner, _), group in groups.items():
        of_owner.setdefault(owner, []).append(group)
    names = {
        id(group): f"GAP_{owner}" + (f"_{k}" if len(all_of) > 1 else "")
        for owner, all_of in of_owner.items()
        for k, group in enumerate(all_of, start=1)
    }
    return tuple(_stop(names[id(group)], group) for group in groups.values())


def _stop(name: str, gaps: list[Gap]) -> Stop:
    first, n = gaps[0], gaps[0].direction
    a, b = (np.array([g.ends[i] for g in gaps], dtype=np.int64) for i in (0, 1))
    axis, oblique = int(np.argmax(np.abs(n))), np.count_nonzero(n) > 1
    below = oblique or n[axis] > 0.0
    return Stop(
        name,
        a,
        b,
        axis + 1,
        lower=0.0 - first.opening if below else None,
        upper=None if below else first.opening,
        stiffness=first.stiffness,
        where=first.where,
        direction=(float(n[0]), float(n[1]), float(n[2])) if oblique else None,
        friction=first.friction,
    )


def in_a_study(stop: Stop) -> str:
    """What `creak info` says of gaps that a study leaves out."""
    return f"give it in the study, as `creak new` does: {_connector(stop)}"


def left_to_a_study(model: Model) -> Model:
    """The model to be written as another deck or as matrices: of its stops the node sets go on, as of all contact."""
    why = {
        stop.where: f"it is contact; a study of what is written has it as {_connector(stop)}" for stop in model.stops
    }
    unread = (
        replace(u, changes_answer=False, why=why[u.where]) if u.changes_answer and u.where in why else u
        for u in model.unread
    )
    return replace(model, unread=tuple(unread))


def _connector(stop: Stop) -> str:
    side = f"lower = {stop.lower:g}" if stop.lower is not None else f"upper = {stop.upper:g}"
    along = f'dof = "{DOFS[stop.dof - 1]}"'
    if stop.direction is not None:
        along = f"axis = [{', '.join(f'{x:g}' for x in stop.direction)}]"
    stiffness = '"hard"' if stop.stiffness == np.inf else f"{stop.stiffness:g}"
    static, kinetic, decay = stop.friction
    rubs = f", friction = {static:g}" if static else ""
    if kinetic != static:
        rubs = f", friction = {{ static = {static:g}, kinetic = {kinetic:g}, decay = {decay:g} }}"
    return (
        '[[connector]] type = "play", '
        f'nodes = ["{stop.name}.A", "{stop.name}.B"], {along}, {side}, stiffness = {stiffness}{rubs}'
    )
