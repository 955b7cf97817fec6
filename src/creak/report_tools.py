"""What creak's pages are made of, for pages of your own: numbers as words, tables, axes of figures, pictures of meshes.

Needs the extra `report` (`pip install 'creak[report]'`). `NONE` stands for a number that is not known, `THIN` is the
space between a number and its unit, `palette` holds the colours; a `Trace` is a curve as Plotly takes it.
"""

from __future__ import annotations

from creak.report.figures import palette
from creak.report.figures.axes import Trace, axis, base_layout, line, plain, stacked
from creak.report.figures.picture import Marks, Panel, data_uri, model_picture, panels_picture
from creak.report.figures.view import Facets, View, facets_of, front, outward
from creak.report.tables.run import Table
from creak.report.templates import page_templates, script_json
from creak.report.words.text import NONE, THIN, fixed, number, percent, plural, tidy, times

__all__ = [
    "NONE",
    "THIN",
    "Facets",
    "Marks",
    "Panel",
    "Table",
    "Trace",
    "View",
    "axis",
    "base_layout",
    "data_uri",
    "facets_of",
    "fixed",
    "front",
    "line",
    "model_picture",
    "number",
    "outward",
    "page_templates",
    "palette",
    "panels_picture",
    "percent",
    "plain",
    "plural",
    "script_json",
    "stacked",
    "tidy",
    "times",
]
