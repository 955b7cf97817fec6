"""What parts meet besides one another: forces, connectors and contacts, and what is watched of their motion."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from creak.arrays import IntArray
from creak.contact.gap_operator import GapOperator
from creak.model.dofs import node_dofs
from creak.model.mesh import Model
from creak.studies.prepare.elines import Elines
from creak.studies.prepare.watched import watched_labels


@dataclass(frozen=True)
class Watch:
    """What is watched of the motion."""

    pairs: IntArray
    """(n_pair, 2) node rows: main, secondary."""
    nodes: IntArray
    """Node rows whose motion is kept."""
    lines: Elines
    """Points between parts whose relative motion is looked at."""


@dataclass(frozen=True)
class Exterior:
    """Where something outside of a part acts on it or looks at it; links, supports and superelements are the
    structure's."""

    forces: tuple[IntArray, ...]
    """Of each force, the physical dofs that it acts on."""
    connectors: IntArray
    """Those of the connectors' channels."""
    contacts: GapOperator
    """Channels of the contact pairs, before the pre-check."""
    watch: Watch

    def seen(self, model: Model) -> IntArray:
        """Physical dofs that a run writes down or looks at, whatever channels are kept."""
        every = [node_dofs(self.watch.nodes), watched_labels(model, self.contacts), self.watch.lines.points.labels]
        return np.unique(np.concatenate(every)).astype(np.int64)
