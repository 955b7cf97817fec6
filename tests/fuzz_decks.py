"""Damaged decks and studies from a seed, and what becomes of them.

A damaged file must end in a model (which, being small, is also assembled) or in one InputError (NumericalError where the
numbers cannot be computed with); anything else - another exception, more than `LIMIT` seconds of CPU time, an exit
status that does not fit - is a fault.
"""

from __future__ import annotations

import contextlib
import io
import random
import re
import signal
import sys
import tempfile
import time
import traceback
import warnings
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from creak.assembly.coupling import Driven, couple
from creak.assembly.part import Rayleigh, loose_system, part_system
from creak.cli.main import main
from creak.errors import InputError, NumericalError
from creak.formats.abaqus.reader import read_deck, read_deck_run
from creak.formats.abaqus.writer import write_deck
from creak.formats.lsdyna.reader import read_lsdyna
from creak.formats.nastran.reader import read_nastran, read_nastran_run
from creak.model.mesh import Model
from creak.studies.file.reader import read_study
from creak.studies.prepare.setup import set_up
from creak.studies.sweep.cases import checked, combinations
from creak.studies.sweep.file import read_sweep
from fuzz_samples import ABAQUS, NASTRAN, STRIPS, STUDIES, SWEEPS
from helpers_lsdyna import clamped_assembly

LIMIT = 5.0
"""s"""
SMALL = 200
"""Nodes up to which a model is assembled."""
MANY_STEPS = 1e6
EVERY = 25
"""One in so many files also goes through the command line."""
VALUES = (
    "",
    "0",
    "-1",
    "1",
    "2",
    "7",
    "1e308",
    "-1e308",
    "1e-320",
    "1e999",
    "nan",
    "NaN",
    "inf",
    "-inf",
    "9" * 23,
    "1e5",
    "-0.0",
    "1.5D3",
    "1.+5",
    "1_0",
    "0x10",
    "abc",
    "THRU",
    "BY",
    "1 2",
    "\u0663",
    "1e",
    "--1",
    "99999999",
    "2147483648",
    "5e-324",
    "9" * 5000,
    "[/nope]",
    "[red]",
    "\x1b[31m",
    "\u00b2",
    "x" * 300,
    "1, THRU, 9999999",
    "\\u0000",
    "[" * 3000,
)
NOISE = "*,.=-+019eEdDnaZ_ \"'\t\x0b\x0c\x85\u00e9\u0663[]{}#$&/\\\u2028\ufeff"
_FIELD = re.compile(r"[,=]")


def damaged(rng: random.Random, text: str) -> bytes:
    """The text with one to four faults, as bytes."""
    lines = text.split("\n")
    for _ in range(rng.choice([1, 1, 1, 1, 1, 2, 2, 3, 4])):
        lines = rng.choice(LINE_FAULTS)(rng, lines) or [""]
    return rng.choice(ENCODINGS)("\n".join(lines)) if rng.random() < 0.08 else "\n".join(lines).encode()


def _delete(rng: random.Random, lines: list[str]) -> list[str]:
    k = rng.randrange(len(lines))
    return lines[:k] + lines[k + rng.choice([1, 1, 1, 5]) :]


def _repeat(rng: random.Random, lines: list[str]) -> list[str]:
    k, j = rng.randrange(len(lines)), rng.randrange(len(lines))
    return lines[:j] + lines[k : k + rng.choice([1, 1, 4])] + lines[j:]


def _swap_lines(rng: random.Random, lines: list[str]) -> list[str]:
    k, j = rng.randrange(len(lines)), rng.randrange(len(lines))
    lines[k], lines[j] = lines[j], lines[k]
    return lines


def _truncate(rng: random.Random, lines: list[str]) -> list[str]:
    k = rng.randrange(len(lines))
    return [*lines[:k], lines[k][: rng.randrange(len(lines[k]) + 1)]]


def _of_a_line(change: Callable[[random.Random, str], str]) -> Callable[[random.Random, list[str]], list[str]]:
    def changed(rng: random.Random, lines: list[str]) -> list[str]:
        k = rng.randrange(len(lines))
        lines[k] = change(rng, lines[k])
        return lines

    return changed


def _split(line: str) -> tuple[list[str], list[str]]:
    """Fields and the separators between them."""
    return _FIELD.split(line), _FIELD.findall(line)


def _joined(fields: list[str], between: list[str]) -> str:
    return "".join(f + s for f, s in zip(fields, [*between, ""], strict=True))


def _value(rng: random.Random, line: str) -> str:
    fields, between = _split(line)
    fields[rng.randrange(len(fields))] = rng.choice(VALUES)
    return _joined(fields, between)


def _other_number(rng: random.Random, line: str) -> str:
    """A number made larger, smaller, negative or another integer: plausible and wrong."""
    fields, between = _split(line)
    k = rng.randrange(len(fields))
    with contextlib.suppress(ValueError, OverflowError):
        value = float(fields[k])
        wrong = (value * 1e30, value * 1e-30, -value, int(value) + 1, 0.0 * value)
        fields[k] = repr(rng.choice(wrong))
    return _joined(fields, between)


def _swap_fields(rng: random.Random, line: str) -> str:
    fields, between = _split(line)
    k, j = rng.randrange(len(fields)), rng.randrange(len(fields))
    fields[k], fields[j] = fields[j], fields[k]
    return _joined(fields, between)


def _add_field(rng: random.Random, line: str) -> str:
    fields, _ = _split(line)
    k = rng.randrange(len(fields))
    return ",".join(fields[: k + 1] + fields[k:] if rng.random() < 0.5 else fields[:k] + fields[k + 1 :])


def _noise(rng: random.Random, line: str) -> str:
    k = rng.randrange(len(line) + 1)
    return (
        line[:k] + "".join(rng.choice(NOISE) for _ in range(rng.choice([1, 1, 2, 6]))) + line[k + rng.choice([0, 1]) :]
    )


def _typo(rng: random.Random, line: str) -> str:
    """A letter dropped, doubled or exchanged in the first word."""
    word = re.match(r"\W*\w+", line)
    if word is None:
        return line
    k = rng.randrange(word.end())
    return line[:k] + rng.choice(["", 2 * line[k], rng.choice("AEXZ5")]) + line[k + 1 :]


LINE_FAULTS = (
    _delete,
    _repeat,
    _swap_lines,
    _truncate,
    *(
        _of_a_line(change)
        for change in (_value, _value, _value, _other_number, _swap_fields, _add_field, _noise, _typo)
    ),
)
ENCODINGS: tuple[Callable[[str], bytes], ...] = (
    lambda text: text.encode("utf-16"),
    lambda text: text.encode("utf-8-sig"),
    lambda text: text.encode("cp037", errors="replace"),
    lambda text: (text + "\u00e4").encode("latin-1", errors="replace"),
    lambda text: text.replace("\n", "\r").encode(),
    lambda text: text.replace("\n", "\r\n").encode(),
    lambda text: text.encode()[:100] + b"\0" + text.encode()[100:],
    lambda text: text.encode()[: len(text) // 2] + b"\xff\xfe\x80" + text.encode()[len(text) // 2 :],
    lambda text: b"",
    lambda text: b"\x1f\x8b" + text.encode(),
)


class Hang(BaseException):
    """A file took longer than the limit."""


@dataclass
class Tally:
    """How many files ended how, and the faults."""

    ended: dict[str, int] = field(default_factory=dict)
    faults: list[str] = field(default_factory=list)
    longest: float = 0.0

    def add(self, end: str, seconds: float) -> None:
        self.ended[end] = self.ended.get(end, 0) + 1
        self.longest = max(self.longest, seconds)


def samples(kind: str) -> list[str]:
    """The good files that are damaged: of abaqus, nastran, lsdyna, study or sweep."""
    decks = {"abaqus": ABAQUS, "nastran": NASTRAN, "lsdyna": [clamped_assembly()]}
    return {**decks, "study": STUDIES, "sweep": SWEEPS}[kind]


FILES = {"abaqus": "deck.inp", "nastran": "deck.bdf", "lsdyna": "deck.k", "study": "study.toml", "sweep": "sweep.toml"}


def fuzz(kind: str, first: int, count: int) -> Tally:
    """Damage and read `count` files from seed `first` on."""
    tally = Tally()
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        (folder / "strips.inp").write_text(STRIPS, encoding="utf-8")
        (folder / "study.toml").write_text(STUDIES[0], encoding="utf-8")
        for ending, word in (("inp", "*INCLUDE, INPUT="), ("bdf", "INCLUDE ")):
            (folder / f"deck2.{ending}").write_text(2 * f"{word}deck2.{ending}\n")
        for seed in range(first, first + count):
            one(kind, seed, folder, tally)
    return tally


def one(kind: str, seed: int, folder: Path, tally: Tally) -> None:
    """Damage and read one file."""
    rng = random.Random(f"{kind} {seed}")
    path = folder / FILES[kind]
    path.write_bytes(damaged(rng, rng.choice(samples(kind))))
    start = time.perf_counter()
    end = guarded(kind, seed, path, tally)
    if kind in ("abaqus", "nastran", "lsdyna") and seed % EVERY == 0:
        _through_the_command(kind, seed, path, end, tally)
    tally.add(end, time.perf_counter() - start)


def guarded(kind: str, seed: int, path: Path, tally: Tally) -> str:
    """How the reading of one file ends; a fault is noted."""
    try:
        with _limited(), warnings.catch_warnings(), np.errstate(all="ignore"):
            warnings.simplefilter("ignore")
            return READERS[kind](path)
    except InputError as error:
        text = str(error)
        if not text.strip() or "Traceback" in text:
            tally.faults.append(f"{kind} {seed}: the message is {text!r}")
        return (
            "InputError"
            if path.name in text or "strips.inp" in text or kind in ("study", "sweep", "files")
            else "InputError without a place"
        )
    except NumericalError:
        return "NumericalError"
    except Hang:
        tally.faults.append(f"{kind} {seed}: more than {LIMIT} s")
        return "hang"
    except BaseException as error:
        last = traceback.extract_tb(error.__traceback__)[-1]
        tally.faults.append(
            f"{kind} {seed}: {type(error).__name__}: {error} ({Path(last.filename).name}:{last.lineno})"
        )
        return "traceback"


def _read_abaqus(path: Path) -> str:
    model = read_deck(path)
    if any(u.keyword == "*STEP" for u in model.unread):
        with contextlib.suppress(InputError):
            read_deck_run(path)
    end = assembled(model)
    with contextlib.suppress(InputError):
        write_deck(model, path.with_name("copy.inp"))
    return end


def _read_study(path: Path) -> str:
    """Set up, but for runs of very many steps, which are right and take their time."""
    study = read_study(path)
    table = study.config.time
    end = study.course.end
    if end / table.step * table.substeps > MANY_STEPS:
        return "study of a long run"
    set_up(study)
    return "study"


def _read_nastran(path: Path) -> str:
    model = read_nastran(path)
    for loads in model.static_loads.values():
        assert all(np.isfinite(f.value) for f in loads.forces)
    if path.read_bytes().startswith(b"SOL 109"):
        with contextlib.suppress(InputError):
            read_nastran_run(path)
    return assembled(model)


def _read_sweep(path: Path) -> str:
    sweep = read_sweep(path)
    for variant in combinations(sweep)[:20]:
        checked(sweep, variant)
    return "sweep"


READERS: dict[str, Callable[[Path], str]] = {
    "abaqus": _read_abaqus,
    "nastran": _read_nastran,
    "lsdyna": lambda path: assembled(read_lsdyna(path)),
    "study": _read_study,
    "sweep": _read_sweep,
}


def assembled(model: Model) -> str:
    """Assemble a small model; its K and M must be finite and square."""
    assert np.isfinite(model.nodes.coords).all()
    if model.nodes.count > SMALL:
        return "model"
    none = Rayleigh(0.0, 0.0)
    parts = [part_system(model, i, none, override=True) for i in range(len(model.parts))]
    loose = loose_system(model, none)
    system = couple([*parts, loose] if loose else parts, model, Driven({}), none, override=True)
    sums = [float(np.abs(A).sum()) for A in (system.K, system.M)]
    assert system.K.shape == system.M.shape == (system.n, system.n)
    return "model" if np.isfinite(sums).all() else "model that overflows"


def _through_the_command(kind: str, seed: int, path: Path, end: str, tally: Tally) -> None:
    """`creak info`: 0 or, of a refused file, 2 (1 where the numbers fail)."""
    before, out = sys.argv, io.StringIO()
    sys.argv = ["creak", "info", str(path)]
    status: object = None
    try:
        with _limited(), contextlib.redirect_stdout(out), contextlib.redirect_stderr(out), np.errstate(all="ignore"):
            main()
    except SystemExit as stop:
        status = stop.code
    except BaseException as error:
        status = repr(error)
    finally:
        sys.argv = before
    fits = {"InputError": (0, 2), "InputError without a place": (0, 2), "NumericalError": (0, 1, 2)}.get(end, (0,))
    if status not in fits:
        tally.faults.append(f"{kind} {seed}: `creak info` ends with {status} where reading ends with {end}")


@contextlib.contextmanager
def _limited() -> Iterator[None]:
    def stop(*_: object) -> None:
        raise Hang

    old = signal.signal(signal.SIGPROF, stop)
    signal.setitimer(signal.ITIMER_PROF, LIMIT)
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_PROF, 0.0)
        signal.signal(signal.SIGPROF, old)
