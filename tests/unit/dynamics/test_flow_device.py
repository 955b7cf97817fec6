"""Which runs go to a GPU, which to the cores, what is told of it; the device itself is played by a core here."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from creak.cli.main import main
from creak.contact.laws.parameters import Friction
from creak.dynamics.chunks import march_chunks
from creak.dynamics.cuda import device as flow_device
from creak.dynamics.cuda.device import march_anywhere
from creak.dynamics.flow.batch import Variant
from helpers_cuda import two_stops
from helpers_refusal import refusal

pytest.importorskip("numba.cuda", reason="this numba has no CUDA target")


@pytest.fixture(scope="module")
def base():
    return two_stops()[0]


@pytest.fixture
def device(monkeypatch):
    """A device with room for two runs at once; the launches that it got."""
    from creak.dynamics.cuda import march as flow_cuda

    launches = []

    def together(runs):
        launches.append(len(runs))
        return [march_chunks(run, None) for run in runs]

    monkeypatch.setattr(flow_device, "no_gpu", lambda: "")
    monkeypatch.setattr(flow_cuda, "at_once", lambda run: 2)
    monkeypatch.setattr(flow_cuda, "name", lambda: "a device")
    monkeypatch.setattr(flow_cuda, "march_together", together)
    return launches


def peaks(base, variants, **how):
    return dict(march_anywhere(base, variants, lambda variant, history: float(history.force.max()), 1, **how))


def some(base, count):
    """Other gaps in each."""
    return [Variant(k, replace(base.gaps, gap0=base.gaps.gap0 * (1.0 + k / 8.0)), base.loads) for k in range(count)]


def test_memory_of_the_device_bounds_a_launch(base, device):
    notes = []
    found = peaks(base, some(base, 5), notes=notes)
    assert device == [2, 2, 1]
    assert found == peaks(base, some(base, 5), device="cpu")
    assert notes == ["marched on the GPU (a device): 5"]


def test_runs_out_of_scope_go_to_the_cores_and_are_told(base, device):
    rubs = replace(base.gaps, friction=Friction(np.full(2, 0.2), np.full(2, 0.2), np.zeros(2)))
    variants, notes = [*some(base, 2), Variant(2, rubs, base.loads)], []
    found = peaks(base, variants, notes=notes)
    assert device == [2]
    assert found == peaks(base, variants, device="cpu")
    assert notes == ["marched on the GPU (a device): 2", "marched on the cores, friction is not for the GPU: 1"]


def test_contact_in_other_steps_is_a_launch_of_its_own(base, device):
    stiff = Variant(1, replace(base.gaps, stiffness=np.full(2, 4e8)), base.loads)
    found = peaks(base, [*some(base, 1), stiff])
    assert device == [1, 1]
    assert found == peaks(base, [*some(base, 1), stiff], device="cpu")


def test_a_device_that_fails_leaves_its_runs_to_the_cores(base, device, monkeypatch):
    from creak.dynamics.cuda import march as flow_cuda

    def fails(runs):
        raise flow_cuda.FAILURES[0]("out of memory\nmore of it")

    monkeypatch.setattr(flow_cuda, "march_together", fails)
    notes = []
    assert peaks(base, some(base, 2), notes=notes) == peaks(base, some(base, 2), device="cpu")
    assert notes == ["marched on the cores, the device failed (out of memory): 2"]


def test_without_a_device_the_cores_march_and_nothing_is_told(base, device, monkeypatch):
    monkeypatch.setattr(flow_device, "no_gpu", lambda: "numba-cuda is not installed")
    notes = []
    assert peaks(base, some(base, 2), notes=notes) == peaks(base, some(base, 2), device="cpu")
    assert device == notes == []


def test_a_device_that_is_asked_for_and_not_there_is_refused(base, monkeypatch):
    monkeypatch.setattr(flow_device, "no_gpu", lambda: "no device or driver of CUDA was found")
    told = str(refusal(peaks, base, some(base, 1), device="gpu"))
    assert "device gpu: no device or driver of CUDA was found" in told
    assert "creak[gpu]" in told


def test_a_device_and_a_cluster_exclude_each_other(tmp_path, capsys, monkeypatch):
    words = ["creak", "robust", str(tmp_path / "s.toml"), "--device", "gpu", "--scheduler", "tcp://a:1"]
    monkeypatch.setattr("sys.argv", words)
    with pytest.raises(SystemExit) as end:
        main()
    assert end.value.code == 2
    assert "--device gpu and --scheduler exclude each other" in capsys.readouterr().err


def test_what_is_told_of_this_machine(monkeypatch):
    """Without numba-cuda, and where it simulates a device."""
    monkeypatch.setattr(flow_device, "find_spec", lambda name: None)
    assert flow_device.no_gpu.__wrapped__() == "numba-cuda is not installed"
    from numba import config

    monkeypatch.setattr(flow_device, "find_spec", lambda name: name)
    monkeypatch.setattr(config, "ENABLE_CUDASIM", 1, raising=False)
    assert flow_device.no_gpu.__wrapped__() == "numba simulates CUDA"
