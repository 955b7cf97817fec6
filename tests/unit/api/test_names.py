"""`import creak`: light, complete, documented, and the same to a type checker as at run time."""

from __future__ import annotations

import ast
import inspect
import subprocess
import sys
from pathlib import Path

import pytest

import creak

HEAVY = ("numpy", "scipy", "numba", "h5py", "pydantic", "plotly", "matplotlib", "jinja2", "rich", "typer")


def test_import_creak_imports_nothing_heavy():
    code = f"import sys, creak; dir(creak); print(*[m for m in {HEAVY} if m in sys.modules])"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == ""


def test_a_page_waits_for_no_filters():
    """Half a second that pages without sound need not wait for."""
    code = "import sys, creak.report.html, creak.studies.evaluate; print('scipy.signal' in sys.modules)"
    assert subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True).stdout == "False\n"


def test_errors_and_decks_do_not_need_numba():
    code = "import sys, creak; creak.InputError; creak.read_deck; print('numba' in sys.modules, 'scipy' in sys.modules)"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.split() == ["False", "False"]


def imported_for_types() -> dict[str, str]:
    """Name -> module, from the imports under TYPE_CHECKING."""
    tree = ast.parse(Path(creak.__file__).read_text(encoding="utf-8"))
    (block,) = (n for n in tree.body if isinstance(n, ast.If))
    return {a.name: n.module for n in block.body if isinstance(n, ast.ImportFrom) for a in n.names if n.module}


def test_type_checkers_see_what_there_is_at_run_time():
    assert imported_for_types() == creak._HOME
    assert set(creak.__all__) == set(creak._HOME)
    assert {*creak.__all__, "__version__"} == set(dir(creak))


@pytest.mark.parametrize("name", sorted(creak._HOME))
def test_every_public_name_is_there_and_says_what_it_is(name):
    value = getattr(creak, name)
    text = inspect.getdoc(value) or ""
    assert len(text) > 15
    if inspect.isfunction(value):
        assert value.__annotations__.get("return"), f"{name} has no return type"


def test_an_unknown_name_is_an_attribute_error():
    with pytest.raises(AttributeError, match="no attribute 'rattle'"):
        creak.rattle  # noqa: B018


def test_functions_that_raise_say_so():
    silent = {
        *("join_gaps", "mac_matrix", "nrmse_fit", "nrmse_by_axis", "near_elements", "displacement_motion"),
        *("integrate_twice", "match_events", "find_events", "find_slips", "acceleration_motion"),
    }
    for name in set(creak.__all__) - silent:
        value = getattr(creak, name)
        if inspect.isfunction(value):
            assert "Raises" in (inspect.getdoc(value) or ""), name
