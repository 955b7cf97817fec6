"""What a keyword that is left out means: harmless, or a change of the answer."""

from __future__ import annotations

from creak.formats.abaqus.reader import read_deck

ROD = (
    "*NODE, NSET=ALL\n1, 0., 0., 0.\n2, 1., 0., 0.\n*ELEMENT, TYPE=T3D2, ELSET=E\n1, 1, 2\n"
    "*MATERIAL, NAME=M\n*ELASTIC\n2.E5, .3\n*DENSITY\n1.E-9\n*SOLID SECTION, ELSET=E, MATERIAL=M\n1.\n"
)
DESIGN = "*DESIGN PARAMETER\nh\n*DESIGN VARIABLES, TYPE=COORDINATE\nALL\n"
STEPS = (
    "*STEP\n*FREQUENCY\n2\n*END STEP\n*STEP\n*SENSITIVITY\n*DESIGN RESPONSE, NAME=R\nEIGENFREQUENCY\n"
    "*OBJECTIVE\nR\n*CONSTRAINT\nR, LE, 1., 2.\n*FILTER, TYPE=LINEAR\n3.\n*NODE FILE\nSEN\n*END STEP\n"
)


def test_design_and_its_sensitivities_change_nothing(tmp_path):
    path = tmp_path / "d.inp"
    path.write_text(ROD + DESIGN + STEPS)
    found = {u.keyword: u for u in read_deck(path).unread}
    assert not [u.keyword for u in found.values() if u.changes_answer]
    for name in ("DESIGN PARAMETER", "DESIGN VARIABLES"):
        assert "design only" in found[f"*{name}"].why
