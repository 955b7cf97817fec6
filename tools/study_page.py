"""docs/study_keys.md from the tables that check a study: `python -m tools.study_page`."""

from __future__ import annotations

import json
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from creak.studies.file.schema import study_schema

PAGE = Path(__file__).parents[1] / "docs" / "study_keys.md"
HEAD = """\
# Keys of the study file

Made from the program by `python -m tools.study_page`; `creak schema` prints the same for editors. "required" stands
where a key has no default. What the keys do together is in [the study file](study.md).
"""
LIMITS = {
    "minimum": "at least",
    "exclusiveMinimum": "above",
    "maximum": "at most",
    "exclusiveMaximum": "below",
    "minItems": "entries: at least",
}
WORDS = {"string": "text", "number": "number", "integer": "whole number", "boolean": "true or false"}


def page() -> str:
    """The whole page: a section for each table of the study, and one for each table inside."""
    schema = study_schema()
    tables = schema["$defs"]
    own = {k: v for k, v in schema["properties"].items() if not _reference(v)}
    text = [HEAD, "## At the top", "", *_rows(own, schema.get("required", []), tables), ""]
    for key, value in schema["properties"].items():
        name = _reference(value)
        if name:
            text += _section(_heading(key, value), value, tables[name], tables)
            for inner, inner_name in _inside(tables[name]):
                text += _inner_section(f"{key}.{inner}", inner_name, tables[inner_name], tables)
    return "\n".join(text)


def _heading(key: str, value: dict[str, Any]) -> str:
    if value.get("type") == "array":
        return f"[[{key}]]"
    return f"[{key}.NAME]" if "additionalProperties" in value else f"[{key}]"


def _section(heading: str, value: dict[str, Any], table: dict[str, Any], tables: dict[str, Any]) -> Iterator[str]:
    yield from (f"## `{heading}`", "")
    told = value.get("description") or table.get("description", "")
    yield from (_sentence(told.removeprefix(heading).lstrip(": ")), "")
    yield from (*_rows(table["properties"], table.get("required", []), tables), "")


def _inner_section(path: str, name: str, table: dict[str, Any], tables: dict[str, Any]) -> Iterator[str]:
    kind = table["properties"].get("type", {}).get("const")
    yield from (f"### `{path}`" + (f' with `type = "{kind}"`' if kind else ""), "")
    yield from (_sentence(table.get("description", "")), "")
    yield from (*_rows(table["properties"], table.get("required", []), tables), "")


def _rows(properties: dict[str, Any], required: list[str], tables: dict[str, Any]) -> Iterator[str]:
    yield from ("| key | value | default | meaning |", "|---|---|---|---|")
    for key, value in properties.items():
        default = "required" if key in required else _default(value)
        yield f"| `{key}` | {_cell(_kind(value))} | {default} | {_cell(value.get('description', ''))} |"


def _kind(value: dict[str, Any]) -> str:
    """What may stand there: type, choices, limits."""
    if "const" in value:
        return f"`{json.dumps(value['const'])}`"
    if "enum" in value:
        return ", ".join(f"`{json.dumps(v)}`" for v in value["enum"])
    if "$ref" in value:
        return "table (below)"
    choices = value.get("anyOf", []) + value.get("oneOf", [])
    if choices:
        return " or ".join(sorted({_kind(v) for v in choices if v.get("type") != "null"}, key=len))
    if "additionalProperties" in value:
        return "tables by key (below)"
    if value.get("type") == "array":
        items = value.get("prefixItems")
        inside = ", ".join(_kind(v) for v in items) if items else _kind(value.get("items", {}))
        return (f"[{inside}]" if items else f"list of {inside}") + _limits(value)
    return WORDS[value["type"]] + _limits(value)


def _limits(value: dict[str, Any]) -> str:
    found = [f"{words} {value[key]:g}" for key, words in LIMITS.items() if key in value]
    return f" ({', '.join(found)})" if found and "prefixItems" not in value else ""


def _default(value: dict[str, Any]) -> str:
    given = value.get("default")
    if given is None or given in ({}, []):
        return "–"
    if isinstance(given, dict):
        return "its own defaults"
    return f"`{json.dumps(given)}`"


def _references(value: Any) -> Iterator[str]:
    """Names of the tables that a value may be."""
    if isinstance(value, dict):
        if "$ref" in value:
            yield value["$ref"].rsplit("/", 1)[-1]
        for key in ("anyOf", "oneOf", "items", "additionalProperties"):
            yield from _references(value.get(key))
    elif isinstance(value, list):
        for v in value:
            yield from _references(v)


def _reference(value: dict[str, Any]) -> str:
    return next(_references(value), "")


def _inside(table: dict[str, Any]) -> Iterator[tuple[str, str]]:
    """Keys of a table that hold tables, with the tables' names."""
    for key, value in table["properties"].items():
        for name in _references(value):
            yield key, name


def _sentence(text: str) -> str:
    text = _cell(text)
    return text[:1].upper() + text[1:]


def _cell(text: str) -> str:
    return " ".join(text.split()).replace("|", "\\|").replace("*", "\\*")


if __name__ == "__main__":
    PAGE.write_text(page(), encoding="utf-8")
    sys.stdout.write(f"wrote {PAGE}\n")
