"""Contacts, connectors and clips of a study that stay closed, as springs of its linear structure."""

from __future__ import annotations

from collections import Counter
from collections.abc import Collection
from dataclasses import replace
from pathlib import Path

import numpy as np
import scipy.sparse as sp

from creak.assembly.system import System
from creak.contact.gap_operator import GapOperator, join
from creak.contact.play import play_channels
from creak.errors import InputError, suggest
from creak.model.mesh import Model
from creak.studies.design.clips import with_clips
from creak.studies.file.case import Touching
from creak.studies.prepare.channels import contact_channels
from creak.studies.prepare.pairs import plays_of


def closed_joints(touching: Touching, path: Path, model: Model, names: Collection[str]) -> GapOperator:
    """The channels of some contacts, connectors and clips.

    Parameters
    ----------
    path : of the study. model : as it has it. names : of contacts, and of connectors and clips as results tell them.

    Raises
    ------
    InputError : an unknown name, or one without a stiffness of its own ("hard", or a law by points).
    """
    plays = [*plays_of(touching), *with_clips(model, touching)[1]]
    known = [*touching.contacts, *(p.name for p, _ in plays)]
    for name in names:
        if name not in known:
            raise InputError(
                f"the study has no contact, connector or clip {name!r} that touches",
                where=path,
                fix=suggest(name, known),
            )
    chosen = replace(touching, contacts={n: t for n, t in touching.contacts.items() if n in names})
    own = [play_channels(model, p, where) for p, where in plays if p.name in names]
    gaps = join([contact_channels(model, chosen)[0], *own])
    soft = np.isfinite(gaps.stiffness) & (gaps.stiffness > 0.0)
    if gaps.curves is not None or not soft.all():
        name = gaps.group[0] if gaps.curves is not None else gaps.group[int((~soft).argmax())]
        raise InputError(
            f"{name} has no stiffness with which it could stay closed",
            where=path,
            expected='stiffness = NUMBER; not "hard", no law by points',
            fix="Give it one.",
        )
    return gaps


def with_closed(system: System, gaps: GapOperator) -> System:
    """The System with K + G' k G: channels that neither open nor slide far, along their normals alone.

    Of a play with two limits one side presses at a time: each counts half.
    """
    places = list(zip(gaps.group, gaps.nodes_idx.tolist(), strict=True))
    sides = Counter(places)
    k = gaps.stiffness / np.array([sides[place] for place in places])
    A = sp.csr_array(gaps.G @ system.rows(gaps.labels)[0])
    added = A.T @ (sp.diags_array(k) @ A)
    return replace(system, K=system.K + (added if sp.issparse(system.K) else added.toarray()))
