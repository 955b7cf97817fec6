"""Studies from Python, and the steps that `creak run` takes."""

from __future__ import annotations

import warnings
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, get_args

from creak.api.result import Result
from creak.errors import InputError
from creak.given import of_kind, one_of, path_of, texts
from creak.model.units import UnitsName
from creak.progress import Progress, told_to
from creak.studies.file import reader as study_file
from creak.studies.file.reader import Study
from creak.studies.file.toml_text import toml_text

if TYPE_CHECKING:
    from creak.studies.evaluate import Changes
    from creak.studies.prepare.setup import Setup
    from creak.studies.run.checkpoint import Checkpoints
    from creak.studies.tasks.queue import Runner

OF_TABLES = "creak.make_study(tables) makes a study of tables."


def read_study(path: str | Path) -> Study:
    """Read and check a study file (TOML, docs/study.md).

    Raises
    ------
    InputError : no such file, not TOML, unknown or missing key, wrong value.
    """
    return study_file.read_study(path_of(path, "the study", "the path of a study file", OF_TABLES))


def make_study(tables: Mapping[str, Any], folder: str | Path = ".") -> Study:
    """A study from tables, as a study file holds them: `{"model": {"deck": "door.inp"}, "time": {"step": 1e-3}, ...}`.

    Parameters
    ----------
    tables : keys and values of docs/study.md; numbers, strings, truth values, lists and mappings.
    folder : where paths in the study start from.

    Raises
    ------
    InputError : unknown or missing key, wrong value.
    """
    of_kind(tables, Mapping, "tables", 'a mapping, as {"model": {"deck": "door.inp"}}')
    data = plain(tables)
    try:
        text = toml_text(data)
    except TypeError as error:
        raise InputError(str(error), where="make_study", expected="numbers, strings, lists and mappings") from error
    return study_file.checked_study(path_of(folder, "folder") / "study.toml", data, text)


def change_study(study: Study | str | Path, changes: Mapping[str, Any]) -> Study:
    """The study with other values, `{"reduction.f_max": 700, "contact.flange.friction": 0.2}`; the file stays as it is.

    Parameters
    ----------
    study : a Study or the path of a study file.
    changes : dotted key -> value; rows of lists by number or name, `clip.0.gap`, `clip.bumper.gap`.

    Raises
    ------
    InputError : a key that there is not, or a wrong value.
    """
    from creak.studies.file.changes import with_changes

    of_kind(changes, Mapping, "changes", 'a mapping, as {"time.end": 1.0}')
    return with_changes(study if isinstance(study, Study) else read_study(study), plain(changes))


def run(
    study: Study | str | Path,
    *,
    converge: bool | None = None,
    superelements: str | Path | None = None,
    record: bool = True,
    ignore: Sequence[str] = (),
    progress: Progress | None = None,
    changes: Changes = "none",
) -> Result:
    """Run a study as `creak run` does: pre-check, reduction, both runs, verification.

    Parameters
    ----------
    study : a Study, the path of a study file, or of a deck whose own step (Abaqus *DYNAMIC; Nastran SOL 109, 112) is
        run, unreduced but where it is one in modes.
    converge : repeat the run to see how far its figures have settled; None: where no scheme is forced, the model is
        reduced and the accuracy is not "quick", at about five times the cost of the run (with a forced one 15 times).
    superelements : folder of saved ones; default: superelements/ beside the study. Those that still fit are used.
    record : keep the motion around the hardest events, for the report's animation.
    ignore : keywords of the deck that may go unread although they change the answer.
    progress : called with (stage, done, total).
    changes : "predicted": look for single changes that quieten the first places, on the reduced model; "checked": and
        make a full run of each that is told.

    Returns
    -------
    Result. A run that stops early (it diverged, or Ctrl-C) warns; `Result.stopped` says why, and what it had is kept.
    A run that created energy, or whose figures are not finite, warns too: `Result.unreliable` says why.

    Raises
    ------
    InputError : anything wrong in the study or the deck. NumericalError : a reduction or a factorisation failed.
    """
    result = run_setup(
        set_up(study, ignore, superelements=superelements),
        progress,
        superelements=superelements,
        converge=converge,
        record=record,
        changes=changes,
    )
    if result.stopped is not None:
        warnings.warn(f"the study ended early: {result.stopped}", RuntimeWarning, stacklevel=2)
    for text in result.unreliable:
        warnings.warn(f"unreliable: {text}", RuntimeWarning, stacklevel=2)
    return result


def set_up(
    study: Study | str | Path,
    ignore: Sequence[str] = (),
    units: UnitsName | None = None,
    superelements: str | Path | None = None,
) -> Setup:
    """Read and check what a study, a study file or a deck with a transient step of its own asks for.

    Parameters
    ----------
    units : of a deck that is run by itself; None: those that its materials and size fit.
    superelements : as in `run`: beside saved ones the channels of contacts are kept.

    Raises
    ------
    InputError : anything wrong in the study or the deck.
    """
    from creak.formats.endings import is_deck
    from creak.model.units import UNITS
    from creak.studies.file.paths import store_of
    from creak.studies.prepare import setup
    from creak.studies.prepare.deck_step import set_up_deck
    from creak.studies.sound.cabin import background_of, room_of
    from creak.studies.sound.listeners import listeners_of

    ignore = texts(ignore, "ignore")
    one_of(units, (*UNITS, None), "units")
    store = None if superelements is None else path_of(superelements, "superelements", "a folder")
    if not isinstance(study, Study):
        path = path_of(study, "the study", "a Study, or the path of a study file or of a deck", OF_TABLES)
        if is_deck(path):
            return set_up_deck(path, ignore, units)
        study = read_study(path)
    found = setup.set_up(study, ignore, store_of(study.path) if store is None else store)
    hearing = found.study.listening
    listeners_of(found.model, hearing.listeners, hearing.places, hearing.metre)
    background_of(hearing.background, hearing.places)
    room_of(hearing.room, hearing.places)
    return found


def run_setup(
    setup: Setup,
    progress: Progress | None = None,
    *,
    superelements: str | Path | None = None,
    converge: bool | None = None,
    record: bool = True,
    changes: Changes = "none",
    keep: bool = False,
    checkpoints: Checkpoints | None = None,
    first: Callable[[Result], object] | None = None,
    runner: Runner | None = None,
    ignore: Sequence[str] = (),
) -> Result:
    """Run what `set_up` made, parameters as `run`, and sum it up; nothing is warned of: look at the Result.

    Parameters
    ----------
    keep : save superelements in their folder, where that is there, for the runs to come.
    checkpoints : from which an unreduced run goes on, and which it writes.
    first : gets a run of more than a minute before it is repeated and explained, to save it. What fails after it is
        told as a warning.
    runner : workers who reduce the parts into the folder of superelements, with `ignore` as `set_up` had it.

    Raises
    ------
    InputError : what is asked for does not fit the model, or is not there. NumericalError : a reduction or a
        factorisation failed.
    """
    from creak.studies.evaluate import Changes, evaluate
    from creak.studies.file.paths import store_of
    from creak.studies.models.saved import Store
    from creak.studies.prepare.setup import Setup

    one_of(changes, get_args(Changes), "changes")
    one_of(converge, (True, False, None), "converge")
    of_kind(setup, Setup, "setup", "what creak.set_up made of a study")
    given = None if superelements is None else path_of(superelements, "superelements", "a folder")
    folder = store_of(setup.study.path) if given is None else given
    found = evaluate(
        setup,
        told_to(progress),
        store=Store(folder, "last" if keep else "nothing", runner, setup.study, texts(ignore, "ignore")),
        converge=converge,
        record=record,
        changes=changes,
        checkpoints=checkpoints,
        first=None if first is None else lambda so_far: first(Result.of(so_far)),
    )
    return Result.of(found)


def plain(value: Any) -> Any:
    """Numbers and arrays of NumPy as Python's own."""
    if isinstance(value, Mapping):
        return {str(k): plain(v) for k, v in value.items()}
    if hasattr(value, "tolist"):
        return plain(value.tolist())
    if isinstance(value, list | tuple):
        return [plain(v) for v in value]
    return str(value) if isinstance(value, Path) else value
