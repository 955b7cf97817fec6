"""`creak info`: what a deck holds, and what of it was not read."""

from __future__ import annotations

from pathlib import Path

import typer
from rich.console import Console
from rich.table import Table


def info(deck: Path = typer.Argument(..., metavar="DECK", help="The deck to look at.")) -> None:
    """Parts, mass, dofs, sets, surfaces, and every keyword that was not read."""
    from creak.assembly.part import Rayleigh, part_system
    from creak.studies.setup import read_model

    model = read_model(deck)
    console = Console()
    console.print(f"{deck}: {model.nodes.count} nodes, {model.n_elements} elements, "
                  f"{len(model.constraints)} constraints", markup=False)  # fmt: skip
    parts = Table("part", "nodes", "elements", "kinds", "dof", "mass", title="Parts", title_justify="left")
    total = 0.0
    for i, part in enumerate(model.parts):
        system = part_system(model, i, Rayleigh(0.0, 0.0), override=True)
        kinds = ", ".join(sorted({b.kind for b in model.blocks if b.part == i}))
        total += system.stats["mass"]
        parts.add_row(part.name, f"{part.nodes_idx.size}", f"{int(system.stats['elements'])}", kinds,
                      f"{system.n}", f"{system.stats['mass']:.6g}")  # fmt: skip
    console.print(parts)
    console.print(f"mass in all: {total:.6g}")
    _listing(console, "node sets", {k: f"{v.size}" for k, v in model.node_sets.items()})
    _listing(console, "element sets", {k: f"{len(v)}" for k, v in model.element_sets.items()})
    surfaces = {k: f"{s.facets.shape[0]} facets" if not s.is_node_based else f"{s.nodes_idx.size} nodes"
                for k, s in model.surfaces.items()}  # fmt: skip
    _listing(console, "surfaces", surfaces)
    if not model.unread:
        console.print("every keyword was read")
    for u in model.unread:
        effect = "changes the answer" if u.changes_answer else "does not change the answer"
        console.print(f"not read: {u.keyword} ({u.where}), {effect}: {u.why}", markup=False, soft_wrap=True)


def _listing(console: Console, title: str, entries: dict[str, str]) -> None:
    shown = {k: v for k, v in entries.items() if not k.startswith("_")}
    if shown:
        text = ", ".join(f"{k} ({v})" for k, v in shown.items())
        console.print(f"{title}: {text}", markup=False, highlight=False)
