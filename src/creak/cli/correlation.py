"""What `creak modes --test` shows: pairs of modes, frequency response functions, what fits, and the page."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

from creak.cli.details import tell_notes
from creak.cli.output import Output
from creak.errors import InputError

if TYPE_CHECKING:
    from creak.model.units import UnitsName
    from creak.studies.models.beside_test import BesideTest


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
