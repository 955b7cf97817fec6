"""`creak modes`: natural frequencies, effective masses and mode shapes of a deck, or of a study."""

from __future__ import annotations

import math
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

import typer
from rich.box import SIMPLE_HEAD
from rich.table import Table

from creak.cli.details import list_unread, model_detail, tell_notes, tell_vain
from creak.cli.output import IGNORE, JSON_FILE, QUIET, VERBOSE, Output, is_stdout, writable_files
from creak.errors import InputError
from creak.model.units import UnitsName

if TYPE_CHECKING:
    from creak.arrays import FloatArray
    from creak.model.units import UnitsName
    from creak.studies.models.beside_test import BesideTest
    from creak.studies.models.deck_modes import DeckModes

LengthName = Literal["mm", "m", "in"]
DIRECTIONS = ("X", "Y", "Z", "RX", "RY", "RZ")
ROUND_OFF = 1e-6
"""Participation factors below this share of the square root of the model's inertia are shown as 0."""


def modes(
    deck: Path = typer.Argument(..., metavar="DECK", help="The deck; or a study: its supports, materials and clips."),
    f_max: float | None = typer.Option(None, "--f-max", help="All modes up to this frequency, Hz."),
    count: int | None = typer.Option(None, "--count", help="The lowest modes; default 20."),
    about: str = typer.Option("0,0,0", "--about", metavar="X,Y,Z", help="Point of the rotations of effective mass."),
    vtk: Path | None = typer.Option(None, "--vtk", help="Write the shapes here (.vtu) for ParaView."),
    uff: Path | None = typer.Option(None, "--uff", help="Write the shapes here as a universal file (data set 55)."),
    pch: Path | None = typer.Option(None, "--pch", help="Write the shapes here as a Nastran punch file (.pch)."),
    units: UnitsName = typer.Option("mm-t-s", "--units", help="Units named in the universal file."),
    test: Path | None = typer.Option(
        None, "--test", metavar="MEASURED", help="Modes or FRFs of a test, universal file (55, 58) or CSV: what fits?"
    ),
    test_units: LengthName | None = typer.Option(
        None, "--test-units", help="Length of the test's points; default: as its file says, or the deck's."
    ),
    sensors: Path | None = typer.Option(None, "--sensors", help="CSV with the columns sensor,node."),
    page: Path | None = typer.Option(None, "--page", help="Write what fits, shapes and functions as a page."),
    ignore: list[str] = IGNORE,
    quiet: bool = QUIET,
    verbose: bool = VERBOSE,
    json_file: Path | None = JSON_FILE,
) -> None:
    """Natural frequencies of the linear structure, contact left out; effective masses and shapes.

    Example: creak modes door/door.inp --f-max 100 --vtk modes.vtu
    """
    from creak.formats.deck.command_files import will_read
    from creak.studies.models.deck_modes import deck_modes

    point = _point(about)
    if vtk is not None and vtk.suffix.lower() != ".vtu":
        raise InputError(f"--vtk {vtk}", expected="a file name that ends in .vtu")
    on_stdout = is_stdout(json_file)
    require_test(test, test_units, sensors, page)
    will_read(deck, *(path for path in (test, sensors) if path is not None))
    files = writable_files((vtk, uff, pch, page, None if on_stdout else json_file))
    with Output(quiet, verbose, on_stdout) as output:
        with output.progress as progress:
            if test is None:
                found, beside = (
                    deck_modes(deck, f_max=f_max, count=count, about=point, ignore=ignore, progress=progress),
                    None,
                )
            else:
                from creak.studies.models.beside_test import deck_beside_test

                beside = deck_beside_test(
                    deck,
                    test,
                    f_max=f_max,
                    count=count,
                    about=point,
                    units=units,
                    test_units=test_units,
                    sensors=sensors,
                    ignore=ignore,
                    progress=progress,
                )
                found = beside.found
            data = _data(found) if beside is None else {**_data(found), **test_data(beside)}
            model_detail(output, found.model)
            for path in files:
                path.parent.mkdir(parents=True, exist_ok=True)
            _write(output, found, (vtk, uff, pch), units, deck.name)
            if beside is not None and page is not None:
                write_page(output, beside, page, units)
            if json_file is not None and not on_stdout:
                output.write(data, json_file)
        tell_vain(output, found.model, ignore)
        if beside is not None:
            print_beside(output, beside)
            _print_checks(output, found)
        else:
            _print(output, found)
        ids = found.model.nodes.ids.tolist()
        if (uff is not None or pch is not None) and len(set(ids)) < len(ids):
            output.say(
                "note: instances repeat node labels; universal and punch files number the nodes 1, 2, ... in the "
                "order of the deck"
            )
        output.tell_written()
        output.result({**data, "written": [str(path) for path in output.written]})


def _point(text: str) -> tuple[float, ...]:
    try:
        point = tuple(float(word) for word in text.split(","))
    except ValueError:
        point = ()
    if len(point) != 3 or not all(map(math.isfinite, point)):
        raise InputError(f"--about {text}", expected="three numbers X,Y,Z without blanks, for instance 0,0,120.5")
    return point


def _write(
    output: Output, found: DeckModes, paths: tuple[Path | None, Path | None, Path | None], units: UnitsName, title: str
) -> None:
    """The shapes, for ParaView, as a universal file, as a punch file."""
    vtk, uff, pch = paths
    if vtk is not None:
        from creak.formats.vtu import write_vtu

        with output.progress.phase("write the shapes for ParaView"):
            write_vtu(vtk, found.model, found.frequencies, found.translations())
        output.wrote(vtk)
    if uff is not None:
        from creak.formats.measured.uff import write_uff

        with output.progress.phase("write the universal file"):
            write_uff(uff, found.model, found.frequencies, found.translations(), units, title=title)
        output.wrote(uff)
    if pch is not None:
        from creak.formats.measured.punch import write_mode_punch

        with output.progress.phase("write the punch file"):
            write_mode_punch(pch, found.model, found.frequencies, found.motion(), title=title)
        output.wrote(pch)


def _data(found: DeckModes) -> dict[str, object]:
    e = found.effective
    return {
        "frequencies": found.frequencies,
        "mass": found.mass,
        "rigid": found.rigid,
        "residual": found.residual,
        "sturm_ok": found.sturm_ok,
        "prestress": found.prestress.where if found.prestress is not None else None,
        "effective_mass": {
            "about": e.about.tolist(),
            "directions": DIRECTIONS,
            "total": e.total.tolist(),
            "participation": e.participation.tolist(),
            "effective": e.effective.tolist(),
            "cumulative_share": e.cumulative.tolist(),
        },
    }


def _print(output: Output, found: DeckModes) -> None:
    import numpy as np

    from creak.studies.prepare.massless import massless_words

    e, (length, mass) = found.effective, _units(found)
    if not found.frequencies:
        output.say("no modes: none in the range, or the model has no mass that can move")
        for text in massless_words(found.model):
            output.warn(text)
    else:
        x, y, z = e.about.tolist()
        about = f"rotations about {x:g}, {y:g}, {z:g} {length}".rstrip()
        share = _table(found, f"Effective mass, % of the model; {about}", 100.0 * e.share)
        share.add_section()
        share.add_row("sum", "", *_cells(100.0 * e.cumulative[-1], e.total, "{:.2f}"))
        share.add_row(f"model, {mass}".removesuffix(", "), "", *_cells(e.total, e.total, "{:.4g}"))
        output.console.print(share)
        output.console.print(_table(found, "Cumulative effective mass, %", 100.0 * e.cumulative))
        factors = np.where(np.abs(e.participation) < ROUND_OFF * np.sqrt(e.total), 0.0, e.participation)
        output.console.print(_table(found, "Participation factors, mass-normalised modes", factors, "{:.3g}"))
    _print_checks(output, found)


def _units(found: DeckModes) -> tuple[str, str]:
    """Of length and mass, where all systems in which materials and size are plausible agree."""
    from creak.cli.info import shared_words
    from creak.studies.prepare.unit_check import guessed_units

    return shared_words(guessed_units(found.model))


def _print_checks(output: Output, found: DeckModes) -> None:
    from creak.studies.prepare.unit_check import guessed_units

    fast = next((s.name for s in guessed_units(found.model) if s.name.endswith("-ms")), "")
    if fast:
        output.warn(
            f"materials and size fit {fast}, with times in ms: what is said in Hz, as of --f-max, is in kHz then"
        )
    list_unread(output, tuple(u for u in found.model.unread if u.used))
    if found.prestress is not None:
        output.say(f"with the linear stress of {found.prestress.keyword} ({found.prestress.where})")
    _, mass = _units(found)
    sturm = "agrees" if found.sturm_ok else "DOES NOT AGREE: a mode may be missing"
    output.say(
        f"mass {found.mass:.6g} {mass}".rstrip()
        + f", {found.rigid} rigid-body mode(s), largest residual {found.residual:.1e}, "
        f"Sturm count {sturm}"
    )


def _table(found: DeckModes, title: str, rows: FloatArray, form: str = "{:.2f}") -> Table:
    table = Table(title=title, title_justify="left", box=SIMPLE_HEAD, padding=(0, 1, 0, 0), pad_edge=False)
    table.add_column("mode", no_wrap=True)
    table.add_column("Hz", no_wrap=True)
    for direction in DIRECTIONS:
        table.add_column(direction, justify="right", no_wrap=True)
    for i, (f, row) in enumerate(zip(found.frequencies, rows, strict=True), start=1):
        table.add_row(f"{i}", f"{f:.6g}", *_cells(row, found.effective.total, form))
    return table


def _cells(values: FloatArray, total: FloatArray, form: str) -> list[str]:
    """A dash where the model has no inertia in the direction."""
    return [form.format(v) if t > 0.0 else "-" for v, t in zip(values.tolist(), total.tolist(), strict=True)]


def require_test(test: Path | None, test_units: str | None, sensors: Path | None, page: Path | None) -> None:
    """Check that options which belong to a test stand with one.

    Raises
    ------
    InputError : one of them stands alone, or what draws the page is not installed.
    """
    from creak.api.extras import need_report

    given = {"--test-units": test_units, "--sensors": sensors, "--page": page}
    alone = [name for name, value in given.items() if value is not None]
    if test is None and alone:
        raise InputError(f"{alone[0]} without --test", expected="--test MEASURED", fix="Name the file of the test.")
    if page is not None:
        need_report("--json")


def test_data(found: BesideTest) -> dict[str, Any]:
    """For machines."""
    from creak.report.words.correlation import frf_sentence, sentence

    data: dict[str, Any] = {}
    if found.modes is not None:
        data["correlation"] = {"sentence": sentence(found.modes), **found.modes.as_dict()}
    if found.frfs is not None:
        data["frfs"] = {"sentence": frf_sentence(found.frfs), **found.frfs.as_dict()}
    return data


def write_page(output: Output, found: BesideTest, path: Path, units: UnitsName) -> None:
    """MAC, shapes, functions and tables as one HTML file."""
    from creak.report.correlation_page import write_correlation

    with output.progress.phase("write the page"):
        write_correlation(found, path, units)
    output.wrote(path)


def print_beside(output: Output, found: BesideTest) -> None:
    """Tables, sentences and notes."""
    from creak.report.words.correlation import frf_rows, frf_sentence, pair_rows, sentence

    if found.modes is not None:
        name = found.modes.measured.path.name
        output.table(f"Modes of {name} and their partners in the model", pair_rows(found.modes))
        output.say(sentence(found.modes))
    if found.frfs is not None:
        output.table(f"Functions of {found.frfs.measured.path.name} and of the model", frf_rows(found.frfs))
        output.say(frf_sentence(found.frfs))
    tell_notes(output, found.notes, set())
