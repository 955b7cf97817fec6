"""How a part that nothing holds can move."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from creak.assembly.coupling import Driven
from creak.assembly.elimination import LinearEquation
from creak.assembly.rigid import unheld_parts
from creak.model.dofs import ALL, dof_label
from creak.model.mesh import Model

AXES = ("x", "y", "z")
NAMED = 3
"""Parts whose motions are looked at one by one; the others are only named."""


def free_motions(model: Model, driven: Driven, name: str, stops: Sequence[LinearEquation] = ()) -> list[str]:
    """`along x`, ..., `about z`: the rigid motions of part `name` that nothing resists.

    A translation is free where the part still moves with its other five motions blocked at one of its nodes; a
    rotation where it still moves with the other two, and the free translations, blocked. A motion that is a mixture
    of all, like a screw, shows as none of them.

    Parameters
    ----------
    stops : what holds parts besides supports, links and springs, see `unheld_parts`.
    """
    node = int(next(p for p in model.parts if p.name == name).nodes_idx[0])
    held = [LinearEquation([dof_label(node, dof)], [1.0]) for dof in ALL]

    def moves(blocked: set[int]) -> bool:
        return name in unheld_parts(model, driven, [*stops, *(held[dof] for dof in sorted(blocked))])

    along = {dof for dof in range(3) if moves(set(range(6)) - {dof})}
    about = [dof for dof in range(3, 6) if moves(({3, 4, 5} - {dof}) | along)]
    return [*(f"along {AXES[dof]}" for dof in sorted(along)), *(f"about {AXES[dof - 3]}" for dof in about)]


def loose_motions(
    model: Model, driven: Driven, loose: Sequence[str], stops: Sequence[LinearEquation] = ()
) -> dict[str, list[str]]:
    """Part that nothing holds -> its `free_motions`; empty beyond the first `NAMED` parts."""
    return {name: free_motions(model, driven, name, stops) if k < NAMED else [] for k, name in enumerate(loose)}


def loose_words(motions: Mapping[str, Sequence[str]]) -> str:
    """`UPPER (along z), LOWER (along x, about y)`: parts and how they can move."""
    return ", ".join(f"{name} ({', '.join(words)})" if words else name for name, words in motions.items())
