"""Nodes that flat membranes alone reach: nothing is stiff along the normal, so they are held there.

They would each have a mode of frequency 0, or, by the trace of bending that membranes keep, one far below the true
modes. Nastran's AUTOSPC holds them as well. Stress from before the modes gives the stiffness of a drum; then they are
free.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from creak.arrays import FloatArray, IntArray
from creak.model.constraints import Equation, Fixed, linked_nodes
from creak.model.dofs import TRANSLATIONS
from creak.model.faces import EXACT, EXACTLY, normals_at_nodes, unit
from creak.model.materials import GeneralShell
from creak.model.mesh import ElementBlock, Model, Unread

WITHOUT_STIFFNESS = ("mass", "rotary")


def with_held_membranes(model: Model) -> Model:
    """The model with such nodes held along their normals; a note says so."""
    nodes, normals = _loose(model)
    if model.prestress is not None or not nodes.size:
        return model
    where = next(b.where for b in model.blocks if _is_membrane(b))
    aligned = np.abs(normals) >= 1.0 - np.finfo(float).eps
    fixed = [Fixed(nodes[aligned[:, k]], (k + 1,), where) for k in range(3) if aligned[:, k].any()]
    oblique = [
        Equation(np.full(3, node), 1 + order, n[order], where)
        for node, n in zip(nodes, normals, strict=True)
        if not (np.abs(n) >= 1.0 - np.finfo(float).eps).any()
        for order in [np.argsort(-np.abs(n))]
    ]
    why = (
        f"{nodes.size} node(s) that flat membranes alone reach are held along the normal: nothing is stiff there, as "
        "with AUTOSPC of Nastran"
    )
    return replace(
        model,
        fixed=(*model.fixed, *fixed),
        constraints=(*model.constraints, *oblique),
        unread=(*model.unread, Unread("MEMBRANES", where, False, why)),
    )


def _loose(model: Model) -> tuple[IntArray, FloatArray]:
    """Nodes (k,) and normals (k, 3)."""
    loose = np.zeros(model.nodes.count, dtype=bool)
    membranes = [b for b in model.blocks if _is_membrane(b)]
    for block in membranes:
        loose[block.nodes_idx] = True
    for block in model.blocks:
        if not _is_membrane(block) and block.kind not in WITHOUT_STIFFNESS:
            loose[block.nodes_idx] = False
    loose[linked_nodes(model.constraints, model.fixed)] = False
    for held in model.fixed:
        if set(TRANSLATIONS) <= set(held.dofs):
            loose[held.nodes_idx] = False
    normals = np.zeros((model.nodes.count, 3))
    for again in (False, True):
        for block in membranes:
            x = model.nodes.coords[block.nodes_idx]
            n = unit(normals_at_nodes(block.kind, block.nodes_idx, model.nodes.coords).sum(axis=1))
            away = np.abs(np.einsum("eni,ei->en", x - x[:, :1], n)).max(axis=1)
            flat = away <= EXACT * np.linalg.norm(np.ptp(x, axis=1), axis=1)
            if again:
                turned = np.abs(np.einsum("eni,ei->en", normals[block.nodes_idx], n)) < EXACTLY
                loose[block.nodes_idx[turned | ~flat[:, None]]] = False
            else:
                normals[block.nodes_idx] = n[:, None]
    nodes = np.flatnonzero(loose)
    return nodes, normals[nodes]


def _is_membrane(block: ElementBlock) -> bool:
    return isinstance(block.section, GeneralShell) and block.section.is_membrane and not block.section.rigid
