"""Element blocks -> *ELEMENT, sections, orientations and nodal thickness."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np

from creak.arrays import FloatArray, IntArray
from creak.formats.abaqus.write.directions import third_nodes, turned_spring
from creak.formats.abaqus.write.names import Scopes, listed, number, quoted, vector
from creak.formats.abaqus.write.sections import Materials, section_lines
from creak.formats.deck.refusals import unwritable
from creak.formats.written_deck import inverted
from creak.model.materials import AxialSpring, BeamSection, NodalMatrices, Section, ShellSection, Spring
from creak.model.mesh import ElementBlock, Model

_TYPES = {
    "quad4": "S4",
    "tri3": "S3",
    "quad8": "S8R",
    "tri6": "STRI65",
    "beam2": "B31",
    "beam3": "B32",
    "truss2": "T3D2",
    "hex8": "C3D8I",
    "wedge6": "C3D6",
    "pyramid5": "C3D5",
    "tet4": "C3D4",
    "tet10": "C3D10",
    "hex20": "C3D20",
    "hex20r": "C3D20R",
    "wedge15": "C3D15",
    "mass": "MASS",
    "rotary": "ROTARYI",
    "bush2": "CONN3D2",
    "nodal1": "MASS",
}
PER_LINE = 16
"""Fields that Abaqus reads from one line."""
_SPRINGS = {"spring1": ("SPRING1", "DASHPOT1"), "spring2": ("SPRING2", "DASHPOT2"), "axial2": ("SPRINGA", "DASHPOTA")}


@dataclass
class Written:
    """Lines of the scopes, and what is numbered through."""

    lines: dict[int, list[str]]
    materials: Materials = field(default_factory=Materials)
    n_orientations: int = 0
    n_sets: int = 0
    thickness: dict[int, float] = field(default_factory=dict)


def element_lines(model: Model, scopes: Scopes, out: Written) -> None:
    """Elements block by block, then their sections.

    Raises
    ------
    InputError : an element or a section that Abaqus keywords do not say.
    """
    for block, scope in zip(model.blocks, scopes.of_block, strict=True):
        out.lines[scope] += _elements(model, block, scopes, scope)
    groups: dict[tuple[int, int], list[int]] = {}
    for k, block in enumerate(model.blocks):
        groups.setdefault((scopes.of_block[k], id(block.section)), []).append(k)
    for group in _merged(model, scopes, groups):
        _section(model, scopes, group, out)


def element_type(block: ElementBlock) -> str:
    """Abaqus's name of the elements of a block.

    Raises
    ------
    InputError : there is none.
    """
    section = block.section
    turned = turned_spring(section) if isinstance(section, NodalMatrices) else None
    if turned is not None:
        return _SPRINGS[f"spring{block.nodes_idx.shape[1]}"][1 if turned.spring.damping else 0]
    if block.kind in _SPRINGS and isinstance(section, Spring | AxialSpring):
        return _SPRINGS[block.kind][1 if section.damping and not section.stiffness else 0]
    if isinstance(section, BeamSection) and not section.shear_area1 and not section.shear_area2:
        return "B33"
    if block.kind == "hex20s":
        why = "Abaqus has no hexahedron with reduced shear; IN = 2 and ISOP = 1 of PSOLID make it a C3D20R"
        raise unwritable(block.title, why)
    if block.kind not in _TYPES:
        raise unwritable(f"{block.title} of kind {block.kind}", "creak writes no such element for Abaqus")
    if block.own.arms is not None and block.own.arms.any():
        raise unwritable(block.title, "rigid arms lead from their nodes to their corners")
    return _TYPES[block.kind]


def _elements(model: Model, block: ElementBlock, scopes: Scopes, scope: int) -> list[str]:
    lines = [f"*ELEMENT, TYPE={element_type(block)}"]
    third = third_nodes(model.nodes.coords, block)
    for k, (label, row) in enumerate(zip(block.ids.tolist(), block.nodes_idx, strict=True)):
        tokens = scopes.nodes(row, scope) + ([scopes.node(third[k], scope)] if third and third[k] >= 0 else [])
        fields = [str(label), *tokens]
        starts = range(0, len(fields), PER_LINE)
        lines += [", ".join(fields[k : k + PER_LINE]) + ("," if k + PER_LINE < len(fields) else "") for k in starts]
    return lines


def _rows(model: Model, blocks: list[int]) -> IntArray:
    return np.concatenate(
        [np.column_stack([np.full(model.blocks[b].ids.size, b), np.arange(model.blocks[b].ids.size)]) for b in blocks]
    )


def _merged(model: Model, scopes: Scopes, groups: dict[tuple[int, int], list[int]]) -> list[list[int]]:
    """Blocks of one section; sections of one name that make up its element set go together (B31 with B33)."""
    result: dict[tuple[object, ...], list[int]] = {}
    for (scope, key), blocks in groups.items():
        section = model.blocks[blocks[0]].section
        shared = isinstance(section, BeamSection | Spring | AxialSpring) and not _set_of(model, scopes, blocks)
        axis = section.axis1 if isinstance(section, BeamSection) else None
        result.setdefault((scope, section.name, axis, 0 if shared else key), []).extend(blocks)
    merged: list[list[int]] = []
    for blocks in result.values():
        one = len({id(model.blocks[b].section) for b in blocks}) == 1
        merged += [blocks] if one or _set_of(model, scopes, blocks) else [[b] for b in blocks]
    return merged


def _set_of(model: Model, scopes: Scopes, blocks: list[int]) -> str:
    """Element set that holds the blocks and nothing else, as their scope sees it; the section's own name first."""
    scope, wanted = scopes.of_block[blocks[0]], sorted(map(tuple, _rows(model, blocks).tolist()))
    title = model.blocks[blocks[0]].section.name.upper()
    names = sorted(model.element_sets, key=lambda n: (scopes.split(n)[1] != title, n.startswith("_")))
    for name in names:
        rows = model.element_sets[name]
        if scopes.split(name)[0] == scope and len(rows) == len(wanted) and sorted(map(tuple, rows.tolist())) == wanted:
            short = scopes.split(name)[1]
            as_written = short == title and quoted(short) == short  # in quotes Abaqus tells case apart
            return model.blocks[blocks[0]].section.name if as_written else short
    return ""


def _section(model: Model, scopes: Scopes, blocks: list[int], out: Written) -> None:
    scope = scopes.of_block[blocks[0]]
    lines = out.lines[scope]
    elset = _set_of(model, scopes, blocks)
    if not elset:
        out.n_sets += 1
        elset = f"_SECTION-{out.n_sets}"
        lines += [f"*ELSET, ELSET={elset}", *listed(scopes.elements(_rows(model, blocks), scope))]
    orientation = _orientation(model, blocks, out, lines)
    varying = any(model.blocks[b].own.thickness is not None for b in blocks)
    if varying:
        lines += _nodal_thickness(model, scopes, blocks, scope, out)
    first = max((model.blocks[b].section for b in blocks), key=_completeness)
    lines += section_lines(first, elset, out.materials, orientation, varying)


def _completeness(section: Section) -> float:
    """Of sections that share a keyword: B31's has the shear areas, a spring's the degrees of freedom."""
    if isinstance(section, BeamSection):
        return section.shear_area1
    return 1.0 if isinstance(section, Spring) else 0.0


def _orientation(model: Model, blocks: list[int], out: Written, lines: list[str]) -> str:
    """*ORIENTATION of the blocks' own axes; its name, or "" where they have none."""
    owns = [model.blocks[b].own for b in blocks]
    section = model.blocks[blocks[0]].section
    turned = turned_spring(section) if isinstance(section, NodalMatrices) else None
    if turned is not None:
        return _axes(turned.axes[0], turned.axes[1], out, lines)
    if isinstance(section, BeamSection | Spring | AxialSpring | NodalMatrices | ShellSection) or owns[0].axis1 is None:
        return ""
    axes = [[a for a in (o.axis1, o.axis2) if a is not None] for o in owns]
    every = np.concatenate([np.concatenate(a, axis=1) for a in axes if a])
    if not all(axes) or np.ptp(every, axis=0).any():
        raise unwritable(f"section {section.name!r}", "the axes of its elements are not all the same")
    a = every[0, :3]
    b = every[0, 3:] if every.shape[1] == 6 else _across(a)
    return _axes(a, b, out, lines)


def _axes(a: FloatArray, b: FloatArray, out: Written, lines: list[str]) -> str:
    """*ORIENTATION of axis 1 and another across it; its name."""
    out.n_orientations += 1
    name = f"AXES-{out.n_orientations}"
    lines += [f"*ORIENTATION, NAME={name}", f"{vector(a)}, {vector(b)}", "3, 0."]
    return name


def _across(a: FloatArray) -> FloatArray:
    """A direction that is not along `a`."""
    return np.eye(3)[int(np.argmin(np.abs(a)))]


def _nodal_thickness(model: Model, scopes: Scopes, blocks: list[int], scope: int, out: Written) -> list[str]:
    """*NODAL THICKNESS of the corners of shells."""
    lines = []
    for b in blocks:
        block = model.blocks[b]
        base = getattr(block.section, "thickness", 0.0)
        if block.own.thickness is None:
            why = "only some of its shells have thicknesses at their nodes"
            raise unwritable(f"section {block.section.name!r}", why)
        for node, share in zip(block.nodes_idx.ravel().tolist(), block.own.thickness.ravel().tolist(), strict=True):
            if node not in out.thickness:
                out.thickness[node] = inverted(_over(base), share, share * base)
                lines.append(f"{scopes.node(node, scope)}, {number(out.thickness[node])}")
    return ["*NODAL THICKNESS", *lines] if lines else []


def _over(base: float) -> Callable[[float], float]:
    return lambda t: t / base
