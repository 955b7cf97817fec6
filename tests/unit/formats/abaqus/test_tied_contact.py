"""Tied contact pairs are ties, and ties of solids that do not touch hold them."""

from __future__ import annotations

import numpy as np
import pytest

from creak.assembly.coupling import Driven
from creak.errors import InputError
from creak.formats.abaqus.reader import read_deck, read_deck_run
from creak.model.constraints import Equation, Tie
from creak.studies.models.deck_modes import model_modes
from helpers_ties import cut_plate

PAIR = "*SURFACE INTERACTION, NAME=GLUE\n*CONTACT PAIR, INTERACTION=GLUE, TIED, ADJUST=.2\nRIGHT_X0, LEFT_X1\n"
STEP = "*STEP\n*FREQUENCY\n 8\n{}*END STEP\n"


def model_of(tmp_path, text):
    path = tmp_path / "deck.inp"
    path.write_text(text, encoding="utf-8")
    return read_deck(path)


def frequencies(model, count=8):
    return model_modes(model, Driven({}), count=count)[1].frequencies


@pytest.mark.parametrize(
    "pair",
    [
        PAIR,
        PAIR.replace(", TIED, ADJUST=.2", ", ADJUST=0.0").replace(
            "*CONTACT", "*SURFACE BEHAVIOR, PRESSURE-OVERCLOSURE=TIED\n1E7\n*CONTACT"
        ),
        PAIR.replace("ADJUST=.2", "ADJUST=JOINED") + "*NSET, NSET=JOINED\nRIGHT_NODES\n",
        STEP.format("*CONTACT PAIR, INTERACTION=GLUE, TIED\nRIGHT_X0, LEFT_X1\n"),
        "*STEP\n*STATIC\n*END STEP\n" + STEP.format("*CONTACT PAIR, INTERACTION=GLUE, TIED\nRIGHT_X0, LEFT_X1\n"),
    ],
)
def test_a_tied_pair_is_a_tie_without_rotation(tmp_path, pair):
    tied = model_of(tmp_path, cut_plate((3, 4), (3, 6), pair))
    assert not any(u.changes_answer for u in tied.unread)
    wanted = model_of(tmp_path, cut_plate((3, 4), (3, 6), "*TIE, NAME=SEAM, NO ROTATION\nRIGHT_X0, LEFT_X1\n"))
    assert len([c for c in tied.constraints if isinstance(c, Tie)]) == 7
    for ours, theirs in zip(tied.constraints, wanted.constraints, strict=True):
        assert ours.node_idx == theirs.node_idx
        assert not ours.rotations
        np.testing.assert_array_equal(ours.weights, theirs.weights)
    assert any(u.keyword == "*CONTACT PAIR, TIED" for u in tied.unread)


def test_other_pairs_stay_contact(tmp_path):
    model = model_of(tmp_path, cut_plate((3, 4), (3, 6), PAIR.replace(", TIED", "")))
    assert not model.constraints
    assert any(u.keyword == "*CONTACT PAIR" for u in model.unread)


def test_a_tied_pair_is_a_tie_in_the_own_step_too(tmp_path):
    step = "*STEP\n*DYNAMIC, DIRECT\n.001, .01\n*END STEP\n"
    path = tmp_path / "deck.inp"
    path.write_text(cut_plate((3, 4), (3, 6), PAIR + step), encoding="utf-8")
    model, run = read_deck_run(path)
    assert len(model.constraints) == 7
    assert run.pairs == ()


def test_surfaces_out_of_reach_stop(tmp_path):
    with pytest.raises(InputError, match=r"CONTACT PAIR, TIED joins no node of 'RIGHT_X0'"):
        model_of(tmp_path, cut_plate((3, 4), (3, 6), PAIR, shift=(5.0, 0.0, 0.0)))


def bar(gap: float) -> str:
    """Two clamped blocks of 50 x 10 x 10 mm end to end, `gap` between them, tied."""
    lines = []
    for name, base, x0 in (("A", 0, 0.0), ("B", 100, 50.0 + gap)):
        corners = [(i, j, k) for i in range(6) for j in range(2) for k in range(2)]
        lines.append(f"*NODE, NSET={name}_NODES")
        lines += [f"{base + 1 + 4 * i + 2 * j + k}, {x0 + 10 * i}, {10 * j}, {10 * k}" for i, j, k in corners]
        lines.append(f"*ELEMENT, TYPE=C3D8I, ELSET={name}")
        for i in range(5):
            at = base + 1 + 4 * i
            ring = (0, 4, 6, 2, 1, 5, 7, 3)
            lines.append(f"{base + 1 + i}, " + ", ".join(str(at + r) for r in ring))
        lines += [f"*SOLID SECTION, ELSET={name}, MATERIAL=M", f"*SURFACE, NAME={name}_FACE", f"{name},"]
    lines += ["*MATERIAL, NAME=M", "*ELASTIC", "2.E5, .3", "*DENSITY", "7.8E-9", "*BOUNDARY"]
    lines += [f"{n}, 1, 3" for n in (1, 2, 3, 4)]
    return "\n".join([*lines, "*SURFACE, NAME=END, TYPE=NODE", *(f"{100 + n}," for n in (1, 2, 3, 4)), ""])


def test_an_arm_on_the_face_of_a_solid_turns_with_it(tmp_path):
    """Solids have no rotations, so an arm that took them let the tied part swing: three modes of frequency zero."""
    whole = frequencies(model_of(tmp_path, bar(0.0) + "*TIE, NAME=T\nEND, A_FACE\n"), 4)
    model = model_of(tmp_path, bar(0.01) + "*TIE, NAME=T\nEND, A_FACE\n")
    assert all(isinstance(c, Equation) for c in model.constraints)
    assert frequencies(model, 4) == pytest.approx(whole, rel=1e-3)


def test_rigid_motion_strains_no_arm(tmp_path):
    """u = t + omega x r of all nodes satisfies each equation, whatever the gap."""
    model = model_of(tmp_path, bar(2.0) + "*TIE, NAME=T, POSITION TOLERANCE=3.\nEND, A_FACE\n")
    x = model.nodes.coords
    u = np.array([0.3, -0.2, 0.5]) + np.cross([0.1, 0.7, -0.4], x)
    assert len(model.constraints) == 12
    for c in model.constraints:
        assert c.coefficients @ u[c.nodes_idx, c.dofs - 1] == pytest.approx(0.0, abs=1e-12)


def two_strips_on_a_block() -> str:
    """Two strips of 100 x 10 x 1 mm, clamped at their ends, that are tied to one edge of a held block."""
    corners = [(10 * i, 10 * j, 10 * k) for k in range(2) for i, j in ((0, 0), (1, 0), (1, 1), (0, 1))]
    lines = ["*NODE", *(f"{n}, {x}, {y}, {z}" for n, (x, y, z) in enumerate(corners, start=1))]
    lines += ["*ELEMENT, TYPE=C3D8I, ELSET=BLOCK", "1, 1, 2, 3, 4, 5, 6, 7, 8"]
    for base, step in ((100, -5), (200, 5)):
        lines += ["*NODE", *(f"{base + 2 * i + j}, {10 + step * i}, {10 * j}, 10" for i in range(21) for j in range(2))]
        lines.append("*ELEMENT, TYPE=S4, ELSET=STRIPS")
        lines += [f"{base + i}, " + ", ".join(str(base + 2 * i + k) for k in (0, 2, 3, 1)) for i in range(20)]
        lines += [f"*NSET, NSET=EDGE{base}", f"{base}, {base + 1}", "*NSET, NSET=ENDS", f"{base + 40}, {base + 41}"]
        lines += [f"*SURFACE, NAME=S{base}, TYPE=NODE", f"EDGE{base},", f"*TIE, NAME=T{base}", f"S{base}, TOP"]
    lines += ["*SURFACE, NAME=TOP", "BLOCK, S2", "*SHELL SECTION, ELSET=STRIPS, MATERIAL=M", "1.,"]
    lines += ["*SOLID SECTION, ELSET=BLOCK, MATERIAL=M", "*MATERIAL, NAME=M", "*ELASTIC", "2.E5, 0.", "*DENSITY"]
    return "\n".join(
        [*lines, "7.8E-9", "*NSET, NSET=HELD, GENERATE", "1, 8", "*BOUNDARY", "HELD, 1, 3", "ENDS, 1, 6", ""]
    )


def test_the_face_of_a_solid_holds_no_rotation_of_a_shell_that_lies_on_it(tmp_path):
    """Each strip is a beam, clamped and pinned: k L = 3.92660. Through rotations that the block's nodes do not have the
    two would bend as one."""
    bending = np.sqrt(2e5 / 12.0 / 7.8e-9)
    expected = 3.92660**2 / (2.0 * np.pi) * bending / 100.0**2
    assert frequencies(model_of(tmp_path, two_strips_on_a_block()), 2) == pytest.approx([expected] * 2, rel=5e-3)
