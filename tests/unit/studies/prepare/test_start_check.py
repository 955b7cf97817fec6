"""What the start of a run says of a model: elements without a mass of their own."""

from __future__ import annotations

import pytest

from creak.studies.file.case import Touching
from creak.studies.file.config import PrecheckTable
from creak.studies.file.places import Places
from creak.studies.prepare.start_check import start_warnings
from helpers_nastran import read

PLATE = "GRID,1,,0.,0.,0.\nGRID,2,,40.,0.,0.\nGRID,3,,40.,20.,0.\nGRID,4,,0.,20.,0.\nCQUAD4,1,1,1,2,3,4\n"


@pytest.mark.parametrize(("rho", "nsm", "told"), [("", "", 1), ("7.85-9", "", 0), ("", "3.-9", 0)])
def test_elements_without_density_are_told_where_no_mass_per_area_is_theirs(tmp_path, rho, nsm, told):
    model = read(tmp_path, f"{PLATE}PSHELL,1,1,1.,1,,1,,{nsm}\nMAT1,1,210000.,,.3,{rho}\n")
    touching = Touching({}, (), (), None, False, "mm-t-s", Places(tmp_path / "study.toml"))
    said = start_warnings(model, touching, PrecheckTable())
    assert len([words for words in said if "no mass of their own" in words]) == told
