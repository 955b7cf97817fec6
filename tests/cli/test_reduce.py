"""Superelements saved, used again, found stale, and written for other programs."""

from __future__ import annotations

import json

import h5py
import numpy as np
import pytest

from creak.errors import NumericalError
from creak.formats.matrices.superelements import FORMATS, read_superelement
from creak.formats.stored import superelement as superelement_file
from creak.linalg.memory import OutOfMemory
from creak.studies.models import superelements
from helpers_decks import STUDY, two_strips, write_strips

pytestmark = pytest.mark.usefixtures("no_page")

NEAR_TIP = STUDY.replace("[reduction]\n", "[reduction]\nkeep_out = 0\n").replace(
    'secondary = "UNDER"', 'secondary = "TIPS"'
)
"""Contact at the last quads only, so that much of each strip is inside."""
TIP_SURFACES = "*SURFACE, NAME=TIPS\n12, SNEG\n24, SNEG\n"


def tip_deck() -> str:
    return two_strips().replace("*SURFACE, NAME=UNDER", TIP_SURFACES + "*SURFACE, NAME=UNDER")


@pytest.fixture
def study(tmp_path):
    short = NEAR_TIP.replace("periods = 2", "periods = 1")
    return write_strips(tmp_path, tip_deck(), f"{short}[reference]\nrun = false\n")


def summary(folder) -> dict:
    return json.loads((folder / "summary.json").read_text())


def test_run_uses_what_reduce_saved(creak, study, tmp_path, monkeypatch):
    text = creak("run", study, "--out", tmp_path / "before").done().words
    assert "taken from" not in text
    text = creak("reduce", study).done().words
    assert "ground check" in text  # the health report
    store = tmp_path / "superelements"
    assert sorted(p.name for p in store.glob("*.h5")) == ["LOWER.h5", "UPPER.h5"]
    opened, real = [], superelement_file.opened_hdf5
    monkeypatch.setattr(superelement_file, "opened_hdf5", lambda path: opened.append(path.name) or real(path))
    text = creak("run", study, "--out", tmp_path / "after").done().words
    assert text.count("taken from") == 2
    assert sorted(opened) == ["LOWER.h5", "UPPER.h5"]  # its checksum is that of a whole file: once is enough
    before, after = summary(tmp_path / "before"), summary(tmp_path / "after")
    for key in ("dof", "retained", "modes", "max_force", "impulse_total"):
        # The same matrices, read back to the bit.
        assert after["runs"]["reduced"][key] == pytest.approx(before["runs"]["reduced"][key], rel=1e-12)
    assert set(after["superelements"]) == {"UPPER", "LOWER"}
    assert after["superelements"]["UPPER"]["rigid_mass_error"] < 1e-6  # round-off of K_ii^-1 K_ib


DOES_NOT_HOLD = NumericalError("its retained dofs do not hold it")


def failing(monkeypatch, part: str, seen=lambda: None, error: Exception = DOES_NOT_HOLD):
    """The reduction of this part ends with an error, the others go their way."""
    real = superelements.fixed_interface_basis

    def basis(inside, *rest, **options):
        if inside.name == part:
            seen()
            raise error
        return real(inside, *rest, **options)

    monkeypatch.setattr(superelements, "fixed_interface_basis", basis)


def test_a_part_that_fails_does_not_lose_the_others(creak, study, tmp_path, monkeypatch):
    with monkeypatch.context() as patch:
        failing(patch, "UPPER")
        said = creak("reduce", study)
    said.refuses("do not hold it", "saved: LOWER. The same command goes on from there")
    assert [p.name for p in (tmp_path / "superelements").iterdir()] == ["LOWER.h5"]
    text = creak("reduce", study).done().words
    assert text.count("taken from") == 1


def test_memory_that_does_not_suffice_is_no_fault_of_the_retained_dofs(creak, study, tmp_path, monkeypatch):
    failing(monkeypatch, "UPPER", error=OutOfMemory("memory does not hold the factor"))
    said = creak("reduce", study, "--quiet")
    assert said.status == 1
    assert "memory does not hold the factor" in said.words
    assert "Couple it" not in said.words
    assert [p.name for p in (tmp_path / "superelements").iterdir()] == ["LOWER.h5"]


def test_a_reduction_that_is_killed_has_saved_what_was_done(creak, study, tmp_path, monkeypatch):
    """Nothing runs after a kill: the first part's file, its health included, lies there before the second begins."""
    saved = []

    def look():
        with h5py.File(tmp_path / "superelements" / "UPPER.h5") as file:
            saved.append(json.loads(file.attrs["about"]))

    failing(monkeypatch, "LOWER", look)
    assert creak("reduce", study, "--quiet").status == 2
    assert [about["health"]["name"] for about in saved] == ["UPPER"]


def test_only_the_changed_part_is_reduced_again(creak, study, tmp_path):
    assert creak("reduce", study, "--quiet").status == 0
    store = tmp_path / "superelements"
    kept = {p.name: p.stat().st_mtime_ns for p in store.iterdir()}
    (tmp_path / "strips.inp").write_text(tip_deck().replace("MATERIAL=STEEL\n1.5,", "MATERIAL=STEEL\n1.6,"))
    text = creak("reduce", study).done().words
    assert "superelement UPPER: taken from UPPER.h5" in text
    assert "superelement LOWER: the saved one in LOWER.h5 is stale (its stiffness changed, its mass changed)" in text
    now = {p.name: p.stat().st_mtime_ns for p in store.iterdir()}
    assert now["UPPER.h5"] == kept["UPPER.h5"]
    assert now["LOWER.h5"] > kept["LOWER.h5"]


def test_other_modes_make_a_saved_superelement_stale(creak, study, tmp_path):
    assert creak("reduce", study, "--quiet").status == 0
    study.write_text(study.read_text().replace("f_max = 3000", "f_max = 9000"))
    text = creak("run", study, "--out", tmp_path / "out").done().words
    assert text.count("stale (other modes are asked for); reduced again") == 2


def test_a_superelement_that_retains_more_serves_runs_that_need_less(creak, study, tmp_path):
    """Reduced with all channels kept; a run whose pre-check keeps fewer takes it, and finds what its own would."""
    study.write_text(study.read_text().replace('secondary = "TIPS"', 'secondary = "UNDER"'))
    few = ("--set", "precheck.margin=0.001")
    assert creak("run", study, "--out", tmp_path / "own", *few).status == 0
    assert creak("reduce", study, "--quiet", "--set", "precheck.margin=100").status == 0
    text = creak("run", study, "--out", tmp_path / "taken", *few).done().words
    assert text.count("which retains more dofs than the run needs") == 2
    own, taken = (summary(tmp_path / name)["runs"]["reduced"] for name in ("own", "taken"))
    assert taken["retained"] > own["retained"]
    assert taken["channels"] == own["channels"]
    assert taken["max_force"] == pytest.approx(own["max_force"], rel=0.02)
    assert taken["impulse_total"] == pytest.approx(own["impulse_total"], rel=0.02)


def test_a_wider_superelement_of_another_part_is_left_alone(creak, study, tmp_path):
    assert creak("reduce", study, "--quiet", "--set", "precheck.margin=100").status == 0
    with h5py.File(tmp_path / "superelements" / "LOWER.h5") as file:
        before = json.loads(file.attrs["made_from"])
    (tmp_path / "strips.inp").write_text(tip_deck().replace("MATERIAL=STEEL\n1.5,", "MATERIAL=STEEL\n1.6,"))
    text = creak("run", study, "--out", tmp_path / "out", "--set", "precheck.margin=0.001").done().words
    assert "superelement LOWER: the saved one in LOWER.h5 is stale (its stiffness changed" in text
    assert before["creak"]


@pytest.mark.parametrize("keep", [0.0, 0.3, 0.9])
def test_file_cut_short_is_refused(creak, keep, study, tmp_path):
    assert creak("reduce", study, "--quiet").status == 0
    file = tmp_path / "superelements" / "UPPER.h5"
    data = file.read_bytes()
    file.write_bytes(data[: int(keep * len(data))])
    creak("run", study, "--quiet", "--out", tmp_path / "out").refuses("UPPER.h5", "cut short", "creak reduce")
    assert not (tmp_path / "out").exists()


def test_foreign_file_is_refused(creak, study, tmp_path):
    (tmp_path / "superelements").mkdir()
    with h5py.File(tmp_path / "superelements" / "LOWER.h5", "w") as file:
        file["x"] = 1.0
    creak("run", study, "--quiet", "--out", tmp_path / "out").refuses("not a superelement that creak has saved")


@pytest.mark.parametrize("name", FORMATS)
def test_export_reads_back_with_the_same_frequencies(creak, name, study, tmp_path):
    out = tmp_path / "out"
    assert creak("reduce", study, "--quiet", "--out", out, "--export", name).status == 0
    files = sorted(p for p in out.iterdir() if p.suffix != ".h5" and p.name.startswith("LOWER"))
    main_file = next(p for p in files if p.suffix in (".op4", ".npz", ".mtx", ".inp", ".dmig", ".bdf", ".dat", ".pch"))
    with h5py.File(out / "LOWER.h5") as file:
        K, M, nodes = (file[k][()] if isinstance(file[k], h5py.Dataset) else None for k in ("K", "M", "node_ids"))
    back = read_superelement(main_file)
    assert sorted(set(back.node_ids.tolist())) == sorted(set(nodes.tolist()))
    dense = [np.asarray(A.toarray() if hasattr(A, "toarray") else A) for A in (back.K, back.M)]
    if K is not None and M is not None:
        # Rows may come in another order; traces and norms do not care.
        for A, B in zip((K, M), dense, strict=True):
            assert np.trace(B) == pytest.approx(np.trace(A), rel=1e-12)
            assert np.linalg.norm(B) == pytest.approx(np.linalg.norm(A), rel=1e-12)


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (("[reduction]\n", '[reduction]\nmethod = "gap-modes"\n'), ["gap-modes", "makes no superelements"]),
        (("[reduction]\n", '[reduction]\nretain = "ROOT_LOWER"\n'), ["cannot retain node 1001", "boundary condition"]),
        (("[reduction]\n", '[reduction]\nretain = "ROOT_LOWR"\n'), ["ROOT_LOWR", "Did you mean"]),
        (("[reduction]\n", '[reduction]\nsubstructures = ["LOVER"]\n'), ["element set", "LOVER", "LOWER"]),
        (("[reduction]\n", '[reduction]\ninterface = { type = "spacing" }\n'), ["interface", "needs n"]),
    ],
)
def test_what_does_not_fit_is_explained(creak, change, words, study, tmp_path):
    study.write_text(study.read_text().replace(*change))
    creak("reduce", study, "--quiet", "--out", tmp_path / "out").refuses(*words)
    assert not (tmp_path / "out").exists()


def test_no_mode_below_f_max_near_the_excitation_is_explained(creak, study, tmp_path):
    """The held strips' first mode lies near 360 Hz: 160 Hz keeps none, and 150 Hz of excitation needs some."""
    study.write_text(study.read_text().replace("f_max = 60", "f_max = 150").replace("f_max = 3000", "f_max = 160"))
    creak("reduce", study, "--quiet", "--out", tmp_path / "out").refuses(
        "f_max = 160 Hz is below the first fixed-interface mode of every part", "guyan"
    )


def test_interface_without_nodes_is_explained(creak, study, tmp_path):
    """No channel comes near, no node is watched: there is nothing to thin out."""
    text = (
        study.read_text()
        .replace('pairs = "PAIRS"\n', "")
        .replace('main = "OVER"\n', 'main = "OVER"\nclearance = 50.0\n')
    )
    study.write_text(text.replace("[reduction]\n", '[reduction]\ninterface = { type = "spacing", n = 2 }\n'))
    creak("reduce", study, "--quiet", "--out", tmp_path / "out").refuses("the interface has no node", "study.toml:")
    assert not (tmp_path / "out").exists()


def test_part_that_floats_is_explained(creak, study, tmp_path):
    deck = (tmp_path / "strips.inp").read_text().replace("ROOT_LOWER, 1, 6\n", "")
    (tmp_path / "strips.inp").write_text(deck)
    creak("reduce", study, "--quiet", "--out", tmp_path / "out").refuses("nothing holds part(s) LOWER")


def test_unknown_export_format(creak, study, tmp_path):
    creak("reduce", study, "--export", "op5").refuses("Did you mean 'op4'")


def test_a_file_that_has_to_stay_is_told_before_a_part_is_reduced(creak, study, tmp_path):
    out = tmp_path / "out"
    out.mkdir()
    for name in ("UPPER.h5", "UPPER.asm"):
        (out / name).hardlink_to(study)
        creak("reduce", study, "--quiet", "--out", out, "--export", "op4").refuses(
            f"cannot write {out / name}: it is the same file as an input"
        )
        (out / name).unlink()
        assert not list(out.glob("*.*")), "nothing was saved"
