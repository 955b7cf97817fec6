"""creak: open squeak-and-rattle simulation with reduced finite element models.

A study, as `creak run` does it:

    import creak

    study = creak.read_study("door.toml")
    result = creak.run(study)
    result.events                     # when, where, how hard
    result.save("results")            # summary.json, results.h5
    result.report("report.html")

The steps alone, on matrices of any program:

    system = creak.system_from_matrices(K, M)                       # SciPy sparse or dense
    reduced = creak.craig_bampton(system, boundary, f_max=1500.0)   # a System like any other
    held = creak.couple(reduced, fixed=[0], driven={"base": [6]})
    gaps = creak.gap_channels(G, gap0, stiffness)                   # g = gap0 + G u
    loads = creak.make_loads(held, time, motion={"base": creak.Sine(20.0, 0.1)})
    history = creak.simulate(creak.diagonalise(held), gaps, loads)  # exact between contacts
    events = creak.find_events(history, gaps, f_max=500.0)

Nothing heavy is imported before it is used. Wrong input raises `creak.InputError`, a failed analysis
`creak.NumericalError`, a full disk `creak.WriteError`.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from creak.api.bench import Bench, make_bench
    from creak.api.channels import gap_channels, join_gaps
    from creak.api.compare import compare, compare_records, compare_sounds, read_recordings
    from creak.api.decks import compare_frfs, correlate, deck_modes, read_deck, write_door
    from creak.api.files import read_json, write_json, write_text
    from creak.api.matrices import couple, modes, system_from_matrices
    from creak.api.motion import make_loads, simulate
    from creak.api.reductions import craig_bampton, diagonalise, gap_modes, guyan
    from creak.api.result import Result
    from creak.api.robust import robust
    from creak.api.saved import SavedResult, open_result
    from creak.api.shown import Events
    from creak.api.study import change_study, make_study, read_study, run, run_setup, set_up
    from creak.api.update import sensitivities, update_study
    from creak.assembly.system import System
    from creak.contact.gap_operator import GapOperator
    from creak.dynamics.history import History
    from creak.dynamics.loads import Loads
    from creak.dynamics.scheme import HHT, Scheme, generalised_alpha
    from creak.errors import CreakError, InputError, NumericalError, WriteError
    from creak.linalg.modes import Modes
    from creak.model.constraints import RigidLink
    from creak.model.mesh import Model
    from creak.signals.signal import Motion
    from creak.signals.sources import (
        Multisine,
        Record,
        Sine,
        Step,
        Table,
        acceleration_motion,
        displacement_motion,
        integrate_twice,
    )
    from creak.sound.loudness import Loudness, SteadyLoudness, loudness, steady_loudness
    from creak.studies.file.reader import Study
    from creak.studies.findings.beside_records import RecordComparison
    from creak.studies.models.correlation import Correlation
    from creak.studies.models.deck_modes import DeckModes
    from creak.studies.models.frfs import FrfComparison
    from creak.studies.models.reduced import ReducedModel
    from creak.studies.models.substructures import near_elements
    from creak.studies.models.update import ModelUpdate, Sensitivities
    from creak.studies.prepare.setup import Setup
    from creak.studies.run.one_run import Run
    from creak.verify.events import Event, find_events
    from creak.verify.mac import mac_matrix
    from creak.verify.matching import EventMatch, match_events
    from creak.verify.nrmse import nrmse_by_axis, nrmse_fit
    from creak.verify.slips import SlipEvent, find_slips

    __version__: str

_HOMES = {
    "api.bench": ("Bench", "make_bench"),
    "api.compare": ("compare", "compare_records", "compare_sounds", "read_recordings"),
    "api.channels": ("gap_channels", "join_gaps"),
    "api.decks": ("compare_frfs", "correlate", "deck_modes", "read_deck", "write_door"),
    "api.files": ("read_json", "write_json", "write_text"),
    "api.matrices": ("couple", "modes", "system_from_matrices"),
    "api.motion": ("make_loads", "simulate"),
    "api.reductions": ("craig_bampton", "diagonalise", "gap_modes", "guyan"),
    "api.result": ("Result",),
    "api.robust": ("robust",),
    "api.saved": ("SavedResult", "open_result"),
    "api.shown": ("Events",),
    "api.study": ("change_study", "make_study", "read_study", "run", "run_setup", "set_up"),
    "api.update": ("sensitivities", "update_study"),
    "assembly.system": ("System",),
    "contact.gap_operator": ("GapOperator",),
    "dynamics.history": ("History",),
    "dynamics.loads": ("Loads",),
    "dynamics.scheme": ("HHT", "Scheme", "generalised_alpha"),
    "errors": ("CreakError", "InputError", "NumericalError", "WriteError"),
    "linalg.modes": ("Modes",),
    "model.constraints": ("RigidLink",),
    "model.mesh": ("Model",),
    "signals.signal": ("Motion",),
    "signals.sources": (
        "Multisine",
        "Record",
        "Sine",
        "Step",
        "Table",
        "acceleration_motion",
        "displacement_motion",
        "integrate_twice",
    ),
    "sound.loudness": ("Loudness", "SteadyLoudness", "loudness", "steady_loudness"),
    "studies.models.correlation": ("Correlation",),
    "studies.models.deck_modes": ("DeckModes",),
    "studies.models.frfs": ("FrfComparison",),
    "studies.models.reduced": ("ReducedModel",),
    "studies.models.substructures": ("near_elements",),
    "studies.models.update": ("ModelUpdate", "Sensitivities"),
    "studies.prepare.setup": ("Setup",),
    "studies.findings.beside_records": ("RecordComparison",),
    "studies.run.one_run": ("Run",),
    "studies.file.reader": ("Study",),
    "verify.events": ("Event", "find_events"),
    "verify.mac": ("mac_matrix",),
    "verify.matching": ("EventMatch", "match_events"),
    "verify.nrmse": ("nrmse_by_axis", "nrmse_fit"),
    "verify.slips": ("SlipEvent", "find_slips"),
}
"""Module -> public names that live in it."""
_HOME = {name: f"creak.{module}" for module, names in _HOMES.items() for name in names}

__all__ = [
    "HHT",
    "Bench",
    "Correlation",
    "CreakError",
    "DeckModes",
    "Event",
    "EventMatch",
    "Events",
    "FrfComparison",
    "GapOperator",
    "History",
    "InputError",
    "Loads",
    "Loudness",
    "Model",
    "ModelUpdate",
    "Modes",
    "Motion",
    "Multisine",
    "NumericalError",
    "Record",
    "RecordComparison",
    "ReducedModel",
    "Result",
    "RigidLink",
    "Run",
    "SavedResult",
    "Scheme",
    "Sensitivities",
    "Setup",
    "Sine",
    "SlipEvent",
    "SteadyLoudness",
    "Step",
    "Study",
    "System",
    "Table",
    "WriteError",
    "acceleration_motion",
    "change_study",
    "compare",
    "compare_frfs",
    "compare_records",
    "compare_sounds",
    "correlate",
    "couple",
    "craig_bampton",
    "deck_modes",
    "diagonalise",
    "displacement_motion",
    "find_events",
    "find_slips",
    "gap_channels",
    "gap_modes",
    "generalised_alpha",
    "guyan",
    "integrate_twice",
    "join_gaps",
    "loudness",
    "mac_matrix",
    "make_bench",
    "make_loads",
    "make_study",
    "match_events",
    "modes",
    "near_elements",
    "nrmse_by_axis",
    "nrmse_fit",
    "open_result",
    "read_deck",
    "read_json",
    "read_recordings",
    "read_study",
    "robust",
    "run",
    "run_setup",
    "sensitivities",
    "set_up",
    "simulate",
    "steady_loudness",
    "system_from_matrices",
    "update_study",
    "write_door",
    "write_json",
    "write_text",
]


def __getattr__(name: str) -> Any:
    """A public name, from its home at its first use."""
    if name == "__version__":
        value: Any = import_module("creak.version").version()
    elif name in _HOME:
        value = getattr(import_module(_HOME[name]), name)
    else:
        raise AttributeError(f"module 'creak' has no attribute {name!r}")
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return sorted([*__all__, "__version__"])
