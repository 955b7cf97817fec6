"""Material directions, spring axes and nodal thickness of the elements of a section."""

from __future__ import annotations

from dataclasses import dataclass, field, replace

import numpy as np

from creak.arrays import FloatArray, IntArray
from creak.errors import InputError, suggest
from creak.formats.abaqus.mesh.elements import Elements
from creak.formats.abaqus.sections.orientations import Distributions, Orientations, find_distribution, find_orientation
from creak.formats.abaqus.text.fields import Registry, positive
from creak.formats.abaqus.text.lexer import Block
from creak.formats.abaqus.text.outline import Outline, Scope
from creak.model.materials import AnisotropicMaterial, BeamSection, GeneralShell, Section, ShellSection, SolidSection
from creak.model.mesh import COMMON, Own


@dataclass(frozen=True)
class Geometry:
    """Where the elements are: for material directions and thicknesses."""

    coords: FloatArray
    """(n_node, 3)"""
    orientations: Orientations
    thickness: FloatArray
    """(n_node,) *NODAL THICKNESS, NaN where there is none."""
    distributions: Distributions = field(default_factory=dict)

    def centres(self, elements: Elements, rows: IntArray) -> FloatArray:
        """(n, 3) mean positions of the nodes of elements."""
        table = elements.nodes_idx[rows]
        used = (table >= 0)[:, :, None]
        return np.asarray(np.where(used, self.coords[table], 0.0).sum(axis=1) / used.sum(axis=1), dtype=np.float64)


def own_data(
    deck: Outline, scope: Scope, block: Block, section: Section, elements: Elements, rows: IntArray, at: Geometry
) -> Own:
    """Material directions, beam axes by a third node and nodal thickness of the elements of one section."""
    own = COMMON
    solid = isinstance(section, SolidSection) and isinstance(section.material, AnisotropicMaterial)
    solid = solid and block.name != "COHESIVE SECTION"
    if block.get("ORIENTATION") and (solid or isinstance(section, GeneralShell)):
        orientation = find_orientation(block.get("ORIENTATION"), at.orientations, scope, deck, block.where)
        centres = at.centres(elements, rows)
        if isinstance(section, GeneralShell):
            own = Own(axis1=orientation.shell_axis1(rows, centres))
            if orientation.about != 3:
                why = f"shells have axis {orientation.about % 3 + 1} of it, projected, as direction 1, as in Abaqus"
                why += "; CalculiX projects axis 1: for that end *ORIENTATION with the line 3, 0."
                deck.note(block, why, changes=False, what=f"*ORIENTATION, NAME={block.get('ORIENTATION')}")
        else:
            axes = orientation.of_elements(rows, centres)
            own = Own(axis1=axes[:, 0], axis2=axes[:, 1])
    elif solid and scope.rotated:
        raise block.error(
            f"the solids of *{block.name}, ELSET={block.get('ELSET')} have an anisotropic material and no axes, in the "
            f"rotated instance {scope.name!r}",
            expected="ORIENTATION= on the section",
            fix="Give *ORIENTATION and name it.",
        )
    elif solid:
        why = "the material has no ORIENTATION: its axes are the global ones, as in CalculiX (Abaqus refuses it)"
        deck.note(block, why, changes=False, what=f"*{block.name}, ELSET={block.get('ELSET')}")
    elif scope.rotated and isinstance(section, GeneralShell):
        own = Own(axis1=_default_direction(scope, elements, rows, at.coords))
    third = elements.third[rows]
    if isinstance(section, BeamSection) and (third >= 0).any():
        toward = at.coords[third] - at.coords[elements.nodes_idx[rows, 0]]
        own = Own(axis1=np.where((third >= 0)[:, None], toward, np.array(section.axis1)))
    if isinstance(section, ShellSection | GeneralShell) and block.has("SHELL THICKNESS"):
        given = _thicknesses(deck, scope, block, rows, at) / section.thickness
        own = replace(own, thickness=np.tile(given, (1, elements.nodes_idx.shape[1])))
    if isinstance(section, ShellSection | GeneralShell) and block.has("NODAL THICKNESS"):
        thickness = at_elements(block, elements.nodes_idx[rows], at.thickness)
        own = replace(own, thickness=thickness / section.thickness)
    return own


def _thicknesses(deck: Outline, scope: Scope, block: Block, rows: IntArray, at: Geometry) -> FloatArray:
    """(n, 1) thickness of elements by SHELL THICKNESS=."""
    name = block.need("SHELL THICKNESS")
    found = find_distribution(name, at.distributions, scope, deck, ("LENGTH",), block.where)
    if found is None:
        raise block.error(
            f"SHELL THICKNESS={name} of *{block.name} is no *DISTRIBUTION", fix=suggest(name, at.distributions)
        )
    values = found.values[rows]
    if not (values > 0.0).all():
        raise InputError(
            f"distribution {name!r} gives {int((~(values > 0.0)).sum())} shell(s) of *{block.name} no thickness",
            expected="lengths greater than zero: a default on its first data line, or a line for each element",
            where=found.where,
            fix="Add the elements.",
        )
    return values


def _default_direction(scope: Scope, elements: Elements, rows: IntArray, coords: FloatArray) -> FloatArray:
    """(n, 3) of a rotated instance: x of the part, or its z where x is within 0.1 degree of the normal."""
    corner = coords[elements.nodes_idx[rows, :4]]
    last = np.where((elements.nodes_idx[rows, 3] >= 0)[:, None], corner[:, 3], corner[:, 2])
    normal = np.cross(corner[:, 2] - corner[:, 0], last - corner[:, 1])
    x, z = scope.rotation[:, 0], scope.rotation[:, 2]
    near = np.linalg.norm(np.cross(normal, x), axis=1) < 1.7e-3 * np.linalg.norm(normal, axis=1)
    return np.where(near[:, None], z, x)


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
        raise block.error(
            f"{int(np.isnan(found).sum())} corner(s) of the shells of *{block.name}, NODAL THICKNESS have no thickness",
            expected="*NODAL THICKNESS for all their nodes",
            fix="Add the nodes.",
        )
    return found
