"""The JSON schema of the study file, from the tables that check it."""

from __future__ import annotations

import ast
import inspect
import json
import sys
from collections.abc import Iterator
from functools import cache
from typing import Any

from pydantic import BaseModel

from creak.studies.file.config import StudyConfig
from creak.studies.file.table import Table

DIALECT = "https://json-schema.org/draft/2020-12/schema"
SCHEMA_FILE = "creak-study.schema.json"
"""What `creak new` calls it beside a study."""


def study_schema() -> dict[str, Any]:
    """What a study file may say, as JSON schema: editors check and complete TOML with it.

    Rules between keys (periods or end, not both) are not in it; `read_study` checks those.
    """
    found = _without_titles(_described(StudyConfig.model_json_schema()))
    return {"$schema": DIALECT, "title": "creak study file", **found}


def schema_text() -> str:
    """The schema as it stands in its file."""
    return json.dumps(study_schema(), indent=2) + "\n"


def _described(schema: dict[str, Any]) -> dict[str, Any]:
    """The schema with the text below each key as its description; what reads studies does without them."""
    tables = {kind.__name__: kind for kind in _below(Table)}
    for name, found in [("StudyConfig", schema), *schema["$defs"].items()]:
        texts = texts_of(tables[name]) if name in tables else {}
        for key, value in found.get("properties", {}).items():
            if key in texts:
                found["properties"][key] = dict(sorted({"description": texts[key], **value}.items()))
    return schema


def _below(kind: type[Table]) -> Iterator[type[Table]]:
    for other in kind.__subclasses__():
        yield other
        yield from _below(other)


def texts_of(kind: type[BaseModel]) -> dict[str, str]:
    """Key -> the text below it, of a table and of those that it extends."""
    found: dict[str, str] = {}
    for base in reversed([k for k in kind.__mro__ if issubclass(k, Table)]):
        body = _classes(base.__module__)[base.__name__]
        for line, text in zip(body.body, body.body[1:], strict=False):
            told = isinstance(text, ast.Expr) and isinstance(text.value, ast.Constant)
            if isinstance(line, ast.AnnAssign) and isinstance(line.target, ast.Name) and told:
                found[line.target.id] = inspect.cleandoc(text.value.value)  # type: ignore[attr-defined]
    aliases = {f.alias or name: name for name, f in kind.model_fields.items()}
    return {key: found[name] for key, name in aliases.items() if name in found}


@cache
def _classes(module: str) -> dict[str, ast.ClassDef]:
    """The classes of a module by name, as written; read once, where `inspect` would parse it for each of them."""
    tree = ast.parse(inspect.getsource(sys.modules[module]))
    return {node.name: node for node in ast.walk(tree) if isinstance(node, ast.ClassDef)}


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
