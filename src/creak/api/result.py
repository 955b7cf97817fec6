"""What a study found, in the hands of a Python program."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any

from creak.api.extras import need_report

if TYPE_CHECKING:
    from creak.dynamics.history import History
    from creak.studies.converge import Convergence
    from creak.studies.run import Run, StudyResult
    from creak.verify.events import Event
    from creak.verify.matching import EventMatch


@dataclass(frozen=True)
class Result:
    """Runs, events and verification of a study; units are the deck's, frequencies Hz."""

    found: StudyResult = field(repr=False)
    """Everything, with models and matrices."""
    summary: dict[str, Any] = field(repr=False)
    """The content of summary.json (docs/results.md)."""
    convergence: Convergence | None = field(default=None, repr=False)
    """What `converge` found; None: it was not asked for."""

    @property
    def runs(self) -> dict[str, Run]:
        """`reduced` and `reference`, those that the study asks for."""
        return self.found.runs

    @property
    def main(self) -> Run:
        """The reduced run; of a study that reduces nothing, the unreduced one."""
        return self.runs["reduced"] if "reduced" in self.runs else self.runs["reference"]

    @property
    def events(self) -> list[Event]:
        """Contact events of the main run, by start time."""
        return self.main.events

    @property
    def history(self) -> History:
        """Gaps, forces, motion and energy of the main run."""
        return self.main.history

    @property
    def agreement(self) -> EventMatch | None:
        """Events of the reduced run against those of the reference; None where one of them is missing."""
        return self.found.events

    @property
    def notes(self) -> list[str]:
        """What the user should know about the answer."""
        return list(self.summary["notes"])

    @property
    def stopped(self) -> str | None:
        """Why the study ended early; None: it did not."""
        return self.found.stopped

    def save(self, folder: str | Path) -> list[Path]:
        """Write summary.json and results.h5 (and convergence.csv) into `folder`; returns their paths."""
        from creak.studies.save import save, save_convergence

        written = save(self.found, self.summary, Path(folder))
        if self.convergence is not None:
            written.append(save_convergence(self.convergence, Path(folder)))
        return written

    def report(self, path: str | Path, animation_mb: float = 12.0) -> Path:
        """Write the report as one HTML file; returns its path.

        Parameters
        ----------
        animation_mb : megabytes that the 3-D motion of the hardest events may add; 0: none.

        Raises
        ------
        InputError : a package of the extra `report` is not installed.
        """
        need_report()
        from creak.report.html import write_report

        path = Path(path)
        path.parent.mkdir(parents=True, exist_ok=True)
        write_report(self.found, self.summary, path, self.convergence, round(1e6 * animation_mb))
        return path
