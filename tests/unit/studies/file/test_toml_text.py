"""Tables written as TOML read back the same."""

from __future__ import annotations

import tomllib

import pytest
from hypothesis import given
from hypothesis import strategies as st

from creak.studies.file.toml_text import toml_text

CHARACTERS = st.characters(exclude_categories=["Cs"])
PLAIN = (
    st.booleans()
    | st.integers(-(2**63), 2**63 - 1)
    | st.floats(allow_nan=False, allow_infinity=False)
    | st.text(CHARACTERS, max_size=8)
)
VALUES = st.recursive(
    PLAIN,
    lambda inner: st.lists(inner, max_size=3) | st.dictionaries(st.text(CHARACTERS, max_size=5), inner, max_size=3),
    max_leaves=8,
)


@given(st.dictionaries(st.text(CHARACTERS, max_size=5), VALUES, max_size=4))
def test_round_trip(data):
    assert tomllib.loads(toml_text(data)) == data


def test_tables_have_headers():
    text = toml_text({"a": {"b": {"c": 1}}, "list": [{"x": 1.0, "in": {"y": "z"}}], "title": 'with "quotes"'})
    assert "[a.b]\nc = 1" in text
    assert "[[list]]\nx = 1.0" in text
    assert text.startswith("title =")


def test_what_toml_has_no_word_for():
    with pytest.raises(TypeError, match="NoneType"):
        toml_text({"a": None})
