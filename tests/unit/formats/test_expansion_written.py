"""Thermal expansion of materials goes along when a deck is written as another."""

from __future__ import annotations

from dataclasses import replace

import pytest

from creak.formats.abaqus.reader import read_deck
from creak.formats.abaqus.writer import write_deck
from creak.formats.nastran.reader import read_nastran
from creak.formats.nastran.writer import write_nastran
from creak.model.materials import GeneralShell
from helpers_nastran import read

GRIDS = "GRID,1\nGRID,2,,1.\nGRID,3,,1.,1.\nGRID,4,,0.,1.\nGRID,5,,0.,0.,1.\nGRID,6,,1.,0.,1.\nGRID,7,,1.,1.,1.\n"
BULK = (
    GRIDS
    + "GRID,8,,0.,1.,1.\nCHEXA,1,1,1,2,3,4,5,6\n,7,8\nPSOLID,1,9\nCQUAD4,2,2,1,2,3,4\nPSHELL,2,1,.2,1,,1\n"
    + "CTRIA3,3,3,5,6,7\nPCOMP,3,,,,,15.\n,8,.1,0.,,8,.2,90.\nCROD,4,4,5,7\nPROD,4,1,2.\n"
    + "MAT1,1,210000.,,.3,7.85-9,1.2-5,20.\nMAT8,8,9000.,3000.,.28,1500.,1100.,800.,1.3-9\n,2.-6,3.-5\n"
    + "MAT9,9,5.,1.,1.,,,,6.\n,1.,,,,7.,,,\n,2.,,,2.,,2.,1.-9,4.-6\n,5.-6,6.-6,0.,0.,0.,25.\n"
)


def strains(model) -> dict[int, tuple]:
    """Of each element, its material's expansion; of a laminate those of its plies."""
    found = {}
    for block in model.blocks:
        section = block.section
        materials = [p.material for p in section.plies] if isinstance(section, GeneralShell) else [section.material]
        found.update(dict.fromkeys(block.ids.tolist(), tuple(m.expansion.strain for m in materials)))
    return found


def test_decks_of_both_kinds(tmp_path):
    model = read(tmp_path, BULK)
    wanted = strains(model)
    assert wanted[1][0][:3] == pytest.approx((4e-6, 5e-6, 6e-6))
    write_nastran(model, tmp_path / "again.bdf")
    again = read_nastran(tmp_path / "again.bdf")
    assert strains(again) == wanted
    shells = [b.section.expansion.reference for b in again.blocks if isinstance(b.section, GeneralShell)]
    others = {b.section.material.expansion.reference for b in again.blocks if not isinstance(b.section, GeneralShell)}
    assert (shells, others) == ([15.0], {20.0, 25.0})
    write_deck(replace(model, mass_form="consistent"), tmp_path / "again.inp")
    text = (tmp_path / "again.inp").read_text()
    assert text.count("*EXPANSION, TYPE=ORTHO") == 2
    assert strains(read_deck(tmp_path / "again.inp")) == wanted
