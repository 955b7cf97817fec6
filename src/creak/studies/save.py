"""What a study leaves on disk: summary.json and results.h5, complete or absent."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np

from creak.assembly.recovery import by_node, recovered
from creak.dynamics.history import ENERGIES
from creak.formats.complete_file import complete_file
from creak.formats.results import Field, RunRecord, write_results
from creak.studies.run import Run, StudyResult


def save(result: StudyResult, summary: dict[str, Any], folder: Path) -> list[Path]:
    """Write both files into `folder` (made if need be); each appears under its name only when complete."""
    folder.mkdir(parents=True, exist_ok=True)
    results, text = folder / "results.h5", folder / "summary.json"
    records = {name: _record(run, result) for name, run in result.runs.items()}
    c = result.setup.study.config
    attributes = {"creak": summary["creak"], "title": c.title, "units": c.model.units,
                  "study": result.setup.study.text}  # fmt: skip
    write_results(results, records, attributes, c.model.units)
    with complete_file(text) as partial:
        partial.write_text(json.dumps(summary, indent=2, allow_nan=False) + "\n", encoding="utf-8")
    return [text, results]


def _record(run: Run, result: StudyResult) -> RunRecord:
    h, nodes, watched = run.history, result.setup.model.nodes, result.setup.watched
    at = h.output_index
    return RunRecord(
        time=h.time[at],
        gap=h.gap[at],
        normal_force=h.force[at],
        slip=h.slip,
        displacement=h.displacement.reshape(at.size, watched.size, 6),
        node_ids=nodes.ids[watched].astype(np.int64),
        node_names=[nodes.label(int(i)) for i in watched],
        channels=result.gaps.names,
        channel_nodes=nodes.ids[result.gaps.nodes_idx].astype(np.int64),
        energy=h.energy[at],
        energy_terms=ENERGIES,
        field=_field(run, result),
    )


def _field(run: Run, result: StudyResult) -> Field | None:
    h, nodes = run.history, result.setup.model.nodes
    if not h.whole_at.size:
        return None
    s = result.setup.loads.support[0, h.whole_at].T
    labels = run.system.labels
    blocks = ((here, by_node(u, labels, nodes.count)) for here, u in recovered(run.system, h.coordinates, s))
    return Field(h.time[h.whole_at], blocks, nodes.ids.astype(np.int64), nodes.coords)
