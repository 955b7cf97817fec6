"""The page of `creak modes --test`: MAC, pairs of modes over one another in 3-D, and the table."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from creak.formats.complete_file import write_text
from creak.model.units import UNITS
from creak.report.figures.correlated import correlated_scene
from creak.report.figures.run import Figure, mac_heat
from creak.report.html import file_parts, script_json
from creak.report.tables.run import Table
from creak.report.templates import page_templates
from creak.report.words.correlation import fits, pair_rows, sentence
from creak.studies.models.correlation import Correlation
from creak.version import version


def write_correlation(found: Correlation, path: Path, units: str = "mm-t-s") -> None:
    """Write the page as one self-contained HTML file; it appears whole or not at all."""
    shape, motions = correlated_scene(found)
    rows = pair_rows(found)
    good = {p.test for p in found.pairs if fits(p)}
    drawn = {"mac": _mac(found), "auto": _auto(found)}
    text = (
        page_templates("creak.report")
        .get_template("correlation.html.j2")
        .render(
            **file_parts(),
            version=version(),
            title=f"{Path(found.found.model.source).name} beside {found.measured.path.name}",
            sentence=sentence(found),
            mark="good" if len(good) == len(rows) - 1 else "look",
            pairs=Table(rows[0], rows[1:], flags=["" if k in good else "missed" for k in range(len(rows) - 1)]),
            notes=[f"{note[:1].upper()}{note[1:]}." for note in found.notes],
            figures=drawn,
            specs=script_json({name: figure.spec for name, figure in drawn.items()}),
            scene=script_json(shape),
            motions=script_json(motions),
            motion_labels=[m["label"] for m in motions],
            units=UNITS[units],
        )
    )
    write_text(path, text)


def _mac(found: Correlation) -> Figure:
    spec, height = mac_heat(
        found.mac,
        ("test", "model"),
        ("measured mode", "mode of the model"),
        (found.measured.frequencies, np.array(found.found.frequencies)),
    )
    caption = (
        "Modal assurance criterion between all modes, at the sensors and along their directions. Modes of the model "
        "count from its first, rigid ones included."
    )
    return Figure(spec, caption, height)


def _auto(found: Correlation) -> Figure:
    test = found.measured.frequencies
    spec, height = mac_heat(found.auto_mac_test, ("test", "test"), ("measured mode", "measured mode"), (test, test))
    caption = (
        "The measured modes against each other: what is dark off the diagonal are modes that the sensors cannot tell "
        "apart, whose partner is then chosen by frequency."
    )
    return Figure(spec, caption, height)
