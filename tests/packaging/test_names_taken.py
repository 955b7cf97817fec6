"""What the source takes of a package is there in the version installed: modules, names in them, and keywords of calls."""

from __future__ import annotations

import ast
import importlib
import importlib.util
import inspect
from collections.abc import Sequence
from functools import cache
from pathlib import Path
from typing import Any

import pytest

from helpers_source import nodes_in, nodes_of

SRC = Path(__file__).parents[2] / "src"
PACKAGES = ("numpy", "scipy", "numba", "threadpoolctl", "pypardiso", "h5py", "pydantic", "typer", "rich")
PACKAGES += ("plotly", "matplotlib", "jinja2", "markupsafe", "distributed")
NOTHING = object()


@cache
def module_of(name: str) -> Any:
    """None where it is no module of a package that is looked at, or that is installed."""
    package = name.partition(".")[0]
    if package not in PACKAGES or importlib.util.find_spec(package) is None:
        return None
    return importlib.import_module(name)


def missing(nodes: Sequence[ast.AST]) -> tuple[list[str], int]:
    """What is not there, and how many names and keywords were looked up."""
    of, lost, looked = dict[str, Any](), list[str](), 0
    for node in nodes:
        if isinstance(node, ast.Import):
            for alias in node.names:
                if (module := module_of(alias.name)) is not None:
                    top = alias.name.partition(".")[0]
                    of[alias.asname or top] = module if alias.asname else importlib.import_module(top)
        elif isinstance(node, ast.ImportFrom) and node.module and (module := module_of(node.module)) is not None:
            for alias in node.names:
                of[alias.asname or alias.name] = found = _member(module, alias.name)
                looked += 1
                lost += [f"{node.module}.{alias.name}"] if found is NOTHING else []

    def found_of(node: ast.expr) -> Any:
        if isinstance(node, ast.Name):
            return of.get(node.id)
        if not isinstance(node, ast.Attribute) or (owner := found_of(node.value)) is None or owner is NOTHING:
            return None
        return _member(owner, node.attr) if inspect.ismodule(owner) else getattr(owner, node.attr, None)

    for node in nodes:
        if isinstance(node, ast.Attribute) and (found := found_of(node)) is not None:
            looked += 1
            lost += [ast.unparse(node)] if found is NOTHING else []
        if isinstance(node, ast.Call) and callable(found := found_of(node.func)):
            taken = keywords_of(found)
            for word in node.keywords if taken is not None else ():
                looked += 1
                lost += [f"{ast.unparse(node.func)}({word.arg}=)"] if word.arg and word.arg not in taken else []
    return lost, looked


def _member(owner: Any, name: str) -> Any:
    found = getattr(owner, name, NOTHING)
    if found is NOTHING and inspect.ismodule(owner) and hasattr(owner, "__path__"):
        inner = f"{owner.__name__}.{name}"
        return importlib.import_module(inner) if importlib.util.find_spec(inner) else NOTHING
    return found


@cache
def keywords_of(found: Any) -> set[str] | None:
    """None where a call takes any, or does not tell."""
    try:
        parameters = inspect.signature(found).parameters.values()
    except (TypeError, ValueError):
        return None
    return None if any(p.kind is p.VAR_KEYWORD for p in parameters) else {p.name for p in parameters}


def test_what_is_taken_is_there():
    lost, looked = list[str](), 0
    for path in sorted(SRC.rglob("*.py")):
        found, count = missing(nodes_of(path))
        lost += [f"{path.relative_to(SRC)}: {name}" for name in found]
        looked += count
    assert lost == []
    assert looked > 5000


@pytest.mark.parametrize(
    ("text", "lost"),
    [
        ("import numpy as np\nnp.trapezoide(y)", ["np.trapezoide"]),
        ("import numpy as np\nnp.linalg.solved(A, b)", ["np.linalg.solved"]),
        ("from scipy.sparse import csr_matricks", ["scipy.sparse.csr_matricks"]),
        ("import scipy.linalg as sla\nsla.eigh(A, tipe=1)", ["sla.eigh(tipe=)"]),
        ("import numpy as np\nimport scipy.sparse as sp\nnp.linalg.norm(sp.eye(3, format='csr').data, axis=0)", []),
    ],
)
def test_what_is_not_there_is_found(text, lost):
    assert missing(nodes_in(text))[0] == lost
