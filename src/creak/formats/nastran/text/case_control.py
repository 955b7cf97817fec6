"""Executive and case control: which constraint sets the subcase of the modes takes, and the sets it names."""

from __future__ import annotations

import re
from dataclasses import dataclass, field

from creak.errors import InputError
from creak.formats.deck.catalogue import misspelling
from creak.formats.deck.text import Line
from creak.formats.nastran.text.bulk_data import MAX_DIGITS
from creak.model.mesh import Unread
from creak.model.steps import EVERY_NODE

_COMMAND = re.compile(r"\s*([A-Za-z][A-Za-z0-9]*)\s*(\([^)]*\))?\s*(?:=\s*|\s+|$)(.*)")
_SENTENCES = ("TITL", "SUBT", "LABE")
"""Commands whose text may end with a comma and does not go on in the next line."""
_CHANGES = {
    *("K42GG", "K2PP", "M2PP", "B2PP", "TFL", "DEFORM", "AXISYMMETRIC", "A2GG", "MFLUID", "RGYRO", "BOLTLD"),
    *("STATSUB", "PRELOAD", "TSTRU"),
}
"""Commands that change the structure and that creak does not follow."""
_ALIKE = {"SPCF", "MPCF", "SPCD", "OLOAD", "CLOAD", "NLLOAD", "CMETHOD", "FMETHOD", "SMETHOD", "RMETHOD", "STEP"} | {
    *("SEDAMP", "SUBCOM", "SUBSEQ"),
}
"""Commands that are spelled like one that creak reads."""
UNFOLLOWED = "creak does not follow this case control command"

_IN_TIME = {"NONLINEAR", "BCSET", "RSDAMP"}
"""Commands that bear on a transient alone: loads that follow the motion (NOLIN), contact, modal damping."""
_MATRICES = ("K2GG", "M2GG", "B2GG")
_STRUCTURE = ("SPC", "MPC", "NSM", "BCONTACT", "BGSET", "TEMPERATURE(INITIAL)", *_MATRICES, *sorted(_CHANGES))
"""Commands that say what the structure is and what holds it."""
_OUTPUT = ("DISPLACEMENT", "VELOCITY", "ACCELERATION")
_OF_RUN = ("DLOAD", "TSTEP", "TSTEPNL", "LOADSET", *_OUTPUT)


STATIC_START = "IC(STATSUB)"
HEAT = "TEMPERATURE(LOAD)"
SEQUENTIAL = ("129",)
"""Solutions whose subcases follow each other in time."""
_BEARS = (*_STRUCTURE, "DLOAD", "LOADSET", "LOAD", HEAT, "IC", STATIC_START, "SDAMPING", *sorted(_IN_TIME))
"""Commands that bear on a transient."""


@dataclass(frozen=True)
class StaticCase:
    """A subcase of statics that a transient starts from."""

    load: int
    """LOAD"""
    temperature: int
    """TEMPERATURE(LOAD), or of both kinds."""
    spc: int
    where: str


@dataclass(frozen=True)
class CaseControl:
    """What of one subcase (and above it) bears on the model: the first that has a METHOD, else the first."""

    solution: str = ""
    spc: int = 0
    mpc: int = 0
    initial: int = 0
    """IC: the set of TIC cards."""
    dload: int = 0
    tsteps: tuple[int, ...] = ()
    """TSTEP or TSTEPNL, of each subcase that goes on from the one before."""
    loadset: int = 0
    """LOADSET: the set of LSEQ cards."""
    nsm: int = 0
    sets: dict[int, tuple[range, ...]] = field(default_factory=dict)
    """SET commands with ids."""
    matrices: dict[str, str] = field(default_factory=dict)
    """K2GG, M2GG, B2GG -> what they select."""
    contact: str = ""
    """BCONTACT: a contact table, or ALLBODY."""
    contact_set: str = ""
    """BCSET: a set of contact pairs."""
    glue: str = ""
    """BGSET: a set of glued surfaces."""
    output: tuple[str, ...] = ()
    """Node sets SET_n, or all nodes, whose motion DISPLACEMENT, VELOCITY or ACCELERATION asks for."""
    commands: frozenset[str] = frozenset()
    """Names of all of its commands."""
    unread: tuple[Unread, ...] = ()
    given: bool = False
    """Whether there is a case control section."""
    where: str = ""
    initial_temperature: int = 0
    """TEMPERATURE(INITIAL)"""
    static: StaticCase | None = None
    """Of the deck's own run; None: it starts without strain."""
    damping_table: str = ""
    """SDAMPING"""


_OF_MODEL = {*_STRUCTURE, "METHOD", "IC", "STATSUB", "SUBCASE"}
"""Commands that bear on a model and its modes."""


def read_case_control(executive: list[Line], case: list[Line], own_run: bool = False) -> CaseControl:
    """SPC, MPC, IC, SET and direct matrices of the subcase of the modes; the rest is listed.

    Parameters
    ----------
    own_run : whether loads, times and output of the deck are used as well.

    Raises
    ------
    InputError : SPC, MPC or IC is not a number.
    """
    above, subcases = _subcases(case)
    solution = _solution(executive)
    at = _taken(subcases, own_run)
    commands = above | (subcases[at][2] if subcases else {})
    later, unread = _others(above, subcases, at, solution if own_run else "")
    static = _static(above, subcases, at, commands, unread) if own_run else None
    ids = {key: _identifier(commands, key) for key in ("SPC", "MPC", "IC", "DLOAD", "LOADSET", "NSM")}
    tsteps = [_identifier(c, "TSTEP") or _identifier(c, "TSTEPNL") for c in (commands, *later)]
    sets = {number: _ids(text) for number, text in _sets(case).items()}
    changing = _CHANGES | (_IN_TIME if own_run else set())
    unread += [Unread(key, line.where, True, UNFOLLOWED) for key, (_, line) in commands.items() if key in changing]
    matrices = {key: commands[key][0] for key in _MATRICES if key in commands}
    used = {"SPC", "MPC", "IC", "NSM", "SET", "BCONTACT", "BCSET", "BGSET", *_MATRICES, *(_OF_RUN if own_run else ())}
    used |= {"TEMPERATURE", HEAT, "LOAD", STATIC_START} if own_run else set()
    wanted = {*_OF_MODEL, *((*_BEARS, *_OF_RUN) if own_run else ())}
    for key, (_, line) in commands.items():
        meant = misspelling(key, wanted, {*_BEARS, *_OF_RUN, *_ALIKE})
        unread += [Unread(key, line.where, True, meant)] if meant else []
    rest = [key for key in commands if key not in changing | used and "(" not in key]
    if rest:
        who = "creak has output of its own" if own_run else "the study file defines loads, analysis and output"
        why = f"{who} ({', '.join(rest)})"
        unread.append(Unread("case control", commands[rest[0]][1].where, False, why))
    unread += [
        Unread(line.text.split()[0].upper(), line.where, True, "creak does not run DMAP")
        for line in executive
        if re.match(r"\s*(ALTER|COMPILE|MALTER)\b", line.text, re.I)
    ]
    return CaseControl(
        solution=solution,
        spc=ids["SPC"],
        mpc=ids["MPC"],
        initial=ids["IC"],
        dload=ids["DLOAD"],
        tsteps=tuple(t for t in tsteps if t),
        loadset=ids["LOADSET"],
        nsm=ids["NSM"],
        sets=sets,
        matrices=matrices,
        contact=_value(commands, "BCONTACT"),
        contact_set=_value(commands, "BCSET"),
        glue=_value(commands, "BGSET"),
        output=tuple(dict.fromkeys(name for c in (commands, *later) for name in _output(c))),
        commands=frozenset(commands),
        unread=tuple(unread),
        given=bool(case or executive),
        where=(case or executive)[0].where if case or executive else "",
        initial_temperature=_initial_temperature(above, subcases),
        static=static,
        damping_table=_value(commands, "SDAMPING"),
    )


def _output(commands: dict[str, tuple[str, Line]]) -> tuple[str, ...]:
    wanted = (commands[key][0] for key in _OUTPUT if key in commands)
    names = (f"SET_{int(t)}" if re.fullmatch("[0-9]{1,15}", t) else t.upper() for t in wanted)
    return tuple(dict.fromkeys(EVERY_NODE if t == "ALL" else t for t in names if t == "ALL" or t.startswith("SET_")))


_OLD_SOLUTIONS = {
    **{str(n): str(100 + n) for n in (1, 3, 5, 7, 8, 9, 10, 11, 12)},
    **{"STATIC": "101", "STATICS": "101", "MODES": "103", "BUCKLING": "105"},
}
"""Rigid formats of NASTRAN, and words of MYSTRAN."""


def _solution(executive: list[Line]) -> str:
    found = (re.match(r"\s*SOL\s+(\w+)", line.text, re.I) for line in executive)
    solution = next((m.group(1).upper() for m in found if m), "")
    return _OLD_SOLUTIONS.get(solution, solution)


Commands = dict[str, tuple[str, Line]]
Subcases = list[tuple[str, Line, Commands]]


def _subcases(case: list[Line]) -> tuple[Commands, Subcases]:
    """Commands above the subcases, and those of each."""
    above: Commands = {}
    subcases: Subcases = []
    commands, go_on = above, False
    for line in case:
        text = line.text.split("$")[0].rstrip()
        found = None if go_on else _COMMAND.match(text)
        go_on = text.endswith(",") and not (found and found.group(1)[:4].upper() in _SENTENCES)
        if not found:
            continue
        key, value = _key(found.group(1)), found.group(3).strip()
        if key in ("SUBCASE", "SUBCOM", "SYM", "REPCASE"):
            commands = {}
            subcases.append((f"{key} {value}", line, commands))
            continue
        kind = (found.group(2) or "").strip("() ").upper()
        if key == "IC" and kind.startswith("STATSUB"):
            key = STATIC_START
            if "DIFFK" in kind:
                commands["STATSUB"] = (value, line)
        commands[key] = (value, line)
        if key == "TEMPERATURE":
            kinds = {"": ("LOAD",), "BOTH": ("LOAD",), "INIT": ("INITIAL",)}.get(kind[:4], (kind,))
            commands.update({f"{key}({k})": (value, line) for k in kinds})
    return above, subcases


def _taken(subcases: Subcases, own_run: bool) -> int:
    """Row of the subcase that is followed.

    Of the deck's own run it is the first that has a TSTEP or DLOAD. Else the first that has a METHOD (those before it
    are statics that it may start from by STATSUB). Else the first.
    """
    wanted = {"TSTEP", "TSTEPNL", "DLOAD"} if own_run else {"METHOD"}
    return next((i for i, (_, _, own) in enumerate(subcases) if wanted & own.keys()), 0)


def _others(above: Commands, subcases: Subcases, at: int, run: str) -> tuple[list[Commands], list[Unread]]:
    """What the run goes on with after subcase `at`, and the subcases that are left out.

    In SOL 129 subcases follow each other in time: the run goes on where nothing but the steps and the output differs.
    In other transients each is an analysis of its own. For a model those count that have another structure or supports.

    Parameters
    ----------
    run : solution of the deck's own run; empty: the model alone is read.
    """
    later: list[Commands] = []
    unread: list[Unread] = []
    taken = above | (subcases[at][2] if subcases else {})
    goes_on, has_modes = run in SEQUENTIAL, bool(subcases) and "METHOD" in subcases[at][2]
    why = "creak takes the first subcase" + (f" that has a {'TSTEP' if run else 'METHOD'}" if at else "")
    for i, (name, line, own) in enumerate(subcases):
        both, kind = above | own, name.split()[0]
        if "STATSUB" in own and i != at:
            unread.append(Unread("STATSUB", own["STATSUB"][1].where, True, UNFOLLOWED))
        if i == at:
            continue
        start = () if "IC" in both or STATIC_START in both else ("IC", STATIC_START)
        bears = [k for k in (_BEARS if run else _STRUCTURE) if k not in start]
        other = ", ".join(k for k in bears if _value(both, k) != _value(taken, k))
        told = ""
        if kind in ("SUBCOM", "REPCASE") or (i < at and run):
            pass
        elif run:
            goes_on = goes_on and not other
            if goes_on:
                later.append(both)
                continue
            told = f"it is an analysis of its own (SOL {run}), and creak runs the first"
            if run in SEQUENTIAL:
                told = (
                    f"the run goes on with it, but not under the same {other or 'commands'}; creak runs what is before"
                )
            told += ": write a deck for each" if run not in SEQUENTIAL else ": write one load over the whole time"
        elif other and ("METHOD" in both or not has_modes):
            told = f"it has another {other} than the subcase that creak takes: write a deck for each"
        unread.append(Unread(name, line.where, bool(told), told or why))
    return later, unread


def _value(commands: Commands, key: str) -> str:
    return commands[key][0] if key in commands else ""


def _static(
    above: Commands, subcases: Subcases, transient: int, commands: Commands, unread: list[Unread]
) -> StaticCase | None:
    """The subcase that IC(STATSUB) or STATSUB names, else the one before the transient that has loads and no times.

    Raises
    ------
    InputError : there is no such subcase.
    """
    named = next((key for key in (STATIC_START, "STATSUB") if key in commands), "")
    at = next((i for i in range(transient - 1, -1, -1) if {"LOAD", HEAT} & subcases[i][2].keys()), -1)
    if named:
        number = _identifier(commands, named)
        at = next((i for i, s in enumerate(subcases) if s[0] == f"SUBCASE {number}" and i != transient), -1)
        if at < 0:
            raise InputError(
                f"{named} = {number}, but there is no such subcase beside the transient one",
                where=commands[named][1].where,
                expected="the number of a static subcase",
                fix="Correct the number.",
            )
    for key in ("LOAD", HEAT) if at < 0 else ():
        if key in commands:
            heat = key == HEAT
            why = "static loads act in a transient only from a static subcase before it, or by LSEQ, as in Nastran"
            why = "temperatures act only from a static subcase before the transient" if heat else why
            unread.append(Unread(key, commands[key][1].where, heat, why))
    if at < 0:
        return None
    name, line, own = subcases[at]
    unread[:] = [u for u in unread if (u.keyword, u.where) != (name, line.where)]
    both = above | own
    load, heated, spc = (_identifier(both, key) for key in ("LOAD", HEAT, "SPC"))
    return StaticCase(load, heated, spc, line.where)


def _initial_temperature(above: Commands, subcases: Subcases) -> int:
    """TEMPERATURE(INITIAL), the first that the deck takes anywhere."""
    key = "TEMPERATURE(INITIAL)"
    every = [above, *(own for _, _, own in subcases)]
    return next((_identifier(c, key) for c in every if key in c), 0)


def _key(word: str) -> str:
    """Full name of a command that may be cut to four letters."""
    word = word.upper()
    full = {
        "SUBC": "SUBCASE",
        "METH": "METHOD",
        "DISP": "DISPLACEMENT",
        "TEMP": "TEMPERATURE",
        "VELO": "VELOCITY",
        "ACCE": "ACCELERATION",
        "SDAM": "SDAMPING",
        "RSDA": "RSDAMP",
        "NONL": "NONLINEAR",
        "BCON": "BCONTACT",
        "DEFO": "DEFORM",
    }
    return full.get(word, word)


def _identifier(commands: dict[str, tuple[str, Line]], key: str) -> int:
    if key not in commands:
        return 0
    value, line = commands[key]
    if not re.fullmatch("[0-9]{1,15}", value):
        raise InputError(f"{key} = {value!r}", where=line.where, expected="the number of a set")
    return int(value)


def _sets(case: list[Line]) -> dict[int, str]:
    found: dict[int, str] = {}
    number = -1
    for line in case:
        text = line.text.split("$")[0].strip()
        if re.match(r"OUTPUT\s*\(", text, re.I):
            break  # what is plotted has sets of its own, with the same numbers
        start = re.match(r"SET\s+([0-9]{1,15})\s*=\s*(.*)", text, re.I)
        if start:
            number, text = int(start.group(1)), start.group(2)
            found[number] = ""
        if number >= 0:
            found[number] += " " + text
        if not text.endswith(","):
            number = -1
    return found


EVERY = range(1, 10**MAX_DIGITS)
"""Ids of SET n = ALL."""


def _ids(text: str) -> tuple[range, ...]:
    """Ids of `1, 5, 10 THRU 20 EXCEPT 15` or ALL; empty for NONE and lists of something else."""
    if text.strip().upper() == "ALL":
        return (EVERY,)
    ids: list[range] = []
    for piece in text.upper().split(","):
        many = re.fullmatch(r"\s*([0-9]{1,15})\s+THRU\s+([0-9]{1,15})((?:\s+EXCEPT)?[\s0-9]*)", piece)
        if many:
            first, last = int(many.group(1)), int(many.group(2))
            left_out = {int(i) for i in many.group(3).replace("EXCEPT", " ").split() if len(i) <= MAX_DIGITS}
            for other in sorted(i for i in left_out if first <= i <= last):
                ids.append(range(first, other))
                first = other + 1
            ids.append(range(first, last + 1))
        elif re.fullmatch(r"\s*[0-9]{1,15}\s*", piece):
            ids.append(range(int(piece), int(piece) + 1))
    return tuple(ids)
