"""What `creak modes --test` shows: pairs of modes, what fits, and the page."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

from creak.cli.output import Output
from creak.errors import InputError

if TYPE_CHECKING:
    from creak.model.units import UnitsName
    from creak.studies.models.correlation import Correlation


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


def correlation_data(found: Correlation) -> dict[str, Any]:
    """For machines."""
    from creak.report.words.correlation import sentence

    return {"sentence": sentence(found), **found.as_dict()}


def write_page(output: Output, found: Correlation, path: Path, units: UnitsName) -> None:
    """MAC, shapes and table as one HTML file."""
    from creak.report.correlation_page import write_correlation

    with output.progress.phase("write the page"):
        write_correlation(found, path, units)
    output.wrote(path)


def print_correlation(output: Output, found: Correlation) -> None:
    """The table, the sentence, and the notes."""
    from creak.report.words.correlation import pair_rows, sentence

    output.table(f"Modes of {found.measured.path.name} and their partners in the model", pair_rows(found))
    output.say(sentence(found))
    for note in found.notes:
        output.say(f"note: {note}")
