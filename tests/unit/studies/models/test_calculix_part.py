"""A part of a study given as CalculiX matrices (.sti, .mas, .dof) moves as the elements that it came from."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from creak.arrays import to_dense
from creak.assembly.part import Rayleigh, part_system
from creak.errors import InputError
from creak.formats.abaqus.reader import read_deck
from creak.studies.file.reader import read_study
from creak.studies.prepare.setup import set_up
from creak.studies.run.job import run_study
from helpers_dynamic_decks import STEEL, column

BRICKS, CUT = 4, 2
"""Bricks of the column; those above the cut become matrices."""
STUDY = """[model]
deck = "{deck}"
units = "m-kg-s"
[reduction]
method = "none"
[damping]
rayleigh = {{ alpha = 5.0, beta = 1e-6 }}
[excitation.push]
node_set = "TOP"
dof = "x"
kind = "force"
signal = {{ type = "sine", frequency = 300.0, amplitude = 1.0 }}
[time]
step = 1e-4
end = 2e-2
[output]
nodes = ["TOP", "MIDDLE"]
[precheck]
enabled = false
[verification]
mac_f_max = 1.0
f_max = 500.0
"""


def deck(folder: Path, name: str, bricks: range) -> Path:
    """The column with some of its bricks and all of its nodes."""
    nodes = [line for line in column(BRICKS, 0.1, 1.0).splitlines() if line.count(",") == 3]
    elements = [line for line in column(BRICKS, 0.1, 1.0).splitlines() if line.count(",") == 8]
    assert (len(nodes), len(elements)) == (4 * (BRICKS + 1), BRICKS)
    top, middle = 4 * BRICKS, 4 * CUT
    text = [
        "*NODE",
        *nodes,
        "*ELEMENT, TYPE=C3D8, ELSET=BAR",
        *(elements[k] for k in bricks),
        "*SOLID SECTION, ELSET=BAR, MATERIAL=STEEL",
        STEEL.strip(),
        f"*NSET, NSET=TOP\n{', '.join(str(top + k) for k in range(1, 5))}",
        f"*NSET, NSET=MIDDLE\n{', '.join(str(middle + k) for k in range(1, 5))}",
        *(["*BOUNDARY", *(f"{k}, 1, 3" for k in range(1, 5))] if 0 in bricks else []),
    ]
    path = folder / f"{name}.inp"
    path.write_text("\n".join(text) + "\n")
    return path


def write_calculix(folder: Path) -> None:
    """The upper bricks as CalculiX writes them: node.dof of every row, one triangle of each matrix."""
    model = read_deck(deck(folder, "upper", range(CUT, BRICKS)))
    system = part_system(model, 0, Rayleigh(0.0, 0.0))
    labels = [f"{model.nodes.ids[c // 6]}.{c % 6 + 1}" for c in system.coordinates.tolist()]
    (folder / "upper.dof").write_text("\n".join(labels) + "\n")
    for ending, matrix in ((".sti", system.K), (".mas", system.M)):
        A = to_dense(matrix)
        rows = [f"{i + 1} {j + 1} {A[i, j]:.17e}" for j in range(len(A)) for i in range(j + 1) if A[i, j]]
        (folder / f"upper{ending}").write_text("\n".join(rows) + "\n")


def study(folder: Path, name: str, more: str = "") -> Path:
    path = folder / f"{name}.toml"
    path.write_text(STUDY.format(deck=f"{name}.inp") + more)
    return path


def motion(path: Path) -> np.ndarray:
    return run_study(set_up(read_study(path)), lambda *_: None).runs["reference"].history.displacement


@pytest.mark.parametrize("ending", [".sti", ".mas"])
def test_matrices_move_as_the_elements(tmp_path, ending):
    """Round-off of one factorisation with a condition number of some 1e6, over 200 steps."""
    deck(tmp_path, "whole", range(BRICKS))
    deck(tmp_path, "lower", range(CUT))
    write_calculix(tmp_path)
    whole = motion(study(tmp_path, "whole"))
    parts = motion(study(tmp_path, "lower", f'[superelement.upper]\nfile = "upper{ending}"\n'))
    assert np.abs(whole).max() > 0.0
    np.testing.assert_allclose(parts, whole, atol=1e-8 * np.abs(whole).max())


def test_a_node_that_the_deck_does_not_have(tmp_path):
    deck(tmp_path, "lower", range(CUT))
    write_calculix(tmp_path)
    text = (tmp_path / "upper.dof").read_text()
    (tmp_path / "upper.dof").write_text(text.replace("20.", "720."))
    with pytest.raises(InputError, match="ends at node 720, which the deck does not have"):
        set_up(read_study(study(tmp_path, "lower", '[superelement.upper]\nfile = "upper.sti"\n')))


def test_a_missing_file(tmp_path):
    deck(tmp_path, "lower", range(CUT))
    write_calculix(tmp_path)
    (tmp_path / "upper.mas").unlink()
    with pytest.raises(InputError, match=r"upper\.mas"):
        set_up(read_study(study(tmp_path, "lower", '[superelement.upper]\nfile = "upper.sti"\n')))
