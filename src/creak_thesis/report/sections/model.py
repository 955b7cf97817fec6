"""The door, its supports and its loads (thesis 3.1.2 and 3.2)."""

from __future__ import annotations

from creak.report_tools import fixed, number
from creak_thesis.doors import DoorFacts
from creak_thesis.report.blocks import PictureBlock, Section, TableBlock, Text, agree, differ
from creak_thesis.report.facts import Facts, thesis
from creak_thesis.report.tables import load_table, material_table, size_table, support_table
from creak_thesis.report.words import by_load, event_rates


def model_section(
    facts: Facts, door: DoorFacts | None, pictures: dict[str, PictureBlock], amplitudes: dict[str, float]
) -> Section:
    section = Section("model", "The door, its supports and its loads")
    section.blocks += [
        pictures["parts"],
        pictures["supports"],
        TableBlock("Table 3.1: parts", material_table(door)),
        TableBlock("Table 3.2: size", size_table(door)),
        TableBlock("Table 3.3: supports", support_table(door)),
        TableBlock("Table 3.4: loads", load_table(facts, amplitudes)),
        agree(_agree(facts), not out_of_range(facts)),
        differ(_differ(facts, door)),
        Text(
            "Figures 1.1, 1.2, 2.1, 3.6 and A.1 of the thesis are schematic or photographs of the test: they hold no "
            "result.",
            "small",
        ),
    ]
    return section


def out_of_range(facts: Facts) -> dict[str, str]:
    """Loads whose number of events per second is not within the thesis's range."""
    told = thesis()["loads"]
    rates = {k: v for k, v in event_rates(facts, "Ref StS").items() if v is not None}
    return {k: str(v) for k, v in rates.items() if not told[k]["events"][0] <= v <= told[k]["events"][1]}


def _agree(facts: Facts) -> str:
    text = "Materials, thicknesses, supports and links are those of the thesis."
    rates = {k: str(v) for k, v in event_rates(facts, "Ref StS").items() if v is not None}
    if not rates:
        return text
    outside = out_of_range(facts)
    text += f" The loads give {by_load(rates)} contact events per second"
    return text + (f"; outside the thesis's range: {by_load(outside)}." if outside else ", all within its ranges.")


def _differ(facts: Facts, door: DoorFacts | None) -> str:
    text = (
        "The thesis's door is confidential; creak's is a parametric one of nearly the same mass, with the "
        "same materials and joints, but its shape is its own, so its modes and the place of its contact are too. "
    )
    if door is not None:
        text += f"This page uses a mesh of {facts.mesh_size:g} mm with {number(door.n_dof)} dofs"
        text += f" and {fixed(door.mass, 2)} kg. "
    return text + (
        "Amplitudes cannot be compared: a sine of 1.4 mm is 56 g at 100 Hz, and one at every frequency would throw "
        "this door far beyond 17 events per second, so creak scales them to the thesis's number of events."
    )
