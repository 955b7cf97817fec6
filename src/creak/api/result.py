"""What a study found, in the hands of a Python program."""

from __future__ import annotations

from dataclasses import dataclass, field, fields
from pathlib import Path
from typing import TYPE_CHECKING

from creak.api.extras import need_report
from creak.api.shown import Shown
from creak.errors import NumericalError
from creak.linalg.threads import one_blas_thread
from creak.studies.evaluate import Evaluation
from creak.studies.warned import Warned

if TYPE_CHECKING:
    import h5py

    from creak.dynamics.history import History
    from creak.report.drawn import Drawn
    from creak.studies.run.one_run import Run


@dataclass(frozen=True, repr=False)
class Result(Shown, Evaluation):
    """Runs, events and verification of a study; units are the deck's, frequencies Hz."""

    _pictures: dict[int, Drawn] = field(default_factory=dict, init=False, repr=False, compare=False)

    @classmethod
    def of(cls, evaluation: Evaluation) -> Result:
        """The same in the hands of a Python program."""
        return cls(**{f.name: getattr(evaluation, f.name) for f in fields(Evaluation)})

    @property
    def runs(self) -> dict[str, Run]:
        """`reduced` and `reference`, those that the study asks for."""
        return self.found.runs

    @property
    def main(self) -> Run:
        """The reduced run; of a study that reduces nothing, the unreduced one."""
        return self.runs["reduced"] if "reduced" in self.runs else self.runs["reference"]

    @property
    def history(self) -> History:
        """Gaps, forces, motion and energy of the main run."""
        return self.main.history

    @property
    def notes(self) -> list[str]:
        """What the user should know about the answer; those that ask to act are `Warned`."""
        return [Warned(note.text) if note.warns else note.text for note in self.findings.said]

    @property
    def stopped(self) -> str | None:
        """Why the study ended early; None: it did not."""
        return self.found.stopped

    @property
    def unreliable(self) -> list[str]:
        """Why runs cannot be relied on, with their names; empty where nothing speaks against them."""
        from creak.studies.findings.summary import unreliable_runs

        return unreliable_runs(self.summary)

    @one_blas_thread()
    def save(self, folder: str | Path, animation_mb: float = 5.0, page: str | None = None) -> list[Path]:
        """Write summary.json and results.h5 (and convergence.csv) into `folder`; returns their paths.

        They appear together or not at all. A report.html or convergence.csv of another run is removed. Where what a
        page shows cannot be gathered, they are written without it before that is told.

        Parameters
        ----------
        animation_mb : megabytes that the 3-D motion of the hardest events may take of a report that `open_result`
            writes later; 0: none.
        page : what `page` made: report.html appears with them.

        Raises
        ------
        WriteError : the disk is full, or fails; what was in the folder is as it was. NumericalError : the files are
            there, but no page can be made of them.
        """
        from creak.report.drawn import write_drawn
        from creak.studies.findings.save import save
        from creak.studies.findings.sound import put_sound
        from creak.studies.findings.stored import write_findings
        from creak.studies.sound.heard import Sound
        from creak.studies.warned import attempted

        notes: list[str] = []
        drawn = attempted("what a page shows", lambda: self._drawn(animation_mb), None, notes)

        def more(file: h5py.File) -> None:
            assert drawn is not None
            write_findings(file, self.findings)
            write_drawn(file, drawn)
            if isinstance(self.sound, Sound):
                put_sound(file, self.sound, self.findings.places)

        written = save(self.findings, self.records(), Path(folder), None if drawn is None else more, page)
        if notes:
            raise NumericalError(f"{notes[0]}, its results are in {folder}")
        return written

    @one_blas_thread()
    def page(self, animation_mb: float = 5.0) -> str:
        """The report as the text of one HTML file; parameters and errors as `report`."""
        need_report()
        from creak.report.html import report_text

        return report_text(self.findings, self._drawn(animation_mb))

    def report(self, path: str | Path, animation_mb: float = 5.0) -> Path:
        """Write the report as one HTML file; returns its path.

        Parameters
        ----------
        animation_mb : megabytes that the 3-D motion of the hardest events may add; 0: none.

        Raises
        ------
        InputError : a package of the extra `report` is not installed.
        """
        need_report()
        from creak.api.saved import SavedResult

        return SavedResult(self.findings, self._drawn(animation_mb)).report(path)

    def _drawn(self, animation_mb: float) -> Drawn:
        """What a report draws of model and motion, made once."""
        from creak.report.drawn import drawn_of

        size = round(1e6 * animation_mb)
        if size not in self._pictures:
            self._pictures[size] = drawn_of(self.found.main, self.found.reference, self.findings, size)
        return self._pictures[size]
