"""A study beside a modal test: which of its numbers would mend it, and the study with them."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from creak.api.study import read_study
from creak.given import path_of, texts
from creak.progress import Progress, told_to
from creak.studies.file.reader import Study

if TYPE_CHECKING:
    from creak.studies.models.trials import UpdateCase
    from creak.studies.models.update import ModelUpdate, Sensitivities


def sensitivities(
    study: Study | str | Path,
    test: str | Path,
    *,
    test_units: str | None = None,
    sensors: str | Path | None = None,
    closed: Sequence[str] = (),
    ignore: Sequence[str] = (),
    progress: Progress | None = None,
) -> Sensitivities:
    """d(ln f)/d(ln p) of every paired mode to every number of materials, sections, springs and clips.

    Parameters
    ----------
    study : a Study, or the path of a study file; its modes are those of the linear structure, contact open.
    test : universal file (.unv, .uff) with data sets 55, or CSV, as `correlate` takes it.
    test_units, sensors, ignore : as `correlate`.
    closed : contacts, connectors and clips that stay closed in the test.
    progress : called with (stage, done, total).

    Returns
    -------
    Sensitivities: keys, values, slopes (n_pair, n_key), `ranked` by what each alone would leave (`left`).

    Raises
    ------
    InputError : anything wrong in study, deck or test. NumericalError : the modes could not be found.
    """
    from creak.studies.models import update as studies

    case = _case(study, test, test_units, sensors, closed, ignore)
    return studies.sensitivities(case, told_to(progress))


def update_study(
    study: Study | str | Path,
    test: str | Path,
    parameters: Sequence[str],
    *,
    sigma: float = 0.01,
    test_units: str | None = None,
    sensors: str | Path | None = None,
    closed: Sequence[str] = (),
    ignore: Sequence[str] = (),
    progress: Progress | None = None,
) -> ModelUpdate:
    """Bring the frequencies of a study to those of a test by bounded least squares over some of its numbers.

    Parameters
    ----------
    study, test, test_units, sensors, closed, ignore, progress : as `sensitivities`.
    parameters : `"section.PANEL.thickness"`, or with bounds `"section.PANEL.thickness=0.8:1.5"`.
    sigma : standard deviation of the measured frequencies, as a share.

    Returns
    -------
    ModelUpdate: study (changed), estimates (value, 95 % interval), before and after (Correlation), unexplained, lost.

    Raises
    ------
    InputError : anything wrong in study, deck or test; more parameters than pairs, or one that moves no mode.
    NumericalError : the modes could not be found, or too few pairs are left.
    """
    from creak.studies.models import update as studies

    parameters = texts(parameters, "parameters")
    case = _case(study, test, test_units, sensors, closed, ignore)
    return studies.update(case, parameters, sigma=sigma, progress=told_to(progress))


def _case(
    study: Study | str | Path,
    test: str | Path,
    test_units: str | None,
    sensors: str | Path | None,
    closed: Sequence[str],
    ignore: Sequence[str],
) -> UpdateCase:
    from creak.studies.models.update import update_case

    read = study if isinstance(study, Study) else read_study(study)
    table = None if sensors is None else path_of(sensors, "sensors")
    ignore, closed = texts(ignore, "ignore"), texts(closed, "closed")
    return update_case(read, path_of(test, "test"), test_units=test_units, sensors=table, ignore=ignore, closed=closed)
