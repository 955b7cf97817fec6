"""Keyword blocks -> scopes: the flat model or assembly, and one scope per part instance."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field, replace

import numpy as np

from creak.arrays import FloatArray
from creak.errors import InputError, suggest
from creak.formats.abaqus.text.fields import floats
from creak.formats.abaqus.text.keywords import canonical, meaning
from creak.formats.abaqus.text.lexer import Block, squeeze
from creak.model.mesh import Unread


@dataclass
class Scope:
    """The blocks that share one numbering of nodes and elements."""

    name: str
    """Instance name, upper case; "" for a flat deck and for the assembly."""
    blocks: list[Block] = field(default_factory=list)
    part: str = ""
    rotation: FloatArray = field(default_factory=lambda: np.eye(3))
    origin: FloatArray = field(default_factory=lambda: np.zeros(3))
    """x_global = rotation x_part + origin."""

    @property
    def rotated(self) -> bool:
        return not np.array_equal(self.rotation, np.eye(3))


@dataclass
class StepBlocks:
    """*STEP and what stands between it and *END STEP."""

    block: Block
    blocks: list[Block] = field(default_factory=list)


@dataclass
class Outline:
    """A deck sorted into scopes, instances first, the flat or assembly scope last."""

    scopes: list[Scope]
    assembly: str = ""
    step_boundaries: list[Block] = field(default_factory=list)
    """*BOUNDARY blocks of the first step."""
    unread: dict[Unread, None] = field(default_factory=dict)
    """In order; a dict, for a deck may hold thousands."""
    steps: list[StepBlocks] = field(default_factory=list)
    set_aside: list[Block] = field(default_factory=list)
    """Blocks of the model data that only a deck's own step uses: contact, amplitudes; and those never used."""

    @property
    def instances(self) -> list[str]:
        return [s.name for s in self.scopes if s.name]

    def blocks(self, *names: str) -> Iterator[tuple[Scope, Block]]:
        """Blocks of the given keywords, scope by scope, in deck order."""
        for scope in self.scopes:
            for block in scope.blocks:
                if block.name in names:
                    yield scope, block

    def note(
        self,
        block: Block,
        why: str,
        *,
        changes: bool,
        what: str = "",
        damps: bool = False,
        used: bool = False,
        share: float = 0.0,
        share_of: str = "",
    ) -> None:
        """List something that creak does not use, or what it made of it, once however often it is looked at."""
        entry = Unread(what or f"*{block.name}", block.where, changes, why, damps, used, share, share_of)
        self.unread.setdefault(entry)


def outline(blocks: Iterable[Block]) -> Outline:
    """Sort the blocks of a deck into scopes.

    Raises
    ------
    InputError : a part, instance or step is not closed, an instance of an unknown part, an option
        (*ELASTIC) without the keyword it belongs to (*MATERIAL).
    """
    sorter = _Sorter()
    for block in blocks:
        block.name = canonical(block.name)
        sorter.take(block)
    return sorter.finish()


class _Sorter:
    def __init__(self) -> None:
        self.root = Scope("")
        self.result = Outline([])
        self.parts: dict[str, Scope] = {}
        self.part_blocks: dict[str, Block] = {}
        self.current = self.root
        self.open: Block | None = None
        self.step: Block | None = None
        self.step_names: list[str] = []
        self.n_steps = 0
        self.parent: Block | None = None

    def take(self, block: Block) -> None:
        handler = _STRUCTURE.get(block.name)
        if self.step is not None and block.name != "END STEP":
            self._in_step(block)
        elif handler is not None:
            handler(self, block)
        else:
            self._ordinary(block)

    def finish(self) -> Outline:
        if self.open is not None:
            raise _not_closed(self.open)
        if self.step is not None:
            raise _not_closed(self.step)
        self._list_unplaced()
        self._leave_out_display_bodies()
        self.result.scopes.append(self.root)
        if self.parts and len(self.result.scopes) == 1 and not any(b.name == "NODE" for b in self.root.blocks):
            raise InputError(
                f"the deck has parts ({', '.join(self.parts)}) but no *INSTANCE",
                where="",
                fix="Place the parts with *INSTANCE lines in an *ASSEMBLY.",
            )
        return self.result

    def _leave_out_display_bodies(self) -> None:
        """Instances of *DISPLAY BODY are not part of the analysis; nor are sets of them."""
        drawn: set[str] = set()
        for block in self.root.blocks:
            if block.name == "DISPLAY BODY":
                drawn.add(block.need("INSTANCE").upper())
                self.result.note(block, "it draws only: the instance is left out", changes=False)
        self.result.scopes = [s for s in self.result.scopes if s.name not in drawn]
        self.root.blocks = [b for b in self.root.blocks if b.get("INSTANCE").upper() not in drawn or not drawn]

    def _list_unplaced(self) -> None:
        placed = {scope.part for scope in self.result.scopes}
        for name, block in self.part_blocks.items():
            if name not in placed:
                self.result.note(block, "the part has no *INSTANCE", changes=False, what=f"*PART, NAME={name}")

    def _ordinary(self, block: Block) -> None:
        known = meaning(block.name)
        if block.name == "SURFACE INTERACTION":
            self.parent = None
        if block.name in OF_GAPS and self.parent is not None and self.parent.name == "GAP":
            self.parent.options.append(block)
            return
        if known.role != "read":
            self.result.note(block, known.why, changes=known.changes_answer)
            self.result.set_aside.append(block)
            return
        self._list_params(block, known.params)
        if known.owners:
            owners = " or *".join(known.owners)
            if self.parent is None or self.parent.name not in known.owners:
                raise block.error(
                    f"*{block.name} without *{owners}",
                    expected=f"*{owners} before it",
                    fix=f"Put *{block.name} after its *{owners}.",
                )
            self.parent.options.append(block)
            return
        self.parent = block
        self.current.blocks.append(block)

    def _list_params(self, block: Block, known: frozenset[str]) -> None:
        for param in block.params:
            if param not in known and param != "INPUT":
                self.result.note(
                    block, "creak does not read this parameter", changes=True, what=f"*{block.name}, {param}"
                )

    def _in_step(self, block: Block) -> None:
        self.step_names.append(f"*{block.name}")
        self.result.steps[-1].blocks.append(block)
        if block.name == "BOUNDARY" and self.n_steps == 1:
            self.result.step_boundaries.append(block)

    def begin_step(self, block: Block) -> None:
        block = replace(block, params={_spelled_out(name): value for name, value in block.params.items()})
        self.step, self.step_names, self.n_steps = block, [], self.n_steps + 1
        self.result.steps.append(StepBlocks(block))

    def end_step(self, block: Block) -> None:
        if self.step is None:
            raise _not_open(block)
        inside = ", ".join(dict.fromkeys(self.step_names)) or "nothing"
        zero = "; its zero-valued *BOUNDARY lines are read" if self.result.step_boundaries else ""
        extra = zero if self.n_steps == 1 else ""
        if any(_is_gravity(block) for block in self.result.steps[-1].blocks):
            extra += "; its gravity acts in a study only as the study's [[static]] gravity"
        self.result.note(self.step, f"the study file defines the step (it holds {inside}){extra}", changes=False)
        self.step = None

    def begin_part(self, block: Block) -> None:
        if self.open is not None:
            raise _not_closed(self.open)
        name = block.need("NAME").upper()
        if name in self.parts:
            raise block.error(f"part {name!r} is defined twice", fix="Rename one of them.")
        self.open, self.parent = block, None
        self.current = self.parts[name] = Scope(name)
        self.part_blocks[name] = block

    def begin_instance(self, block: Block) -> None:
        if self.open is not None:
            raise _not_closed(self.open)
        name, part = block.need("NAME").upper(), block.need("PART").upper()
        if part not in self.parts:
            raise block.error(f"instance {name!r} of unknown part {part!r}", fix=suggest(part, self.parts))
        if any(s.name == name for s in self.result.scopes):
            raise block.error(f"instance {name!r} is defined twice", fix="Rename one of them.")
        rotation, origin = placement(block)
        self.open, self.parent = block, None
        self.current = Scope(name, list(self.parts[part].blocks), part, rotation, origin)
        self.result.scopes.append(self.current)

    def end_scope(self, block: Block) -> None:
        if self.open is None or block.name != f"END {self.open.name}":
            raise _not_open(block)
        self.open, self.parent, self.current = None, None, self.root

    def assembly(self, block: Block) -> None:
        if self.open is not None:
            raise _not_closed(self.open)
        self.parent = None
        self.result.assembly = self.result.assembly or block.get("NAME").upper()


OF_GAPS = ("SURFACE BEHAVIOR", "FRICTION", "CONTACT DAMPING")
"""Options of a *GAP where they stand after one; elsewhere of a *SURFACE INTERACTION."""

_STRUCTURE = {
    "STEP": _Sorter.begin_step,
    "END STEP": _Sorter.end_step,
    "PART": _Sorter.begin_part,
    "END PART": _Sorter.end_scope,
    "INSTANCE": _Sorter.begin_instance,
    "END INSTANCE": _Sorter.end_scope,
    "ASSEMBLY": _Sorter.assembly,
    "END ASSEMBLY": _Sorter.assembly,
}


def placement(block: Block) -> tuple[FloatArray, FloatArray]:
    """Rotation (3, 3) and origin (3,) of an *INSTANCE: first translated, then rotated.

    First data line: translation. Second: two points of the axis and the angle in degrees.
    x_global = R (x + t - a) + a, R from Rodrigues' formula.

    Raises
    ------
    InputError : the two points of the axis coincide.
    """
    rows = list(block.rows(blanks=True))
    if not rows:
        return np.eye(3), np.zeros(3)
    shift = np.array(floats(*rows[0], "translation", 3))
    if len(rows) == 1:
        return np.eye(3), shift
    fields, where = rows[1]
    numbers = floats(fields, where, "rotation", 7)
    start, axis = np.array(numbers[:3]), np.array(numbers[3:6]) - np.array(numbers[:3])
    length = float(np.linalg.norm(axis))
    if not 0.0 < length < math.inf:
        raise InputError(
            "the two points of the rotation axis coincide",
            expected="ax, ay, az, bx, by, bz, angle",
            where=where,
            fix="Give two different points.",
        )
    x, y, z = axis / length
    cross = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    angle = math.radians(numbers[6])
    rotation = np.eye(3) + math.sin(angle) * cross + (1.0 - math.cos(angle)) * (cross @ cross)
    return rotation, rotation @ (shift - start) + start


def _not_closed(block: Block) -> InputError:
    return block.error(
        f"*{block.name} {block.get('NAME')}".rstrip() + " is not closed",
        expected=f"*END {block.name}",
        fix=f"Add *END {block.name} after its last line.",
    )


def _not_open(block: Block) -> InputError:
    begin = block.name.removeprefix("END ")
    return block.error(
        f"*{block.name} without *{begin}", expected=f"*{begin} before it", fix=f"Add *{begin} or delete this line."
    )


_OF_STEP = ("NAME", "NLGEOM", "INC", "AMPLITUDE", "UNSYMM", "EXTRAPOLATION", "CONVERTSDI", "SOLVER", "PERTURBATION")
SHORTEST = 3
"""Letters that an abbreviation has at least."""


def _spelled_out(name: str) -> str:
    """A parameter of *STEP in full, where what is written begins one alone (NLGEO)."""
    whole = [known for known in _OF_STEP if known.startswith(name)]
    return whole[0] if len(whole) == 1 and len(name) >= SHORTEST else name


def _is_gravity(block: Block) -> bool:
    """A *DLOAD of type GRAV."""
    return block.name == "DLOAD" and any("GRAV" in (x.strip().upper() for x in fields) for fields, _ in block.rows())


def list_params(deck: Outline, block: Block, known: str) -> None:
    """List every parameter that is not in `known` (names with commas between them) as one that changes the answer."""
    names = {squeeze(name) for name in known.split(",")}
    for param in block.params:
        if param not in names:
            deck.note(block, "creak does not read this parameter", changes=True, what=f"*{block.name}, {param}")
