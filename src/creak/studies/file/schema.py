"""The JSON schema of the study file, from the tables that check it."""

from __future__ import annotations

import json
from typing import Any

from creak.studies.file.config import StudyConfig

DIALECT = "https://json-schema.org/draft/2020-12/schema"
SCHEMA_FILE = "creak-study.schema.json"
"""What `creak new` calls it beside a study."""


def study_schema() -> dict[str, Any]:
    """What a study file may say, as JSON schema: editors check and complete TOML with it.

    Rules between keys (periods or end, not both) are not in it; `read_study` checks those.
    """
    found = _without_titles(StudyConfig.model_json_schema())
    return {"$schema": DIALECT, "title": "creak study file", **found}


def schema_text() -> str:
    """The schema as it stands in its file."""
    return json.dumps(study_schema(), indent=2) + "\n"


def _without_titles(value: Any) -> Any:
    """The same without the titles that are made of the keys' names, and with descriptions on one line."""
    if isinstance(value, list):
        return [_without_titles(v) for v in value]
    if not isinstance(value, dict):
        return value
    kept = {k: _without_titles(v) for k, v in value.items() if not (k == "title" and isinstance(v, str))}
    if isinstance(kept.get("description"), str):
        kept["description"] = " ".join(kept["description"].split())
    return kept
