"""`creak schema`: the JSON schema of the study file, for editors."""

from __future__ import annotations

import sys
from pathlib import Path

import typer

from creak.cli.output import Output, writable_file


def schema(
    out: Path | None = typer.Option(None, "--out", help="Write it to this file instead of stdout."),
) -> None:
    """Print the JSON schema of the study file: names, types, limits, defaults, meanings and units.

    Editors with TOML support (Even Better TOML, taplo) check and complete a study whose first line is
    `#:schema ./creak-study.schema.json`, the line that `creak new` writes.

    Example: creak schema --out creak-study.schema.json
    """
    from creak.formats.complete_file import write_text
    from creak.studies.file.schema import schema_text

    if out is None:
        sys.stdout.write(schema_text())
        return
    writable_file(out)
    out.parent.mkdir(parents=True, exist_ok=True)
    write_text(out, schema_text())
    output = Output()
    output.wrote(out)
    output.tell_written()
