"""The linear structure of a study for any values of its keys: which keys modes depend on and where they begin; modes,
their slopes, their partners in a test."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
import scipy.sparse as sp

from creak.arrays import FloatArray, IntArray, Matrix
from creak.assembly.part import loose_system
from creak.assembly.system import System
from creak.contact.gap_operator import GapOperator, join
from creak.contact.play import play_channels
from creak.errors import InputError, NumericalError, suggest
from creak.formats.measured.modes import MeasuredModes
from creak.linalg.modes import Modes
from creak.model.mesh import Model
from creak.studies.design.clips import with_clips
from creak.studies.design.properties import properties_of, sections_of
from creak.studies.file.case import Touching
from creak.studies.file.changes import value_at, with_changes
from creak.studies.file.places import dotted
from creak.studies.file.reader import Study
from creak.studies.models.correlation import Correlation, correlate
from creak.studies.models.deck_modes import structure_modes
from creak.studies.prepare.linear_model import linear_structure
from creak.studies.prepare.measured_damping import ABOVE, shapes_at
from creak.studies.prepare.pairs import contact_channels, plays_of
from creak.studies.prepare.sensors import Sensors, locate
from creak.studies.prepare.structure import Structure, modes_up_to
from creak.verify.mac import mac_matrix, pair_measured, real_shapes, turned_twins

RANGE = 10.0
"""A parameter without bounds may rise and fall by this factor."""
EXPECTED = "KEY, or KEY=LOW:HIGH, as section.PANEL.thickness=0.8:1.5"
OF_DECK = ("material", "section")


@dataclass(frozen=True)
class Parameter:
    """A number that may change."""

    key: str
    """As `creak run --set` takes it."""
    start: float
    low: float
    high: float


def read_parameters(study: Study, model: Model, texts: Sequence[str]) -> list[Parameter]:
    """Parameters of `KEY` or `KEY=LOW:HIGH`; without bounds a tenth to ten times the start.

    Raises
    ------
    InputError : an unknown key, one given twice, one that is no positive number; bounds that are none, or that leave
        the start out.
    """
    found: dict[str, Parameter] = {}
    for text in texts:
        given, sign, bounds = (part.strip() for part in text.partition("="))
        if not given or (sign and not bounds):
            raise InputError(f"{text!r} is no parameter", expected=EXPECTED)
        key = _spelled(study, given)
        same = key.upper() if key.split(".")[0] in OF_DECK else key
        if same in found:
            raise InputError(f"the parameter {key} is given twice", fix="Give it once.")
        start = start_of(study, model, key)
        low, high = _bounds(text, bounds) if sign else (start / RANGE, start * RANGE)
        if not low < start < high:
            raise InputError(
                f"{text}: {key} is {start:g} in the study, which the bounds leave out",
                expected="LOW below and HIGH above it",
                fix="Widen them.",
            )
        found[same] = Parameter(key, start, low, high)
    return list(found.values())


def start_of(study: Study, model: Model, key: str) -> float:
    """The value of a key, of the study or else of the deck.

    Raises
    ------
    InputError : there is none, or it is no positive number.
    """
    value = value_at(study.config.model_dump(by_alias=True), key)
    if value is None and key.split(".")[0] in OF_DECK:
        kind, *words, word = key.split(".")
        name = ".".join(words)
        every = properties_of(model)
        own = sections_of(model, name) if kind == "section" else (name,)
        found = {every.get((kind, one.upper(), word)) for one in own}
        value = found.pop() if len(found) == 1 else None
    if value is None:
        known = candidates(study, model)
        raise InputError(
            f"{key} is no number of the study or its deck",
            expected="a key that `creak run --set` takes, or a number of the deck's materials and sections",
            fix=suggest(key, known),
        )
    if isinstance(value, bool) or not isinstance(value, int | float) or not 0.0 < value < math.inf:
        raise InputError(
            f"{key} is {value!r} in the study",
            expected="a number above 0: parameters are changed by factors",
            fix="Name one number; those of a list by their place, as clip.0.stiffness.4.",
        )
    return float(value)


def candidates(study: Study, model: Model) -> list[str]:
    """Keys of all that the modes can depend on: numbers of materials and sections, stiffness of bushings and of joints.

    Parameters
    ----------
    model : of the deck.
    """
    keys = [_spelled(study, dotted(key)) for key in properties_of(model) if not any("." in word for word in key)]
    for i, clip in enumerate(study.config.clip):
        if isinstance(clip.stiffness, list):
            keys += [f"clip.{i}.stiffness.{j}" for j, k in enumerate(clip.stiffness) if k > 0.0]
        else:
            keys.append(f"clip.{i}.ageing")
    keys += [f"contact.{n}.stiffness" for n, t in study.config.contact.items() if not isinstance(t.stiffness, str)]
    return keys + [f"connector.{i}.stiffness" for i in range(len(study.config.connector))]


def _spelled(study: Study, key: str) -> str:
    """The key with the name of a material or section as the study writes it."""
    kind, *name, word = key.split(".")
    if kind not in OF_DECK or not name:
        return key
    given = study.config.material if kind == "material" else study.config.section
    same = next((n for n in given if n.upper() == ".".join(name).upper()), ".".join(name))
    return f"{kind}.{same}.{word}"


def _bounds(text: str, bounds: str) -> tuple[float, float]:
    words = bounds.split(":")
    try:
        low, high = (float(word) for word in words)
    except ValueError:
        raise InputError(f"{text!r} has no bounds", expected=EXPECTED) from None
    if not 0.0 < low < high < math.inf:
        raise InputError(f"{text!r} has bounds that are none", expected="0 < LOW < HIGH")
    return low, high


STEP = 1e-3
"""Of ln p in the differences of matrices. Exact where a matrix is linear in p, as in stiffness, modulus, density
and mass: one step up is enough. Where it is not, as in a thickness, they are central, over 2 sinh(STEP); the bending of
a shell goes with its cube: 1.3e-6 too much."""
CURVED = "thickness"
"""Last word of the keys in which matrices are not linear."""


@dataclass(frozen=True)
class UpdateCase:
    """A study beside a test: what all trials share."""

    study: Study
    model: Model
    """Of the deck, as it was read."""
    measured: MeasuredModes
    test_units: str | None
    mapped: Mapping[str, int]
    """Sensor -> row of a node, before label and place."""
    ignore: Sequence[str]
    closed: Sequence[str]
    """Contacts, connectors and clips that stay closed; all others are open."""

    @property
    def f_max(self) -> float:
        """Hz, up to which modes are sought."""
        return ABOVE * float(self.measured.frequencies.max())


@dataclass(frozen=True)
class Joined:
    """A linear structure and its parts."""

    structure: Structure
    parts: tuple[System, ...]
    loose: System | None
    system: System


@dataclass(frozen=True)
class Trial:
    """A joined structure and its modes."""

    joined: Joined
    found: Modes


def joined(case: UpdateCase, values: Mapping[str, float], like: Joined | None = None) -> Joined:
    """The structure with these values; parts that they leave as in `like` are taken from it."""
    study = with_changes(case.study, values)
    structure = linear_structure(study, case.model, case.ignore)
    kept = None if like is None else like.structure.model
    parts = tuple(
        like.parts[k]
        if like is not None and kept is not None and _same_part(kept, structure.model, k)
        else structure.part(k)
        for k in range(len(structure.model.parts))
    )
    loose = loose_system(structure.model, structure.rayleigh) if like is None else like.loose
    system = structure.joined(parts, loose)
    if case.closed:
        system = with_closed(system, closed_joints(study.touching, study.path, structure.model, case.closed))
    return Joined(structure, parts, loose, system)


def _same_part(a: Model, b: Model, part: int) -> bool:
    """Whether the sections of a part are equal in two models of one deck."""
    both = zip(a.blocks, b.blocks, strict=True)
    return all(x.section is y.section or x.section == y.section for x, y in both if x.part == part)


def tried(case: UpdateCase, values: Mapping[str, float], like: Joined | None = None) -> Trial:
    """The structure with these values, and its modes.

    Raises
    ------
    NumericalError : the modes could not be found.
    """
    made = joined(case, values, like)
    return Trial(made, modes_up_to(made.system, case.f_max))


def slopes(case: UpdateCase, trial: Trial, values: Mapping[str, float], changing: Mapping[str, float]) -> FloatArray:
    """(n_mode, n_key) d(ln f)/d(ln p) of the modes of a trial, 0 of rigid ones.

    Parameters
    ----------
    values : key -> value, of the trial. changing : those that slopes are asked of.

    Matrices are differenced by `STEP`, modes are not (`reduction.sensitivity`).
    """
    found, elastic = trial.found, trial.found.omega2 > 0.0
    out = np.zeros((found.omega2.size, len(changing)))
    for j, (key, value) in enumerate(changing.items()):
        up, down = (
            trial.joined.system if h == 0.0 else joined(case, {**values, key: value * math.exp(h)}, trial.joined).system
            for h in (STEP, -STEP if key.endswith(CURVED) else 0.0)
        )
        width = 2.0 * math.sinh(STEP) if key.endswith(CURVED) else math.expm1(STEP)
        if not np.array_equal(up.coordinates, down.coordinates):
            raise NumericalError(f"{key} changes which degrees of freedom the model has: its slope has no meaning")
        dK, dM = ((a - b) / width for a, b in ((up.K, down.K), (up.M, down.M)))
        out[elastic, j] = frequency_slopes(dK, dM, found.shapes[:, elastic], found.omega2[elastic])
    return out


def partners(case: UpdateCase, sensors: Sensors, trial: Trial, tests: Sequence[int]) -> IntArray:
    """(n,) mode of a trial of each of some measured ones: its partner, or where it has none the mode most like it.

    Parameters
    ----------
    tests : rows of the measured modes.
    """
    freq = trial.found.frequencies
    shapes = shapes_at(trial.joined.system, case.measured, sensors, trial.found.shapes)
    test = real_shapes(case.measured.shapes)
    matrix = mac_matrix(test, shapes @ turned_twins(test, shapes, case.measured.frequencies, freq))
    partner = pair_measured(matrix, case.measured.frequencies, freq)
    most_like = np.where(freq > 0.0, matrix, -1.0).argmax(axis=1)
    return np.where(partner >= 0, partner, most_like)[list(tests)]


def correlated(case: UpdateCase, trial: Trial) -> Correlation:
    """The modes of a trial beside the measured ones.

    Raises
    ------
    InputError : as `locate` and `correlate`.
    """
    of = trial.joined
    parts = [*of.parts, *([of.loose] if of.loose is not None else [])]
    found = structure_modes(of.structure, parts, of.system, trial.found)
    units = case.study.config.model.units
    return correlate(found, case.measured, locate(found.model, case.measured, units, case.test_units, case.mapped))


def closed_joints(touching: Touching, path: Path, model: Model, names: Collection[str]) -> GapOperator:
    """The channels of some contacts, connectors and clips.

    Parameters
    ----------
    path : of the study. model : as it has it. names : of contacts, and of connectors and clips as results tell them.

    Raises
    ------
    InputError : an unknown name, or one without a stiffness of its own ("hard", or a law by points).
    """
    plays = [*plays_of(touching), *with_clips(model, touching)[1]]
    known = [*touching.contacts, *(p.name for p, _ in plays)]
    for name in names:
        if name not in known:
            raise InputError(
                f"the study has no contact, connector or clip {name!r} that touches",
                where=path,
                fix=suggest(name, known),
            )
    chosen = replace(touching, contacts={n: t for n, t in touching.contacts.items() if n in names})
    own = [play_channels(model, p, where) for p, where in plays if p.name in names]
    gaps = join([contact_channels(model, chosen)[0], *own])
    soft = np.isfinite(gaps.stiffness) & (gaps.stiffness > 0.0)
    if gaps.curves is not None or not soft.all():
        name = gaps.group[0] if gaps.curves is not None else gaps.group[int((~soft).argmax())]
        raise InputError(
            f"{name} has no stiffness with which it could stay closed",
            where=path,
            expected='stiffness = NUMBER; not "hard", no law by points',
            fix="Give it one.",
        )
    return gaps


def with_closed(system: System, gaps: GapOperator) -> System:
    """The System with K + G' k G: channels that neither open nor slide far, along their normals alone.

    Of a play with two limits one side presses at a time: each counts half.
    """
    places = list(zip(gaps.group, gaps.nodes_idx.tolist(), strict=True))
    sides = Counter(places)
    k = gaps.stiffness / np.array([sides[place] for place in places])
    A = sp.csr_array(gaps.G @ system.rows(gaps.labels)[0])
    added = A.T @ (sp.diags_array(k) @ A)
    return replace(system, K=system.K + (added if sp.issparse(system.K) else added.toarray()))


def frequency_slopes(dK: Matrix, dM: Matrix, shapes: FloatArray, omega2: FloatArray) -> FloatArray:
    """(n_mode,) d(ln f)/dp = phi' (dK/dp - omega^2 dM/dp) phi / (2 omega^2) of mass-normalised modes.

    Parameters
    ----------
    dK, dM : (n, n) derivatives of stiffness and mass. shapes : (n, n_mode), phi' M phi = 1. omega2 : (n_mode,) > 0.

    Exact for modes of different frequency. Modes of one frequency have a slope each only along the shapes into which
    the parameter splits them, which these need not be.

    Source: Fox and Kapoor, AIAA Journal 6 (1968), equation 5.
    """
    stiffness, mass = (np.einsum("ij,ij->j", shapes, np.asarray(A @ shapes)) for A in (dK, dM))
    return np.asarray((stiffness - omega2 * mass) / (2.0 * omega2))
