"""*CONTACT PAIR, *SURFACE INTERACTION with its options, *CLEARANCE."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import replace

from creak.errors import InputError, suggest
from creak.formats.abaqus.text.lexer import Block
from creak.formats.abaqus.text.names import qualified
from creak.formats.abaqus.text.numbers import floats, positive, to_float
from creak.formats.abaqus.text.outline import Outline, list_params
from creak.model.steps import DeckContact, Interaction, SurfacePair

OPTIONS = ("SURFACE BEHAVIOR", "FRICTION", "CONTACT DAMPING")
KEYWORDS = ("CONTACT PAIR", "SURFACE INTERACTION", "CLEARANCE", *OPTIONS)
EDGES = ("E1", "E2", "E3", "E4")
_METHODS = {"NODE TO SURFACE": "node-to-surface", "SURFACE TO SURFACE": "surface-to-surface"}
_PAIR = (
    "TYPE, INTERACTION, SMALL SLIDING, ADJUST, CPSET, MECHANICAL CONSTRAINT, HCRIT, EXTENSION ZONE, SMOOTH,"
    "SUPPLEMENTARY CONSTRAINTS, TRACKING, WEIGHT"
)


def described_contact(deck: Outline, surfaces: Iterable[str]) -> DeckContact | None:
    """Contact pairs, their interactions and that of general contact, for a study of the deck; nothing is listed of it.

    What is wrong with them stops nothing, but is told as a flaw.
    """
    deck, known, flaws = replace(deck, unread={}), set(surfaces), list[str]()
    interactions = read_interactions(deck, deck.set_aside, flaws)
    found, sets, everywhere = dict[tuple[str, str], SurfacePair](), dict[str, list[int]](), ""
    for block in (*deck.set_aside, *(b for step in deck.steps for b in step.blocks)):
        if block.name == "CONTACT PAIR":
            with _noted(flaws):
                for p in _pairs(deck, block, interactions, known):
                    found[p.secondary, p.main] = p
                    sets.setdefault(block.get("CPSET").upper(), []).append([*found].index((p.secondary, p.main)))
        elif block.name == "CONTACT PROPERTY ASSIGNMENT":
            rows = [[*fields, "", ""][:3] for fields, _ in block.rows(blanks=True)]
            everywhere = next((r[2].upper() for r in rows if not (r[0] or r[1])), everywhere)
    pairs, everywhere = list(found.values()), everywhere if everywhere in interactions else ""
    for block in deck.set_aside:
        if block.name == "CLEARANCE":
            with _noted(flaws):
                _clear(deck, block, pairs, sets, known)
    return DeckContact(interactions, tuple(pairs), everywhere, tuple(flaws)) if pairs or everywhere or flaws else None


@contextmanager
def _noted(flaws: list[str] | None) -> Iterator[None]:
    """What is wrong inside, as one more flaw; an error where nobody takes flaws."""
    try:
        yield
    except InputError as error:
        if flaws is None:
            raise
        flaws.append(str(error))


def read_interactions(deck: Outline, blocks: Iterable[Block], flaws: list[str] | None = None) -> dict[str, Interaction]:
    """Interactions by name, upper case; options belong to the *SURFACE INTERACTION before them.

    Parameters
    ----------
    flaws : takes what is wrong with an option, which is left out then; None: that is an error.

    Raises
    ------
    InputError : an option without *SURFACE INTERACTION, a name used twice, or a law that creak does not have.
    """
    result: dict[str, Interaction] = {}
    name = ""
    for block in blocks:
        if block.name == "SURFACE INTERACTION":
            name = block.need("NAME").upper()
            if name in result:
                raise InputError(
                    f"surface interaction {name!r} is defined twice", where=block.where, fix="Rename one of them."
                )
            list_params(deck, block, "NAME, TRACKING THICKNESS, UNSYMM")
            result[name] = Interaction(name, where=block.where)
        elif block.name in _RULES:
            if not name:
                raise InputError(
                    f"*{block.name} without *SURFACE INTERACTION",
                    expected="*SURFACE INTERACTION before it",
                    where=block.where,
                    fix="Put it after its *SURFACE INTERACTION.",
                )
            with _noted(flaws):
                result[name] = _RULES[block.name](deck, block, result[name])
    return result


def read_pairs(
    deck: Outline, blocks: Sequence[Block], interactions: Mapping[str, Interaction], surfaces: Iterable[str]
) -> tuple[SurfacePair, ...]:
    """Contact pairs with their clearances.

    Raises
    ------
    InputError : unknown interaction or surface, a pair of one surface, an unknown TYPE, a clearance without pair.
    """
    known = set(surfaces)
    pairs: list[SurfacePair] = []
    sets: dict[str, list[int]] = {}
    for block in blocks:
        if block.name != "CONTACT PAIR":
            continue
        first = len(pairs)
        pairs += _pairs(deck, block, interactions, known)
        sets.setdefault(block.get("CPSET").upper(), []).extend(range(first, len(pairs)))
    for block in blocks:
        if block.name == "CLEARANCE":
            _clear(deck, block, pairs, sets, known)
    return tuple(pairs)


def _pairs(
    deck: Outline, block: Block, interactions: Mapping[str, Interaction], surfaces: set[str]
) -> list[SurfacePair]:
    name = block.need("INTERACTION").upper()
    if name not in interactions:
        raise InputError(f"unknown surface interaction {name!r}", where=block.where, fix=suggest(name, interactions))
    kind = block.option("TYPE", "NODE TO SURFACE")
    if kind not in _METHODS:
        raise InputError(
            f"*CONTACT PAIR has TYPE={kind}",
            expected=" or ".join(_METHODS),
            where=block.where,
            fix=suggest(kind, _METHODS),
        )
    list_params(deck, block, _PAIR)
    _check_adjust(deck, block)
    result = []
    for fields, where in block.rows():
        if len(fields) < 2:
            raise InputError(
                "*CONTACT PAIR names one surface",
                expected="secondary surface, main surface",
                where=where,
                fix="Name both; creak has no self-contact.",
            )
        secondary, main = (surface_name(deck, f, surfaces, where) for f in fields[:2])
        if secondary == main:
            raise InputError(
                f"surface {secondary!r} touches itself",
                expected="two surfaces",
                where=where,
                fix="creak has no self-contact.",
            )
        if any(fields[2:]):
            deck.note(block, "creak does not read the orientation of a contact pair", changes=False)
        result.append(SurfacePair(secondary, main, name, _METHODS[kind], block.has("SMALL SLIDING"), where=where))
    return result


def _check_adjust(deck: Outline, block: Block) -> None:
    """ADJUST=0 only removes overclosure, as creak does; a band or a set moves nodes that are apart."""
    given = block.option("ADJUST", "NO")
    if given == "NO":
        return
    try:
        moves = to_float(given, block.where, "ADJUST") != 0.0
    except InputError:
        moves = True
    if moves:
        deck.note(
            block,
            "creak does not move nodes onto the main surface; give the gap as *CLEARANCE",
            changes=True,
            what="*CONTACT PAIR, ADJUST",
        )


def surface_name(deck: Outline, name: str, surfaces: set[str], where: str) -> str:
    """The name of a surface as the model has it.

    Raises
    ------
    InputError : there is none of this name.
    """
    key = name.upper()
    if key not in surfaces and deck.assembly:
        key = key.removeprefix(f"{deck.assembly}.")
    if key not in surfaces:
        raise InputError(f"unknown surface {name!r}", where=where, fix=suggest(name, surfaces))
    return key


def list_node_areas(deck: Outline, pairs: Iterable[SurfacePair], interactions: Mapping[str, Interaction]) -> None:
    """List surfaces of nodes with areas of their own, and of edges, where a law of pressure would need an area."""
    pressed = {p.secondary for p in pairs if interactions[p.interaction].law in ("linear", "tabular")}
    for scope, block in deck.blocks("SURFACE"):
        key = qualified(scope.name, block.get("NAME"))
        if not pressed & {key, block.get("NAME").upper()}:
            continue
        if block.option("TYPE") != "NODE":
            if any(len(fields) > 1 and fields[1].upper() in EDGES for fields, _ in block.rows()):
                deck.note(block, "creak gives an edge no area", changes=True, what="*SURFACE of edges")
        elif any(len(fields) > 1 and to_float(fields[1], where, "area") != 1.0 for fields, where in block.rows()):
            deck.note(
                block,
                "creak gives every node of a node surface the area 1",
                changes=True,
                what="*SURFACE, TYPE=NODE with areas",
            )


def _clear(
    deck: Outline, block: Block, pairs: list[SurfacePair], sets: Mapping[str, Sequence[int]], surfaces: set[str]
) -> None:
    list_params(deck, block, "CPSET, VALUE, MASTER, SLAVE, MAIN, SECONDARY")
    if not block.has("VALUE"):
        if not block.has("TABULAR"):
            block.need("VALUE")
        return
    value = to_float(block.need("VALUE"), block.where, "clearance")
    if block.has("CPSET"):
        chosen = list(sets.get(block.get("CPSET").upper(), []))
    else:
        main = surface_name(deck, block.get("MAIN") or block.need("MASTER"), surfaces, block.where)
        other = surface_name(deck, block.get("SECONDARY") or block.need("SLAVE"), surfaces, block.where)
        chosen = [i for i, p in enumerate(pairs) if (p.secondary, p.main) == (other, main)]
    if not chosen:
        raise InputError(
            "*CLEARANCE for a contact pair that the deck does not have",
            where=block.where,
            expected="CPSET= or the surfaces of a *CONTACT PAIR",
            fix="Check the names.",
        )
    if value < 0.0:
        raise InputError(
            f"clearance of {value:g}", expected="zero or more", where=block.where, fix="creak has no press fits."
        )
    for i in chosen:
        pairs[i] = replace(pairs[i], clearance=value)


def _behavior(deck: Outline, block: Block, of: Interaction) -> Interaction:
    list_params(deck, block, "PRESSURE-OVERCLOSURE, PENALTY, DIRECT, AUGMENTED LAGRANGE")
    law = block.option("PRESSURE-OVERCLOSURE", "HARD")
    if law == "LINEAR":
        return _linear(deck, block, of)
    if law == "TABULAR":
        return replace(of, law="tabular", curve=_curve(block))
    if law == "TIED":  # its pairs are ties, see `tied_contact`
        return of
    if law != "HARD":
        raise InputError(
            f"PRESSURE-OVERCLOSURE={law}",
            expected="HARD, LINEAR or TABULAR",
            where=block.where,
            fix="Write the law as a table of pressure and overclosure.",
        )
    if block.has("PENALTY"):
        return _penalty(block, of)
    enforced = block.has("DIRECT") or block.has("AUGMENTED LAGRANGE")
    return replace(of, law="hard" if enforced else "default")


def _linear(deck: Outline, block: Block, of: Interaction) -> Interaction:
    rows = list(block.rows())
    if not rows:
        raise InputError(
            "PRESSURE-OVERCLOSURE=LINEAR without a stiffness",
            expected="a data line with pressure / length",
            where=block.where,
            fix="Add it.",
        )
    fields, where = rows[0]
    if any(fields[1:]):
        deck.note(
            block, "creak reads the slope of a linear law alone", changes=True, what="*SURFACE BEHAVIOR, second value"
        )
    return replace(of, law="linear", stiffness=positive(fields[0], where, "contact stiffness"))


def _penalty(block: Block, of: Interaction) -> Interaction:
    """A penalty stiffness of its own, or one from the elements."""
    rows = list(block.rows())
    if block.option("PENALTY") not in ("", "LINEAR"):
        raise InputError(
            f"PENALTY={block.get('PENALTY')}",
            expected="PENALTY or PENALTY=LINEAR",
            where=block.where,
            fix="creak's penalties are linear.",
        )
    if not rows:
        return replace(of, law="penalty")
    fields, where = rows[0]
    stiffness, clearance, scale = floats(fields, where, "penalty", 3)
    if clearance or scale not in (0.0, 1.0):
        raise InputError(
            f"a penalty with clearance {clearance:g} and scale factor {scale:g}",
            expected="0 and 1",
            where=where,
            fix="Give the stiffness itself.",
        )
    if not stiffness:
        return replace(of, law="penalty")
    return replace(of, law="linear", stiffness=positive(fields[0], where, "penalty stiffness"))


def _curve(block: Block) -> tuple[tuple[float, float], ...]:
    """(overclosure, pressure); the deck gives pressure first."""
    points: list[tuple[float, float]] = []
    for fields, where in block.rows():
        pressure, overclosure = floats(fields, where, "pressure or overclosure", 2)
        if not points and (pressure, overclosure) != (0.0, 0.0):
            raise InputError(
                f"the pressure-overclosure table starts at {pressure:g}, {overclosure:g}",
                expected="0, 0",
                where=where,
                fix="Let pressure begin at overclosure 0.",
            )
        if points and not (overclosure > points[-1][0] and pressure >= points[-1][1]):
            raise InputError(
                f"the pressure-overclosure table does not rise to {pressure:g}, {overclosure:g}",
                expected="rising overclosure and pressure",
                where=where,
                fix="Sort its lines.",
            )
        points.append((overclosure, pressure))
    if len(points) < 2 or points[-1][1] <= 0.0:
        raise InputError(
            f"the pressure-overclosure table has {len(points)} line(s)",
            expected="two or more, up to a pressure",
            where=block.where,
            fix="Add lines: pressure, overclosure.",
        )
    return tuple(points)


def _friction(deck: Outline, block: Block, of: Interaction) -> Interaction:
    list_params(deck, block, "EXPONENTIAL DECAY, LAGRANGE, SLIP TOLERANCE, ELASTIC SLIP")
    rows = list(block.rows())
    if not rows:
        return replace(of, friction=(0.0, 0.0, 0.0))
    fields, where = rows[0]
    if len(rows) > 1 or (not block.has("EXPONENTIAL DECAY") and any(fields[1:])):
        deck.note(
            block,
            "creak reads one coefficient of friction, or three with EXPONENTIAL DECAY",
            changes=True,
            what="*FRICTION, table",
        )
    if not block.has("EXPONENTIAL DECAY"):
        mu = _not_negative(fields[0], where, "coefficient of friction")
        return replace(of, friction=(mu, mu, 0.0))
    names = ("static coefficient", "kinetic coefficient", "decay coefficient")
    padded = [*fields, "", "", ""][:3]
    static, kinetic, decay = (_not_negative(f, where, n) for f, n in zip(padded, names, strict=True))
    if kinetic > static:
        raise InputError(
            f"the kinetic coefficient {kinetic:g} is above the static one {static:g}",
            where=where,
            expected="friction that falls with the sliding speed",
            fix="Swap them.",
        )
    return replace(of, friction=(static, kinetic, 1.0 / decay) if decay else (static, static, 0.0))


def _damping(deck: Outline, block: Block, of: Interaction) -> Interaction:
    list_params(deck, block, "DEFINITION")
    if block.option("DEFINITION", "DAMPING COEFFICIENT") != "DAMPING COEFFICIENT":
        raise InputError(
            f"*CONTACT DAMPING, DEFINITION={block.get('DEFINITION')}",
            expected="DAMPING COEFFICIENT",
            where=block.where,
            fix="Give the coefficient itself.",
        )
    rows = list(block.rows())
    if len(rows) != 1 or any(rows[0][0][1:]):
        raise InputError(
            "*CONTACT DAMPING that depends on the clearance",
            expected="one line with one coefficient",
            where=block.where,
            fix="creak's contact damping acts while closed.",
        )
    return replace(of, damping=_not_negative(rows[0][0][0], rows[0][1], "contact damping"))


def _not_negative(field: str, where: str, what: str) -> float:
    value = to_float(field, where, what)
    if value < 0.0:
        raise InputError(f"{what} is {value:g}", expected="zero or more", where=where, fix="Correct it.")
    return value


_RULES: dict[str, Callable[[Outline, Block, Interaction], Interaction]] = {
    "SURFACE BEHAVIOR": _behavior,
    "FRICTION": _friction,
    "CONTACT DAMPING": _damping,
}
