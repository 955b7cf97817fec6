"""Every way to reduce, through a study: contact is found and agrees with the unreduced model.

A factor of the stiffness of what may move freely: with as much mass as it takes.
Static shapes of forces need a structure that is held without contact.
"""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace

import h5py
import numpy as np
import pytest
import scipy.linalg as sla

import creak
from creak.arrays import to_dense
from creak.errors import InputError
from creak.linalg.factor import SingularMatrixError
from creak.model.dofs import node_dofs
from creak.progress import silent
from creak.studies.converge.repeats import not_looked_at
from creak.studies.file.reader import read_study
from creak.studies.models.interface import Line, _participating
from creak.studies.models.reduced import reduced_modes
from creak.studies.models.reference import build_reference, held_factor, static_shapes
from creak.studies.models.substructures import reach_of_keep_out
from creak.studies.prepare.setup import set_up
from creak.studies.run.job import StudyResult, run_study
from creak.studies.warned import warnings_of
from helpers_core import system_of
from helpers_decks import STUDY, two_strips, write_strips
from helpers_findings import save_plain, summarised
from helpers_nastran_strips import strips

TIPS = "*SURFACE, NAME=TIPS\n12, SNEG\n24, SNEG\n*ELSET, ELSET=HALF, GENERATE\n1001, 1006, 1\n1013, 1018, 1\n"
ALONE = "\n[reference]\nrun = false\n", "end = 0.07"
"""No unreduced run beside it, to a little after the first blow."""


def run(folder, reduction: str, more: str = "", time: str = "periods = 1") -> StudyResult:
    deck = two_strips().replace("*SURFACE, NAME=UNDER", TIPS + "*SURFACE, NAME=UNDER")
    study = STUDY.replace('secondary = "UNDER"', 'secondary = "TIPS"').replace("[reduction]\nf_max = 3000\n", reduction)
    write_strips(folder, deck)
    path = write_strips(folder, deck, study.replace("periods = 2", time) + more)
    return run_study(set_up(read_study(path)), lambda *_: None)


@pytest.mark.parametrize(
    "reduction",
    [
        "[reduction]\nf_max = 6000\n",
        "[reduction]\nf_max = 6000\nkeep_out = 15\n",
        '[reduction]\nf_max = 6000\nsubstructures = ["HALF"]\n',
        '[reduction]\nf_max = 6000\nkeep_out = 15\ninterface = { type = "characteristic", n = 12 }\n',
        '[reduction]\nf_max = 6000\nkeep_out = 15\ninterface = { type = "characteristic", n = 12, level = "local" }\n',
        '[reduction]\nf_max = 6000\nkeep_out = 15\ninterface = { type = "interpolation", n = 2 }\n',
        '[reduction]\nf_max = 6000\nkeep_out = 15\ninterface = { type = "coarse-mesh", deck = "strips.inp" }\n',
        '[reduction]\nf_max = 6000\nkeep_out = 15\ninterface = { type = "coarse-mesh", deck = "strips.bdf" }\n',
        '[reduction]\nmethod = "gap-modes"\nf_max = 6000\n',
    ],
)
def test_modes_and_motion_agree_with_the_unreduced_model(reduction, tmp_path):
    """f_max is 100 x the excitation: what is left is interface error, a per cent or two at most."""
    (tmp_path / "strips.bdf").write_text(strips(extra='$HMSET 1 1 "ROOT_UPPER"'), encoding="utf-8")
    result = run(tmp_path, reduction, time="end = 0.1")
    check = summarised(result)["verification"]
    assert min(check["mac"]) > 0.99
    for reference, reduced in check["frequencies"]:
        assert reduced == pytest.approx(reference, rel=0.02)
    assert check["nrmse"]["all"] > 0.9
    assert check["events"]["missed"] == 0


def test_guyan_and_spacing_keep_fewer_dofs_and_run(tmp_path):
    full = run(tmp_path, "[reduction]\nf_max = 6000\n", *ALONE)
    static = run(tmp_path, '[reduction]\nmethod = "guyan"\n', *ALONE)
    assert static.runs["reduced"].modes == 0
    spaced = run(tmp_path, '[reduction]\nf_max = 6000\ninterface = { type = "spacing", n = 2 }\n', *ALONE)
    assert spaced.runs["reduced"].retained < full.runs["reduced"].retained
    some = run(tmp_path, '[reduction]\nf_max = 6000\ninterface = { type = "participation", eta = 0.5 }\n', *ALONE)
    assert some.runs["reduced"].retained < full.runs["reduced"].retained


def test_whole_field_is_recovered_and_agrees_with_the_watched_nodes(tmp_path):
    result = run(tmp_path, "[reduction]\nf_max = 6000\n", "\n[output]\nfield_interval = 0.01\nfield_start = 0.05\n")
    save_plain(result, tmp_path / "out")
    with h5py.File(tmp_path / "out" / "results.h5") as file:
        for name in ("reduced", "reference"):
            field, own = file[f"runs/{name}/field"], file[f"runs/{name}"]
            assert field["displacement"].shape == (16, 78, 3)
            at = np.round(field["time"][:] / 5e-4).astype(int)
            rows = [field["node_ids"][:].tolist().index(i) for i in own["node_ids"][:]]
            motion = own["displacement"][:][at][:, :, :3]
            # Two routes to the same motion; round-off of K_ii^-1 K_ib.
            np.testing.assert_allclose(field["displacement"][:][:, rows], motion, atol=1e-7 * np.abs(motion).max())


@pytest.mark.parametrize("sparse", [True, False])
def test_a_body_whose_stiffness_is_round_off_has_a_factor(sparse):
    """Links make it rigid: what is left of K is of either sign, and larger than a trace of mass."""
    M = np.diag([2.0, 2.0, 2.0, 0.1])
    K = 1e-9 * np.array([[1.0, 0.3, 0.0, 0.0], [0.3, -0.5, 0.1, 0.0], [0.0, 0.1, 2.0, 0.2], [0.0, 0.0, 0.2, -0.1]])
    found = held_factor(system_of(M, K, sparse=sparse))
    assert np.isfinite(found.solve(np.ones(4))).all()


def test_motion_without_stiffness_and_mass_has_none():
    with pytest.raises(SingularMatrixError, match="row 1"):
        held_factor(system_of(np.diag([1.0, 0.0]), np.diag([1.0, 0.0]), sparse=False))


def test_a_structure_that_only_contact_holds_has_none(tmp_path):
    text = STUDY.replace('node_set = "ROOT_UPPER"', 'node_set = "PAIRS"').replace(
        'kind = "displacement"', 'kind = "force"'
    )
    deck = two_strips().replace("ROOT_UPPER, 1, 2", "ROOT_UPPER, 1, 3")
    path = write_strips(tmp_path, deck, text.replace("f_max = 3000", 'method = "gap-modes"'))
    setup = set_up(read_study(path))
    reference = build_reference(setup.structure, setup.band, silent)
    shapes = static_shapes(reference, setup.reduction)
    assert shapes.shape == (reference.system.n, 1)
    pushed = np.asarray(reference.system.K @ shapes[:, 0])
    assert np.abs(pushed).sum() == pytest.approx(4.0, rel=1e-6)  # one on each of four nodes
    with pytest.raises(InputError, match="only contact holds the structure"):
        static_shapes(replace(reference, stiffness=None), setup.reduction)


def test_dofs_at_which_joined_parts_are_left_free_are_told(tmp_path):
    """Courant and Fischer: no Galerkin reduction is softer; one whose parts are not joined everywhere may be."""
    spaced = run(
        tmp_path, '[reduction]\nf_max = 6000\nkeep_out = 15\ninterface = { type = "spacing", n = 3 }\n', *ALONE
    )
    full = run(tmp_path, "[reduction]\nf_max = 6000\nkeep_out = 15\n", *ALONE)
    (said,) = not_looked_at(spaced.setup.study.config.reduction, spaced.reduced)
    assert f"free of each other at {spaced.reduced.freed} dofs" in said
    assert not spaced.reduced.complete
    assert full.reduced.freed == 0
    assert not not_looked_at(full.setup.study.config.reduction, full.reduced)
    known = full.reference.modes.frequencies
    assert reduced_modes(spaced.reduced.system, known[-1]).frequencies[0] < (1.0 - 1e-4) * known[0]
    assert reduced_modes(full.reduced.system, known[-1]).frequencies[0] > (1.0 - 1e-6) * known[0]


@pytest.mark.parametrize("level", ["system", "local"])
def test_an_interface_in_fewer_shapes_leaves_something_out_though_all_modes_are_kept(level, tmp_path):
    """A small model gets all modes. With one shape of each border it is none the less far from the unreduced one."""
    interface = f'interface = {{ type = "characteristic", n = 1, level = "{level}" }}'
    deck = two_strips().replace("*SURFACE, NAME=UNDER", TIPS + "*SURFACE, NAME=UNDER")
    study = STUDY.replace('"UNDER"', '"TIPS"').replace("f_max = 3000", f"keep_out = 15\n{interface}")
    study = study.replace("step = 5e-4\nperiods = 2", 'end = 0.042\n[reference]\nrun = "none"')
    path = write_strips(tmp_path, deck, study.replace("amplitude = 0.05", "amplitude = 0.3"))
    found = creak.run(path, record=False)
    reduced, reference = found.found.reduced, found.found.reference.system
    K, M = (to_dense(A) for A in (reference.K, reference.M))
    exact = np.sqrt(sla.eigh(K, M, eigvals_only=True)[:4]) / (2.0 * np.pi)
    off = reduced_modes(reduced.system, 1e9).frequencies[:4] / exact - 1.0
    assert off.max() > 0.01  # it lacks shapes
    assert reduced.every_mode
    assert not reduced.complete
    told = found.summary["runs"]["reduced"]
    assert told["events"]
    assert told["verdict"] == "unsettled"
    assert told["reasons"][0].startswith('what interface = "characteristic" leaves out was not looked at')
    lost = [text for text in found.summary["warnings"] if "the reduced model lacks modes of the unreduced one" in text]
    assert bool(lost) == (level == "local")  # its third mode lies 62 % higher, beyond 15 %
    if lost:
        third = np.sqrt(sla.eigh(K, M, eigvals_only=True)[2]) / (2.0 * np.pi)
        assert f"({third:.4g} Hz)" in lost[0]
        assert 'interface = { type = "full" }' in lost[0]


def test_elements_that_keep_out_does_not_part_are_told(tmp_path):
    found = run(tmp_path, "[reduction]\nf_max = 6000\nkeep_out = 1e4\n", *ALONE)
    assert [text for text in warnings_of(found.notes) if "keep_out = 10000: every element lies within it" in text]
    reduction, nodes = found.setup.reduction, found.gaps.retained_nodes
    for distance, some, told in ((0.01, nodes[:1], "no element"), (15.0, nodes, None)):
        own = replace(reduction, table=reduction.table.model_copy(update={"keep_out": distance}))
        said = reach_of_keep_out(own, SimpleNamespace(m=1, retained_nodes=some))
        assert [told in text for text in said] == [True] * (told is not None)


def test_characteristic_modes_of_no_interface_are_told(tmp_path):
    """Parts that meet nothing but each other's contact have none: all is kept."""
    reduction = '[reduction]\nf_max = 6000\ninterface = { type = "characteristic", n = 1 }\n'
    found = run(tmp_path, reduction, *ALONE)
    assert not found.reduced.fewer
    assert [text for text in found.notes if "reduces nothing: no part meets unreduced elements" in text]
    assert not not_looked_at(found.setup.study.config.reduction, found.reduced)


def test_translations_alone_take_part_by_their_own_size():
    """Six translations: the three that move stay, whatever dofs of one node their number would fit."""
    shapes = np.array([[1.0], [1.0], [1.0], [0.1], [0.1], [0.1]])
    line = Line("PART", SimpleNamespace(), node_dofs(np.arange(6))[2::6])
    modes = SimpleNamespace(frequencies=np.array([10.0]), shapes=shapes)
    whole = SimpleNamespace(modes=modes, system=SimpleNamespace(rows=lambda labels: (np.eye(labels.size), None)))
    np.testing.assert_array_equal(_participating(20.0, whole, line, 0.35), [0, 1, 2])
