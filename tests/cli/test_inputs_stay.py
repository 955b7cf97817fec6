"""No output of any command takes the place of a file that it reads or that creak did not write, by whatever name."""

import inspect
import os
import shutil
from itertools import cycle
from pathlib import Path

import numpy as np
import pytest
import typer

from creak.cli.main import app
from creak.formats.wav import write_wav
from helpers_cli import workers_here
from helpers_decks import STUDY, two_strips, write_study

pytestmark = pytest.mark.slow

SHAKEN = (
    STUDY.replace("step = 5e-4", 'accuracy = "quick"')
    .replace("periods = 2", "end = 0.06\n[output]\ninterval = 5e-4\nfield_interval = 0.01\n[reference]\nrun = false")
    .replace(
        '"multisine", f_min = 5, f_max = 60, amplitude = 0.05, period = 0.2, seed = 3', '"table", file = "shake.csv"'
    )
    .replace(
        "mac_f_max = 500",
        'mac_f_max = 500\n[scatter.vary]\n"contact.tip.clearance" = { type = "uniform", low = 0.0, high = 0.6 }',
    )
)
SHAKE = "time,value\n0,0\n0.01,0.5\n0.02,-0.5\n0.03,0.5\n0.06,0\n"
TEST = "frequency_hz,sensor,direction,value\n93.2,4,z,0.06\n93.2,7,z,0.25\n93.2,10,z,0.56\n93.2,13,z,1.0\n"
DECK, OWN = ("strips.inp", "lower.inp"), ("own.bdf",)
STUDIED = ("study.toml", *DECK, "shake.csv")
RESULTS = ("results/results.h5", "results/summary.json")
READ = (
    *("--beside", "--calibrator", "--sensors", "--superelements", "--test", "--tls-ca-file"),
    *("--tls-cert", "--tls-key"),
)
"""Options that are paths and name what is read."""
UPDATE = "update study.toml --test test.csv --parameter section.UPPER.thickness"
NAMED = [
    ("modes strips.inp --count 1 --json OUT", ".json", DECK),
    ("modes strips.inp --count 1 --vtk OUT", ".vtu", DECK),
    ("modes strips.inp --count 1 --uff OUT", ".unv", DECK),
    ("modes strips.inp --count 1 --pch OUT", ".pch", DECK),
    ("modes study.toml --count 1 --vtk OUT", ".vtu", ("study.toml", *DECK)),
    ("modes strips.inp --count 9 --test test.csv --page OUT", ".html", (*DECK, "test.csv")),
    (f"{UPDATE} --page OUT", ".html", (*STUDIED, "test.csv")),
    (f"{UPDATE} --json OUT", ".json", (*STUDIED, "test.csv")),
    ("convert strips.inp OUT", ".inp", DECK),
    ("convert own.bdf OUT", ".bdf", OWN),
    ("convert own.inp OUT", ".inp", ("own.inp",)),
    ("convert strips.inp OUT --matrices npz", ".npz", DECK),
    ("convert results/results.h5 OUT", ".pvd", RESULTS),
    ("convert results/results.h5 OUT", ".vtu", RESULTS),
    ("convert results/results.h5 OUT", ".unv", RESULTS),
    ("convert results/results.h5 OUT", ".pch", RESULTS),
    ("convert results/results.h5 OUT", ".csv", RESULTS),
    ("report results --out OUT", ".html", RESULTS),
    ("compare results other --out OUT", ".html", RESULTS),
    ("screen study.toml --csv OUT", ".csv", STUDIED),
    ("schema --out OUT", ".json", STUDIED),
    ("new strips.inp --out OUT --overwrite", ".toml", DECK),
]
"""Commands that write a file which they are told, its ending, and what they read."""
FOLDERS = [
    ("run study.toml --no-converge --animation-mb 0 --out OUT", ("results.h5", "summary.json", "report.html"), STUDIED),
    ("run study.toml --no-converge --force --out OUT", ("results.h5", "summary.json", "convergence.csv"), STUDIED),
    ("run strips.inp --out OUT", ("results.h5", "summary.json", "report.html"), DECK),
    ("compare results --set reduction.f_max=2000", ("results.h5", "summary.json"), (*STUDIED, *RESULTS)),
    ("report results --out OUT/page.html", ("page.html",), RESULTS),
    ("listen results --out OUT", ("ear_all.wav", "ear_tip_1.wav"), RESULTS),
    ("listen results --beside hiss.wav --out OUT", ("beside.png",), (*RESULTS, "hiss.wav")),
    ("robust study.toml --n 4 --no-indices --out OUT", ("robust.json", "draws.csv", "robust.html"), STUDIED),
    (
        "sweep sweep.toml --workers 1 --out OUT",
        ("sweep.csv", "sweep.h5", "sweep.html", "f_max=2000.toml"),
        ("sweep.toml", *STUDIED),
    ),
    ("reduce study.toml --out OUT --export op4 --export matrix-market", ("UPPER.op4", "UPPER_K.mtx"), STUDIED),
    ("convert strips.inp OUT/k --matrices mtx", ("k_K.mtx", "k_dofs.csv"), DECK),
    ("new strips.inp --out OUT/s.toml --overwrite", ("creak-study.schema.json",), DECK),
    ("example door --mesh-size 40 --out OUT", ("door.inp", "door.toml"), STUDIED),
    ("example cockpit --mesh-size 20 --out OUT", ("cockpit.inp", "cockpit.toml", "cabin.csv"), STUDIED),
    ("thesis --mesh-size 40 --out OUT", ("thesis.html",), STUDIED),
]
"""Commands that write into a folder, some files that they write there, and what they read or should not touch."""


@pytest.fixture(scope="module")
def made(tmp_path_factory):
    """All that the commands read."""
    folder = tmp_path_factory.mktemp("made")
    head, _, rest = two_strips().partition("*NODE\n1001, ")
    lower, _, rest = rest.partition("*MATERIAL")
    write_study(
        folder,
        SHAKEN,
        {"strips.inp": f"{head}*INCLUDE, INPUT=lower.inp\n*MATERIAL{rest}", "lower.inp": f"*NODE\n1001, {lower}"},
    )
    (folder / "shake.csv").write_text(SHAKE)
    (folder / "test.csv").write_text(TEST)
    write_wav(folder / "hiss.wav", 0.1 * np.random.default_rng(0).standard_normal(48_000))
    (folder / "sweep.toml").write_text('base = "study.toml"\n[grid]\n"reduction.f_max" = [2000]\n')
    before = Path.cwd()
    os.chdir(folder)
    try:
        for words in (
            "convert strips.inp own.bdf --mass lumped",
            "convert strips.inp own.inp",
            "run study.toml --no-converge --animation-mb 0",
        ):
            app([*words.split(), "--quiet"], standalone_mode=False)
    finally:
        os.chdir(before)
    shutil.copytree(folder / "results", folder / "other")
    return folder


@pytest.fixture
def here(made, tmp_path, monkeypatch, no_page):
    """A copy of it to work in; workers are this process."""
    monkeypatch.setattr("creak.studies.tasks.queue.local_workers", workers_here)
    shutil.copytree(made, tmp_path / "made")
    monkeypatch.chdir(tmp_path / "made")
    return tmp_path / "made"


LINKS = ("symlink", "hard link")


def linked(target, name, how):
    """A name for a file; links are laid anew."""
    if how == "itself":
        return Path(target)
    name.unlink(missing_ok=True)
    name.parent.mkdir(exist_ok=True)
    if how == "symlink":
        name.symlink_to(Path(target).absolute())
    else:
        os.link(target, name)
    return name


def contents(folder):
    return {path: path.read_bytes() for path in folder.rglob("*") if path.is_file() and "far" not in path.parts}


@pytest.mark.parametrize(
    ("words", "ending", "inputs"), NAMED, ids=lambda value: value if isinstance(value, str) else ""
)
def test_a_named_output_onto_an_input(creak, here, words, ending, inputs):
    far = here / "far"
    far.mkdir()
    (here / "folder").symlink_to(here, target_is_directory=True)
    before = contents(here)
    for k, target in enumerate(inputs):
        links = LINKS if k == 0 else LINKS[k % 2 :][:1]
        for how in (*links, *(["itself"] if Path(target).suffix == ending or "--json" in words else [])):
            out = linked(target, far / f"out{ending}", how)
            for name in (out, here / "folder" / out, Path("results/..") / out) if how == "itself" else (out,):
                said = creak(*(str(name) if w == "OUT" else w for w in words.split()))
                assert said.status == 2, (target, how, said.words)
                assert f"cannot write {name}: " in said.words, (target, how, said.words)
                assert contents(here) == before, (target, how)


@pytest.mark.parametrize(
    ("words", "names", "inputs"), FOLDERS, ids=lambda value: value if isinstance(value, str) else ""
)
def test_an_output_in_a_folder_onto_an_input(creak, here, words, names, inputs):
    out = here / ("results_f_max=2000" if "--set" in words else "far")
    given = {path: (here / path).read_bytes() for path in inputs}
    ways = cycle(LINKS)
    for name in names:
        for target in dict.fromkeys((inputs[0], inputs[-1])):
            how = next(ways)
            shutil.rmtree(out, ignore_errors=True)
            linked(target, out / name, how)
            said = creak(*(w.replace("OUT", "far") for w in words.split()))
            assert said.status == 2, (name, target, how, said.words)
            assert "cannot write " in said.words, (name, target, how, said.words)
            assert {path: (here / path).read_bytes() for path in inputs} == given, (name, target, how)


WRITTEN = [(words, (f"out{ending}",)) for words, ending, _ in NAMED if not words.startswith(UPDATE)]
WRITTEN += [(f"{UPDATE} --page OUT/a.html --json OUT/b.json", ("a.html", "b.json"))]
WRITTEN += [(words, names) for words, names, _ in FOLDERS]
WRITTEN = [(words, names, sum(len(row[1]) for row in WRITTEN[:k])) for k, (words, names) in enumerate(WRITTEN)]
OTHERS = (b'{"mine": 1}\n', b"*HEADING\nmy own\n", b"title = 'mine'\n", b"\x89HDF\r\n\x1a\n")
"""What other programs write; each file of a command meets the next one of them."""
LONG_OR_TOLD = ("new", "thesis", "compare results --set", "run strips.inp", "run study.toml --no-converge --force")
"""Commands that take hours, need more than is here, or are told to replace what is there."""


@pytest.mark.parametrize(("words", "names", "first"), [row for row in WRITTEN if not row[0].startswith(LONG_OR_TOLD)])
def test_a_file_of_another_program_stays_and_creaks_own_is_written_again(creak, here, words, names, first):
    """The first time beside nothing, the second over what the first one wrote, then over what is not creak's."""
    (here / "far").mkdir()
    line = words.replace("OUT", f"far/{names[0]}" if names[0].startswith("out.") else "far").split()
    for _ in range(2):
        said = creak(*line).done()
    for k, name in enumerate(names, first):
        path, other = here / "far" / name, OTHERS[k % len(OTHERS)]
        written = path.read_bytes()
        path.write_bytes(other)
        said = creak(*line)
        assert said.status == 2, (name, other, said.words)
        assert path.read_bytes() == other
        path.write_bytes(written)


@pytest.mark.parametrize("target", [*STUDIED, "test.csv"])
def test_an_updated_study_replaces_nothing_that_was_read(creak, here, target):
    """It lies beside the study, whose files it names."""
    for how in (*LINKS, *(["itself"] if target.endswith(".toml") else [])):
        out = linked(target, here / "other.toml", how)
        before = contents(here)
        said = creak(*UPDATE.split(), "--out", str(out))
        assert said.status == 2, (how, said.words)
        assert f"cannot write {out}: " in said.words, (how, said.words)
        assert contents(here) == before


def test_no_option_that_writes_is_forgotten():
    """Every option that is a path stands in a line above, but for those that name folders to read and certificates."""
    told = [f"{UPDATE} --out", *(words for words, *_ in (*NAMED, *FOLDERS))]
    root = typer.main.get_command(app)
    commands = {(name,): command for name, command in root.commands.items()}
    commands |= {("example", name): command for name, command in commands.pop(("example",)).commands.items()}
    for name, command in commands.items():
        kinds = {key: str(p.annotation) for key, p in inspect.signature(command.callback).parameters.items()}
        for p in command.params:
            if "Path" in kinds[p.name] and p.opts[0].startswith("--") and p.opts[0] not in READ:
                assert any(words.startswith(" ".join(name)) and p.opts[0] in words for words in told), (name, p.opts)
