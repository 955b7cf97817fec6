"""A first study for a deck: contacts from what lies near, excitation and outputs from its sets and supports."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from creak.arrays import BoolArray, IntArray
from creak.contact.pair import Keep
from creak.model.constraints import supported_nodes, tied_nodes
from creak.model.materials import Discrete
from creak.model.mesh import Model
from creak.model.steps import Stop
from creak.progress import Progress
from creak.studies.file.table import DOFS
from creak.studies.prepare.deck_contact import contact_flaw
from creak.studies.prepare.unit_check import OTHERS, SYSTEMS, UnitSystem, across, guessed_units
from creak.studies.propose.contacts import Contact, Tools, find_contacts
from creak.studies.propose.deck_pairs import deck_pairs, general_law, kept_apart
from creak.studies.propose.joints import by_bodies, joints_of
from creak.studies.propose.proximity import closest_parts, near_beams, near_parts, skins_of
from creak.studies.warned import Warned
from creak.words import listed

REACH = 0.01
"""Share of the model's size up to which surfaces count as near unless told otherwise."""
FAR = 2.0
"""Times that distance: what is farther than the distance and nearer than this is asked about."""
MOST_NODES = 100
"""Sets with more nodes are proposed neither for excitation nor for output."""
MOST_SHAKEN = 1000
"""Supports of more nodes are shaken only where one set has them: the study would have to name them all."""
OTHER_SETS = 8
"""Most sets named beside the one proposed for excitation."""
PICTURES = 12
"""Most questions that are drawn."""
OUTPUTS = 3
"""Most node sets proposed for output."""


@dataclass(frozen=True)
class Drive:
    """Nodes to excite."""

    node_set: str
    dof: str
    kind: str
    why: str
    others: tuple[str, ...] = ()
    """Node sets that would do as well."""
    freed: bool = False
    """The deck holds the nodes along dof: the study has to let them go."""
    labels: tuple[str, ...] = ()
    """Nodes, where the study itself has to name them."""


@dataclass(frozen=True)
class Proposal:
    """What `creak new` found in a deck."""

    units: UnitSystem
    guess: str
    """How sure the units are, in words."""
    distance: float
    """Up to which surfaces were looked for, length."""
    contacts: tuple[Contact, ...]
    closest: tuple[str, str, float] | None
    """The nearest two parts where no surfaces are near."""
    held: dict[str, str]
    """Node set -> its held dofs; sets that hold nothing are left out."""
    n_held: int
    """Nodes that the deck holds, in sets or not."""
    drive: Drive | None
    undriven: str
    """Why nothing is proposed to move or push; empty where something is."""
    pairs: str | tuple[str, str] | None
    """For [verification]."""
    outputs: tuple[str, ...]
    joints: tuple[str, ...]
    """What joins parts in the deck, a line each."""
    beams: tuple[str, ...] = ()
    """Parts of beams that are near others, a sentence each."""
    flaws: tuple[str, ...] = ()
    """What of the deck's own contact is not taken over, a sentence each."""
    apart: tuple[str, ...] = ()
    """What is near but kept out of contact by the deck, a sentence each."""
    stops: tuple[Stop, ...] = ()
    """Gaps of the deck between pairs of nodes."""

    @property
    def untouched(self) -> str:
        """Why nothing of the study could touch, and what to fill in; empty where something can."""
        if self.stops or any(c.live for c in self.contacts):
            return ""
        fill = "fill in a [contact.NAME] or a [[connector]]"
        asked = [c.name for c in self.contacts if not c.problem]
        if asked:
            return (
                f"no contact: all are questions that the study asks ({listed(asked)}); uncomment those that can touch"
            )
        if self.contacts:
            why = "; ".join(f"{c.name} is left out, because {c.problem}" for c in self.contacts)
            return f"no contact: {why}; {fill}"
        if self.apart:
            return f"no contact: {listed(self.apart)}; {fill}"
        unit = self.units.words[0]
        return f"no contact: no surfaces of two parts come within {self.distance:.3g} {unit} of each other; {fill}"


def propose(
    model: Model, distance: float | None, units: str | None, progress: Progress, keep: Keep | None = None
) -> Proposal:
    """Look at a deck for what a study needs.

    What lies between the distance and `FAR` times it is asked about, unless the distance was told.

    Parameters
    ----------
    distance : between surfaces that count as near, in the deck's unit of length; None: `REACH` of its size.
    units : of the deck; None: guessed from its materials and size.
    keep : as of `Tools`.
    """
    model = by_bodies(model)
    system, guess = _units(model, units)
    far = FAR * REACH * across(model) if distance is None else distance
    distance = REACH * across(model) if distance is None else distance
    progress("look for parts near each other", 0, 1)
    skins = skins_of(model)
    near, apart = kept_apart(model, near_parts(model, skins, distance, far))
    progress("look for parts near each other", 1, 1)
    tools = Tools(keep, system.words[0])
    own = deck_pairs(model, progress, tools)
    contacts, law = find_contacts(model, near, distance, progress, tools, own), general_law(model)
    contacts = tuple(c if c.deck else replace(c, law=law) for c in contacts)
    flaws = () if model.contact is None else model.contact.flaws
    held = held_dofs(model)
    drive = _drive(model, held, contacts)
    return Proposal(
        units=system,
        guess=guess,
        distance=distance,
        contacts=contacts,
        closest=None if contacts else closest_parts(model),
        held=_held_sets(model, held),
        n_held=int(supported_nodes(model.constraints, model.fixed).size),
        drive=drive,
        undriven="" if drive is not None else _undriven(model, held),
        pairs=_pairs(model),
        outputs=_outputs(model),
        joints=joints_of(model),
        beams=tuple(Warned(said) for said in near_beams(model, skins, distance, system.words[0])),
        flaws=tuple(contact_flaw(said) for said in flaws),
        apart=tuple(apart),
        stops=model.stops,
    )


def with_files(found: Proposal, stem: str) -> Proposal:
    """The first questions each with a picture, `STEM_question_1.png`; clearances by node with a table."""
    asked = [c.name for c in found.contacts if c.question][:PICTURES]
    files = {name: f"{stem}_question_{k}.png" for k, name in enumerate(asked, start=1)}
    contacts = (replace(c, picture=files.get(c.name, "")) for c in found.contacts)
    tables = (f"{stem}_{c.name}.csv" if isinstance(c.clearance, Mapping) else "" for c in found.contacts)
    return replace(found, contacts=tuple(replace(c, table=t) for c, t in zip(contacts, tables, strict=True)))


def _units(model: Model, units: str | None) -> tuple[UnitSystem, str]:
    if units is not None:
        return SYSTEMS[units], "as told by --units"
    fits = guessed_units(model)
    if fits and fits[0].name in SYSTEMS:
        others = [s.name for s in fits[1:]]
        also = f"; {', '.join(others)} would fit as well" if others else ""
        return fits[0], f"guessed: materials and size fit{also}"
    if fits:
        return SYSTEMS["mm-t-s"], f"the deck seems to be in {fits[0].name}, which creak has no labels for: convert it"
    tried = ", ".join([*SYSTEMS, *(s.name for s in OTHERS)])
    return SYSTEMS["mm-t-s"], f"not known: materials and size fit none of {tried}"


def held_dofs(model: Model) -> BoolArray:
    """(n_node, 6) which dofs the deck holds at zero."""
    held = np.zeros((model.nodes.count, 6), dtype=bool)
    for fixed in model.fixed:
        held[np.ix_(fixed.nodes_idx, np.array(fixed.dofs, dtype=np.int64) - 1)] = True
    return held


def _named_sets(model: Model) -> dict[str, IntArray]:
    """Node sets of the user's, not too large."""
    of_stops = {name for stop in model.stops for name in stop.node_sets}
    return {
        name: rows
        for name, rows in model.node_sets.items()
        if 0 < rows.size <= MOST_NODES and not name.startswith("_") and name not in of_stops
    }


def _held_sets(model: Model, held: BoolArray) -> dict[str, str]:
    found = {name: _all_held(held, rows) for name, rows in _named_sets(model).items()}
    return {name: dofs for name, dofs in found.items() if dofs}


def _all_held(held: BoolArray, rows: IntArray) -> str:
    """`x y rz`: dofs that are held at all of the nodes."""
    at_all = np.all(held[rows], axis=0)
    return " ".join(d for k, d in enumerate(DOFS) if at_all[k])


def _drive(model: Model, held: BoolArray, contacts: Sequence[Contact]) -> Drive | None:
    """Where the road comes in: nodes that are held all but in one direction; else all supports together; else a force
    on nodes that are free.

    What stands on springs is not held in the direction of these: the ground that they stand on is moved. Of sets that
    would do as well the one with the fewest nodes that may touch, for contact cannot move driven nodes.
    """
    following, structural, sprung = _following(model), _with_elements(model), _on_springs(model, held)
    touching = np.array(sorted({row for c in contacts for row in c.nodes}), dtype=np.int64)
    found: list[tuple[tuple[int, int, int], Drive]] = []
    for name, rows in _named_sets(model).items():
        if following[rows].any() or not structural[rows].all():
            continue
        free = [d for d in (2, 1, 0) if not held[rows, d].any()]
        if not free:
            continue
        dof, dofs = DOFS[free[0]], _all_held(held, rows)
        if dofs and sprung[rows, free[0]].any():
            continue
        if dofs:
            drive = Drive(name, dof, "displacement", f"the deck holds {dofs} of it and leaves {dof} free")
        else:
            drive = Drive(name, dof, "force", "the deck holds nothing of it")
        found.append(((len(dofs.split()), -int(np.isin(rows, touching).sum()), -rows.size), drive))
    best = max(found, key=lambda f: f[0], default=None)
    shaken = None if best is not None and best[1].kind != "force" else _shaken(model, held, contacts)
    if best is None:
        return shaken
    if shaken is not None:
        return replace(shaken, others=(best[1].node_set,))
    others = [d.node_set for rank, d in found if rank[0] == best[0][0] and d is not best[1]]
    return replace(best[1], others=tuple(others[:OTHER_SETS]))


def _shaken(model: Model, held: BoolArray, contacts: Sequence[Contact]) -> Drive | None:
    """All that the deck holds, moved together along the axis nearest to the normal of the first contact, or z.

    Contacts that are asked about come after those that are there.
    """
    axis = next((int(np.argmax(np.abs(c.toward))) for c in contacts if not c.problem), 2)
    rows = np.flatnonzero(held[:, axis] & _with_elements(model) & ~_following(model))
    if not rows.size:
        return None
    dof = DOFS[axis]
    why = f"the deck holds {dof} of it: all that is held is let go along {dof} and moved as one, as on a shaker"
    own = [n for n, s in model.node_sets.items() if not n.startswith("_") and np.array_equal(np.unique(s), rows)]
    if own:
        return Drive(min(own), dof, "displacement", why, freed=True)
    if rows.size > MOST_SHAKEN:
        return None
    name = "SHAKEN"
    while name in model.node_sets:
        name += "_"
    return Drive(name, dof, "displacement", why, freed=True, labels=tuple(model.nodes.label(int(r)) for r in rows))


def _undriven(model: Model, held: BoolArray) -> str:
    """Why no node set can be excited, and what would help."""
    known = _named_sets(model)
    if not known:
        return (
            f"the deck has no node set of at most {MOST_NODES} nodes to move or push; name some: *NSET of Abaqus, SET1 "
            "or SET3 of Nastran"
        )
    if all(held[rows, :3].all() for rows in known.values()):
        return (
            f"the deck holds x, y and z of all its small node sets ({', '.join(list(known)[:OTHER_SETS])}); take one "
            "direction out of the support that moves, or name nodes to push"
        )
    return "all small node sets follow other nodes, or have held and free nodes mixed; name nodes that carry elements"


def _following(model: Model) -> BoolArray:
    """(n_node,) nodes whose motion follows from that of others: they cannot be driven."""
    found = np.zeros(model.nodes.count, dtype=bool)
    for c in model.constraints:
        found[c.dependents] = True
    return found


def _on_springs(model: Model, held: BoolArray) -> BoolArray:
    """(n_node, 3) translations of nodes that a spring, dashpot, bushing or matrix ties to a node that is held there."""
    found = np.zeros((model.nodes.count, 3), dtype=bool)
    for block in model.blocks:
        if isinstance(block.section, Discrete) and block.nodes_idx.shape[1] == 2:
            a, b = block.nodes_idx.T
            for one, other in ((a, b), (b, a)):
                np.logical_or.at(found, one, held[other, :3])
    return found


def _with_elements(model: Model) -> BoolArray:
    """(n_node,) nodes of an element or of a link."""
    found = tied_nodes(model.constraints, model.nodes.count)
    for block in model.blocks:
        found[block.nodes_idx] = True
    return found


def _pairs(model: Model) -> str | tuple[str, str] | None:
    """Sets NAME_MAIN and NAME_SECONDARY, or a set whose nodes belong to two parts in turn."""
    names = sorted(n for n in model.node_sets if n.endswith("_MAIN") and f"{n[:-5]}_SECONDARY" in model.node_sets)
    for name in sorted(names, key=lambda n: -model.node_sets[n].size):
        base = name[:-5]
        if model.node_sets[name].size == model.node_sets[f"{base}_SECONDARY"].size and base not in model.node_sets:
            return base
    part = np.full(model.nodes.count, -1, dtype=np.int64)
    for i, p in enumerate(model.parts):
        part[p.nodes_idx] = i
    for name, rows in _named_sets(model).items():
        sides = part[rows]
        if (
            rows.size % 2 == 0
            and np.unique(sides[::2]).size == np.unique(sides[1::2]).size == 1
            and (sides[0] != sides[1] and sides.min() >= 0)
        ):
            return name
    return None


def _outputs(model: Model) -> tuple[str, ...]:
    """Small sets of nodes that carry elements and follow nothing, the smallest first; of equal ones the first."""
    following, structural = _following(model), _with_elements(model)
    good = sorted(
        (rows.size, name, tuple(rows.tolist()))
        for name, rows in _named_sets(model).items()
        if structural[rows].all() and not following[rows].any()
    )
    first = dict[tuple[int, ...], str]()
    for _, name, nodes in good:
        first.setdefault(nodes, name)
    return tuple(first.values())[:OUTPUTS]
