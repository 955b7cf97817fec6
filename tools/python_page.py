"""The Python page of the site: every public name of `import creak`, in the order of a study."""

from __future__ import annotations

import inspect
from importlib import import_module

import creak

GROUPS = {
    "Studies": (
        "read_study",
        "make_study",
        "change_study",
        "run",
        "set_up",
        "run_setup",
        "open_result",
        "compare",
        "compare_records",
        "robust",
        "Study",
        "Setup",
        "Run",
        "Result",
        "RecordComparison",
        "SavedResult",
        "Events",
    ),
    "Many reductions of one study": ("make_bench", "Bench", "ReducedModel"),
    "Decks": (
        "read_deck",
        "deck_modes",
        "correlate",
        "compare_frfs",
        "sensitivities",
        "update_study",
        "near_elements",
        "write_door",
        "Model",
        "RigidLink",
        "DeckModes",
        "Sensitivities",
        "ModelUpdate",
        "Correlation",
        "FrfComparison",
    ),
    "Systems from matrices": ("system_from_matrices", "couple", "modes", "System", "Modes"),
    "Reduction": ("craig_bampton", "guyan", "gap_modes", "diagonalise"),
    "Contact": ("gap_channels", "join_gaps", "GapOperator"),
    "Loads": (
        "make_loads",
        "displacement_motion",
        "acceleration_motion",
        "integrate_twice",
        "Multisine",
        "Sine",
        "Step",
        "Table",
        "Record",
        "Motion",
        "Loads",
    ),
    "Time integration": ("simulate", "HHT", "generalised_alpha", "Scheme", "History"),
    "Events and verification": (
        "find_events",
        "find_slips",
        "match_events",
        "mac_matrix",
        "nrmse_fit",
        "nrmse_by_axis",
        "Event",
        "SlipEvent",
        "EventMatch",
    ),
    "Sound": ("loudness", "steady_loudness", "Loudness", "SteadyLoudness", "read_recordings", "compare_sounds"),
    "Files": ("write_text", "write_json", "read_json"),
    "Errors": ("CreakError", "InputError", "NumericalError", "WriteError"),
}
MODULES = {
    "Time integrations of your own": "stepping",
    "Pages of your own": "report_tools",
}
"""Public modules: title -> name."""
HEAD = """\
# Python

Everything here is a name of `import creak`, or of one of the two modules at the end. Nothing heavy is imported
before it is used. How the names work together:
[matrices of your own](howto_matrices.md), [the results](howto_results.md), [the examples](gallery/index.md).
"""


def page() -> str:
    """The page, with a directive for each name at the module that it lives in."""
    text = [HEAD]
    for title, names in GROUPS.items():
        text.append(f"## {title}\n")
        text += [f"::: {home(name)}.{name}\n" for name in names]
    for title, name in MODULES.items():
        text.append(f"## {title}: creak.{name}\n")
        text.append(f"{import_module(f'creak.{name}').__doc__}")
        text += [f"::: {where}\n" for where in documented(name)]
    return "\n".join(text)


def documented(name: str) -> list[str]:
    """Where the classes and functions of a public module are defined."""
    module = import_module(f"creak.{name}")
    values = (getattr(module, n) for n in module.__all__)
    return [f"{v.__module__}.{v.__name__}" for v in values if inspect.isclass(v) or inspect.isfunction(v)]


def home(name: str) -> str:
    """Module in which a public name is defined."""
    return creak._HOME[name]
