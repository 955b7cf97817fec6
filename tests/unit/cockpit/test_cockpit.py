"""The cockpit: what is written, and that it has something to rank."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.integrate import trapezoid
from typer.testing import CliRunner

import creak
from creak.cli.main import app
from creak.errors import InputError
from creak_thesis.cockpit import FILES, write_cockpit


@pytest.mark.parametrize("size", [20.0, 10.0])
def test_the_deck_is_read_whole_and_its_parts_meet_at_nodes(size, tmp_path):
    paths = write_cockpit(size, tmp_path / "new")
    assert [p.name for p in paths] == list(FILES)
    model = creak.read_deck(paths[0])
    assert [p.name for p in model.parts] == ["CARRIER", "LID", "TRIM", "DUCT", "BEAM", "HOLDER"]
    assert model.unread == ()
    assert size > 10.0 or 3000 < sum(len(b.ids) for b in model.blocks) < 5000
    xyz = model.nodes.coords
    for one, other in (("LATCH_CARRIER", "LATCH_LID"), ("BUMPER_LEFT_CARRIER", "BUMPER_LEFT_LID")):
        apart = xyz[model.node_sets[other]] - xyz[model.node_sets[one]]
        assert apart[0, [0, 2]] == pytest.approx(np.zeros(2))
        assert apart[0, 1] > 0.0


def test_same_text_every_time_and_another_road_by_the_seed(tmp_path):
    first, same, other = (
        [p.read_bytes() for p in write_cockpit(20.0, tmp_path / name, seed=seed)]
        for name, seed in (("a", 1), ("b", 1), ("c", 2))
    )
    assert first == same
    assert [a == b for a, b in zip(first, other, strict=True)] == [True, False, True]


@pytest.mark.parametrize(("load", "rms"), [(1.0, 2.0), (0.5, 1.0)])
def test_the_mounts_shake_as_on_a_rough_road(load, rms, tmp_path):
    """Root of the area under the density, log-log between its points, 1 to 3 m/s2 at the load of the study."""
    signal = creak.read_study(write_cockpit(20.0, tmp_path, load)[1]).config.excitation["road_y"].signal
    f, g = np.array(signal.values).T
    fine = np.geomspace(f[0], f[-1], 20_000)
    found = 9.80665 * math.sqrt(trapezoid(np.exp(np.interp(np.log(fine), np.log(f), np.log(g))), fine))
    assert 0.8 * rms < found < 1.5 * rms


@pytest.mark.parametrize(
    ("given", "says"),
    [
        ({"mesh_size": 21.0}, "mesh size 21; expected a number from 4 to 20"),
        ({"mesh_size": math.nan}, "mesh size nan"),
        ({"load": 0.0}, "load 0; expected a number from 0.01 to 10"),
        ({"load": math.inf}, "load inf"),
        ({"seed": -1}, "seed -1"),
    ],
)
def test_what_cannot_be_written_is_refused(given, says, tmp_path):
    with pytest.raises(InputError, match=says):
        write_cockpit(**{"mesh_size": 20.0, "out": tmp_path / "out", **given})
    assert not (tmp_path / "out").exists()


def test_a_file_in_place_of_the_folder_is_refused(tmp_path):
    (tmp_path / "cockpit").write_text("mine", encoding="utf-8")
    with pytest.raises(InputError, match="this is a file; expected a folder"):
        write_cockpit(20.0, tmp_path / "cockpit")


def test_command_writes_it_and_says_what_comes_next(tmp_path):
    out = tmp_path / "its own"
    said = CliRunner().invoke(app, ["example", "cockpit", "--mesh-size", "20", "--out", str(out)])
    assert said.exit_code == 0, said.output
    assert sorted(p.name for p in out.iterdir()) == sorted(FILES)
    assert f"creak run '{out / 'cockpit.toml'}'" in said.output.replace("\n", "")


@pytest.mark.slow
@pytest.mark.once
def test_one_place_only_squeaks_one_is_a_false_alarm_and_one_is_missed(tmp_path):
    """The promise of the example, on a coarse mesh that a little more load and another road make up for."""
    study = creak.read_study(write_cockpit(20.0, tmp_path, load=1.2, seed=5)[1])
    quick = {"time.accuracy": "quick", "reduction.f_max": 1200}
    summary = creak.run(creak.change_study(study, quick), converge=False, record=False).summary
    run = summary["runs"]["reduced"]
    assert summary["warnings"] == []
    places = {p["contact"]: p for p in run["places"]}
    assert sorted(places) == ["bumper_left", "bumper_right", "card_holder", "duct", "latch", "trim"]
    assert len(run["places"]) == 6
    assert [name for name, p in places.items() if not p["events"]] == ["trim"]
    assert places["trim"]["slips"] > 20
    (squeak,) = run["squeak"]
    assert squeak["slips"] == places["trim"]["slips"]
    assert squeak["against_measured"] == "within"
    lines = {line["name"]: line for line in summary["elines"]["lines"]}
    assert {name: line["outcome"] for name, line in lines.items()} == {
        **dict.fromkeys(("bumper_left", "bumper_right", "duct", "trim"), "both"),
        "lid_rim": "false alarm",
        "card_holder": "miss",
    }
    for side, sign in (("linear", 1.0), ("contact", -1.0)):
        assert sign * lines["card_holder"][side]["margin"] > 0.0
        assert sign * lines["lid_rim"][side]["margin"] < -0.2
    added = [p["n5_added"] for p in run["places"]]
    assert added == sorted(added, reverse=True)
    assert added[0] > 2.0 * added[-1]
