"""[test.NAME]: measurements over a run, made of its own motion or of the dense matrices of its model."""

from __future__ import annotations

import numpy as np
import pytest
import scipy.linalg
from scipy.io import wavfile

import creak
from creak.errors import InputError
from creak.formats.measured.histories import read_histories
from creak.model.dofs import TRANSLATIONS, node_dofs
from creak.sound.zwicker_tables import RATE
from creak.studies.file.reader import read_study
from creak.studies.prepare.setup import set_up
from helpers_decks import STUDY as UNDAMPED
from helpers_decks import write_strips
from helpers_frfs import function
from helpers_modal import data_set

pytestmark = pytest.mark.once

STUDY = UNDAMPED + "\n[damping]\nmodal = 0.02\n[reference]\nrun = false\n"
LATE = 0.31
"""s by which the clock of the test is ahead."""
HIGH = 1.03
"""Frequencies of the model over those of the test."""


@pytest.fixture(scope="module")
def plain(tmp_path_factory):
    """A run without tests, and its folder."""
    folder = tmp_path_factory.mktemp("plain")
    result = creak.run(read_study(write_strips(folder, study=STUDY)), converge=False)
    result.save(folder / "out")
    return result, folder


@pytest.fixture(scope="module")
def run(plain):
    return read_histories(plain[1] / "out" / "results.h5")


def with_tests(folder, tables):
    return read_study(write_strips(folder, study=STUDY + tables))


def mode_table(path, result, factor=1.0):
    """The first four elastic modes at every fifth node along z, in CSV."""
    reference, model = result.found.reference, result.found.setup.model
    nodes = np.arange(0, model.nodes.count, 5)
    rows = reference.system.rows(node_dofs(nodes, TRANSLATIONS))[0] @ reference.modes.shapes
    along = np.asarray(rows).reshape(nodes.size, 3, -1)[:, 2]
    lines = ["frequency_hz,damping,sensor,x,y,z,direction,value"]
    for k, hz in enumerate(reference.modes.frequencies[:4]):
        for row, node in enumerate(nodes):
            x, y, z = model.nodes.coords[node]
            lines.append(f"{hz / factor:.12g},.013,{model.nodes.label(node)},{x},{y},{z},z,{along[row, k]:.12g}")
    path.write_text("\n".join(lines), encoding="utf-8")


def record_table(path, run, node="probe z"):
    n = slice(70, 700)
    columns = {
        f"{node} [mm]": run.displacement[n, 0, 2],
        "tip force [N]": run.normal_force[n].sum(axis=1),
        "room temperature [C]": np.full(630, 20.0),
    }
    rows = zip(run.time[n] + LATE, *columns.values(), strict=True)
    text = [",".join(["time [s]", *columns]), *(",".join(f"{x:.9g}" for x in row) for row in rows)]
    path.write_text("\n".join(text), encoding="utf-8")


@pytest.fixture(scope="module")
def found(plain, run, tmp_path_factory):
    """A run with its own modes, histories and functions as tests."""
    result, folder = plain[0], tmp_path_factory.mktemp("tests")
    mode_table(folder / "modes.csv", result, HIGH)
    record_table(folder / "drive.csv", run)
    (folder / "frfs.unv").write_bytes(dense_functions(result))
    tables = f"""
[test.modal]
file = "modes.csv"
[test.drive]
file = "drive.csv"
channels = {{ "probe z" = "{run.node_names[0]} Z" }}
[test.hammer]
file = "frfs.unv"
[test.logger]
file = "logger.wav"
full_scale = 2.0
unit = "mm"
channels = {{ "1" = "{run.node_names[0]} Z" }}
[test.microphone]
file = "mic.csv"
"""
    rate, half = 8000, 0.5 * run.displacement[:, 0, 2]
    at = np.arange(run.time[0], run.time[-1], 1.0 / rate)
    wavfile.write(folder / "logger.wav", rate, np.interp(at, run.time, half).astype(np.float32))
    sound = plain[0].sound
    t = np.arange(sound.pressure.shape[2]) / RATE
    rows = zip(t[:20_000:2] + LATE, 2.0 * sound.pressure[0, -1, :20_000:2], strict=True)
    lines = ["time [s],ear pressure [Pa]", *(f"{a:.9g},{b:.6g}" for a, b in rows)]
    (folder / "mic.csv").write_text("\n".join(lines), encoding="utf-8")
    study = with_tests(folder, tables)
    again = creak.run(study, converge=False)
    again.save(folder / "out")
    return again, folder


def dense_functions(result):
    """Receptance of two nodes along z by the dense matrices of the unreduced model, m/N."""
    reference, model, zeta = result.found.reference, result.found.setup.model, result.found.setup.structure.modal
    system = reference.system
    every = np.asarray(abs(system.rows(node_dofs(np.arange(model.nodes.count), np.array([3])))[0]).sum(axis=1))
    nodes = np.flatnonzero(every.ravel() > 0.0)[[6, 9]].tolist()
    R = system.rows(node_dofs(np.array(nodes), np.array([3])))[0].toarray()
    K, M = system.K.toarray(), system.M.toarray()
    values, phi = scipy.linalg.eigh(K, M)
    freq = np.arange(5.0, 120.0, 1.0)
    omega = 2.0 * np.pi * freq[:, None]
    gain = 1.0 / (values - omega**2 + 2j * zeta * omega * np.sqrt(np.maximum(values, 0.0)))
    H = 1e-3 * np.einsum("ir,fr,jr->fij", R @ phi, gain, R @ phi)
    first, other = (int(model.nodes.ids[n]) for n in nodes)
    grid = [
        f"{i:10d}{0:10d}{0:10d}{8:10d}" + "".join(f"{v:13.5E}" for v in model.nodes.coords[n])
        for i, n in ((first, nodes[0]), (other, nodes[1]))
    ]
    both = [
        function(H[:, k, 0], (i, 3), (first, 3), freq=freq, quantity=8, labels=("m", "N"))
        for k, i in enumerate((first, other))
    ]
    return data_set(15, *grid).encode() + b"".join(both)


def test_modes_are_those_of_the_structure_three_per_cent_off(found):
    fit = found[0].findings.tests[0].modes
    assert [p.test for p in fit.pairs] == [0, 1, 2, 3]
    assert [p.mac for p in fit.pairs] == pytest.approx([1.0] * 4, abs=1e-9)
    assert [p.difference for p in fit.pairs] == pytest.approx([HIGH - 1.0] * 4, abs=1e-9)
    assert [p.damping_model for p in fit.pairs] == pytest.approx([found[0].found.setup.structure.modal] * 4)


def test_records_lie_over_the_run_at_their_shift(found, run):
    records = found[0].findings.tests[1].records
    assert records.shift == pytest.approx(-LATE, abs=1e-5)
    assert [p.name for p in records.pairs] == [f"{run.node_names[0]} Z", "tip force"]
    assert min(p.fit.fit for p in records.pairs) > 0.99
    assert any("room temperature" in note for note in found[0].findings.notes)


def test_a_wav_file_has_the_unit_that_the_study_gives(found, run):
    (pair,) = found[0].findings.tests[3].records.pairs
    assert pair.name == f"{run.node_names[0]} Z"
    assert pair.fit.fit > 0.98  # of means over the steps of the run
    assert pair.fit.rms[0] == pytest.approx(pair.fit.rms[1], rel=0.02)


def test_a_pressure_lies_over_that_of_the_listener(found):
    """Twice as loud as what was computed."""
    records = found[0].findings.tests[4].records
    (pair,) = records.pairs
    assert (pair.name, pair.unit) == ("ear pressure", "Pa")
    assert records.shift == pytest.approx(-LATE, abs=1e-4)
    assert pair.fit.correlation > 0.999
    assert pair.fit.rms[0] == pytest.approx(2.0 * pair.fit.rms[1], rel=0.01)


def test_functions_are_those_of_the_dense_matrices(found):
    frfs = found[0].findings.tests[2].frfs
    assert len(frfs.pairs) == len(frfs.reduced) == 2
    for p in frfs.pairs:
        assert np.abs(p.model - p.measured.values).max() <= 2e-5 * np.abs(p.measured.values).max()
    for p in frfs.reduced:
        assert p.frac > 0.999


def test_what_was_found_is_told_and_stored(found):
    result, folder = found
    told = result.summary["tests"]
    assert list(told) == ["modal", "drive", "hammer", "logger", "microphone"]
    assert [key for key, part in told["modal"].items() if part is None] == ["frfs", "records"]
    assert told["hammer"]["frfs"]["functions"][0]["frac_reduced"] > 0.999
    again = creak.open_result(folder / "out")
    assert again.summary["tests"] == told
    text = again.report(folder / "page.html").read_text(encoding="utf-8")
    for words in (
        "Beside the test",
        "4 of 4 measured modes fit",
        "2 of 2 frequency response functions fit",
        "FRAC red.",
    ):
        assert words in text, words


def refused(folder, tables):
    try:
        set_up(with_tests(folder, tables))
    except InputError as error:
        return str(error)
    return "nothing was refused"


def test_what_the_run_does_not_compute_is_refused(tmp_path, run):
    record_table(tmp_path / "drive.csv", run, node="elsewhere z")
    text = (tmp_path / "drive.csv").read_text(encoding="utf-8").replace("tip force", "pedal force")
    (tmp_path / "drive.csv").write_text(text, encoding="utf-8")
    said = refused(tmp_path, '[test.drive]\nfile = "drive.csv"\n')
    assert "computes none of its 3 channels" in said
    assert "channels = {" in said


def test_a_table_of_modes_is_one_whatever_its_separator(plain, tmp_path):
    mode_table(tmp_path / "modes.csv", plain[0])
    text = (tmp_path / "modes.csv").read_text(encoding="utf-8").replace(",", ";")
    (tmp_path / "modes.csv").write_text(f"# of a hammer test\n{text}", encoding="utf-8")
    (test,) = set_up(with_tests(tmp_path, '[test.modal]\nfile = "modes.csv"\n')).tests
    assert test.modes is not None
    assert test.modes[0].frequencies.size == 4
    assert test.channels == ()


def test_wrong_tables_are_refused(tmp_path, run):
    record_table(tmp_path / "drive.csv", run)
    wavfile.write(tmp_path / "probe.wav", 8000, np.zeros(8000, dtype=np.int16))
    for tables, expected in (
        ('[test.drive]\nfile = "gone.unv"\n', "[test.drive.file]: no such file"),
        ('[test.drive]\nfile = "drive.xlsx"\n', "a universal file"),
        ('[test.drive]\nfile = "drive.csv"\nchannels = { "prob z" = "1 Z" }\n', "no channel 'prob z'"),
        ('[test.drive]\nfile = "drive.csv"\nunit = "mm"\n', "both full_scale and unit"),
        ('[test.drive]\nfile = "drive.csv"\nfull_scale = 2.0\nunit = "mm"\n', "belong to WAV files"),
        ('[test.drive]\nfile = "probe.wav"\n', "does not tell what its samples are"),
        (
            '[test.drive]\nfile = "probe.wav"\nfull_scale = 2.0\nunit = "Pa"\n',
            "creak listen RESULTS --beside probe.wav",
        ),
        ('[test.drive]\nfiles = "drive.csv"\n', "unknown key"),
    ):
        assert expected in refused(tmp_path, tables), tables
