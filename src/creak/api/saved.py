"""What an earlier run left on disk, in the hands of a Python program."""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

from creak.api.extras import need_report
from creak.api.shown import Shown
from creak.given import path_of

if TYPE_CHECKING:
    from creak.report.drawn import Drawn
    from creak.studies.converge.settling import Convergence
    from creak.studies.findings.tree import Findings, FoundRun


@dataclass(frozen=True, repr=False)
class SavedResult(Shown):
    """Events and verification of an earlier run, and its report; the histories are in results.h5."""

    findings: Findings = field(repr=False)
    """Everything that the study found."""
    drawn: Drawn = field(repr=False)
    """What the report draws of model and motion."""

    @cached_property
    def summary(self) -> dict[str, Any]:
        """The content of summary.json (docs/results.md)."""
        from creak.studies.findings.summary import summary_of

        return summary_of(self.findings)

    @property
    def runs(self) -> dict[str, FoundRun]:
        """`reduced` and `reference`, those that there were."""
        return self.findings.runs

    @property
    def convergence(self) -> Convergence | None:
        """What `converge` found; None: it was not asked for."""
        return self.findings.convergence

    def report(self, path: str | Path) -> Path:
        """Write the report as one HTML file, the page that the run itself wrote; returns its path.

        Raises
        ------
        InputError : a package of the extra `report` is not installed.
        """
        need_report()
        from creak.report.html import write_page

        path = Path(path)
        path.parent.mkdir(parents=True, exist_ok=True)
        write_page(self.findings, self.drawn, path)
        return path


def open_result(folder: str | Path) -> SavedResult:
    """Read what `creak run` or `Result.save` left in a folder.

    Raises
    ------
    InputError : summary.json or results.h5 is missing, not whole, or of another version.
    """
    from creak.report.drawn import read_drawn
    from creak.studies.findings.stored import read_findings

    return SavedResult(*read_findings(path_of(folder, "folder"), read_drawn))
