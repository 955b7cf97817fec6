"""true and false are no numbers, whatever the key: pydantic would take them for 1 and 0."""

from __future__ import annotations

from itertools import product
from typing import Any

import pytest
from pydantic import BaseModel, ValidationError

from creak.errors import InputError
from creak.studies.file.changes import read_changes, with_changes
from creak.studies.file.material_pairs import MaterialPairTable
from creak.studies.file.reader import read_study
from creak.studies.file.table import Table, _kinds
from creak.studies.sweep.file import SweepConfig

STUDY = """
[model]
deck = "d.inp"
[excitation.hit]
node_set = "N"
dof = "z"
kind = "force"
signal = {type = "half-sine", amplitude = 1.0, duration = 0.01}
[time]
end = 0.1
"""


def models(base: type[BaseModel]) -> list[type[BaseModel]]:
    return [m for sub in base.__subclasses__() for m in (sub, *models(sub))]


KEYS = [
    (m, f.alias or name)
    for m in models(Table)
    for name, f in m.model_fields.items()
    if not _kinds(f.annotation) & {bool, Any}
]
SEEN = (SweepConfig, MaterialPairTable)
"""Imported, so that their tables are among the models."""


def test_no_key_takes_it():
    assert len(KEYS) > 200
    for (model, key), value in product(KEYS, (True, [False], [[0.0, True]], [1.0, True, False, 3.0, 4.0, 5.0])):
        with pytest.raises(ValidationError, match=key) as caught:
            model.model_validate({key: value})
        assert any(e["loc"][:1] == (key,) for e in caught.value.errors()), (model, key, value)


@pytest.mark.parametrize(
    ("old", "new", "key"),
    [
        ("end = 0.1", "end = true", "time.end"),
        ("amplitude = 1.0", "amplitude = false", "excitation.hit.signal.amplitude"),
        ("[time]", "[damping]\nmodal = true\n[time]", "damping.modal"),
        ("[time]", "[damping]\nrayleigh = {beta = true}\n[time]", "damping.rayleigh.beta"),
    ],
)
def test_the_message_names_key_and_line(tmp_path, old, new, key):
    path = tmp_path / "study.toml"
    path.write_text(STUDY.replace(old, new), encoding="utf-8")
    with pytest.raises(InputError, match=rf"study.toml:\d+: {key} = (True|False): is true or false"):
        read_study(path)


def test_nor_does_a_change(tmp_path):
    path = tmp_path / "study.toml"
    path.write_text(STUDY, encoding="utf-8")
    with pytest.raises(InputError, match=r"time\.end = True"):
        with_changes(read_study(path), read_changes(["time.end=true"]))
    assert with_changes(read_study(path), read_changes(["precheck.enabled=false"])).config.precheck.enabled is False
