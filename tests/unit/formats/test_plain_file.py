"""What is no plain file is refused at once by whatever reads it: a pipe would wait, a device may have no end."""

import os
import signal
import socket
from contextlib import contextmanager, suppress

import pytest

from creak import read_json
from creak.errors import InputError
from creak.formats.decks import read_model
from creak.formats.matrices.superelements import read_superelement
from creak.formats.measured.files import read_channels
from creak.formats.measured.histories import read_histories
from creak.formats.measured.motion_series import motion_field
from creak.formats.stored.record_log import read_records
from creak.formats.stored.solved import read_solved
from creak.formats.stored.sound import read_sound
from creak.formats.stored.superelement import read_superelement_file
from creak.formats.wav import read_wav
from creak.studies.file.material_pairs import material_pairs
from creak.studies.file.paths import PLACES, Contents
from creak.studies.file.reader import read_study
from creak.studies.findings.stored import read_findings
from creak.studies.models.saved import boundary
from creak.studies.prepare.setup import set_up
from creak.studies.prepare.tolerances import points_of
from creak.studies.robust.job import deviations_of
from creak.studies.run.checkpoint import read_checkpoint
from creak.studies.sound.cabin import background_of, room_of
from creak.studies.sound.listeners import listeners_of
from creak.studies.sweep.file import read_sweep
from helpers_decks import STUDY, write_strips

KINDS = ["pipe", "device", "socket", "folder", "dangling link", "forbidden"]
SAID = {
    "pipe": "is a pipe or a device; expected a plain file",
    "device": "is a pipe or a device; expected a plain file",
    "socket": "is a socket; expected a plain file",
}
"""Others are told by each reader in its own words."""
READERS = {
    "study.toml": read_study,
    "sweep.toml": read_sweep,
    **dict.fromkeys(("deck.inp", "deck.bdf", "deck"), read_model),
    **dict.fromkeys(("a.rsp", "a.drv", "a.unv", "a.uff"), read_channels),
    "a.wav": read_wav,
    **dict.fromkeys(("a.op4", "a.pch", "a.npz", "a.mtx", "a.sti", "a_K.mtx"), read_superelement),
    "results.h5": lambda path: read_sound(path.parent),
    "summary.json": lambda path: read_findings(path.parent, lambda _: None),
    "r.h5": read_histories,
    "motion.h5": motion_field,
    "part.h5": read_superelement_file,
    "saved.h5": lambda path: boundary(path.parent, path),
    "any.json": read_json,
    "any.csv": lambda path: Contents().of(("clips",), path),
    "any.inp": lambda path: Contents().of(("model", "deck"), path),
}
KEPT = {
    "kept.h5": lambda path: read_solved(path, ""),
    "checkpoint.h5": lambda path: read_checkpoint(path, "", dict),
    "log.bin": lambda path: read_records(path, {}, 1),
}
"""What creak keeps for itself: what is not there is made."""


@contextmanager
def at_once():
    """A reader that waits, or that never comes to an end, is stopped."""

    def stop(*_):
        pytest.fail("it waits, or reads on and on")

    before = signal.signal(signal.SIGALRM, stop)
    signal.alarm(10)
    try:
        yield
    finally:
        signal.alarm(0)
        signal.signal(signal.SIGALRM, before)


def node(path, kind, monkeypatch):
    monkeypatch.chdir(path.parent)
    if kind == "pipe":
        os.mkfifo(path)
    elif kind == "device":
        path.symlink_to("/dev/zero")
    elif kind == "socket":
        with socket.socket(socket.AF_UNIX) as server:
            server.bind(path.name)
    elif kind == "folder":
        path.mkdir()
    elif kind == "dangling link":
        path.symlink_to("nowhere")
    else:
        path.write_text("a text")
        monkeypatch.setattr("os.access", lambda *_: False)  # whoever runs the tests may read everything


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("name", READERS)
def test_every_reader_refuses_at_once(name, kind, tmp_path, monkeypatch):
    node(tmp_path / name, kind, monkeypatch)
    with at_once(), pytest.raises(InputError, match=SAID.get(kind, rf"{name.partition('.')[0]}|nowhere")):
        READERS[name](tmp_path / name)


@pytest.mark.parametrize("kind", ["pipe", "device"])
@pytest.mark.parametrize("name", KEPT)
def test_what_is_kept_neither(name, kind, tmp_path, monkeypatch):
    node(tmp_path / name, kind, monkeypatch)
    with at_once(), suppress(InputError):
        assert KEPT[name](tmp_path / name) is None


SCATTER = '[scatter.vary]\n"contact.tip.clearance" = {{ type = "field", tolerance = {}, length = 50 }}\n'
BRANCH = {
    "model.deck": STUDY.replace('"strips.inp"', '"FILE.inp"'),
    "damping.from_test": STUDY + '[damping]\nfrom_test = "FILE.unv"\n',
    "contact.*.clearance": STUDY.replace('method = "surface-to-surface"', 'clearance = "FILE.csv"'),
    "excitation.*.signal.file": STUDY.replace(
        '"multisine", f_min = 5, f_max = 60, amplitude = 0.05, period = 0.2, seed = 3', '"table", file = "FILE.csv"'
    ).replace("periods = 2", "end = 0.1"),
    "superelement.*.file": STUDY + '[superelement.BAR]\nfile = "FILE.op4"\n',
    "superelement.*.map": STUDY + '[superelement.BAR]\nfile = "bar_K.mtx"\nmap = "FILE.csv"\n',
    "eline.*.points": STUDY + '[eline.E]\nmain = "OVER"\nsecondary = "UNDER"\npoints = "FILE.csv"\n',
    "eline.*.tolerance": STUDY + '[eline.tip]\ntolerance = "FILE.csv"\n',
    "eline.*.tolerance.file": STUDY + '[eline.tip]\ntolerance = { file = "FILE.csv" }\n',
    "limit.tolerance": STUDY + '[limit]\ntolerance = "FILE.csv"\n',
    "limit.tolerance.file": STUDY + '[limit]\ntolerance = { file = "FILE.csv" }\n',
    "scatter.vary.*.tolerance": STUDY + SCATTER.format('"FILE.csv"'),
    "scatter.vary.*.tolerance.file": STUDY + SCATTER.format('{ file = "FILE.csv" }'),
    "material_pairs": 'material_pairs = "FILE.toml"\n' + STUDY,
    "background.file": STUDY + '[background]\nfile = "FILE.csv"\n',
    "room.reverberation": STUDY + '[room]\nvolume = 3\nreverberation = "FILE.csv"\n',
    "listener.*.transfer.*.file": STUDY
    + '[listener.ear]\nposition = [60, 400, 500]\n[listener.ear.transfer.UPPER]\nfile = "FILE.csv"\n',
    "listener.*.hrtf": STUDY + '[listener.ear]\nposition = [60, 400, 500]\nfaces = [0, -1, 0]\nhrtf = "FILE.sofa"\n',
    "clips": 'clips = "FILE.toml"\n'
    + STUDY
    + '[[clip]]\nuse = "own"\nat = [[120.0, 0.0, 0.0]]\nparts = ["LOWER"]\naxis = [0, 0, 1]\n',
    "test.*.file": STUDY + '[test.T]\nfile = "FILE.unv"\n',
    "test.*.sensors": STUDY + '[test.T]\nfile = "modes.csv"\nsensors = "FILE.csv"\n',
    "static.*.temperature": STUDY + '[[static]]\ntemperature = "FILE.csv"\nreference = 20\n',
    "reduction.interface.deck": STUDY.replace(
        "f_max = 3000", 'f_max = 3000\ninterface = { type = "coarse-mesh", deck = "FILE.inp" }'
    ),
}
"""Place of a path in a study -> a study with it."""


@pytest.mark.parametrize("kind", ["pipe", "device"])
@pytest.mark.parametrize("place", BRANCH)
def test_every_file_that_a_study_names_is_refused_at_once(place, kind, tmp_path, monkeypatch):
    ending = next(word for word in ("inp", "csv", "op4", "toml", "unv", "sofa") if f"FILE.{word}" in BRANCH[place])
    node(tmp_path / f"FILE.{ending}", kind, monkeypatch)
    for name in ("bar_K.mtx", "bar_M.mtx"):
        (tmp_path / name).write_text("%%MatrixMarket matrix array real symmetric\n1 1\n1.0\n")
    modes = "frequency_hz,sensor,x,y,z,direction,value\n50.0,tip,100,0,0,z,1.0\n"
    (tmp_path / "modes.csv").write_text(modes, encoding="utf-8")
    study = write_strips(tmp_path, study=BRANCH[place])

    def read():
        setup = set_up(read_study(study))
        found = setup.study
        background_of(found.config.background, found.places)
        room_of(found.config.room, found.places)
        listeners_of(setup.model, found.config.listener, found.places, 1e-3)
        material_pairs(found.lines)
        points = points_of(setup.watch.lines.points, setup.model)
        deviations_of(points, found.config.scatter.vary, found.places, found.config.model.units)

    with at_once(), pytest.raises(InputError, match=SAID[kind]):
        read()


def test_every_place_is_in_the_table():
    assert BRANCH.keys() == {".".join(place) for place in PLACES}
