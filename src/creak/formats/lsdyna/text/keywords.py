"""What each keyword means to creak: read, harmless to leave out, or a change of the answer."""

from __future__ import annotations

from collections.abc import Iterable

from creak.formats.deck.catalogue import Catalogue, Meaning, listed
from creak.formats.lsdyna.text.deck import Block, Deck, Named

CONTACT_PAIRS = (
    *("CONTACT_AUTOMATIC_SURFACE_TO_SURFACE", "CONTACT_SURFACE_TO_SURFACE"),
    *("CONTACT_AUTOMATIC_ONE_WAY_SURFACE_TO_SURFACE", "CONTACT_ONE_WAY_SURFACE_TO_SURFACE"),
    *("CONTACT_AUTOMATIC_NODES_TO_SURFACE", "CONTACT_NODES_TO_SURFACE"),
)
"""Of two sides."""
GENERAL_CONTACT = ("CONTACT_AUTOMATIC_SINGLE_SURFACE", "CONTACT_SINGLE_SURFACE", "CONTACT_AUTOMATIC_GENERAL")
_TIED = ("OFFSET", "CONSTRAINED", "BEAM", "ID", "TITLE")
_LISTS = ("LIST", "GENERATE", "ADD", "TITLE")
OPTIONS: dict[str, tuple[str, ...]] = {
    **dict.fromkeys(("KEYWORD", "TITLE", "NODE", "ELEMENT_SOLID", "ELEMENT_BEAM", "ELEMENT_DISCRETE"), ()),
    "ELEMENT_MASS": (),
    "ELEMENT_SHELL": ("THICKNESS", "BETA", "MCID", "OFFSET"),
    **dict.fromkeys(("INITIAL_VELOCITY", "INITIAL_VELOCITY_NODE", "INITIAL_VELOCITY_GENERATION"), ()),
    "PART": ("CONTACT",),
    "DAMPING_GLOBAL": (),
    **dict.fromkeys(("DAMPING_PART_MASS", "DAMPING_PART_STIFFNESS"), ("SET",)),
    "DEFINE_CURVE": ("TITLE",),
    **dict.fromkeys(("SECTION_SHELL", "SECTION_SOLID", "SECTION_BEAM", "SECTION_DISCRETE"), ("TITLE",)),
    **dict.fromkeys(
        (
            *("MAT_ELASTIC", "MAT_PLASTIC_KINEMATIC", "MAT_RIGID", "MAT_PIECEWISE_LINEAR_PLASTICITY", "MAT_SPOTWELD"),
            *("MAT_SPRING_ELASTIC", "MAT_DAMPER_VISCOUS"),
        ),
        ("TITLE",),
    ),
    "SET_NODE": _LISTS,
    "SET_PART": _LISTS,
    **dict.fromkeys(("SET_SHELL", "SET_SOLID", "SET_BEAM", "SET_DISCRETE"), ("LIST", "GENERATE", "TITLE")),
    "SET_SEGMENT": ("TITLE",),
    **dict.fromkeys(("BOUNDARY_SPC_NODE", "BOUNDARY_SPC_SET"), ("ID",)),
    **dict.fromkeys(
        (
            *("DEFINE_COORDINATE_SYSTEM", "DEFINE_COORDINATE_NODES", "DEFINE_COORDINATE_VECTOR"),
            *("DEFINE_SD_ORIENTATION", "DEFINE_TRANSFORMATION"),
        ),
        ("TITLE",),
    ),
    "CONSTRAINED_NODAL_RIGID_BODY": ("SPC", "TITLE"),
    "CONSTRAINED_SPOTWELD": ("ID", "FILTERED", "FORCE"),
    "CONSTRAINED_GENERALIZED_WELD_SPOT": ("ID",),
    **dict.fromkeys(("CONSTRAINED_RIGID_BODIES", "CONSTRAINED_EXTRA_NODES_NODE", "CONSTRAINED_EXTRA_NODES_SET"), ()),
    **dict.fromkeys(
        (
            *("CONTACT_TIED_NODES_TO_SURFACE", "CONTACT_TIED_SURFACE_TO_SURFACE"),
            *("CONTACT_TIED_SHELL_EDGE_TO_SURFACE", "CONTACT_SPOTWELD"),
        ),
        _TIED,
    ),
    **dict.fromkeys((*CONTACT_PAIRS, *GENERAL_CONTACT), ("MORTAR", "SMOOTH", "MPP", "ID", "TITLE")),
}
"""Keywords that creak reads, and the options in their names that it knows."""
ALIASES = {
    "MAT_001": "MAT_ELASTIC",
    "MAT_003": "MAT_PLASTIC_KINEMATIC",
    "MAT_020": "MAT_RIGID",
    "MAT_024": "MAT_PIECEWISE_LINEAR_PLASTICITY",
    "MAT_100": "MAT_SPOTWELD",
    "MAT_S01": "MAT_SPRING_ELASTIC",
    "MAT_S02": "MAT_DAMPER_VISCOUS",
}
_LOADS = "loads do not act on modes, and the study file defines the excitation"
_HARMLESS = {
    "it controls the job, not the model": "CONTROL, COMMENT, CASE, CHANGE, DELETE, INTERFACE, RIGIDWALL_FORCE, SENSOR, "
    "PARAMETER_DUPLICATION",
    "it asks for output, and the study file has its own": "DATABASE, DEFINE_HAZ, CONTACT_FORCE",
    _LOADS: "LOAD, BOUNDARY_PRESCRIBED",
    "the study file defines contact, and `creak new` takes nothing from here": "CONTACT, DEFINE_FRICTION, RIGIDWALL",
    "creak's elements have no hourglass modes": "HOURGLASS",
    "nothing that creak reads uses it": "DEFINE, SET, EOS, TRANSLATE, PERTURBATION, FREQUENCY, TERMINATION",
    "creak has no heat": "MAT_THERMAL, INITIAL_TEMPERATURE",
    "creak takes the elastic constants of a material, and nothing that is added to it": "MAT_ADD",
    "no part that has elements uses it": "MAT, SECTION, INTEGRATION",
}
_CHANGES = {
    "creak does not read this element": "ELEMENT, AIRBAG",
    "creak does not read this constraint": "CONSTRAINED",
    "creak does not read this support": "BOUNDARY",
    "stress or motion before the analysis, which creak leaves out": "INITIAL, STRESS, DEFINE_STAGED",
    "creak reads *INITIAL_VELOCITY, _NODE and _GENERATION": "INITIAL_VELOCITY_RIGID, INITIAL_VELOCITY_GENERATION_START",
    "creak does not read this option of a part": "PART",
    "creak does not read this damping; [damping] in a study stands in its place": "DAMPING",
    "creak does not read this tied contact": ("CONTACT_TIEBREAK, CONTACT_SPOTWELD, CONTACT_GUIDED"),
    "creak does not read this way to include a file": "INCLUDE",
    "creak does not read this way to give values names: write them in their places": "PARAMETER",
    "creak does not move nodes but by *INCLUDE_TRANSFORM": "NODE",
    "it repeats or moves parts, which creak does not": "PART_MOVE, PART_DUPLICATE, NODE_TRANSFORM",
}
KEYWORDS = Catalogue(
    "keyword",
    {**listed("read", {"": ",".join(OPTIONS)}), **listed("harmless", _HARMLESS), **listed("changes", _CHANGES)},
)


def split(block: Block) -> tuple[str, frozenset[str]] | None:
    """The keyword that a block is read as, and the options in its name; None: creak does not read it."""
    words = block.name.split("_")
    for n in range(len(words), 0, -1):
        base = "_".join(words[:n])
        base = ALIASES.get(base, base)
        if base in OPTIONS:
            options = frozenset(words[n:])
            return (base, options) if options <= set(OPTIONS[base]) else None
    return None


def sorted_blocks(blocks: Iterable[Block]) -> tuple[dict[str, list[Named]], list[Block]]:
    """The blocks by the keywords that creak reads, and those that it does not."""
    found: dict[str, list[Named]] = {}
    unread: list[Block] = []
    for block in blocks:
        known = split(block)
        if known is None:
            unread.append(block)
        else:
            found.setdefault(known[0], []).append(Named(block, known[1]))
    return found, unread


def meaning(name: str) -> Meaning:
    """Of a keyword that is not read: that of its longest beginning that creak knows."""
    words = name.split("_")
    if words[0] == "CONTACT" and {"TIED", "TIEBREAK"} & set(words):
        return KEYWORDS.known["CONTACT_TIEBREAK"]
    for n in range(len(words), 0, -1):
        known = KEYWORDS.known.get("_".join(words[:n]))
        if known is not None and known.role != "read":
            return known
    hint = KEYWORDS.meaning(name)
    return hint if hint.role != "read" else Meaning("changes", "creak does not read this option of the keyword")


def list_unread(deck: Deck, unread: Iterable[Block]) -> None:
    """List every keyword that is not read, once for each name."""
    first: dict[str, Block] = {}
    count: dict[str, int] = {}
    for block in unread:
        first.setdefault(block.name, block)
        count[block.name] = count.get(block.name, 0) + 1
    for name, block in first.items():
        known, what = meaning(name), f"*{name}"
        parts = deck.left_out.get(what)
        why = f"the elements of {', '.join(parts)} are left out" if parts else known.why
        times = "" if count[name] == 1 else f" ({count[name]} times)"
        damps = known is KEYWORDS.known["DAMPING"]
        deck.note(block.where, what, why + times, changes=bool(parts) or known.changes_answer, damps=damps)
