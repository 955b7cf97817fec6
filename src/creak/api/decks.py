"""Decks as models."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

from creak.given import finite, number, of_kind, path_of, texts, whole

if TYPE_CHECKING:
    from creak.model.mesh import Model
    from creak.studies.models.beside_test import BesideTest
    from creak.studies.models.correlation import Correlation
    from creak.studies.models.deck_modes import DeckModes
    from creak.studies.models.frfs import FrfComparison

A_DECK = "the path of a deck"


def read_deck(path: str | Path) -> Model:
    """Read a deck: nodes, element blocks, sections, parts, sets, surfaces, constraints.

    Parameters
    ----------
    path : Abaqus (.inp), Nastran (.bdf, .dat, .nas, .fem) or LS-DYNA (.k, .key, .dyn) deck; units are the deck's own.

    Returns
    -------
    Model, with rows instead of labels; `Model.unread` lists the keywords that were not read.

    Raises
    ------
    InputError : no such file, or a line that is wrong.
    """
    from creak.formats.decks import read_model

    return read_model(path_of(path, "path", A_DECK))


def deck_modes(
    path: str | Path, *, f_max: float | None = None, count: int | None = None, ignore: tuple[str, ...] = ()
) -> DeckModes:
    """Undamped modes K x = omega^2 M x of a deck's structure as its supports hold it, contact left out.

    Parameters
    ----------
    path : Abaqus (.inp), Nastran (.bdf, .dat, .nas, .fem) or LS-DYNA (.k, .key, .dyn) deck; or a study (.toml), with
        its supports, materials and clips.
    f_max : all modes up to this frequency, Hz. count : the lowest ones (default 20).
    ignore : keywords or cards that may go unread although they change the answer.

    Returns
    -------
    DeckModes: frequencies (Hz, rigid ones first), mass, effective masses, shapes; `translations()` gives the motion
    of all nodes, (n_node, 3) mode by mode.

    Raises
    ------
    InputError : the deck is wrong, or holds something unread that changes the answer.
    NumericalError : the modes could not be found.
    """
    from creak.studies.models import deck_modes as studies

    return studies.deck_modes(path_of(path, "path", A_DECK), f_max=f_max, count=count, ignore=texts(ignore, "ignore"))


def correlate(
    deck: str | Path,
    test: str | Path,
    *,
    f_max: float | None = None,
    count: int | None = None,
    test_units: str | None = None,
    sensors: str | Path | None = None,
    ignore: tuple[str, ...] = (),
) -> Correlation:
    """The modes of a deck beside those of a modal test: MAC, pairs, frequency and damping, what has no partner.

    Parameters
    ----------
    deck, f_max, count, ignore : as `deck_modes`; without f_max and count up to 1.3 times the highest measured
        frequency.
    test : universal file (.unv, .uff) with data sets 55, or CSV with the columns
        frequency_hz,damping,sensor,x,y,z,direction,value.
    test_units : mm, m or in; None: what the file tells, or that of the deck.
    sensors : CSV with the header sensor,node, for sensors that neither label nor place puts on the model.

    Returns
    -------
    Correlation: pairs, mac (n_test, n_model), sensors, collinearity, notes; `as_dict()` for JSON.

    Raises
    ------
    InputError : a file is wrong, sensors are not on the model, or no measured mode has a partner.
    NumericalError : the modes could not be found.
    """
    options = {"f_max": f_max, "count": count, "test_units": test_units, "ignore": ignore}
    found = _beside(deck, test, sensors, functions=False, **options).modes
    assert found is not None  # else the test was refused
    return found


def compare_frfs(
    deck: str | Path,
    test: str | Path,
    *,
    f_max: float | None = None,
    test_units: str | None = None,
    sensors: str | Path | None = None,
    ignore: tuple[str, ...] = (),
) -> FrfComparison:
    """The frequency response functions of a deck beside measured ones: FRAC, level and phase of each.

    Parameters
    ----------
    deck, test_units, sensors, ignore : as `correlate`. f_max : functions are compared up to it, Hz; None: all of them.
    test : universal file (.unv, .uff) with data sets 58 of function type 4; of modes in it too the damping is taken.

    Returns
    -------
    FrfComparison: pairs (measured function, model, frac, level, phase), error, notes; `as_dict()` for JSON.

    Raises
    ------
    InputError : a file is wrong, it holds no such functions, or sensors are not on the model.
    NumericalError : the modes could not be found.
    """
    from creak.errors import InputError

    found = _beside(deck, test, sensors, f_max=f_max, test_units=test_units, ignore=ignore).frfs
    if found is None:
        raise InputError("no frequency response functions in it", where=test, fix="Call creak.correlate for its modes.")
    return found


def _beside(deck: str | Path, test: str | Path, sensors: str | Path | None, **options: Any) -> BesideTest:
    """A deck beside a test; options as `deck_beside_test` has them."""
    from creak.studies.models.beside_test import deck_beside_test

    options["ignore"] = texts(options["ignore"], "ignore")
    table = None if sensors is None else path_of(sensors, "sensors")
    return deck_beside_test(path_of(deck, "deck", A_DECK), path_of(test, "test"), sensors=table, **options)


def write_door(
    folder: str | Path, mesh_size: float = 20.0, *, coarsen: int = 1, load: str = "A3", hook_play: float | None = None
) -> list[Path]:
    """Write the example door, door.inp and its study door.toml (mm, t, s), into a folder; returns their paths.

    Parameters
    ----------
    mesh_size : length of the elements' sides, mm, 2 to 40.
    coarsen : 1, 2 or 3 elements of the frame's flange merged into one along the contact line.
    load : A1 (no contact) to A4 (most contact).
    hook_play : play of the panel's hooks to either side, mm; None: they are rigid.

    Raises
    ------
    InputError : a size, number or load that there is not, or `folder` is a file.
    """
    from creak_thesis.door import writer

    of_kind(load, str, "load", "a text: A1 to A4")
    play = None if hook_play is None else finite(hook_play, "hook_play")
    size, merged = number(mesh_size, "mesh_size"), whole(coarsen, "coarsen", 1, 3)
    return writer.write_door(size, path_of(folder, "folder"), merged, load, play)
