"""The static state that the modes of a deck start from: linear, at the undeformed shape."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace

import numpy as np

from creak.arrays import FloatArray
from creak.assembly.coupling import Driven
from creak.assembly.system import System, to_dense
from creak.elements.geometric import GEOMETRIC, UNSTRESSED
from creak.errors import InputError
from creak.linalg.factor import Factor
from creak.model.constraints import Equation, Tie
from creak.model.dofs import PER_NODE, dofs_of, node_dofs, nodes_of
from creak.model.mesh import Model, Unread
from creak.model.steps import StaticStep


def is_ignored(step: StaticStep, ignore: Iterable[str]) -> bool:
    """Whether `ignore` names the step: modes without its stress."""
    return step.keyword.lstrip("*") in {k.upper().lstrip("*") for k in ignore}


def require_known(model: Model, step: StaticStep) -> None:
    """Raise InputError for elements and couplings that stress changes in a way that creak does not know."""
    for block in model.blocks:
        arms = block.own.arms is not None and block.kind in GEOMETRIC
        known = block.kind in UNSTRESSED or (block.kind in GEOMETRIC and block.part >= 0)
        if arms or not known:
            raise _unknown(
                step,
                f"element {block.ids[0]}" + (", which is off its nodes" if arms else f" ({block.kind})"),
                block.where,
            )
    for constraint in model.constraints:
        if not isinstance(constraint, Equation | Tie):
            raise _unknown(step, f"a {type(constraint).__name__} with arms", constraint.where)


def _unknown(step: StaticStep, what: str, where: str) -> InputError:
    return InputError(
        f"the stress of {step.keyword} ({step.where}) stiffens {what} in a way that creak does not know",
        expected="shells, solids, beams and trusses, joined by equations and ties",
        where=where,
        fix=f"Run with --ignore {step.keyword.lstrip('*')} for the modes without stress.",
    )


def driven_by(step: StaticStep) -> Driven:
    """The dofs that the step moves; the modes hold them."""
    return Driven({f"{m.name}.{m.dof} at {m.where}": node_dofs(m.nodes_idx, (m.dof,)) for m in step.moved})


def displacements(system: System, factor: Factor | None, model: Model, step: StaticStep) -> FloatArray:
    """(n_node, 6) of K q = f - K_s s, at held drilling rotations those of the shells.

    Raises
    ------
    InputError : supports and links do not hold the structure.
    """
    if factor is None:
        raise InputError(
            f"the structure can move freely under {step.keyword}",
            where=step.where,
            expected="supports, links or springs that hold it",
            fix=f"Hold it, or run with --ignore {step.keyword.lstrip('*')}.",
        )
    f = np.zeros(system.n)
    for load in step.loads:
        f += load.value * np.asarray(system.rows(node_dofs(load.nodes_idx, (load.dof,)))[0].sum(axis=0)).ravel()
    s = np.array([m.value for m in step.moved])
    if s.size:
        f -= to_dense(system.supports.K_qs) @ s
    u = np.zeros((model.nodes.count, PER_NODE))
    u[nodes_of(system.labels), dofs_of(system.labels) - 1] = system.displacement(~system.labels, factor.solve(f), s)
    return u


def noted(model: Model, step: StaticStep) -> Model:
    """The model whose unread parts say that the step is used."""
    why = "its stress, linear and at the undeformed shape, stiffens the structure in these modes"
    used = [Unread(u.keyword, u.where, False, why) if u.keyword == step.keyword else u for u in model.unread]
    return replace(model, unread=tuple(used))
