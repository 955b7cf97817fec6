"""Supports freed and held by the study, and nodes named by label or place: the same as a deck that says so itself."""

from __future__ import annotations

import numpy as np
import pytest

from creak.errors import InputError
from creak.studies.file.reader import read_study
from creak.studies.models.reference import build_reference
from creak.studies.prepare.setup import set_up
from helpers_decks import STUDY, two_strips, write_strips, write_study
from helpers_nastran_strips import STUDY as CHANGED
from helpers_nastran_strips import strips

CLAMPED = two_strips().replace("ROOT_UPPER, 1, 2\nROOT_UPPER, 4, 6\n", "ROOT_UPPER, 1, 6\n")
FREED = '[support.root]\nnodes = "ROOT_UPPER"\nfree = ["z"]\n'


def matrices(path):
    """The unreduced K, and the motion that its supports force on it."""
    setup = set_up(read_study(path))
    built = build_reference(setup.structure, setup.band, lambda *_: None)
    return setup, built.system.K.toarray(), built.support_shapes


def same(path, other):
    (setup, K, R), (_, K1, R1) = matrices(path), matrices(other)
    assert np.abs(K - K1).max() <= 1e-12 * np.abs(K).max()
    assert np.abs(R - R1).max() <= 1e-9
    return setup


def study_in(folder, deck, text):
    folder.mkdir()
    return write_strips(folder, deck, text)


def test_a_support_of_the_deck_is_freed_and_shaken(tmp_path):
    """As the deck that leaves it free; another one that holds less is held to the same."""
    plain = study_in(tmp_path / "plain", None, STUDY)
    shaken = same(study_in(tmp_path / "clamped", CLAMPED, STUDY + FREED), plain)
    assert any("3 dofs of the deck freed" in note for note in shaken.notes)
    every = FREED.replace("ROOT_UPPER", "*").replace("root", "all")
    held = '[support.lower]\nnodes = "ROOT_LOWER"\nhold = ["z"]\n'
    same(study_in(tmp_path / "all", CLAMPED, STUDY + every + held), plain)


def test_nastran_supports_have_names(tmp_path):
    text = STUDY
    for old, new in CHANGED.items():
        text = text.replace(old, new)
    folders = [tmp_path / name for name in ("plain", "clamped")]
    held = strips().replace("SPC1,1,12456,1,14,27", '$HMNAME LOADCOL 2"upper root"\nSPC1,2,123456,1,14,27')
    both = held.replace("SPC = 1\n", "SPC = 3\n").replace("PARAM,COUPMASS", "SPCADD,3,1,2\nPARAM,COUPMASS")
    for folder, deck, more in zip(
        folders, (strips(), both), ("", FREED.replace("ROOT_UPPER", "upper_root")), strict=True
    ):
        folder.mkdir()
        write_study(folder, text + more, {"strips.bdf": deck})
    setup = same(*(folder / "study.toml" for folder in folders[::-1]))
    sets = setup.model.node_sets
    assert np.array_equal(sets["SPC_2"], sets["UPPER_ROOT"])
    assert setup.model.nodes.ids[sets["SPC_2"]].tolist() == [1, 14, 27]


def test_places_and_labels_name_nodes(tmp_path):
    """Both ways name the root that the deck names; the distance is told, and every key takes the name."""
    labels = '[nodes.root]\nlabels = [1, "14", 27]\n'
    near = "[nodes.root]\nnear = [[0.1, 0, 1.75], [0, 10, 1.75], [0, 20.0, 1.75]]\n"
    sets = []
    for text in (labels, near):
        study = STUDY.replace('"ROOT_UPPER"', '"root"') + text + '[output]\nnodes = "ROOT"\n'
        setup = set_up(read_study(write_strips(tmp_path, None, study)))
        sets.append(setup.model.node_sets["ROOT"])
        assert set(sets[-1]) <= set(setup.watch.nodes)
    assert np.array_equal(*sets)
    assert np.array_equal(sets[0], setup.model.node_sets["ROOT_UPPER"])
    assert any("node 1, 14, 27, 0.1 mm from the given place at most" in note for note in setup.notes)


REFUSED = {
    "far": (
        "[nodes.a]\nnear = [[0, 0, 5]]\n",
        r"no node within 1.2\d* mm of \(0, 0, 5\): the nearest, 1 at .* is \S+ mm away",
    ),
    "one node twice": ("[nodes.a]\nnear = [[0, 0, 1.75], [0.1, 0, 1.75]]\n", "the same nearest node"),
    "unknown": ("[nodes.a]\nlabels = [17777]\n", "unknown node 17777"),
    "double": ("[nodes.a]\nlabels = [1, 1]\n", "node 1 is named twice"),
    "taken": ("[nodes.root_lower]\nlabels = [1]\n", "the deck has a node set 'root_lower' of its own"),
    "both": ("[nodes.a]\nlabels = [1]\nwithin = 2\n", "within and part belong to near"),
    "part": ('[nodes.a]\nnear = [[0, 0, 0]]\npart = "LOVER"\n', "unknown part 'LOVER'"),
    "not held": ('[support.a]\nnodes = "ROOT_UPPER"\nfree = ["z"]\n', "holds no node of 'ROOT_UPPER' in z"),
    "empty": ('[support.a]\nnodes = "ROOT_UPPER"\n', "give free or hold"),
    "freed and held": ('[support.a]\nnodes = "ROOT_UPPER"\nfree = ["x"]\nhold = ["x"]\n', "x is both freed and held"),
    "driven and held": (
        '[support.a]\nnodes = "ROOT_UPPER"\nhold = ["z"]\n',
        r"\[excitation.root\] moves node 1 z, which is held.*Free them: \[support.NAME\]",
    ),
    "loose": ('[support.a]\nnodes = "ROOT_LOWER"\nfree = ["x", "y", "z"]\n', "nothing holds part"),
    "wrong dof": ('[support.a]\nnodes = "ROOT_LOWER"\nfree = ["q"]\n', "support.a.free"),
}


@pytest.mark.parametrize("case", REFUSED)
def test_what_cannot_be_meant_is_refused(tmp_path, case):
    tables, match = REFUSED[case]
    with pytest.raises(InputError, match=match):
        set_up(read_study(write_strips(tmp_path, None, STUDY + tables)))


def test_two_nodes_at_one_place_need_a_part(tmp_path):
    deck = two_strips(gap=-1.25)  # both strips lie in one plane
    text = STUDY + "[nodes.a]\nnear = [[0, 0, 0]]\n"
    with pytest.raises(InputError, match=r"nodes (1 and 1001|1001 and 1) both lie at"):
        set_up(read_study(write_strips(tmp_path, deck, text)))
    setup = set_up(read_study(write_strips(tmp_path, deck, text + 'part = "LOWER"\n')))
    assert setup.model.nodes.ids[setup.model.node_sets["A"]].tolist() == [1001]


def test_a_support_along_its_own_axes_is_not_freed(tmp_path):
    deck = two_strips().replace("*BOUNDARY\n", "*EQUATION\n2\n1, 1, 1.0, 1, 3, 1.0\n*BOUNDARY\n")
    text = STUDY.replace('"ROOT_UPPER"', '"TIP_UPPER"') + '[support.a]\nnodes = "ROOT_UPPER"\nfree = ["x"]\n'
    with pytest.raises(InputError, match="node 1 of 'ROOT_UPPER' is held along axes of its own"):
        set_up(read_study(write_strips(tmp_path, deck, text)))
