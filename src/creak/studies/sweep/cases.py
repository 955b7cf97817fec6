"""The cases of a sweep: combinations of changes, their names, and the studies that come of them."""

from __future__ import annotations

import itertools
import math
import os
import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from pydantic import ValidationError

from creak.contact.play import check_play
from creak.digest import digest
from creak.errors import InputError
from creak.formats.decks import read_model
from creak.model.mesh import Model
from creak.studies.design.clips import check_clips
from creak.studies.design.properties import with_properties
from creak.studies.file.changes import SEEDED, change_words, changed, short_keys, value_at
from creak.studies.file.config import StudyConfig
from creak.studies.file.excitation_tables import ExcitationTable
from creak.studies.file.paths import DECKS, Contents, map_paths
from creak.studies.file.places import Places, overlap
from creak.studies.file.reader import Study, check_idle, explain
from creak.studies.file.toml_text import toml_text, toml_value
from creak.studies.prepare.excitation import count_steps
from creak.studies.prepare.flight_steps import with_flight_steps
from creak.studies.prepare.pairs import contact_law, plays_of
from creak.studies.prepare.setup import check_frequencies
from creak.studies.sweep.file import CaseTable, SweepFile
from creak.version import version

LONGEST = 120
"""Characters of a folder's name."""
MOST_CASES = 100_000
TAKEN = ("sweep", "superelements", "references")
"""Names that the sweep uses itself."""


@dataclass(frozen=True)
class Combination:
    """One combination of changes."""

    name: str
    changes: Mapping[str, Any]
    seed: int | None


@dataclass(frozen=True)
class Case:
    """A combination with the study that it makes."""

    name: str
    folder_name: str
    changes: Mapping[str, Any]
    """Every key that some case of the sweep changes -> its value in this one; None: the study does not have it."""
    seed: int | None
    """Of the sweep's, or that of the random signals where they share one."""
    text: str
    """The study as TOML, for a file in the sweep's folder."""
    study_hash: str
    """Of the checked study with all defaults, without its title, and of the files it names besides the deck."""
    deck_hash: str
    reference_key: str | None
    """What the run of the unreduced model depends on; None: the case does not make it."""

    converge: bool | None = None
    """Whether it is repeated to see how far it has settled; None: as its study says."""

    @property
    def id(self) -> str:
        """Cases with the same id have the same results."""
        return digest([self.study_hash, self.deck_hash, version(), *[self.converge] * (self.converge is not None)])


def combinations(sweep: SweepFile) -> list[Combination]:
    """Every case with every point of the grid and every seed, with unique names."""
    config = sweep.config
    _check_count(sweep)
    short = short_keys([*sweep.keys])
    grid = [dict(zip(config.grid, point, strict=True)) for point in itertools.product(*config.grid.values())]
    own_cases: list[CaseTable | None] = [*config.case] or [None]
    seeds: list[int | None] = [*config.seeds] or [None]
    out = []
    for case, point, seed in itertools.product(own_cases, grid, seeds):
        own = {} if case is None else dict(case.changes)
        words = [] if case is None else [case.name or change_words(own, short)]
        words += [change_words(point, short)] if point else []
        words += [] if seed is None else [f"seed={seed}"]
        out.append(Combination(",".join(words), {**own, **point}, seed))
    names = unique([v.name for v in out])
    return [Combination(name, v.changes, v.seed) for name, v in zip(names, out, strict=True)]


def _check_count(sweep: SweepFile) -> None:
    """Raise InputError before more cases are made than can be run."""
    config = sweep.config
    lengths = [len(values) for values in (*config.grid.values(), config.case, config.seeds) if values]
    if (count := math.prod(lengths)) > MOST_CASES:
        what = f"{count:,}" if count < 10**15 else f"{float(min(count, 10**300)):.0e}"
        raise InputError(
            f"the sweep has {what} cases ({' x '.join(map(str, lengths))})",
            where=sweep.path,
            expected=f"at most {MOST_CASES:,}",
            fix="Give fewer values in [grid], or list the combinations that matter as [[case]].",
        )


def unique(names: Iterable[str]) -> list[str]:
    """The names, those that occurred before (in whatever case) with a number."""
    out: list[str] = []
    seen: set[str] = set()
    for name in names:
        numbered = itertools.chain([name], (f"{name}#{k}" for k in itertools.count(2)))
        free = next(n for n in numbered if n.lower() not in seen)
        seen.add(free.lower())
        out.append(free)
    return out


def folder_names(names: Sequence[str]) -> list[str]:
    """Names that every file system takes, unique too."""
    safe = [re.sub(r"[^\w.,=+#-]", "_", name).lstrip(".") or "_" for name in names]
    short = [s if len(s) <= LONGEST else f"{s[: LONGEST - 9]}_{digest(s)[:8]}" for s in safe]
    return unique([*TAKEN, *short])[len(TAKEN) :]


def resolve(sweep: SweepFile, out: Path, converge: bool | None = None) -> list[Case]:
    """All cases with their studies checked; nothing is written.

    Parameters
    ----------
    out : folder of the sweep; paths in the studies are made relative to it.
    converge : of every case, as `creak.run` has it.

    Raises
    ------
    InputError : a case is not a correct study, a file that it names is missing, a material or section that a case
        changes is not in its deck.
    """
    signals = [t.signal.type for t in sweep.study.excitation.values()]
    if sweep.config.seeds and not {*SEEDED} & {*signals} and not any("signal" in k for k in sweep.keys):
        raise InputError(
            "seeds, but no excitation of the base study is a multisine or psd",
            where=sweep.where("seeds"),
            fix="Leave out seeds.",
        )
    found, contents = combinations(sweep), Contents()
    folders = folder_names([v.name for v in found])
    models: dict[Path, Model] = {}
    cases = [_case(sweep, v, folder, out, contents, models) for v, folder in zip(found, folders, strict=True)]
    return [replace(case, converge=converge) for case in cases]


def _case(
    sweep: SweepFile, one: Combination, folder: str, out: Path, contents: Contents, models: dict[Path, Model]
) -> Case:
    data, config = checked(sweep, one)
    base = sweep.base.parent.resolve()
    _check_properties(sweep, one, config, base / config.model.deck, models)
    tables = map_paths(data, lambda _, name: name if Path(name).is_absolute() else _relative(base / name, out))
    text = f"# written by creak sweep\n{toml_text(tables)}"
    plain = config.model_dump(mode="json", by_alias=True)
    deck_hash = contents.of(DECKS[0], base / config.model.deck)

    def content(place: tuple[str, ...], name: str) -> str:
        return contents.of(place, base / name)

    content_of = map_paths({k: v for k, v in plain.items() if k != "title"}, content)
    runs_reference = config.proof == "whole" or config.reduction.method == "none"
    unreduced = {k: v for k, v in content_of.items() if k not in ("reduction", "reference")}
    unreduced["until"] = config.reference.until
    if config.damping.modal is not None or config.damping.from_test is not None:
        unreduced["damped"] = config.reduction.f_max  # `modal_band`
    key = digest([unreduced, deck_hash, version()]) if runs_reference else None
    given = config.model_dump(mode="json", by_alias=True, exclude_none=True)
    values = {k: value_at(given, k) for k in sweep.keys}
    return Case(one.name, folder, values, _seed(config.excitation, one.seed), text, digest(content_of), deck_hash, key)


def _check_properties(
    sweep: SweepFile, one: Combination, config: StudyConfig, deck: Path, models: dict[Path, Model]
) -> None:
    """Raise InputError where a case changes a material or section that its deck has not; each deck is read once."""
    keys = [k for k in one.changes if k.split(".")[0] in ("material", "section")]
    if not keys:
        return
    if deck not in models:
        models[deck] = read_model(deck)
    try:
        with_properties(models[deck], config.material, config.section, Places(sweep.base, changes=one.changes))
    except InputError as error:
        key = next((k for k in keys if f"the change {k} = " in error.where), keys[0])
        text = f"case {one.name}: {error.what}"
        raise InputError(text, where=sweep.where(key), expected=error.expected, fix=error.fix) from None


def checked(sweep: SweepFile, one: Combination) -> tuple[dict[str, Any], StudyConfig]:
    """The study of a combination, as tables and checked.

    Raises
    ------
    InputError : a change names a key that studies do not have, or a wrong value.
    """
    try:
        return _checked(sweep, one.changes, one.seed)
    except InputError as error:
        problem = error
        keys = [k for k in one.changes if overlap(k, error.where) or f"the change {k} = " in error.where]
        keys = keys or [k for k in one.changes if suspicious(k, sweep, one)]
    except ValidationError as error:
        at = [".".join(str(k) for k in e["loc"]) for e in error.errors()]
        problem = explain(sweep.path, "", error)
        keys = [k for k in one.changes if any(_within(k, a) for a in at)]
    where = sweep.where(keys[0]) if keys else str(sweep.path)
    text = f"case {one.name}: {problem.what}"
    raise InputError(text, where=where, expected=problem.expected, fix=problem.fix)


def _checked(sweep: SweepFile, changes: Mapping[str, Any], seed: int | None) -> tuple[dict[str, Any], StudyConfig]:
    data = changed(sweep.data, changes, seed)
    config = StudyConfig.model_validate(data)
    check_idle(config, data, lambda *key: key[0])
    check_file(Study(config, "", Places(sweep.base, changes=changes)))
    return data, config


def suspicious(key: str, sweep: SweepFile, one: Combination) -> bool:
    """Whether this change alone cannot be made."""
    try:
        _checked(sweep, {key: one.changes[key]}, None)
    except (InputError, ValidationError):
        return True
    return False


def _within(key: str, at: str) -> bool:
    """The place of an error (which also names union members) lies in a key, or beside it in its table."""
    words = [w for w in at.split(".") if w in key.split(".")]
    return overlap(".".join(words), key) if words else False


def _relative(path: Path, folder: Path) -> str:
    try:
        return Path(os.path.relpath(path, folder.resolve())).as_posix()
    except ValueError:  # another drive
        return str(path)


def _seed(excitations: Mapping[str, ExcitationTable], asked: int | None) -> int | None:
    seeds = {t.signal.random for t in excitations.values()} - {None}
    return asked if asked in seeds else seeds.pop() if len(seeds) == 1 else None


def shown(value: Any) -> Any:
    """A value for a cell of a table: numbers and strings as they are, the rest as TOML."""
    return toml_value(value) if isinstance(value, Mapping | list | bool) else value


def check_file(study: Study) -> None:
    """Check names, laws and limits of what may touch, and how fast and how long the run is; no deck is read.

    Raises
    ------
    InputError : as setting up has it.
    """
    touching = study.touching
    check_clips(touching)
    for play, where in plays_of(touching):
        check_play(play, where)
    for name, table in touching.contacts.items():
        contact_law(table, touching.places.where("contact", name))
    check_frequencies(study.config.reduction, study.config.time, study.driving)
    study, _ = with_flight_steps(study)
    count_steps(study.course, study.config.time.substeps)
