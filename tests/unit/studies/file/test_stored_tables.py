"""A study comes back from a file of results as it went in, whichever keys it sets.

Tables written as TOML read back the same.
By what files a study is known again.
"""

from __future__ import annotations

import hashlib
import tomllib
from dataclasses import dataclass
from typing import Any, get_args

import h5py
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from creak.formats.stored.tree import read_tree, write_tree
from creak.studies.file.config import StudyConfig
from creak.studies.file.paths import Contents, digests_of
from creak.studies.file.reader import read_study
from creak.studies.file.table import Table
from creak.studies.file.toml_text import toml_text
from helpers_decks import STUDY, write_strips


@dataclass(frozen=True)
class Held:
    config: StudyConfig


def signals(*tables: dict[str, Any]) -> list[dict[str, Any]]:
    one = {"node_set": "A", "dof": "x", "kind": "acceleration"}
    return [{"excitation": {"hit": {**one, "signal": table}}} for table in tables]


POINTS = [[0.0, 0.0], [0.5, 1.0]]
LINE = {"main": "A", "secondary": "B"}
WAY = {"file": "way.csv"}
PLAY = {"type": "play", "nodes": ["A", "B"], "dof": "x", "stiffness": 5.0}
TABLES: list[dict[str, Any]] = [
    {"title": "as it is", "material_pairs": "pairs.toml", "clips": "clips.toml"},
    {"material": {"PC": {"youngs_modulus": 1.0}, "ABS": {"density": 1.0}}},
    *({"section": {"S": {key: 2.0}}} for key in ("thickness", "stiffness", "stiffness_factor", "mass")),
    {"nodes": {"A": {"labels": [17, "FRAME-1.17"]}, "B": {"near": [[0.0, 1.0, 2.0]], "part": "P"}}},
    {"support": {"S": {"nodes": "A", "hold": ["x"]}, "T": {"nodes": "*", "free": ["y"]}}},
    *({"damping": one} for one in ({"modal": 0.02}, {"rayleigh": {"beta": 1e-5}}, {"from_test": "test.unv"})),
    {"contact": {"c": LINE, "d": {**LINE, "overclosure": POINTS, "friction": {"static": 0.5, "kinetic": 0.3}}}},
    {"connector": [{**PLAY, "lower": -0.1}, {**PLAY, "nodes": "A", "upper": 0.1, "preload": 1.0}]},
    {
        "clip": [
            {"type": "bushing", "nodes": "A", "stiffness": [1.0] * 6},
            {"use": "foam", "at": [[0.0] * 3], "parts": "P"},
        ]
    },
    {"clip": [{"type": "stop", "nodes": ["A", "B"], "table": POINTS, "axis": [0.0, 0.0, 1.0]}]},
    {
        "scatter": {
            "vary": {
                "time.end": {"type": "normal", "sigma": 0.1, "low": 0.0},
                "a.b": {"type": "field", "tolerance": {"file": "t.csv", "columns": {"point": "P"}}, "length": 5.0},
                "c.d": {"type": "clip-one-side"},
            }
        }
    },
    {
        "eline": {
            "l": {**LINE, "points": [[0.0] * 3], "tolerance": "0.5 mm"},
            "m": {"points": "p.csv", "columns": {"x": "X"}},
        }
    },
    {"material-pair": {"p": {"source": "rig", "impulse_rate_min": 1.0, "impulse_rate_max": 2.0}}},
    {"limit": {"tolerance": "0.3 mm", "n5": "2 sone", "third_octaves": {"1000": "40 dB"}}},
    *signals(
        {"type": "multisine", "f_max": 50.0, "amplitude": 1.0},
        {"type": "sine", "frequency": 5.0, "amplitude": 1.0},
        {"type": "step", "amplitude": 1.0},
        {"type": "table", "values": POINTS},
        {"type": "table", "file": "t.csv", "channel": 2},
        {"type": "record", "file": "r.csv", "high_pass": 1.0},
        {"type": "smooth-step", "values": POINTS},
        {"type": "periodic", "frequency": 5.0, "cosine": [1.0]},
        {"type": "psd", "unit": "g2/Hz", "file": "p.csv"},
        {"type": "sweep", "f_start": 5.0, "f_end": 50.0, "amplitude": 1.0, "duration": 1.0},
        {"type": "half-sine", "amplitude": 1.0, "duration": 0.01},
        {"type": "trapezoid", "amplitude": 1.0, "rise": 0.01, "hold": 0.1, "fall": 0.01},
    ),
    {"static": [{"gravity": [0.0, 0.0, -9810.0]}, {"temperature": 80.0, "part": "P"}, {"press_fit": True}]},
    {"static": [{"force": 1.0, "node_set": "A", "dof": "x"}, {"deck_loads": 3}]},
    {"reduction": {"f_max": 700.0, "interface": {"type": "spacing", "n": 2}}},
    {"reduction": {"interface": {"type": "coarse-mesh", "deck": "coarse.inp"}}},
    {"superelement": {"s": {"file": "s.npz"}}},
    {"precheck": {"margin": 0.5}},
    *({"time": one} for one in ({"periods": 3.0}, {"end": 1.0, "step": 1e-4}, {"rho_inf": 0.5})),
    *({"reference": one} for one in ({"run": False}, {"run": "spots"}, {"until": 0.5})),
    {"output": {"nodes": "A", "interval": 1e-3}},
    {"verification": {"pairs": "P", "f_max": 250.0}},
    {"listener": {"ear": {"position": [0.0] * 3, "transfer": {"P": WAY, "Q": {**WAY, "function": 2}}}}},
    {
        "listener": {"head": {"position": [0.0] * 3, "faces": [1.0, 0.0, 0.0]}},
        "room": {"volume": 3.0, "reverberation": 0.1},
    },
    {"test": {"t": {"file": "t.wav", "full_scale": 1.0, "unit": "m/s^2"}, "u": {"file": "t.unv"}}},
    {"background": {"linear": True}},
]


def back(config: StudyConfig, path: Any) -> StudyConfig:
    with h5py.File(path, "w") as file:
        write_tree(file.create_group("held"), Held(config))
        return read_tree(Held, file["held"]).config


def made(tables: dict[str, Any]) -> StudyConfig:
    return StudyConfig.model_validate({"model": {"deck": "d.inp"}, **tables})


@pytest.mark.parametrize("tables", TABLES, ids=lambda tables: next(iter(tables)))
def test_round_trip(tables, tmp_path):
    config = made(tables)
    assert back(config, tmp_path / "t.h5") == config


def kinds_in(value: Any) -> set[type]:
    """The tables that a value holds."""
    if isinstance(value, Table):
        return {type(value)}.union(*(kinds_in(one) for _, one in value))
    inside = value.values() if isinstance(value, dict) else value if isinstance(value, list) else ()
    return set().union(*map(kinds_in, inside))


def kinds_named(hint: Any) -> set[type]:
    """The tables that a hint allows."""
    if isinstance(hint, type) and issubclass(hint, Table):
        return {hint}.union(*(kinds_named(f.annotation) for f in hint.model_fields.values()))
    return set().union(*map(kinds_named, get_args(hint)))


def test_every_kind_of_table_is_among_them():
    assert set().union(*(kinds_in(made(tables)) for tables in TABLES)) == kinds_named(StudyConfig)


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
def test_tables_read_back_the_same(data):
    assert tomllib.loads(toml_text(data)) == data


def test_tables_have_headers():
    text = toml_text({"a": {"b": {"c": 1}}, "list": [{"x": 1.0, "in": {"y": "z"}}], "title": 'with "quotes"'})
    assert "[a.b]\nc = 1" in text
    assert "[[list]]\nx = 1.0" in text
    assert text.startswith("title =")


def test_numbers_of_numpy_are_numbers():
    assert toml_text({"modal": np.float64(0.025)}) == "modal = 0.025\n"


def test_what_toml_has_no_word_for():
    with pytest.raises(TypeError, match="NoneType"):
        toml_text({"a": None})


def sha256(content: bytes) -> str:
    return hashlib.sha256(content).hexdigest()


PLACE = ("superelement", "*", "file")


@pytest.mark.parametrize("named", ["BEAM_K.mtx", "BEAM"])
@pytest.mark.parametrize("changed", ["BEAM_K.mtx", "BEAM_M.mtx", "BEAM_dofs.csv"])
def test_matrices_that_come_as_several_files_all_count(changed, named, tmp_path):
    files = {"BEAM_K.mtx": b"stiffness", "BEAM_M.mtx": b"mass", "BEAM_dofs.csv": b"rows"}
    for name, content in files.items():
        (tmp_path / name).write_bytes(content)
    (tmp_path / "OTHER_K.mtx").write_bytes(b"of another part")
    study = read_study(write_strips(tmp_path, study=f'{STUDY}\n[superelement.BEAM]\nfile = "{named}"\n'))
    found, of_sweep = digests_of(study)[1], Contents().of(PLACE, tmp_path / named)
    assert found == sha256("".join(f"{sha256(content)}\n" for content in files.values()).encode())
    (tmp_path / "OTHER_K.mtx").write_bytes(b"changed")
    assert digests_of(study)[1] == found
    (tmp_path / changed).write_bytes(b"changed")
    assert digests_of(study)[1] != found
    assert Contents().of(PLACE, tmp_path / named) != of_sweep


def test_a_file_alone_has_its_own_digest(tmp_path):
    study = read_study(write_strips(tmp_path, study=f'clips = "clips.toml"\n{STUDY}'))
    (tmp_path / "clips.toml").write_bytes(b"x = 1\n")
    (tmp_path / "clips_b.toml").write_bytes(b"x = 2\n")
    (tmp_path / "clips.csv").write_bytes(b"of something else")
    assert digests_of(study)[1] == sha256(b"x = 1\n")
