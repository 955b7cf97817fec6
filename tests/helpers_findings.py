"""Findings of a result, and the views of them that tests look at."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

from creak.arrays import IntArray
from creak.report.drawn import ANIMATION_BYTES, Drawn, drawn_of
from creak.studies.evaluate import Evaluation
from creak.studies.findings.gather import findings_of
from creak.studies.findings.save import save
from creak.studies.findings.summary import summary_of
from creak.studies.findings.tree import Findings
from creak.studies.run.job import StudyResult
from creak.studies.sound.heard import Sound, hear


def summarised(result: StudyResult, *told: Any, **more: Any) -> dict[str, Any]:
    """The content of summary.json; what is told of the result as `findings_of` takes it."""
    return summary_of(findings_of(result, *told, **more))


def to_draw(result: StudyResult, *told: Any, size: int = ANIMATION_BYTES, **more: Any) -> tuple[Findings, Drawn]:
    """What a page takes; its motion may take so many bytes."""
    findings = findings_of(result, *told, **more)
    return findings, drawn_of(result.main, result.reference, findings, size)


def sound_of(result: StudyResult, places: Sequence[IntArray]) -> Sound | str:
    """What is heard of its main run; places: channels of each."""
    s, run = result.setup, result.main
    return hear(s.study.listening, s.marching, s.reduction, result.reference, result.reduced, run, places)


def save_plain(result: StudyResult, folder: Path) -> list[Path]:
    """Its files without what a page needs."""
    found = Evaluation(result, findings_of(result))
    return save(found.findings, found.records(), folder)
