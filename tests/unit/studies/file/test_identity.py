"""By what files a study is known again."""

from __future__ import annotations

import hashlib

import pytest

from creak.studies.file.identity import digests_of
from creak.studies.file.paths import Contents
from creak.studies.file.reader import read_study
from helpers_decks import STUDY, write_strips


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
