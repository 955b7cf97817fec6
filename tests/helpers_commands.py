"""The commands of README.md and docs/, and folders with stand-ins for the files that they name.

Only the names are those of the pages: decks are two strips, that of the door too; a door that a command writes or the
thesis takes is as coarse as it gets. Each shakes for a twentieth of a second.
"""

from __future__ import annotations

import functools
import inspect
import re
import shutil
import tempfile
import tomllib
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from itertools import pairwise
from pathlib import Path
from typing import Any

import typer

import creak_thesis.doors
import creak_thesis.record
import creak_thesis.run
from creak.cli.main import app
from creak.formats.measured.uff import write_uff
from creak.studies.file.changes import changed
from creak.studies.file.toml_text import toml_text
from creak.studies.models.deck_modes import deck_modes
from creak_thesis.door import LOAD, write_door
from helpers_cli import Said
from helpers_decks import STUDY, two_strips
from helpers_docs import PAGES, commands
from helpers_nastran_strips import STUDY as NASTRAN_STUDY
from helpers_nastran_strips import strips

PLACEHOLDER = re.compile(r"[A-Z]+(\.\w+)?|.*[][|].*|\.\.\.")
"""`DECK`, `STUDY.toml`, `[OPTIONS]`, `STUDY.toml|DECK`, `...`."""
READ = {"superelements", "test", "sensors"}
"""Options that name files which are read."""
UNREAD = {
    "IMPERFECTION": "*IMPERFECTION, FILE=modes, STEP=1\n1, 0.1\n",
    "CGAP": "CGAP,901,9,1013,13\nPGAP,9,1.75,,1.+4",
}
"""What a deck holds where a command ignores it."""
OWN_STEP = (
    "*SURFACE INTERACTION, NAME=STOP\n*SURFACE BEHAVIOR, PRESSURE-OVERCLOSURE=LINEAR\n50.\n"
    "*CONTACT PAIR, INTERACTION=STOP, SMALL SLIDING, TYPE=SURFACE TO SURFACE\nUNDER, OVER\n"
    "*AMPLITUDE, NAME=SHAKE\n0., 0., 0.01, 1., 0.02, 0.\n"
    "*STEP\n*DYNAMIC, DIRECT, ALPHA=-0.05\n1.E-3, 0.02\n*BOUNDARY, AMPLITUDE=SHAKE\nROOT_UPPER, 3, 3, 0.5\n"
    "*NODE OUTPUT, NSET=TIP_UPPER\nU\n*END STEP\n"
)
CASE_CONTROL = "SPC = 1\nTSTEP = 5\nDLOAD = 7\nDISPLACEMENT = 2"
FORCE = "TSTEP,5,20,1.-3\nTLOAD1,7,6,,,8\nTABLED1,8\n,0.,0.,.01,1.,ENDT\nDAREA,6,1039,3,1."
SWEEP = 'base = "study.toml"\n[grid]\n"reduction.f_max" = [2000]\n'
SCATTER = '[scatter.vary]\n"contact.tip.clearance" = { type = "uniform", low = 0.0, high = 0.6 }\n'
QUICK_RUN = 'accuracy = "quick"\nend = 0.02'
COARSEST = 40.0
"""mm, mesh size of the door."""
QUICK = {
    "excitation.hinge.signal.f_min": 20,
    "excitation.hinge.signal.period": 0.05,
    "excitation.hinge.signal.amplitude": 0.025,
    "time.periods": 1,
    "time.accuracy": "quick",
    "output.interval": 1e-3,
    "reduction.f_max": 200,
    "verification.pairs": "PAIRS15",
    "reference.run": False,
}
"""What makes the study of the door quick; the strips are compared with the unreduced model."""


@dataclass(frozen=True)
class Command:
    """A command as a page has it."""

    words: tuple[str, ...]
    nastran: bool = False
    """Whether the study that it takes is one of a Nastran deck."""

    def __str__(self) -> str:
        return " ".join(self.words) + (" (Nastran)" if self.nastran else "")


def all_commands() -> list[Command]:
    """Each command of the pages once; those that take study.toml twice where pages on both kinds of decks have them."""
    found = [
        Command(tuple(words), "nastran" in page.stem and "study.toml" in words[:2])
        for page in PAGES
        for words in commands(page)
    ]
    return list(dict.fromkeys(found))


def concrete(words: Sequence[str]) -> bool:
    """Whether a command can be run as it stands: nothing in it is a placeholder, nothing that it needs is missing.

    Keywords to ignore are in capitals because decks have them so.
    """
    if any(PLACEHOLDER.fullmatch(w) for before, w in pairwise(("creak", *words)) if before != "--ignore"):
        return False
    command, rest = _split(words)
    if hasattr(command, "commands"):  # options of the program itself, or a group alone
        return bool(rest)
    return not _needs_file(command) or (bool(rest) and not rest[0].startswith("-"))


@functools.cache
def _program() -> Any:
    return typer.main.get_command(app)


def _split(words: Sequence[str]) -> tuple[Any, Sequence[str]]:
    """The command of the program, and the words after its name."""
    command = _program()
    while words and hasattr(command, "commands") and words[0] in command.commands:
        command, words = command.commands[words[0]], words[1:]
    return command, words


def _needs_file(command: Any) -> bool:
    return any(p.required for p in command.params)


def meaning(command: Command) -> str:
    """The same for commands that differ in defaults alone."""
    found, rest = _split(command.words)
    if hasattr(found, "commands"):
        return str(command)
    given = found.make_context(found.name, list(rest)).params
    return f"{found.name} {given} {command.nastran}"


def inputs(words: Sequence[str]) -> list[str]:
    """The file or folder that a command reads: its first argument."""
    command, rest = _split(words)
    return [rest[0]] if _needs_file(command) else []


def outputs(words: Sequence[str]) -> list[str]:
    """Files and folders that a command names and is to write: values of its options that are paths, and what it converts to."""
    command, rest = _split(words)
    paths = {name for name, p in inspect.signature(command.callback).parameters.items() if "Path" in str(p.annotation)}
    writes = {o for p in command.params if p.name in paths - READ for o in p.opts}
    named = [w for before, w in pairwise(rest) if before in writes]
    if words[0] == "convert":
        ending = dict(pairwise(rest)).get("--matrices")
        named.append(rest[1] if ending is None else f"{rest[1]}.{ending}")
    return named


def write_stand_ins(folder: Path, command: Command) -> None:
    """What a command may read, but for what another command of the pages makes."""
    extra = [UNREAD[w] for before, w in pairwise(command.words) if before == "--ignore"]
    abaqus = "".join([two_strips(), *extra, OWN_STEP])
    nastran = strips(extra="\n".join([FORCE, *extra])).replace("SPC = 1", CASE_CONTROL)
    study = STUDY.replace("f_min = 5", "f_min = 20").replace("period = 0.2", "period = 0.05")
    study = study.replace("periods = 2", "periods = 1") + "\n[output]\nfield_interval = 0.01\n"
    for old, new in NASTRAN_STUDY.items() if command.nastran else ():
        study = study.replace(old, new)
    texts = {
        **dict.fromkeys(("model.inp", "strip.inp", "car.inp", "deck.inp"), abaqus),
        **dict.fromkeys(("model.bdf", "plate.bdf", "deck.bdf"), nastran),
        **{f"door/{name}": text for name, text in door_texts(None).items()},
        **{f"door_loose/{name}": text for name, text in door_texts(0.2).items()},
        "study.toml": study.replace("strips.", "model."),
        "cockpit/cockpit.toml": "# written by creak\n" + study.replace("strips.", "model."),
        "cockpit/model.inp": abaqus,
        "scatter.toml": STUDY.replace("strips.", "model.").replace("step = 5e-4\nperiods = 2", QUICK_RUN) + SCATTER,
        "test.unv": test_text(),
        "sweep.toml": SWEEP,
        "door_sweep.toml": SWEEP,
    }
    for name, text in texts.items():
        (folder / name).parent.mkdir(exist_ok=True)
        (folder / name).write_text(text, encoding="utf-8")


@functools.cache
def test_text() -> str:
    """Modes of the strips as a test found them."""
    with tempfile.TemporaryDirectory() as folder:
        deck, path = Path(folder) / "strips.inp", Path(folder) / "test.unv"
        deck.write_text(two_strips(), encoding="utf-8")
        found = deck_modes(deck, count=8)
        write_uff(path, found.model, found.frequencies, found.translations())
        return path.read_text(encoding="ascii")


@functools.cache
def door_texts(hook_play: float | None) -> dict[str, str]:
    """The files of the quick door; its deck is that of two strips, whose sets have the names of the door's."""
    with tempfile.TemporaryDirectory() as folder:
        _, path = quick_door(COARSEST, Path(folder), hook_play=hook_play)
        study = path.read_text(encoding="utf-8").replace("f_max = 200\n", "f_max = 3000\n")  # modes of strips
    names = {"UNDER": "PANEL_EDGE", "OVER": "FRAME_FLANGE", "ROOT_UPPER": "F", "NSET=PAIRS": "NSET=PAIRS15"}
    deck = two_strips(gap=3.65)
    for old, new in names.items():
        deck = re.sub(rf"\b{old}\b", new, deck)
    hooks = [names for connector in tomllib.loads(study).get("connector", ()) for names in connector["nodes"]]
    sets = (f"*NSET, NSET={name}\n{'12' if 'PANEL' in name else '1012'}\n" for name in hooks)
    return {path.name: study, path.with_suffix(".inp").name: deck + "".join(sets)}


def quick_door(
    mesh_size: float, out: Path, coarsen: int = 1, load: str = LOAD, hook_play: float | None = None
) -> list[Path]:
    """Files of the coarsest door, whatever the mesh size, with a quick study."""
    deck, study = write_door(COARSEST, out, coarsen, load, hook_play)
    study.write_text(
        toml_text(changed(tomllib.loads(study.read_text(encoding="utf-8")), QUICK, None)), encoding="utf-8"
    )
    return [deck, study]


def shorten_thesis(monkeypatch: Any) -> None:
    """Leaves one case of the plan, under one load, on the quick door, and a record of four seconds."""
    whole, record = creak_thesis.run.plan(), creak_thesis.record.study_record
    one = [replace(c, loads=(), newton=False) for c in whole if c.name == "F300"]
    monkeypatch.setattr(creak_thesis.run, "plan", lambda: one)
    monkeypatch.setattr(creak_thesis.record, "study_record", lambda: record(1, duration=4.0, rate=4800.0))
    monkeypatch.setattr(creak_thesis.doors, "write_door", quick_door)


@dataclass(frozen=True)
class Workshop:
    """Runs each command once, in a folder of its own; what it reads and no stand-in gives, the command that writes it makes first."""

    commands: Sequence[Command]
    new_folder: Callable[[], Path]
    done: dict[str, Path] = field(default_factory=dict)
    """Folder after a command, by its meaning."""

    def run(self, command: Command, say: Callable[[Path, Sequence[str]], Said]) -> Path:
        """The folder after the command, which has ended well and written what it names."""
        key = meaning(command)
        if key not in self.done:
            self.done[key] = self._run(command, say)
        for name in outputs(command.words):
            assert (self.done[key] / name).exists(), f"{command}: {name} was not written"
        return self.done[key]

    def _run(self, command: Command, say: Callable[[Path, Sequence[str]], Said]) -> Path:
        folder = self.new_folder()
        write_stand_ins(folder, command)
        for name in inputs(command.words):
            if not (folder / name).exists():
                self._make(name, folder, say)
        for name in outputs(command.words):
            _remove(folder / name)
        say(folder, command.words).done()
        return folder

    def _make(self, name: str, folder: Path, say: Callable[[Path, Sequence[str]], Said]) -> None:
        """Take a file, or the folder that it lies in, from where the command that writes it has run."""
        makers = {o: c for c in reversed(self.commands) for o in outputs(c.words) if Path(name).is_relative_to(o)}
        assert makers, f"no stand-in and no command gives {name}"
        closest = max(makers, key=len)
        made = self.run(makers[closest], say) / closest
        if made.is_dir():
            shutil.copytree(made, folder / closest)
        else:
            shutil.copy(made, folder / closest)


def _remove(path: Path) -> None:
    if path.is_dir():
        shutil.rmtree(path)
    else:
        path.unlink(missing_ok=True)
