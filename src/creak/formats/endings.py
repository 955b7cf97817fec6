"""Endings of deck files."""

from __future__ import annotations

from pathlib import Path

ABAQUS = ".inp"
NASTRAN = (".bdf", ".dat", ".nas", ".fem", ".blk", ".bulk", ".pch")
"""Decks of Nastran and its kin: .fem of OptiStruct, bulk data alone, what was punched."""
LSDYNA = (".k", ".key", ".dyn")
WRITTEN = (ABAQUS, *NASTRAN[:3])
DECKS = (ABAQUS, *NASTRAN, *LSDYNA)


def is_nastran(path: Path) -> bool:
    """Is it read as a Nastran deck? Decks with any other ending are read as Abaqus decks."""
    return path.suffix.lower() in NASTRAN


def is_deck(path: Path) -> bool:
    """Is it a deck rather than a study file?"""
    return path.suffix.lower() in DECKS
