"""*NODAL THICKNESS."""

from __future__ import annotations

import numpy as np

from creak.arrays import FloatArray
from creak.errors import InputError
from creak.formats.abaqus.text.lexer import Block
from creak.formats.abaqus.text.names import Registry
from creak.formats.abaqus.text.numbers import positive
from creak.formats.abaqus.text.outline import Outline


def read_nodal_thickness(deck: Outline, nodes: Registry, n_node: int) -> FloatArray:
    """Thickness (n_node,) that the deck gives at nodes, NaN where it gives none; the last line of a node counts.

    Raises
    ------
    InputError : unknown node or set, a thickness that is not positive.
    """
    result = np.full(n_node, np.nan)
    for scope, block in deck.blocks("NODAL THICKNESS"):
        for fields, where in block.rows():
            value = positive(fields[1] if len(fields) > 1 else "", where, "nodal thickness")
            result[nodes.find(fields[0], scope.name, where)] = value
    return result


def at_elements(block: Block, table: np.ndarray, thickness: FloatArray) -> FloatArray:
    """(n_elem, n_node_per_element) thickness at the corners of elements; node rows -1 are left out.

    Raises
    ------
    InputError : a node of the section has no thickness.
    """
    found = np.where(table >= 0, thickness[table], 0.0)
    if np.isnan(found).any():
        raise InputError(
            f"{int(np.isnan(found).sum())} corner(s) of the shells of *{block.name}, NODAL THICKNESS have no thickness",
            expected="*NODAL THICKNESS for all their nodes",
            where=block.where,
            fix="Add the nodes.",
        )
    return found
