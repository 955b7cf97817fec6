"""The Python page of the site: every public name of `import creak`, in the order of a study."""

from __future__ import annotations

import creak

GROUPS = {
    "Studies": (
        "read_study",
        "make_study",
        "change_study",
        "run",
        "open_result",
        "compare",
        "Study",
        "Result",
        "SavedResult",
    ),
    "Decks": ("read_deck", "deck_modes", "write_door", "Model", "DeckModes"),
    "Systems from matrices": ("system_from_matrices", "couple", "modes", "System", "Modes"),
    "Reduction": ("craig_bampton", "guyan", "gap_modes", "massless_boundary", "diagonalise"),
    "Contact": ("gap_channels", "join_gaps", "GapOperator"),
    "Loads": ("make_loads", "acceleration_motion", "Multisine", "Sine", "Step", "Table", "Record", "Motion", "Loads"),
    "Time integration": ("simulate", "HHT", "generalised_alpha", "Scheme", "History"),
    "Events and verification": (
        "find_events",
        "find_slips",
        "match_events",
        "mac_matrix",
        "nrmse_fit",
        "Event",
        "SlipEvent",
        "EventMatch",
    ),
    "Sound": ("loudness", "steady_loudness", "Loudness", "SteadyLoudness"),
    "Errors": ("CreakError", "InputError", "NumericalError", "WriteError"),
}
HEAD = """\
# Python

Everything here is a name of `import creak`. Nothing heavy is imported before it is used. How the names work together:
[matrices of your own](howto_matrices.md), [the results](howto_results.md), [the examples](gallery/index.md).
"""


def page() -> str:
    """The page, with a directive for each name at the module that it lives in."""
    text = [HEAD]
    for title, names in GROUPS.items():
        text.append(f"## {title}\n")
        text += [f"::: {home(name)}.{name}\n" for name in names]
    return "\n".join(text)


def home(name: str) -> str:
    """Module in which a public name is defined."""
    return creak._HOME[name]
