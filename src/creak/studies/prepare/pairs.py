"""[contact.NAME] tables -> contact pairs; tables of clearances."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np

from creak.arrays import IntArray
from creak.contact.facets import nodes_of
from creak.contact.pair import ContactPair
from creak.errors import InputError, suggest
from creak.model.contact_law import ContactLaw, Coulomb
from creak.model.mesh import Model
from creak.studies.design.named_nodes import node_labels
from creak.studies.file.contact_tables import ContactTable, FrictionTable
from creak.studies.file.reader import Study
from creak.studies.file.tables import read_rows

STIFFNESS = {"auto": None, "hard": math.inf}


def contact_pair(model: Model, study: Study, name: str) -> ContactPair:
    """What the study says of one contact, with its table of clearances read.

    Raises
    ------
    InputError : an unknown surface or node; a table that cannot be used; a stiffness beside an overclosure curve.
    """
    t = study.config.contact[name]
    return ContactPair(
        name,
        t.secondary,
        t.main,
        t.method,
        _clearance(model, study, name),
        t.normal,
        t.per_area,
        contact_law(t, study.where("contact", name)),
        press_fit=any(s.press_fit for s in study.config.static),
    )


def contact_law(table: ContactTable, where: str) -> ContactLaw:
    """The law of a contact table.

    Raises
    ------
    InputError : numbers that are no law; a stiffness beside an overclosure curve.
    """
    mu = table.friction
    return ContactLaw(
        STIFFNESS[table.stiffness] if isinstance(table.stiffness, str) else table.stiffness,
        None if table.overclosure is None else np.array(table.overclosure, dtype=np.float64).reshape(-1, 2),
        table.damping,
        Coulomb(mu.static, mu.kinetic, mu.decay) if isinstance(mu, FrictionTable) else Coulomb(mu, mu),
        where=where,
    )


def _clearance(model: Model, study: Study, name: str) -> float | dict[int, float] | None:
    t = study.config.contact[name]
    if not isinstance(t.clearance, str):
        return t.clearance
    rows = nodes_of(model, t.secondary, where=f"[contact.{name}] secondary").rows
    where = study.where("contact", name, "clearance")
    return read_clearances(study.sibling(t.clearance), model, rows, t.secondary, where)


def read_clearances(path: Path, model: Model, nodes: IntArray, surface: str, where: str) -> dict[int, float]:
    """Clearances by node row, from a CSV file with the header node,clearance (further columns are not used).

    Parameters
    ----------
    nodes : rows of the nodes of the secondary surface; in decks with instances the label alone will do where it is
        unique among them.

    Raises
    ------
    InputError : no such file, wrong header, no rows; a row without node, with an unknown node, with one that is not
        on the surface or was there before, or with a clearance that is no finite number.
    """
    rows = read_rows(path, where, "table of clearances", ["node", "clearance"])
    known = node_labels(model, nodes)
    result: dict[int, float] = {}
    for line, row in rows:
        node, value = _node(row, f"{path}:{line}", known, model, surface), _number(row, f"{path}:{line}")
        if node in result:
            raise InputError(
                f"node {row[0].strip()} has a second row",
                where=f"{path}:{line}",
                expected="one row for each node",
                fix="Remove one of them.",
            )
        result[node] = value
    if not result:
        raise InputError("the table has no rows", where=path, expected="node,clearance lines", fix="Add them.")
    return result


def _node(row: list[str], where: str, known: dict[str, int], model: Model, surface: str) -> int:
    label = row[0].strip().upper()
    if not label:
        raise InputError("a row without a node", where=where, expected="node,clearance", fix="Name the node.")
    if label not in known:
        exists = label in {str(i) for i in model.nodes.ids.tolist()} or "." in label
        what = f"node {row[0].strip()} is not on {surface!r}" if exists else f"unknown node {row[0].strip()}"
        raise InputError(
            what,
            where=where,
            expected=f"a node of the secondary surface {surface!r}",
            fix=suggest(label, known) if len(known) < 10_000 else "Correct the label.",
        )
    return known[label]


def _number(row: list[str], where: str) -> float:
    text = row[1].strip() if len(row) > 1 else ""
    try:
        value = float(text)
    except ValueError:
        value = math.nan
    if not math.isfinite(value):
        raise InputError(
            f"the clearance of node {row[0].strip()} is {text!r}",
            where=where,
            expected="a finite number",
            fix="Repair the row, or remove it to keep the geometric gap.",
        )
    return value
