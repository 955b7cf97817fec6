"""What a page draws of model and motion: made from a result, stored in results.h5, read back."""

from __future__ import annotations

from dataclasses import dataclass

import h5py
import numpy as np

from creak.arrays import IntArray
from creak.formats.stored.tree import read_tree, write_tree
from creak.report.figures.motions import ModeShapes, Motions, mode_shapes, recorded_motions
from creak.report.figures.surface import Surface, surface_of
from creak.studies.findings.tree import Findings
from creak.studies.models.reference import ReferenceModel
from creak.studies.run.one_run import Run

ANIMATION_BYTES = 5_000_000
"""What the motion around events may take of a report."""


@dataclass(frozen=True)
class Drawn:
    """The model as a page shows it, and how it moves."""

    surface: Surface | None
    """None: nothing can be drawn."""
    motions: Motions
    mode_shapes: ModeShapes | None
    """Of the unreduced model; None: there are none to draw."""


def drawn_of(
    run: Run | None, reference: ReferenceModel, findings: Findings, animation_bytes: int = ANIMATION_BYTES
) -> Drawn:
    """The surface of the model, and motion on it.

    Parameters
    ----------
    animation_bytes : what the motion around the hardest events may take of the report.
    """
    surface, n_node = _surface(findings), findings.setup.model.nodes.count
    motions = recorded_motions(run, n_node, surface, animation_bytes)
    shapes = mode_shapes(reference.system, reference.modes, n_node, surface) if animation_bytes > 0 else None
    return Drawn(surface, motions, shapes)


def _surface(findings: Findings) -> Surface | None:
    """What is drawn of the model, with all marks; None where that has no extent."""
    setup = findings.setup
    marked: list[IntArray] = [findings.gaps.nodes_idx, setup.held, setup.driven]
    needed = np.unique(np.concatenate([*marked, *(p.nodes_idx for p in findings.places)]))
    surface = surface_of(setup.model, needed)
    if surface is None or float(np.ptp(setup.model.nodes.coords[surface.nodes_idx], axis=0).max()) == 0.0:
        return None
    return surface


def write_drawn(file: h5py.File, drawn: Drawn) -> None:
    """Add the group `drawn` to a results.h5."""
    write_tree(file.create_group("drawn"), drawn)


def read_drawn(file: h5py.File) -> Drawn:
    """What `write_drawn` wrote.

    Raises
    ------
    KeyError, TypeError, ValueError : the file does not hold it.
    """
    return read_tree(Drawn, file["drawn"])
