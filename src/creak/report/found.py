"""What the report shows of a study: a read-only view, made from a result or read back from results.h5."""

from __future__ import annotations

import platform
from dataclasses import dataclass
from functools import cached_property
from importlib.metadata import PackageNotFoundError
from importlib.metadata import version as installed
from pathlib import Path

import numpy as np

from creak.arrays import FloatArray, IntArray, SingleArray
from creak.assembly.part import Rayleigh
from creak.contact.gap_operator import GapOperator
from creak.digest import file_sha256
from creak.dynamics.history import History
from creak.model.dofs import nodes_of
from creak.model.plain_mesh import PlainMesh, plain_mesh
from creak.reduction.health import health_rows
from creak.report.figures.motions import ModeShapes, Motions, mode_shapes, recorded_motions
from creak.report.figures.surface import Surface, surface_of
from creak.report.words.text import number
from creak.sound.zwicker_tables import RATE
from creak.studies.converge.settling import Convergence
from creak.studies.file.config import StudyConfig
from creak.studies.prepare.setup import Setup
from creak.studies.results.places import Place
from creak.studies.results.sound import heard_places
from creak.studies.run.agreement import ModeComparison, SpectraComparison
from creak.studies.run.compared import main_run
from creak.studies.run.elines import LineFindings
from creak.studies.run.job import StudyResult
from creak.studies.run.one_run import Run
from creak.studies.sound.heard import Sound
from creak.studies.warned import plain_notes, warnings_of
from creak.verify.events import Event
from creak.verify.matching import EventMatch
from creak.verify.slips import SlipEvent, Squeak
from creak.version import version

ANIMATION_BYTES = 12_000_000
"""What the motion around events may take of a report."""
PACKAGES = ("numpy", "scipy", "numba", "pypardiso", "h5py", "plotly")


@dataclass(frozen=True)
class Channels:
    """Gap channels without their matrices."""

    names: tuple[str, ...]
    group: tuple[str, ...]
    """(m,) the contact or connector that each channel belongs to."""
    nodes_idx: IntArray
    """(m,) node row of the secondary node."""
    gap0: FloatArray
    """(m,) initial clearance, length."""
    stiffness: FloatArray
    """(m,) force / length; inf: no penetration at all."""
    retained_nodes: IntArray
    """Node rows of both sides."""
    rubs: bool
    """Any channel has friction."""

    @property
    def m(self) -> int:
        return int(self.gap0.size)


@dataclass(frozen=True)
class FoundStudy:
    """The study file."""

    path: Path
    """Its name."""
    config: StudyConfig
    text: str


@dataclass(frozen=True)
class FoundSetup:
    """The study, its model, and where that is held, driven and watched."""

    study: FoundStudy
    model: PlainMesh
    rayleigh: Rayleigh
    contacts: Channels
    """Before the pre-check."""
    connectors: Channels
    pairs: IntArray
    """(n_pair, 2) node rows: main, secondary."""
    held: IntArray
    """Node rows."""
    driven: IntArray
    """Node rows."""


@dataclass(frozen=True)
class FoundRun:
    """One time integration at all its instants, gaps as the smallest of each contact."""

    name: str
    time: FloatArray
    """(n_time,)"""
    force: FloatArray
    """(n_time, m)"""
    energy: FloatArray
    """(n_time, len(ENERGIES))"""
    closest: SingleArray
    """(n_time, n_contact) smallest gap of each contact or connector, in the order of `Found.contacts`; 7 digits."""
    nearest: tuple[str, float, float] | None
    """Channel, time and gap of the closest approach; None without channels."""
    contact_steps: int
    setup_s: float
    residual: float
    events: list[Event]
    slips: tuple[SlipEvent, ...]
    squeaks: tuple[Squeak, ...]

    @cached_property
    def history(self) -> History:
        """Forces and energy of the run; it holds neither gaps nor motion."""
        none = np.zeros((0, 0))
        return History(
            self.time,
            none,
            self.force,
            none,
            np.zeros(0, dtype=np.int64),
            none,
            self.energy,
            self.contact_steps,
            self.setup_s,
            residual=self.residual,
        )


@dataclass(frozen=True)
class FoundSound:
    """Pressure at the first listener."""

    listener: str
    rate: float
    """Hz"""
    band: FloatArray
    """(2,) Hz, what is in it."""
    pressure: SingleArray
    """(n_place + 1, n) Pa from t = 0, in the order of the places; last all contact together."""


@dataclass(frozen=True)
class Found:
    """Everything that the report shows, besides summary.json."""

    setup: FoundSetup
    gaps: Channels
    """Channels that were kept, contacts first, connectors after."""
    runs: dict[str, FoundRun]
    linear_gaps: FloatArray | None
    """(m,) smallest gap of each channel of the contacts in the pre-check; None: there was none."""
    modes: ModeComparison | None
    spectra: SpectraComparison | None
    events: EventMatch | None
    places: tuple[Place, ...]
    surface: Surface | None
    """What is drawn of the model; None: nothing can be."""
    motions: Motions
    window: tuple[float, float]
    alarms: tuple[str, ...]
    """What the user should act on."""
    notes: tuple[str, ...]
    health: dict[str, list[tuple[str, str, str]]]
    """Of each superelement: label, value, remark."""
    convergence: Convergence | None
    provenance: tuple[tuple[str, str], ...]
    stopped: str | None = None
    elines: LineFindings | None = None
    """E-lines in the main run and without contact; None: there are none."""
    sound: FoundSound | None = None
    """What is heard; None: nothing was."""
    mode_shapes: ModeShapes | None = None
    """Of the unreduced model; None: there are none to draw."""

    @property
    def contacts(self) -> tuple[str, ...]:
        """Contacts and connectors that have a channel."""
        return tuple(dict.fromkeys(self.gaps.group))


def found_of(
    result: StudyResult,
    convergence: Convergence | None = None,
    animation_bytes: int = ANIMATION_BYTES,
    sound: Sound | str | None = None,
) -> Found:
    """The view of a result; large arrays are those of the result, not copies.

    Parameters
    ----------
    convergence : what `creak.studies.converge.repeats` found, where it was looked at.
    animation_bytes : what the motion around the hardest events may take of the report.
    sound : of `creak.studies.sound.heard`: places are ranked by it.
    """
    run = main_run(result.runs)
    places = heard_places(result, run, sound)
    setup = _setup(result.setup)
    surface = _surface(setup, result.gaps, places)
    return Found(
        setup,
        _channels(result.gaps),
        {name: _run(r, result.gaps) for name, r in result.runs.items()},
        result.reference.linear_gaps,
        result.modes,
        result.spectra,
        result.events,
        places,
        surface,
        recorded_motions(run, setup.model.nodes.count, surface, animation_bytes),
        result.window,
        tuple(warnings_of(result.notes)),
        tuple(plain_notes(result.notes)),
        {name: health_rows(health) for name, health in result.health.items()},
        convergence,
        tuple(provenance(result)),
        result.stopped,
        result.elines,
        _sound(sound),
        mode_shapes(result.reference.system, result.reference.modes, setup.model.nodes.count, surface)
        if animation_bytes > 0
        else None,
    )


def _sound(sound: Sound | str | None) -> FoundSound | None:
    if not isinstance(sound, Sound):
        return None
    band = np.array([sound.band.low, sound.band.high])
    return FoundSound(sound.listeners[0].name, float(RATE), band, sound.pressure[0])


def _setup(setup: Setup) -> FoundSetup:
    study = setup.study
    moved = [*setup.driven.labels.values(), *setup.loads.force_labels]
    return FoundSetup(
        FoundStudy(Path(study.path.name), study.config, study.text),
        plain_mesh(setup.model),
        setup.rayleigh,
        _channels(setup.contacts),
        _channels(setup.connectors),
        setup.pairs,
        _nodes([f.nodes_idx for f in setup.model.fixed]),
        _nodes([nodes_of(a) for a in moved]),
    )


def _channels(gaps: GapOperator) -> Channels:
    return Channels(
        gaps.names,
        gaps.group,
        gaps.nodes_idx,
        gaps.gap0,
        gaps.stiffness,
        gaps.retained_nodes,
        gaps.friction is not None,
    )


def _run(run: Run, gaps: GapOperator) -> FoundRun:
    h = run.history
    nearest = None
    if h.gap.size:
        row, j = np.unravel_index(int(h.gap.argmin()), h.gap.shape)
        nearest = (gaps.names[int(j)], float(h.time[row]), float(h.gap[row, j]))
    return FoundRun(
        run.name,
        h.time,
        h.force,
        h.energy,
        _closest(h, gaps),
        nearest,
        h.contact_steps,
        h.setup_s,
        h.residual,
        run.events,
        run.slips,
        run.squeaks,
    )


def _closest(h: History, gaps: GapOperator) -> SingleArray:
    """(n_time, n_contact) smallest gap of each contact, in single precision."""
    row = {group: k for k, group in enumerate(dict.fromkeys(gaps.group))}
    closest = np.full((h.time.size, len(row)), np.inf)
    for j, group in enumerate(gaps.group):
        np.minimum(closest[:, row[group]], h.gap[:, j], out=closest[:, row[group]])
    return closest.astype(np.float32)


def _surface(setup: FoundSetup, gaps: GapOperator, places: tuple[Place, ...]) -> Surface | None:
    """What is drawn of the model, with all marks; None where that has no extent."""
    needed = _nodes([gaps.nodes_idx, setup.held, setup.driven, *(p.nodes_idx for p in places)])
    surface = surface_of(setup.model, needed)
    if surface is None or float(np.ptp(setup.model.nodes.coords[surface.nodes_idx], axis=0).max()) == 0.0:
        return None
    return surface


def _nodes(rows: list[IntArray]) -> IntArray:
    return np.unique(np.concatenate([np.zeros(0, dtype=np.int64), *rows]))


def provenance(result: StudyResult) -> list[tuple[str, str]]:
    """Name and value, for a table: files with their digests, versions, machine."""
    study = result.setup.study
    source = Path(result.setup.model.source)
    deck = study.places.sibling(study.config.model.deck)
    rows = [("Run", result.identity.id), ("Study file", f"{study.path.name}, SHA-256 {result.identity.study_sha256}")]
    for path in dict.fromkeys((deck, source)):
        if path.is_file():
            rows.append(("Deck", f"{path.name}, {number(path.stat().st_size)} bytes, SHA-256 {file_sha256(path)}"))
            break
    rows.append(("creak", version()))
    rows.append(("Python and packages", f"Python {platform.python_version()}; {_versions()}"))
    return [*rows, ("Machine", f"{platform.system()}, {platform.machine()}")]


def _versions() -> str:
    words = []
    for name in PACKAGES:
        try:
            words.append(f"{name} {installed(name)}")
        except PackageNotFoundError:
            continue
    return ", ".join(words)
