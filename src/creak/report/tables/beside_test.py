"""What was measured beside what was computed, as tables; rows that do not fit are marked."""

from __future__ import annotations

from creak.report.tables.run import Table
from creak.report.words.correlation import frf_fits, frf_rows, pair_rows
from creak.report.words.records import record_rows
from creak.studies.findings.beside_records import RecordFits
from creak.studies.models.frfs import FrfFit
from creak.verify.mode_fit import ModeFit

OFF = "missed"
"""Mark of a row that does not fit."""


def pair_table(found: ModeFit) -> Table:
    """A row for each measured mode."""
    rows, good = pair_rows(found), {p.test for p in found.pairs if p.fits}
    return Table(rows[0], rows[1:], flags=["" if k in good else OFF for k in range(len(rows) - 1)])


def frf_table(found: FrfFit) -> Table:
    """A row for each function."""
    rows = frf_rows(found)
    return Table(rows[0], rows[1:], flags=["" if frf_fits(p) else OFF for p in found.pairs])


def record_table(found: RecordFits) -> Table:
    """A row for each channel."""
    rows = record_rows(found)
    return Table(rows[0], rows[1:])
