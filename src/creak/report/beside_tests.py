"""What was measured beside what the run computed, on the page of the run: one part for each [test.NAME]."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

from creak.report.figures.beside_test import auto_figure, frf_figure, mac_figure, records_figure
from creak.report.figures.run import Figure
from creak.report.tables.run import Table
from creak.report.words.correlation import (
    frf_fits,
    frf_rows,
    frf_sentence,
    pair_rows,
    record_rows,
    record_sentence,
    sentence,
)
from creak.report.words.text import as_sentence
from creak.studies.findings.beside_records import RecordFits
from creak.studies.findings.tree import Findings, FoundTest
from creak.studies.models.frfs import FrfFit
from creak.verify.mode_fit import ModeFit

OFF = "missed"
"""Mark of a row that does not fit."""


@dataclass(frozen=True)
class MeasuredPlot:
    """A plot and what may be chosen of it."""

    name: str
    figure: Figure
    choices: tuple[tuple[str, str], ...] = ()
    """Name, and title of the first axis."""
    what: str = ""
    """That the list chooses."""


@dataclass(frozen=True)
class MeasuredPart:
    """One measurement."""

    title: str
    sentences: tuple[str, ...]
    plots: tuple[MeasuredPlot, ...]
    tables: tuple[Table, ...]
    notes: tuple[str, ...]


def measured_parts(result: Findings) -> list[MeasuredPart]:
    """Sentences, plots and tables of every measurement of which something was compared."""
    return [_part(k, test) for k, test in enumerate(result.tests) if test.modes or test.frfs or test.records]


def _part(k: int, test: FoundTest) -> MeasuredPart:
    sentences, tables = [], []
    if test.modes is not None:
        sentences.append(sentence(test.modes))
        tables.append(pair_table(test.modes))
    if test.frfs is not None:
        sentences.append(frf_sentence(test.frfs))
        tables.append(frf_table(test.frfs))
    if test.records is not None:
        sentences.append(record_sentence(test.records))
        tables.append(record_table(test.records))
    sides = (test.modes, test.frfs, test.records)
    notes = dict.fromkeys(as_sentence(note) for side in sides if side is not None for note in side.notes)
    return MeasuredPart(
        f"{test.name}: {test.file}", tuple(sentences), tuple(_plots(k, test)), tuple(tables), tuple(notes)
    )


def _plots(k: int, test: FoundTest) -> Iterator[MeasuredPlot]:
    if test.modes is not None:
        yield MeasuredPlot(f"test{k}-mac", mac_figure(test.modes))
        yield MeasuredPlot(f"test{k}-auto", auto_figure(test.modes))
    if test.frfs is not None:
        figure, choices = frf_figure(test.frfs)
        yield MeasuredPlot(f"test{k}-frfs", figure, tuple(choices), "function")
    if test.records is not None:
        figure, choices = records_figure(test.records)
        yield MeasuredPlot(f"test{k}-records", figure, tuple(choices), "channel")


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
