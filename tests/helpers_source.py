"""The syntax trees of source files, read once for all tests that look at them."""

from __future__ import annotations

import ast
import gc
from functools import cache
from pathlib import Path

LOOKED_AT = ast.Import | ast.ImportFrom | ast.Call | ast.Attribute | ast.BinOp


@cache
def nodes_of(path: Path) -> tuple[ast.AST, ...]:
    """Those of the kinds that rules look at, in the order of `ast.walk`."""
    return nodes_in(path.read_text(encoding="utf-8"), str(path))


def nodes_in(text: str, name: str = "text") -> tuple[ast.AST, ...]:
    """With the garbage collector at rest, which would look at all nodes again and again."""
    collects = gc.isenabled()
    gc.disable()
    try:
        return tuple(node for node in ast.walk(ast.parse(text, filename=name)) if isinstance(node, LOOKED_AT))
    finally:
        if collects:
            gc.enable()
