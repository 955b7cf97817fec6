"""What compiled code cannot hand on ends the analysis."""

from __future__ import annotations

import sys
import threading
from types import SimpleNamespace

import pytest

from creak.errors import InputError, NumericalError
from creak.studies.prepare import setup
from creak.studies.unraised import none_ignored
from helpers_cli import caller
from helpers_decks import write_strips

NAME = "scipy.sparse.csgraph._traversal._connected_components_undirected"
MET = SimpleNamespace(
    exc_type=ValueError, exc_value=ValueError("Buffer dtype mismatch"), exc_traceback=None, err_msg=None, object=NAME
)
"""What Python tells its hook where Cython had to ignore an exception, as SciPy 1.11.1 did."""


def ignore() -> None:
    sys.unraisablehook(MET)


def ignore_and_stumble() -> None:
    ignore()
    raise InputError("element 1 has the same node twice")


def ignore_inside(before) -> None:
    with pytest.raises(NumericalError, match="dtype mismatch"), none_ignored():
        ignore()
    assert sys.unraisablehook is not before


def test_an_ignored_exception_is_a_failed_analysis():
    before = sys.unraisablehook
    with pytest.raises(NumericalError, match=f"{NAME}: ValueError: Buffer dtype mismatch"), none_ignored():
        ignore()
    assert sys.unraisablehook is before


def test_it_is_told_instead_of_what_came_of_it():
    with pytest.raises(NumericalError, match="dtype mismatch") as found, none_ignored():
        ignore_and_stumble()
    assert isinstance(found.value.__cause__, InputError)


def test_other_errors_pass_and_the_hook_is_put_back():
    before = sys.unraisablehook
    with pytest.raises(InputError, match="wrong"), none_ignored():
        raise InputError("wrong")
    assert sys.unraisablehook is before


def test_destructors_and_other_threads_do_not_fail_the_analysis(monkeypatch):
    seen = []
    monkeypatch.setattr(sys, "unraisablehook", seen.append)
    of_destructor = SimpleNamespace(**{**vars(MET), "object": test_other_errors_pass_and_the_hook_is_put_back})
    with none_ignored():
        sys.unraisablehook(of_destructor)
        other = threading.Thread(target=ignore)
        other.start()
        other.join()
    assert seen == [of_destructor]


def test_inner_and_outer_ones_both_see_it_and_the_last_puts_the_hook_back():
    before = sys.unraisablehook
    with pytest.raises(NumericalError, match="dtype mismatch"), none_ignored():
        ignore_inside(before)
    assert sys.unraisablehook is before


def test_creak_run_ends_with_status_1_and_writes_nothing(tmp_path, monkeypatch, capsys):
    """As with SciPy 1.11.1, whose search for connected parts found nothing: warnings were lost, the status was 0."""
    before = setup.read_model

    def cut_short(*args, **kwargs):
        ignore()
        return before(*args, **kwargs)

    monkeypatch.setattr(setup, "read_model", cut_short)
    study = write_strips(tmp_path)
    said = caller(monkeypatch, capsys)("run", study, "--out", tmp_path / "out")
    assert said.status == 1
    assert f"the analysis failed: {NAME}: ValueError: Buffer dtype mismatch" in said.words
    assert "Traceback" not in said.words
    assert not (tmp_path / "out").exists()
