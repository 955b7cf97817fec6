"""How the templates of pages are filled in."""

from __future__ import annotations

import json
import re
from functools import cache
from typing import Any

from jinja2 import Environment, PackageLoader, StrictUndefined
from markupsafe import Markup, escape


def page_templates(package: str) -> Environment:
    """The templates of a package, for HTML: everything is escaped, a name that is not given is an error."""
    return _templates(package)


@cache
def _templates(package: str) -> Environment:
    made = Environment(
        loader=PackageLoader(package, "."),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    made.filters["coded"] = coded  # before any template is compiled: they are compiled once, for all pages
    return made


def coded(text: str) -> Markup:
    """A message as HTML: what stands between back-ticks as code, all else escaped."""
    return Markup(re.sub(r"`([^`]+)`", r"<code>\1</code>", str(escape(text))))


def script_json(value: Any) -> Markup:
    """JSON that may stand inside a script element: no `<` that could end it."""
    text = json.dumps(value, separators=(",", ":"), allow_nan=False)
    return Markup(text.replace("<", "\\u003c").replace("\u2028", "\\u2028").replace("\u2029", "\\u2029"))
