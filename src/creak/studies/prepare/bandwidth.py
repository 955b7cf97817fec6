"""Up to which frequency forces and spectra are looked at, where the study does not say: what run and mesh can tell."""

from __future__ import annotations

import math

import numpy as np

from creak.arrays import FloatArray, IntArray
from creak.contact.facets import confined_modulus
from creak.contact.gap_operator import GapOperator
from creak.model.constraints import held_nodes
from creak.model.materials import SolidSection
from creak.model.mesh import Model
from creak.model.shell_facets import facet_areas
from creak.model.solid_faces import FACES, face_numbers, faces_of, volumes
from creak.studies.file.case import Course
from creak.studies.file.config import VerificationTable

IN_A_RUN = 10.0
"""Periods of the low-pass that a run has at least: over fewer it is no mean force, but what its ends make of it."""
PER_WAVE = 10.0
"""Steps of the mesh in a wave of compression that it carries."""


def bandwidth(
    table: VerificationTable, course: Course, model: Model, contacts: GapOperator
) -> tuple[VerificationTable, list[str]]:
    """[verification] with the f_max that a run and the mesh at its contacts can tell, and notes.

    One that is given stays. A run shorter than ten periods of it has a higher one; a mesh of solids at the
    contacts that does not carry it a lower one (`carried`): touches which follow each other faster are of the mesh.

    Raises
    ------
    InputError : no end of the run.
    """
    if "f_max" in table.model_fields_set or not course.time.exact:
        return table, []
    highest = carried(model, contacts.retained_nodes)
    f_max = min(max(table.f_max, IN_A_RUN / course.end), highest)
    if f_max == table.f_max:
        return table, []
    given = {**table.model_dump(exclude_unset=True), "f_max": f_max}
    why = f"the run is {course.end:.3g} s long"
    if f_max == highest:
        why = f"the solids at the contacts are too coarse for more ({PER_WAVE:g} steps of the mesh in a wave)"
    return VerificationTable.model_validate(given), [
        f"forces are low-passed at {f_max:.3g} Hz, and touches closer than half a "
        f"period of it are one blow: {why}; [verification] f_max sets another"
    ]


def carried(model: Model, nodes_idx: IntArray) -> float:
    """Hz, of waves of compression that the mesh of the solids at some nodes carries; inf where there are none.

    c / (10 h) with c^2 = E_c / rho of confined compression and h the least way from node to node across an element: the
    median of the elements of each block that have one of the nodes and are not held, the lowest of all blocks.
    """
    touched, held = np.zeros(model.nodes.count, dtype=bool), np.zeros(model.nodes.count, dtype=bool)
    touched[nodes_idx], held[held_nodes(model.fixed)] = True, True
    found = [math.inf]
    for block in model.blocks:
        if block.kind not in FACES or not isinstance(block.section, SolidSection):
            continue
        nodes = block.nodes_idx[touched[block.nodes_idx].any(axis=1) & ~held[block.nodes_idx].all(axis=1)]
        material = block.section.material
        if nodes.size and material.density > 0.0:
            c = math.sqrt(confined_modulus(material) / material.density)
            found.append(c / (PER_WAVE * float(np.median(_spacing(model.nodes.coords, block.kind, nodes)))))
    return min(found)


def _spacing(coords: FloatArray, kind: str, nodes: IntArray) -> FloatArray:
    """(n,) length: the least height of elements, from node to node."""
    x, face = coords[faces_of(kind, nodes)], face_numbers(kind)
    largest = (facet_areas(x) @ (face[:, None] == np.arange(1, face.max() + 1))).max(axis=1)
    middle = face.size > np.unique(face).size
    return np.abs(volumes(x)) / np.maximum(largest, 1e-300) / (2.0 if middle else 1.0)
