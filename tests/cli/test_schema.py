"""`creak schema`: a valid JSON schema that takes what creak takes and refuses a misspelt key."""

from __future__ import annotations

import json
import tomllib

import pytest

from creak_thesis.door.study import study_text
from helpers_decks import STUDY

jsonschema = pytest.importorskip("jsonschema", reason="pip install jsonschema")


@pytest.fixture
def schema(creak):
    return json.loads(creak("schema").out)


def problems(schema, text):
    return list(jsonschema.Draft202012Validator(schema).iter_errors(tomllib.loads(text)))


def test_it_is_a_schema(schema):
    jsonschema.Draft202012Validator.check_schema(schema)


@pytest.mark.parametrize("text", [study_text(), STUDY])
def test_studies_fit(schema, text):
    assert problems(schema, text) == []


@pytest.mark.parametrize(
    ("old", "new", "word"),
    [
        ("secondary", "secondry", "secondry"),
        ('"surface-to-surface"', '"mortar"', "mortar"),
        ("f_max = 3000", "f_max = -1", "-1"),
        ("step = 5e-4", 'step = "short"', "short"),
        ('deck = "strips.inp"', "", "deck"),
        ('"multisine"', '"noise"', "noise"),
    ],
)
def test_mistakes_do_not(schema, old, new, word):
    assert old in STUDY
    found = problems(schema, STUDY.replace(old, new, 1))
    assert found
    assert any(word in str(e) for e in found)


def test_every_key_is_described(schema):
    tables = [schema, *schema["$defs"].values()]
    bare = [
        key for t in tables for key, value in t["properties"].items() if key != "type" and "description" not in value
    ]
    assert bare == []
    assert "Hz" in schema["$defs"]["ReductionTable"]["properties"]["f_max"]["description"]


def test_out_writes_a_file(creak, tmp_path, schema):
    said = creak("schema", "--out", tmp_path / "s.json")
    assert said.status == 0
    assert json.loads((tmp_path / "s.json").read_text()) == schema
