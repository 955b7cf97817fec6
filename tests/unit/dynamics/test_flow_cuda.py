"""The march on a GPU, by the simulator of numba's CUDA: equal to that of the cores; what is left to the cores."""

from __future__ import annotations

import os
import subprocess
import sys
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

import helpers_cuda
from creak.contact.laws.parameters import Friction
from creak.dynamics.chunks import march_chunks
from helpers_core import channels

pytest.importorskip("numba.cuda", reason="this numba has no CUDA target")
TESTS = Path(helpers_cuda.__file__).parent


@pytest.fixture(scope="module")
def simulated(tmp_path_factory):
    out = tmp_path_factory.mktemp("cuda") / "out.npz"
    path = os.pathsep.join([str(TESTS), str(TESTS.parent / "src"), os.environ.get("PYTHONPATH", "")])
    own = {"NUMBA_ENABLE_CUDASIM": "1", "NUMBA_DISABLE_JIT": "1", "PYTHONPATH": path}
    command = [sys.executable, helpers_cuda.__file__, str(out), *helpers_cuda.MODELS]
    subprocess.run(command, env=os.environ | own, check=True, timeout=300)
    with np.load(out) as found:
        return dict(found)


@pytest.mark.slow
@pytest.mark.parametrize("name", list(helpers_cuda.MODELS))
def test_the_device_gives_what_a_core_gives(simulated, name):
    """Free flight, first events, openings and touches again: rows, gaps, forces and motion to 1e-9 of the largest."""
    for v, run in enumerate(helpers_cuda.MODELS[name]()):
        history = march_chunks(run, None)
        assert history.force[0].sum() == pytest.approx(5.0 if name == "many" else 0.0)
        touched = np.diff((history.force > 0.0).astype(int), axis=0) > 0
        assert touched.sum() >= 1
        for key in helpers_cuda.KEPT:
            own, there = getattr(history, key), simulated[f"{name}/{v}/{key}"]
            np.testing.assert_allclose(there, own, rtol=0.0, atol=1e-9 * np.abs(own).max(), err_msg=f"{v} {key}")


@pytest.mark.slow
def test_blocks_and_lasting_contact_were_marched(simulated):
    """Else the comparison says nothing of them."""
    assert simulated["blocks"] > 5
    assert simulated["held"] >= 2


@pytest.mark.slow
@pytest.mark.once
def test_the_kernel_compiles_for_devices(monkeypatch):
    """To PTX, without a device."""
    pytest.importorskip("numba_cuda", reason="numba-cuda is not installed: pip install 'creak[gpu]'")
    pytest.importorskip("nvidia", reason="NVVM is not installed: pip install 'numba-cuda[cu12]'")
    from numba import cuda, typeof
    from numba.cuda import dispatcher

    from creak.dynamics.cuda import march as flow_cuda
    from creak.dynamics.cuda.kernel import march_block

    runs = helpers_cuda.many_stops()
    given = flow_cuda.launch_of(runs, flow_cuda.THREADS)
    monkeypatch.setattr(dispatcher, "get_current_device", lambda: SimpleNamespace(compute_capability=(8, 0)))
    ptx, _ = cuda.compile_ptx(march_block, tuple(typeof(x) for x in given), cc=(8, 0))
    assert ".target sm_80" in ptx
    assert "bar.sync" in ptx


@pytest.fixture(scope="module")
def base():
    return helpers_cuda.two_stops()[0]


def test_runs_that_a_device_takes(base):
    from creak.dynamics.cuda.march import alike, out_of_scope

    assert out_of_scope(base) == ""
    softer = base.again(replace(base.gaps, stiffness=np.full(2, 3.9e4)), base.loads)
    assert alike(base, softer)
    stiffer = base.again(replace(base.gaps, stiffness=np.full(2, 4e7)), base.loads)
    assert out_of_scope(stiffer) == ""
    assert not alike(base, stiffer)


def test_laws_that_a_core_has_to_march(base):
    from creak.dynamics.cuda.march import out_of_scope

    damped = channels(np.eye(2, helpers_cuda.N), 1e-3, 1e4, damping=1.0)
    assert out_of_scope(base.again(damped, base.loads)) == "dampers of contacts"
    rubs = Friction(*(np.full(2, 0.2) for _ in range(2)), np.zeros(2))
    assert out_of_scope(base.again(replace(base.gaps, friction=rubs), base.loads)) == "friction"


def test_memory_of_a_run_counts_its_table_and_its_motion(base):
    from creak.dynamics.cuda.march import bytes_of

    table = base.rows(base.n_step) * (1 + 2 * base.gaps.m) * 8
    motion = base.n_step * base.model.m.size * 8
    assert table + motion < bytes_of(base) < 2 * (table + motion)
