"""`creak run --device`: the unreduced run on a GPU, a stand-in here, is that of the cores, and is told."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import creak
from creak.errors import InputError
from creak.linalg import cudss
from creak.studies.file.reader import read_study
from creak.studies.prepare.setup import set_up
from creak.studies.results.summary import summarise
from creak.studies.run.job import run_study
from helpers_cli import caller
from helpers_cudss import stand_in
from helpers_decks import STUDY, write_strips

WHOLE = (
    STUDY.replace("f_max = 3000", 'method = "none"')
    .replace("step = 5e-4\nperiods = 2", "end = 0.03")
    .replace("amplitude = 0.05", "amplitude = 0.8")
)


@pytest.fixture
def gpu(monkeypatch):
    yield from stand_in(monkeypatch)


def test_the_unreduced_run_is_that_of_the_cores(tmp_path, gpu):
    setup = set_up(read_study(write_strips(tmp_path, study=WHOLE)))
    there, here = (run_study(replace(setup, device=device), lambda *_: None) for device in ("gpu", "cpu"))
    assert "reference run: factors on the GPU: 8 (a stand-in)" in summarise(there)["notes"]
    assert not [text for text in here.notes if "GPU" in text]
    for name in ("displacement", "gap", "force"):
        a, b = (getattr(found.runs["reference"].history, name) for found in (there, here))
        assert np.abs(b).max() > 0.0
        np.testing.assert_allclose(a, b, atol=1e-8 * np.abs(b).max(), rtol=0.0, err_msg=name)


def test_a_gpu_that_has_nothing_to_do_is_told_so(tmp_path, gpu):
    path = write_strips(tmp_path, study=STUDY.replace("periods = 2", "end = 0.005\n[reference]\nrun = false\n"))
    found = creak.run(path, record=False, converge=False, device="gpu")
    assert "device gpu: no run needed a factor of a sparse matrix" in found.summary["notes"]
    assert gpu.kinds == []


@pytest.mark.parametrize("device", ["auto", "cpu", "gpu"])
def test_the_command_says_where(device, tmp_path, gpu, monkeypatch, capsys):
    asked = []

    def run_setup(setup, progress, **more):
        asked.append(more["device"])
        raise InputError("enough")

    monkeypatch.setattr("creak.api.study.run_setup", run_setup)
    said = caller(monkeypatch, capsys)("run", write_strips(tmp_path), "--device", device)
    assert (said.status, asked) == (2, [device])


def test_a_gpu_that_is_not_there_is_refused_before_anything_is_read(tmp_path, monkeypatch, capsys):
    monkeypatch.setattr(cudss, "find_spec", lambda name: None)
    cudss.no_cudss.cache_clear()
    said = caller(monkeypatch, capsys)("run", tmp_path / "none.toml", "--device", "gpu")
    cudss.no_cudss.cache_clear()
    assert said.status == 2
    assert "device gpu: nvmath-python is not installed" in said.err
    assert "Traceback" not in said.err
    assert list(tmp_path.iterdir()) == []
