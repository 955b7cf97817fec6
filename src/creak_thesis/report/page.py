"""thesis.html: the thesis and creak side by side, in one file that opens anywhere."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from markupsafe import Markup

import creak
from creak import write_text
from creak.report_tools import THIN, page_templates, script_json
from creak_thesis.doors import Doors
from creak_thesis.outcome import Outcome
from creak_thesis.record import RecordStudy
from creak_thesis.report import answers, pictures
from creak_thesis.report.blocks import Block, FigureBlock, Finding, PictureBlock, Section
from creak_thesis.report.facts import Facts, million
from creak_thesis.report.sections.beyond import interface_section, play_section, step_section
from creak_thesis.report.sections.coarse import coarse_section
from creak_thesis.report.sections.cost import cost_section
from creak_thesis.report.sections.distance import distance_section
from creak_thesis.report.sections.million import million_section
from creak_thesis.report.sections.model import model_section
from creak_thesis.report.sections.node import node_section
from creak_thesis.report.sections.participation import participation_section
from creak_thesis.report.sections.ranges import range_section
from creak_thesis.report.sections.signal import signal_section
from creak_thesis.report.sections.spacing import precheck_section, spacing_section
from creak_thesis.report.summary import findings

PICTURES = {
    "parts": "Figure 3.4",
    "supports": "Figure 3.5",
    "pairs": "Figure 3.7 and C.1",
    "main": "Figure 3.10",
    "distance": "Figure 3.11",
    "coarse": "Figure 3.12",
}
NO_DOOR = "No picture: the door was not built."
NO_CHANNELS = "No picture: without the unreduced run under A4 the channels of the pre-check are not known."


@dataclass(frozen=True)
class Inputs:
    """Everything that the page is made of; what is absent is said on the page."""

    mesh_size: float
    outcomes: Mapping[str, Outcome]
    record: RecordStudy | None = None
    doors: Doors | None = None
    amplitudes: Mapping[str, float] = field(default_factory=dict)
    """Of each sine under A1 to A4, mm."""
    million: Mapping[str, Any] | None = field(default_factory=million)


def write_thesis_page(inputs: Inputs, path: Path) -> None:
    """Write the page as one self-contained HTML file; it appears whole or not at all."""
    text = thesis_page(inputs)
    write_text(path, text)


def thesis_page(inputs: Inputs) -> str:
    """The page as HTML."""
    from plotly.offline import get_plotlyjs

    facts = Facts(inputs.mesh_size, inputs.outcomes)
    parts = sections(inputs, facts)
    lines = findings(facts, inputs.record)
    environment = page_templates("creak_thesis.report")
    environment.filters["kind"] = lambda block: type(block).__name__
    environment.filters["tight"] = lambda words: words.replace(" %", f"{THIN}%")
    environment.globals["ids"] = id
    specs, ids = _specs(parts)
    return environment.get_template("thesis.html.j2").render(
        version=creak.__version__,
        mesh_size=f"{inputs.mesh_size:g}",
        findings=lines,
        verdict=verdict(lines),
        sections=parts,
        failed=[(name, o.reason) for name, o in facts.outcomes.items() if o.reason],
        figure_ids=ids,
        specs=script_json(specs),
        answered=[
            ("questions", "The five questions of section 1.2", answers.questions(facts)),
            ("recommendations", "The four recommendations of section 5.2", answers.recommendations(facts)),
            ("open", "The four open points of section 5.3", answers.open_points(facts)),
        ],
        plotly=Markup(get_plotlyjs()),
    )


def sections(inputs: Inputs, facts: Facts) -> list[Section]:
    """The sections in the order of the thesis, then beyond it."""
    drawn = _pictures(inputs)
    doors = inputs.doors
    channels = None if doors is None else doors.setup.contacts.m
    return [
        signal_section(inputs.record),
        model_section(facts, None if doors is None else doors.facts, drawn, dict(inputs.amplitudes)),
        spacing_section(facts, drawn),
        precheck_section(facts, channels, drawn),
        range_section(facts),
        distance_section(facts, drawn),
        participation_section(facts),
        coarse_section(facts, drawn),
        node_section(facts),
        cost_section(facts),
        million_section(None if inputs.million is None else dict(inputs.million)),
        step_section(facts),
        interface_section(facts),
        play_section(facts),
    ]


def verdict(lines: list[Finding]) -> str:
    """The first sentence of the page."""
    count = {mark: sum(f.mark == mark for f in lines) for mark in ("same", "explained", "differs", "not run")}
    words = (
        f"Of {len(lines)} findings of the thesis creak confirms {count['same']}, explains or moves on from "
        f"{count['explained']} and differs in {count['differs']}"
    )
    return words + (f"; {count['not run']} are not run here." if count["not run"] else ".")


def _pictures(inputs: Inputs) -> dict[str, PictureBlock]:
    doors = inputs.doors
    if doors is None:
        return {k: PictureBlock(t, "", NO_DOOR) for k, t in PICTURES.items()}
    drawn = {
        "parts": pictures.parts_picture(doors),
        "supports": pictures.supports_picture(doors),
        "pairs": pictures.pairs_picture(doors),
        "coarse": pictures.coarse_picture(doors, inputs.mesh_size),
    }
    if doors.kept is None:
        return drawn | {k: PictureBlock(PICTURES[k], "", NO_CHANNELS) for k in ("main", "distance")}
    return drawn | {
        "main": pictures.main_model_picture(doors, doors.kept),
        "distance": pictures.distance_picture(doors, doors.kept),
    }


def _specs(parts: list[Section]) -> tuple[dict[str, Any], dict[int, str]]:
    """Specifications of the figures by the id of their place, and the id of each figure block."""
    specs: dict[str, Any] = {}
    ids: dict[int, str] = {}
    blocks: list[Block] = [b for s in parts for b in s.blocks]
    for block in blocks:
        if isinstance(block, FigureBlock) and block.spec is not None:
            ids[id(block)] = name = f"plot-{len(specs) + 1}"
            specs[name] = block.spec
    return specs, ids
