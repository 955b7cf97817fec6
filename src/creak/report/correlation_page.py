"""Pages of what was measured over what was computed: modes and functions of a deck, and courses of a run."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from creak.arrays import FloatArray, IntArray
from creak.formats.complete_file import write_text
from creak.model.units import UNITS
from creak.report.beside_tests import frf_table, pair_table, record_table
from creak.report.drawn import LIMIT
from creak.report.figures import beside_test as beside
from creak.report.figures.beside_test import records_figure
from creak.report.figures.scene import drawn_surface, part_of, period
from creak.report.figures.view import Surface, front, surface_of
from creak.report.html import file_parts
from creak.report.tables.run import Table
from creak.report.templates import page_templates, script_json
from creak.report.words.correlation import frf_sentence, record_sentence, sentence
from creak.report.words.text import as_sentence, number
from creak.report.words.update import gained_note, mode_rows, parameter_rows, update_notes, update_sentence
from creak.studies.findings.beside_records import RecordComparison
from creak.studies.models.beside_test import BesideTest
from creak.studies.models.correlation import Correlation
from creak.studies.models.update import ModelUpdate
from creak.studies.warned import plain_notes, warnings_of
from creak.verify.mode_fit import ModePair
from creak.version import version

MOST_NODES = 8000
"""Of the model that are drawn: each pair takes 8 bytes for each."""
MOST_PAIRS = 40
LINES, BESIDE = "lines of the test", "the test beside the model"
APART = 1.15
"""Of the model's width: how far to the right the test is drawn once more."""
COLOUR = "#d55e00"


def write_update(found: ModelUpdate, path: Path) -> None:
    """Write the page of a changed study: its modes beside the test, and what was changed."""
    units = found.study.config.model.units
    write_correlation(BesideTest(found.after.found, found.after, None), path, units, found)


def write_correlation(found: BesideTest, path: Path, units: str = "mm-t-s", update: ModelUpdate | None = None) -> None:
    """Write the page as one self-contained HTML file; it appears whole or not at all.

    Parameters
    ----------
    update : what brought the modes there.
    """
    modes, frfs = found.modes, found.frfs
    test = next(side.measured.path.name for side in (modes, frfs) if side is not None)
    shape, motions = (None, []) if modes is None else correlated_scene(modes)
    drawn = {} if modes is None else {"mac": beside.mac_figure(modes), "auto": beside.auto_figure(modes)}
    choices: list[tuple[str, str]] = []
    if frfs is not None:
        drawn["frfs"], choices = beside.frf_figure(frfs)
    pairs = None if modes is None else pair_table(modes)
    functions = None if frfs is None else frf_table(frfs)
    sentences = [*([] if modes is None else [sentence(modes)]), *([] if frfs is None else [frf_sentence(frfs)])]
    all_good = not any(flag for table in (pairs, functions) if table is not None for flag in table.flags)
    title = Path(found.found.model.source).name
    parameters = changes = None
    notes = [*([] if update is None else gained_note(update)), *plain_notes(found.notes)]
    doubts = warnings_of(found.notes)
    if update is not None:
        parameters, changes = (Table(rows[0], rows[1:]) for rows in (parameter_rows(update), mode_rows(update)))
        sentences, title = [update_sentence(update), *sentences], update.study.path.name
        doubts = [*update_notes(update), *doubts]
    text = (
        page_templates("creak.report")
        .get_template("correlation.html.j2")
        .render(
            **file_parts(),
            version=version(),
            title=f"{title} beside {test}",
            sentences=sentences,
            mark="good" if all_good else "look",
            parameters=parameters,
            changes=changes,
            pairs=pairs,
            functions=functions,
            choices=choices,
            error=None if frfs is None else number(frfs.error, 2),
            doubts=[as_sentence(doubt) for doubt in doubts],
            notes=[as_sentence(note) for note in notes],
            figures=drawn,
            specs=script_json({name: figure.spec for name, figure in drawn.items()}),
            scene=script_json(shape),
            motions=script_json(motions),
            motion_labels=[m["label"] for m in motions],
            units=UNITS[units],
        )
    )
    write_text(path, text)


def write_records(found: RecordComparison, path: Path) -> None:
    """Write the page as one self-contained HTML file; it appears whole or not at all."""
    figure, choices = records_figure(found)
    drawn = {"records": figure}
    text = (
        page_templates("creak.report")
        .get_template("records.html.j2")
        .render(
            **file_parts(),
            version=version(),
            title=f"{found.results.name} beside {found.test.name}",
            sentence=record_sentence(found),
            channels=record_table(found),
            choices=choices,
            notes=[as_sentence(note) for note in found.notes],
            figures=drawn,
            specs=script_json({name: figure.spec for name, figure in drawn.items()}),
        )
    )
    write_text(path, text)


def correlated_scene(found: Correlation) -> tuple[dict[str, Any] | None, list[dict[str, Any]]]:
    """The surface of the model with the measured points behind its nodes, these once more beside it, and a period of
    each pair of modes.

    A measured point has the smallest motion that gives what its directions measured, in the scale and the sign that
    fit the mode of the model best. None where the model has nothing that can be drawn.
    """
    model = found.found.model
    surface = surface_of(model, np.zeros(0, dtype=np.int64), MOST_NODES)
    if surface is None:
        return None, []
    names, first = np.unique(found.measured.sensors, return_index=True)
    row_of = {str(name): len(surface.nodes_idx) + k for k, name in enumerate(names)}
    of = np.array([row_of[name] for name in found.measured.sensors])
    xyz = np.concatenate([model.nodes.coords[surface.nodes_idx], found.sensors.points[first]])
    ids = np.concatenate([model.nodes.ids[surface.nodes_idx], model.nodes.ids[found.sensors.nodes_idx[first]]])
    view = front(model.nodes.coords, np.zeros(3)).matrix
    right = APART * float(np.ptp(model.nodes.coords @ view[:, 0])) * view[:, 0]
    xyz, ids = np.concatenate([xyz, found.sensors.points[first] + right]), np.concatenate([ids, ids[-names.size :]])
    joined = [(row_of[a], row_of[b]) for a, b in found.measured.lines if a in row_of and b in row_of]
    lines = np.array(joined, dtype=np.int64).reshape(-1, 2)
    edges = np.concatenate([surface.edges, lines, lines + names.size])
    parts = [part_of(model, row) for row in surface.parts.tolist()]
    for k, name in enumerate((LINES, BESIDE) if joined else ()):
        ends, drawn = [len(surface.triangles), 0], [len(surface.edges) + k * len(joined), len(joined)]
        parts.append({"name": name, "colour": COLOUR, "triangles": ends, "edges": drawn})
    shape = {
        **drawn_surface(xyz, ids, surface.triangles, edges),
        "parts": parts,
        "view": view.T.tolist(),
        "marks": {"measured": [*row_of.values(), *(row + names.size for row in row_of.values())]},
        "places": [],
        "impulse": None,
    }
    return shape, _motions(found, surface, xyz, of)


def _motions(found: Correlation, surface: Surface, xyz: FloatArray, of: IntArray) -> list[dict[str, Any]]:
    shown: dict[int, ModePair] = {p.model: p for p in found.pairs[:MOST_PAIRS]}
    made = {}
    for k, u in enumerate(found.found.translations()):
        if k in shown:
            p = shown[k]
            moved = np.zeros((len(xyz), 3))
            moved[: len(surface.nodes_idx)] = u[surface.nodes_idx]
            along = p.scale * found.test_shapes[:, p.test]
            for row in np.unique(of):
                own = np.linalg.pinv(found.measured.directions[of == row]) @ along[of == row]
                moved[[row, row + len(np.unique(of))]] = own
            largest = float(np.abs(moved).max()) or 1.0
            label = f"{p.frequency_test:g} Hz measured, {p.frequency_model:.6g} Hz in the model, MAC {p.mac:.3f}"
            short = np.round(moved.ravel() * (LIMIT / largest)).astype(np.int16)
            made[k] = period(label, p.frequency_test, short, xyz)
    return [made[p.model] for p in found.pairs[:MOST_PAIRS]]
