"""Every example against closed forms or its reference, its picture included; as users run them."""

from __future__ import annotations

import copy
import importlib.util
from pathlib import Path
from types import ModuleType, SimpleNamespace

import numpy as np
import pytest

import creak

RECORDED = {"section": "examples", "source": "closed form"}

pytestmark = pytest.mark.slow

FOLDER = Path(__file__).parents[2] / "examples"
NAMES = sorted(p.stem for p in FOLDER.glob("*.py"))


def example(name: str) -> ModuleType:
    spec = importlib.util.spec_from_file_location(f"example_{name}", FOLDER / f"{name}.py")
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def figures(name: str, folder: Path, **options: float) -> dict[str, float]:
    """What `main` returns; the picture must be there and hold more than empty axes."""
    pyplot = pytest.importorskip("matplotlib.pyplot")
    picture = folder / f"{name}.png"
    found = example(name).main(str(picture), **options)
    pyplot.close("all")
    assert picture.stat().st_size > 20_000
    return found


@pytest.fixture(autouse=True)
def no_window(monkeypatch):
    monkeypatch.setenv("MPLBACKEND", "Agg")


def test_there_is_a_test_for_every_example():
    own = {name.removeprefix("test_example_") for name in globals() if name.startswith("test_example_")}
    assert own == set(NAMES)


@pytest.mark.parametrize("name", NAMES)
def test_examples_use_the_public_interface_alone(name):
    text = (FOLDER / f"{name}.py").read_text(encoding="utf-8")
    assert "from creak" not in text
    assert "import creak." not in text
    assert text.startswith('"""# ')  # a heading in Markdown: the page of the gallery


def test_example_plate_modes(tmp_path, measured):
    found = figures("plate_modes", tmp_path)
    # Linear shells: (k h)^2 / 24 with k of some 5 / a at the sixth mode, h = a / 24: .2 %; half as much again allowed.
    measured("plate modes: worst frequency error", found["frequency_error"], at_most=0.003)
    assert abs(found["mass_error"]) < 1e-12
    assert found["rigid"] == 0


def test_example_craig_bampton_beam(tmp_path, measured):
    found = figures("craig_bampton_beam", tmp_path)
    # half a digit of the last of three printed ones
    measured(
        "Craig-Bampton beam: deviation from the table of errors",
        found["table_deviation"],
        at_most=1e-3,
        source="extended precision",
    )
    # Upper bounds; dense modes of a matrix with a condition of 1e9 are good to eps x 1e9 = 2e-7, or 2e-5 %.
    assert found["lowest_error_percent"] > -2e-5
    assert abs(found["first_frequency_error"]) < 2e-7  # the same round-off; cubic elements themselves 2e-10


def test_example_bar_on_wall(tmp_path, measured):
    found = figures("bar_on_wall", tmp_path)
    assert found["events"] == 2
    # Smeared fronts: first contacts to a step, the second after a flight with a foot that rings, 5 % of a contact.
    assert found["height_error"] < 0.03 * 5.0
    assert found["energy_created"] < 1e-9
    measured("bar on a wall: onset, error", found["time_error_s"], at_most=0.05 * 2.0 / 3.0, unit="s")
    measured("bar on a wall: impulse, relative error", found["impulse_error"], at_most=0.01)


def test_example_stick_slip_belt(tmp_path, measured):
    found = figures("stick_slip_belt", tmp_path)
    # Stick and slip begin and end in a step near contact each, 1/128 of 100 us: 1.6 us of .08 s.
    assert found["stick_s"] == pytest.approx(0.04, abs=1.6e-6)
    assert found["first_slip_s"] == pytest.approx(0.05, abs=1.6e-6)
    # The end of a slip falls between two steps: a share (h / slip)^2 of its energy.
    assert found["energy_created"] < 1e-6
    measured("block on a belt: rate", found["rate_hz"], 12.3932817, rel=2e-5, unit="Hz")
    measured("block on a belt: slip", found["slip_s"], 0.04068888, abs=1.6e-6, unit="s")


def test_example_two_strips(tmp_path, measured):
    found = figures("two_strips", tmp_path)
    assert found["unknowns"] < found["unknowns_reference"] / 8
    assert found["events"] > 20
    assert found["matched"] >= 10
    assert found["missed"] == found["extra"] == 0
    # f_max is 60 times the excitation; what is left are impacts that amplify it: a per cent.
    measured("two strips: impulse over unreduced", found["impulse_ratio"], 1.0, abs=0.01, source="unreduced model")
    assert found["energy_created"] < 1e-6


def test_example_door(tmp_path, measured, monkeypatch):
    run = creak.run

    def quick(study):
        """Both models are what is looked at, by steps of the same kind, the unreduced one for .6 s."""
        return run(creak.change_study(study, {"time.accuracy": "quick", "reference.until": 0.6}), converge=False)

    monkeypatch.setattr(creak, "run", quick)
    found = figures("door", tmp_path, mesh_size=40.0, periods=1)
    assert found["dof_reduced"] < found["dof"] / 10
    assert found["events"] > 0
    assert found["missed"] == found["extra"] == 0
    # f_max is 15 times the excitation: force to .1 % and fit .9999 on a rough door of the like, less on a coarse mesh.
    measured("door of 40 mm: impulse over unreduced", found["impulse_ratio"], 1.0, abs=0.03, source="unreduced model")
    measured("door of 40 mm: lowest MAC", found["lowest_mac"], 1.0, between=(0.999, 1.0), source="unreduced model")
    measured("door of 40 mm: NRMSE fit", found["nrmse"], 1.0, between=(0.99, 1.0), source="unreduced model")


def test_a_window_without_events_is_drawn(tmp_path):
    run = SimpleNamespace(history=SimpleNamespace(time=np.arange(3.0), force=np.zeros((3, 1))), events=[])
    spectra = SimpleNamespace(freq=np.ones(2), spectra=dict.fromkeys(("reference", "reduced"), np.ones((2, 1, 3))))
    found = SimpleNamespace(window=(0.0, 2.0), spectra=spectra)
    picture = tmp_path / "door.png"
    example("door").draw(SimpleNamespace(found=found, runs={"reference": run, "reduced": run}), str(picture))
    assert picture.exists()


def test_friction_on_soft_contact_marches_to_the_end(tmp_path):
    """Its long steps leave fewer modes than channels that rub: without give no forces are found at .001 s."""
    strips = example("two_strips")
    (tmp_path / "strips.inp").write_text(strips.deck())
    study = copy.deepcopy(strips.STUDY)
    study["contact"]["tips"] |= {"clearance": 0.0, "stiffness": 2.0, "friction": 0.2}
    study["excitation"]["base"]["signal"]["amplitude"] = 0.2
    study |= {"time": {"end": 0.02}, "verification": {}}
    run = creak.run(creak.make_study(study, tmp_path), converge=False).runs["reduced"]
    assert not run.stopped
    assert run.history.time[-1] == pytest.approx(0.02)
    assert run.history.energy_created < 1e-3
