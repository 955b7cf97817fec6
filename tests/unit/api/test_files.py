"""Files of a program that builds on creak: whole or not at all, and known when they were changed."""

import math

import pytest

import creak
from helpers_refusal import refusal


def test_json_comes_back_and_a_changed_one_is_known(tmp_path):
    path = tmp_path / "cases" / "one.json"
    creak.write_json(path, {"name": "D8", "found": [1.5, math.inf], "loads": {"A4": None}})
    assert creak.read_json(path) == {"name": "D8", "found": [1.5, math.inf], "loads": {"A4": None}}
    path.write_text(path.read_text(encoding="utf-8").replace("1.5", "1.6"), encoding="utf-8")
    assert "checksum does not fit" in str(refusal(creak.read_json, path))


@pytest.mark.parametrize("content", [None, "{}", "no json", "[1]"])
def test_what_write_json_did_not_write_is_refused(tmp_path, content):
    path = tmp_path / "one.json"
    if content is not None:
        path.write_text(content, encoding="utf-8")
    assert "one.json" in str(refusal(creak.read_json, path))


def test_data_that_json_cannot_hold_leave_the_file_as_it_was(tmp_path):
    path = tmp_path / "one.json"
    creak.write_json(path, {"a": 1})
    assert "not JSON serializable" in str(refusal(creak.write_json, path, {"a": object()}))
    assert creak.read_json(path) == {"a": 1}


def test_text_is_written_as_it_is(tmp_path):
    creak.write_text(str(tmp_path / "page.html"), "länge\n")
    assert (tmp_path / "page.html").read_bytes() == "länge\n".encode()
    assert "folder" in str(refusal(creak.write_text, tmp_path, "text"))
