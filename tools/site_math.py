"""Equations of the site: math blocks become MathML, which browsers draw by themselves."""

from __future__ import annotations

from typing import Any

from latex2mathml.converter import convert


def fence(source: str, language: str, css_class: str, options: Any, md: Any, **more: Any) -> str:
    """A block of LaTeX as MathML, in the form that pymdownx.superfences asks for."""
    return f'<div class="{css_class}">{convert(" ".join(source.split()), display="block")}</div>'
