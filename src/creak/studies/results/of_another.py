"""Whether the results in a folder are those of another study."""

from __future__ import annotations

import json
from pathlib import Path

from creak.errors import InputError
from creak.formats.stored.run_identity import SUMMARY


def refuse_other_study(folder: Path, study: str) -> None:
    """Check that a run of a study may replace what is in `folder`.

    Results of the same study file are replaced, whatever the file said then; so is what cannot be read.

    Parameters
    ----------
    study : name of the study file, or of the deck that is run by itself.

    Raises
    ------
    InputError : the folder holds the results of another study file.
    """
    try:
        found = json.loads((folder / SUMMARY).read_text(encoding="utf-8"))
        other = found["study"]
    except (OSError, ValueError, KeyError, TypeError, RecursionError):
        return
    if isinstance(other, str) and other != study:
        raise InputError(
            f"{folder} holds the results of {other}, which {study} would replace",
            expected="a folder of its own for each study",
            fix="Write beside it with --out FOLDER, or replace it with --force.",
        )
