"""Motion in the report is the motion of the run."""

import base64
from dataclasses import replace
from functools import partial

import numpy as np
import pytest
from small_study import plates, study_text

from creak.formats.measured.motion_series import motion_field, write_series
from creak.model.units import UNITS
from creak.report.drawn import LEFT_OUT, shapes_of
from creak.report.figures.scene import animations, scene
from creak.studies.file.reader import read_study
from creak.studies.prepare.setup import set_up
from creak.studies.run import motion
from creak.studies.run.job import run_study
from creak.studies.run.motion import recorded_steps
from helpers_decks import write_study
from helpers_findings import save_plain, to_draw

UNIT = UNITS["mm-t-s"]


def run_recorded(folder, text):
    return run_study(
        set_up(read_study(write_study(folder, text, {"plates.inp": plates()}))), lambda *_: None, record=True
    )


@pytest.fixture(scope="module")
def result(tmp_path_factory):
    return run_recorded(tmp_path_factory.mktemp("recorded"), study_text(reference=False))


def decoded(text, kind):
    return np.frombuffer(base64.b64decode(text), dtype=np.dtype(kind).newbyteorder("<"))


def moved(result, budget=10**7):
    found, drawn = to_draw(result, size=budget)
    return drawn.surface, scene(found, drawn), animations(found, drawn, UNIT)


def test_recovered_motion_is_that_of_the_watched_nodes(result):
    surface, shape, found = moved(result)
    first = found.shown[0]
    amplitudes = np.array(first["amplitudes"])
    u = amplitudes @ decoded(first["shapes"], np.int16).reshape(amplitudes.shape[1], -1).astype(float)
    u = u.reshape(len(first["time"]), shape["count"], 3)
    h, watched = result.runs["reduced"].history, result.setup.watch.nodes
    kept = h.displacement.reshape(h.output_index.size, -1, 6)[:, :, :3]
    at = np.searchsorted(h.time[h.output_index], np.array(first["time"]) - 1e-9)
    # What the shapes leave out, and the rounding of each to 16 bits.
    bound = (LEFT_OUT + 0.5 * amplitudes.shape[1] / 32767) * first["largest"]
    assert np.abs(u[:, surface.rows(watched)] - kept[at]).max() <= bound
    assert np.abs(u).max() == pytest.approx(first["largest"], rel=2 * LEFT_OUT)


def test_shapes_are_as_few_as_the_motion_has():
    rng = np.random.default_rng(1)
    u = rng.normal(size=(20, 3)) @ rng.normal(size=(3, 500))
    amplitudes, shapes = shapes_of(u, 1e-3 * np.abs(u).max())
    assert shapes.shape == (3, 500)
    # Three roundings of half a unit, with amplitudes of at most the largest shape.
    assert np.abs(amplitudes @ shapes - u).max() <= 1.5 * np.abs(amplitudes).max()
    assert shapes_of(np.zeros((4, 6)), 0.0)[0].shape == (4, 1)


def test_points_and_forces_survive_their_quantisation(result):
    surface, shape, found = moved(result)
    xyz = decoded(shape["points"], np.int16).reshape(-1, 3) * shape["scale"] + np.array(shape["centre"])
    assert np.abs(xyz - result.setup.model.nodes.coords[surface.nodes_idx]).max() <= 0.501 * shape["scale"]
    first = found.shown[0]
    force = decoded(first["force"], np.uint8).reshape(len(first["time"]), -1)
    assert force.max() == 255
    h = result.runs["reduced"].history
    inside = (h.time >= first["time"][0]) & (h.time <= first["time"][-1])
    assert first["peak"] == pytest.approx(h.force[inside].max())


def test_the_budget_decides_how_many_there_are(result):
    _, _, everything = moved(result)
    assert everything.size == sum(len(a["shapes"]) + len(a["force"]) for a in everything.shown)
    _, _, few = moved(result, everything.size - 1)
    assert len(few.shown) == len(everything.shown) - 1
    _, _, none = moved(result, 1)
    assert none.shown == []
    assert "takes more than" in none.words
    assert "--animation-mb 0" in moved(result, 0)[2].words


def test_runs_without_recorded_motion_say_so(result):
    run = replace(result.runs["reduced"], recording=None)
    _, _, found = moved(replace(result, runs={"reduced": run}))
    assert found.shown == []
    assert "did not keep the motion" in found.words


def test_only_the_fields_asked_for_stay_in_the_history(result, tmp_path):
    assert result.runs["reduced"].history.whole_at.size == 0
    text = study_text(reference=False) + "[output]\nfield_interval = 5e-3\n"
    other = run_recorded(tmp_path, text).runs["reduced"]
    assert other.history.whole_at.tolist() == list(range(0, 81, 10))
    assert other.history.coordinates.shape[1] == 9
    assert other.recording.motions


def test_a_run_too_large_to_keep_says_what_to_do(tmp_path, monkeypatch):
    monkeypatch.setattr(motion, "MEMORY", 100)
    run = run_recorded(tmp_path, study_text(reference=False)).runs["reduced"]
    assert run.recording.motions == ()
    assert "field_interval" in run.recording.why


def test_steps_are_thinned_as_far_as_the_motion_allows(result, monkeypatch):
    setup, n = result.setup, 100
    steps = partial(recorded_steps, setup.marching, 0.02, n)
    every = steps()
    monkeypatch.setattr(motion, "MEMORY", 8 * n * every.size // 2 + 1)
    assert steps().size == -(-every.size // 2)
    # 50 Hz: five instants a period are 4 ms apart, eight steps; ten are too many.
    monkeypatch.setattr(motion, "MEMORY", 8 * n * every.size // 10)
    assert steps().size == 0


def test_results_hold_the_motion_of_all_nodes_around_the_hardest_event_unasked(result, tmp_path, monkeypatch):
    """What ParaView shows is what the watched nodes do, to round-off; large models keep less."""
    run, watched = result.runs["reduced"], result.setup.watch.nodes
    save_plain(result, tmp_path)
    field = motion_field(tmp_path / "results.h5")
    hardest = max(run.events, key=lambda e: e.force_peak_filtered)
    assert field.time[0] < hardest.t_start < hardest.t_end < field.time[-1]
    outputs = run.history.time[run.history.output_index]
    at = np.abs(outputs[:, None] - field.time).argmin(axis=0)
    assert outputs[at] == pytest.approx(field.time, rel=1e-12)
    expected = run.history.displacement.reshape(outputs.size, watched.size, 6)[at, :, :3]
    found = np.stack([u for _, u in field.instants()])
    assert np.abs(found[:, watched] - expected).max() <= 1e-9 * np.abs(expected).max()
    assert len(list(write_series(field, tmp_path / "motion.pvd").iterdir())) == field.time.size
    monkeypatch.setattr("creak.studies.findings.histories.UNASKED", 24 * result.setup.model.nodes.count * 5)
    save_plain(result, tmp_path)
    assert motion_field(tmp_path / "results.h5").time.size <= 5
