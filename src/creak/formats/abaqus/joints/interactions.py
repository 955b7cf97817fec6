"""*SURFACE INTERACTION with its options, and GAPUNI elements with their *GAP: how what touches presses and rubs."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from dataclasses import replace
from math import inf

import numpy as np

from creak.arrays import FloatArray
from creak.errors import InputError
from creak.formats.abaqus.mesh.elements import Elements
from creak.formats.abaqus.text.fields import Registry, floats, positive, to_float
from creak.formats.abaqus.text.lexer import Block
from creak.formats.abaqus.text.outline import Outline, Scope, list_params
from creak.formats.deck.refusals import noted
from creak.formats.deck.stops import Gap, in_a_study, stops_of
from creak.model.mesh import Unread
from creak.model.steps import Interaction, Stop

OPTIONS = ("SURFACE BEHAVIOR", "FRICTION", "CONTACT DAMPING")


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
                raise block.error(f"surface interaction {name!r} is defined twice", fix="Rename one of them.")
            list_params(deck, block, "NAME, TRACKING THICKNESS, UNSYMM")
            result[name] = Interaction(name, where=block.where)
        elif block.name in _RULES:
            if not name:
                raise block.error(
                    f"*{block.name} without *SURFACE INTERACTION",
                    expected="*SURFACE INTERACTION before it",
                    fix="Put it after its *SURFACE INTERACTION.",
                )
            with noted(flaws):
                result[name] = _RULES[block.name](deck, block, result[name])
    return result


def law_of_gap(deck: Outline, block: Block, flaws: list[str]) -> Interaction:
    """The law of a *GAP, whose options stand after it; hard without any. flaws : takes what is wrong with an option."""
    result = Interaction(block.get("ELSET").upper(), law="hard", where=block.where)
    for option in block.options:
        with noted(flaws):
            result = _RULES[option.name](deck, option, result)
    return replace(result, law="hard") if result.law in ("default", "penalty") else result


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
        raise block.error(
            f"PRESSURE-OVERCLOSURE={law}",
            expected="HARD, LINEAR or TABULAR",
            fix="Write it as a table of pressure and overclosure from 0, 0 on"
            + " (Abaqus and CalculiX have different exponential laws)." * (law == "EXPONENTIAL"),
        )
    if block.has("PENALTY"):
        return _penalty(block, of)
    enforced = block.has("DIRECT") or block.has("AUGMENTED LAGRANGE")
    return replace(of, law="hard" if enforced else "default")


def _linear(deck: Outline, block: Block, of: Interaction) -> Interaction:
    """p = K c of overclosure c. CalculiX adds sigma and c_0 (where it looks for contact, at nodes): there
    p = K c (1/2 + arctan(K c / (pi sigma)) / pi), which ends sigma below K c, and at -sigma far away.
    """
    rows = list(block.rows())
    if not rows:
        raise block.error(
            "PRESSURE-OVERCLOSURE=LINEAR without a stiffness",
            expected="a data line with pressure / length",
            fix="Add it.",
        )
    fields, where = rows[0]
    if len(fields) > 3:
        raise InputError(
            f"PRESSURE-OVERCLOSURE=LINEAR with {len(fields)} values",
            expected="the slope, and of CalculiX tension and clearance",
            where=where,
            fix="Take away what is too much.",
        )
    tension, _ = (_not_negative(f or "0", where, "tension or clearance") for f in [*fields[1:], "", ""][:2])
    if tension:
        why = f"CalculiX's node-to-face contact is softened by it, up to a pressure of {tension:g}; creak's is linear"
        deck.note(block, why, changes=False, what="*SURFACE BEHAVIOR, second value")
    return replace(of, law="linear", stiffness=positive(fields[0], where, "contact stiffness"))


def _penalty(block: Block, of: Interaction) -> Interaction:
    """A penalty stiffness of its own, or one from the elements."""
    rows = list(block.rows())
    if block.option("PENALTY") not in ("", "LINEAR"):
        raise block.error(
            f"PENALTY={block.get('PENALTY')}", expected="PENALTY or PENALTY=LINEAR", fix="creak's penalties are linear."
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
        raise block.error(
            f"the pressure-overclosure table has {len(points)} line(s)",
            expected="two or more, up to a pressure",
            fix="Add lines: pressure, overclosure.",
        )
    return tuple(points)


def _friction(deck: Outline, block: Block, of: Interaction) -> Interaction:
    list_params(deck, block, "EXPONENTIAL DECAY, LAGRANGE, SLIP TOLERANCE, ELASTIC SLIP")
    rows = list(block.rows())
    if not rows:
        return replace(of, friction=(0.0, 0.0, 0.0))
    if not block.has("EXPONENTIAL DECAY"):
        return replace(of, friction=_of_table(deck, block, rows))
    fields, where = rows[0]
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


def _of_table(deck: Outline, block: Block, rows: list[tuple[list[str], str]]) -> tuple[float, float, float]:
    """Static and kinetic coefficient and decay speed of a table: coefficient, slip rate, pressure, temperature.

    A coefficient that falls over the slip rate becomes the exponential between its ends that has the same area above
    the last one. Of the lines that differ in more than the slip rate those like the first are taken.
    """
    what = ("coefficient of friction", "slip rate", "contact pressure", "temperature")
    each = [
        tuple(_not_negative(f, w, n) for f, n in zip([*fields, "", "", ""], what, strict=False)) for fields, w in rows
    ]
    curve = [line[:2] for line in each if line[2:] == each[0][2:]]
    if len(curve) < len(each):
        why = "creak's friction depends on the sliding speed alone: the lines like the first are taken"
        deck.note(block, why, changes=True, what="*FRICTION, table")
    mu, speed = (np.array(column) for column in zip(*curve, strict=True))
    static, kinetic = float(mu[0]), float(mu[-1])
    if len(curve) == 1:
        return (static, static, 0.0)
    if (np.diff(speed) <= 0.0).any() or (np.diff(mu) > 0.0).any() or kinetic == static:
        why = f"creak's friction falls with the sliding speed: it is {static:g}, the first of the table, at any speed"
        deck.note(block, why, changes=True, what="*FRICTION, table")
        return (static, static, 0.0)
    area = float(np.sum(np.diff(speed) * (0.5 * (mu[1:] + mu[:-1]) - kinetic)))
    decay = float(f"{area / (static - kinetic):.6g}")
    why = f"its table is read as {static:g} that falls to {kinetic:g} by exp(-v / {decay:.4g}), with the same area"
    deck.note(block, why, changes=True, what="*FRICTION, table")
    return (static, kinetic, decay)


def _damping(deck: Outline, block: Block, of: Interaction) -> Interaction:
    list_params(deck, block, "DEFINITION")
    if block.option("DEFINITION", "DAMPING COEFFICIENT") != "DAMPING COEFFICIENT":
        raise block.error(
            f"*CONTACT DAMPING, DEFINITION={block.get('DEFINITION')}",
            expected="DAMPING COEFFICIENT",
            fix="Give the coefficient itself.",
        )
    rows = list(block.rows())
    if len(rows) != 1 or any(rows[0][0][1:]):
        raise block.error(
            "*CONTACT DAMPING that depends on the clearance",
            expected="one line with one coefficient",
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


def read_gaps(
    deck: Outline, elements: Elements, names: Registry, coords: FloatArray, *, own_step: bool
) -> tuple[Stop, ...]:
    """Gaps of one *GAP and direction together: h = d + n . (u_2 - u_1) stays above 0.

    d is the initial clearance of the data line (below 0: they overlap) and n its direction, without one from the first
    node to the second. They are hard, or have PRESSURE-OVERCLOSURE=LINEAR times the contact area of the data line; with
    the *FRICTION of the *GAP. Others (GAPCYL, GAPSPHER, other laws) are listed as not read.

    Parameters
    ----------
    own_step : whether the deck's own step is to be run; else each stop is listed with what a study must say of it.

    Raises
    ------
    InputError : unknown elements, a clearance that is no number, nodes that coincide without a direction.
    """
    found = list[Gap]()
    for scope, block in deck.blocks("GAP"):
        found += _of_block(deck, scope, block, elements, names, coords)
    stops = stops_of(found)
    if not own_step:
        for stop in stops:
            deck.unread.setdefault(Unread("*GAP", stop.where, True, in_a_study(stop)))
    return stops


def _of_block(
    deck: Outline, scope: Scope, block: Block, elements: Elements, names: Registry, coords: FloatArray
) -> Iterator[Gap]:
    rows = names.find(block.need("ELSET"), scope.name, block.where)
    round_ones = sorted({elements.of(int(row)).name for row in rows} - {"GAPUNI"})
    flaws = list[str]()
    law = law_of_gap(deck, block, flaws)
    clearance, given, area = _data(block)
    refused = "".join(flaws[:1])
    if round_ones:
        refused = f"creak has stops along one line, and {round_ones[0]} keeps its nodes at a distance in all directions"
    elif law.law not in ("hard", "linear") or law.damping:
        refused = "of the laws of a *GAP creak reads HARD and LINEAR, without damping"
    if refused:
        deck.note(block, f"{refused}; give it in the study as [[connector]] or [contact.NAME]", changes=True)
        return
    owner = ".".join(name for name in (scope.name, block.need("ELSET").upper()) if name)
    stiffness = law.stiffness * area if law.law == "linear" else inf
    for row in rows.tolist():
        a, b = elements.nodes_idx[row, :2].tolist()
        line = scope.rotation @ given if given.any() else coords[b] - coords[a]
        if not line.any():
            raise InputError(
                f"the nodes of gap element {elements.ids[row]} coincide",
                where=block.where,
                expected="a direction: clearance, cosine x, y, z",
                fix="Give the direction in which the second node leaves the first.",
            )
        yield Gap(owner, (a, b), line, clearance, stiffness, elements.where(row), law.friction)


def _data(block: Block) -> tuple[float, FloatArray, float]:
    """Clearance, direction (3,) (zeros: that of the nodes) and contact area."""
    rows = list(block.rows())
    if not rows:
        return 0.0, np.zeros(3), 1.0
    fields, where = rows[0]
    clearance, *direction = floats(fields, where, "clearance or direction of the gap", 4)
    area = positive(fields[4], where, "contact area") if len(fields) > 4 and fields[4] else 1.0
    return clearance, np.array(direction), area
