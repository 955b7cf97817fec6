"""Parts reduced by workers: the same files, one that fails loses no other, and the same command goes on."""

from __future__ import annotations

import json
import pickle

import numpy as np
import pytest

from creak.arrays import to_dense
from creak.errors import NumericalError
from creak.formats.stored.superelement import read_superelement_file
from creak.studies.converge import auto_band
from creak.studies.models import part_jobs as part_jobs_module
from creak.studies.models import superelements
from creak.studies.models.part_jobs import Saved, part_jobs
from creak.studies.models.saved import Store
from creak.studies.prepare.setup import set_up
from creak.studies.run.precheck import ready
from creak.studies.tasks import queue
from helpers_cli import workers_here
from helpers_decks import STUDY, two_strips, write_strips

STUDY_OF_TIPS = (
    STUDY.replace('secondary = "UNDER"', 'secondary = "TIPS"')
    .replace("periods = 2", "end = 0.05")
    .replace("amplitude = 0.05", "amplitude = 0.2")
)
"""Contact at the last quads only, so that much of each strip is inside; they meet at once."""


@pytest.fixture
def study(tmp_path, no_page):
    deck = two_strips().replace("*SURFACE, NAME=UNDER", "*SURFACE, NAME=TIPS\n12, SNEG\n24, SNEG\n*SURFACE, NAME=UNDER")
    return write_strips(tmp_path, deck, STUDY_OF_TIPS)


@pytest.fixture
def here(monkeypatch):
    """Workers of this process; how many were asked for."""
    asked: list[int] = []

    def local_workers(count: int):
        asked.append(count)
        return workers_here(count)

    monkeypatch.setattr(queue, "local_workers", local_workers)
    return asked


def matrices(folder) -> dict[str, np.ndarray]:
    found = {}
    for path in sorted(folder.glob("*.h5")):
        saved = read_superelement_file(path)
        found |= {f"{path.stem} {key}": to_dense(saved.matrices[key]) for key in ("K", "M")}
        found[f"{path.stem} health"] = np.array(saved.about["health"]["good"])
    return found


def test_workers_save_what_one_process_would(creak, study, tmp_path, here):
    assert creak("reduce", study, "--out", tmp_path / "one").status == 0
    said = creak("reduce", study, "--out", tmp_path / "many", "--workers", "5", "--json").done()
    assert here == [2]  # no more than parts
    one, many = matrices(tmp_path / "one"), matrices(tmp_path / "many")
    assert list(one) == list(many)
    assert len(one) == 6
    for name, value in one.items():
        np.testing.assert_array_equal(many[name], value)
    told = json.loads(said.out)
    assert {name: part["reused"] for name, part in told["superelements"].items()} == {"UPPER": False, "LOWER": False}
    assert sorted(path.rsplit("/")[-1] for path in told["written"]) == ["LOWER.h5", "UPPER.h5"]
    assert not any("taken from" in note for note in told["notes"])


def test_nothing_is_left_to_do(creak, study, tmp_path, here):
    assert creak("reduce", study, "--workers", "2", "--quiet").status == 0
    said = creak("reduce", study, "--workers", "2").done()
    assert here == [2]
    assert said.words.count("taken from") == 2


def test_a_part_that_fails_does_not_lose_the_others(creak, study, tmp_path, monkeypatch, here):
    real = superelements.fixed_interface_basis

    def basis(inside, *rest, **options):
        if inside.name == "UPPER":
            raise NumericalError("its retained dofs do not hold it")
        return real(inside, *rest, **options)

    with monkeypatch.context() as patch:
        patch.setattr(superelements, "fixed_interface_basis", basis)
        said = creak("reduce", study, "--workers", "2")
    assert said.status == 1
    assert "1 of 2 parts could not be reduced UPPER:" in said.words
    assert "do not hold it" in said.words
    assert "saved: LOWER. The same command goes on from there" in said.words
    assert [p.name for p in (tmp_path / "superelements").glob("*.h5")] == ["LOWER.h5"]
    assert creak("reduce", study, "--workers", "2", "--quiet").status == 0
    assert here == [2, 1]


def figures(folder):
    """What the run found, without times and what it was made by."""
    told = json.loads((folder / "summary.json").read_text())
    return [[e[key] for key in ("t_start", "t_end", "impulse")] for e in told["runs"]["reduced"]["events"]], told


def test_a_run_has_its_parts_reduced_by_workers(creak, study, tmp_path, here, monkeypatch):
    """Each f_max that "auto" tries is a job for each part; what comes out is what one process finds."""
    monkeypatch.setattr(auto_band, "SMALL", 0.0)
    monkeypatch.setattr(auto_band, "WORTH", 0.0)
    text = study.read_text().replace("f_max = 3000", 'f_max = "auto"').replace("step = 5e-4\n", "")
    study.write_text(text + '[reference]\nrun = "none"\n')
    alone = creak("run", study, "--out", tmp_path / "one", "--no-keep", "--no-converge", "--quiet")
    raised: list[tuple[str, int]] = []
    real = part_jobs_module.run_part

    def counted(job):
        raised.append((job.name, job.raised))
        return real(job)

    monkeypatch.setattr(part_jobs_module, "run_part", counted)
    many = creak("run", study, "--out", tmp_path / "many", "--workers", "3", "--no-converge", "--quiet")
    assert (alone.status, many.status) == (0, 0)
    assert here == [3]
    (one, _), (other, told) = figures(tmp_path / "one"), figures(tmp_path / "many")
    assert one
    np.testing.assert_allclose(other, one, rtol=1e-6)
    stages = told["runs"]["reduced"]["stages"]
    assert len(stages) > 1
    assert sorted(raised) == sorted((part, k) for part in ("LOWER", "UPPER") for k in range(len(stages) - 1))
    assert all("reduced here" not in note for note in told["notes"])


def test_what_a_worker_cannot_reduce_the_run_reduces(creak, study, tmp_path, here, monkeypatch):
    monkeypatch.setattr(part_jobs_module, "run_part", lambda job: Saved(None, None, "it died"))
    creak("run", study, "--out", tmp_path / "out", "--workers", "2", "--no-converge").done()
    notes = [n for n in figures(tmp_path / "out")[1]["notes"] if n.startswith("superelement UPPER: reduced here")]
    assert [n.endswith("for the worker could not: it died") for n in notes] == [True]


def test_a_method_without_superelements_has_nothing_for_workers(creak, study):
    said = creak("run", study, "--workers", "2", "--set", "reduction.method=gap-modes", "--quiet")
    said.refuses("method = 'gap-modes' makes no superelements")


def test_workers_need_a_place_to_hand_over(creak, study):
    said = creak("run", study, "--workers", "2", "--no-keep", "--quiet")
    said.refuses("workers with --no-keep; expected a study whose superelements are kept")


def test_a_worker_that_finds_another_deck_says_so(study, tmp_path):
    """Or another version of creak: all that the superelement depends on is compared before it is made."""
    from creak.studies.file.reader import read_study

    setup, reference, gaps, _ = ready(set_up(read_study(study)), lambda *_: None)
    jobs = part_jobs(setup.reduction, reference, gaps, Store(tmp_path / "out", study=setup.study))
    assert sorted(job.name for job in jobs) == ["LOWER", "UPPER"]
    deck = tmp_path / "strips.inp"
    deck.write_text(deck.read_text().replace("210000", "200000"), encoding="utf-8")
    saved = pickle.loads(pickle.dumps(jobs[0])).run()
    assert saved.health is None
    assert f"finds another part {jobs[0].name}" in saved.error
    assert "its stiffness; expected the same creak, study and deck" in saved.error
    assert not (tmp_path / "out").exists()
    assert jobs[0].lost("its worker died", 0.0).error == "its worker died"


@pytest.mark.parametrize(
    ("words", "told"),
    [
        (["--workers", "2", "--scheduler", "tcp://127.0.0.1:1"], "exclude each other"),
        (["--tls-cert", "a.crt"], "--tls-cert without --scheduler"),
        (["--workers", "0"], "--workers"),
    ],
)
def test_options_that_do_not_fit(creak, study, words, told):
    said = creak("reduce", study, *words)
    said.refuses(told)


@pytest.mark.slow
def test_two_processes(creak, study, tmp_path):
    assert creak("reduce", study, "--workers", "2", "--quiet").status == 0
    assert sorted(p.name for p in (tmp_path / "superelements").glob("*.h5")) == ["LOWER.h5", "UPPER.h5"]
