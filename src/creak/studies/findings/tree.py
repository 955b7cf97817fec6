"""What a study found, as one tree of records: summary.json, results.h5, tables and pages are views of it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np

from creak.arrays import FloatArray, IntArray, SingleArray
from creak.assembly.part import Rayleigh
from creak.dynamics.history import History
from creak.model.mesh import Unread
from creak.model.plain_mesh import PlainMesh
from creak.reduction.health import Health
from creak.studies.converge.settled import Verdict
from creak.studies.converge.settling import Convergence
from creak.studies.file.config import StudyConfig
from creak.studies.findings.beside_records import RecordFits
from creak.studies.findings.places import Place
from creak.studies.models.frfs import FrfFit
from creak.studies.models.reduced import Stage
from creak.studies.run.compared import ResultBase, RunBase
from creak.studies.sound.band import SoundBase
from creak.studies.sound.loud import Heard
from creak.verify.mode_fit import ModeFit


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
    changes: dict[str, Any]
    """Dotted key -> value of each change that was made of the file."""


@dataclass(frozen=True)
class FoundPart:
    """A part as it was assembled."""

    name: str
    nodes: int
    elements: int
    mass: float


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
    parts: tuple[FoundPart, ...]
    """Of the unreduced model."""
    free_dof: int
    mass: float
    unread: tuple[Unread, ...]
    """Keywords of the deck that were not used."""

    @property
    def dof(self) -> int:
        """Six of each node that a part or an element has."""
        of_parts, of_blocks = (p.nodes_idx for p in self.model.parts), (b.nodes_idx.ravel() for b in self.model.blocks)
        return 6 * int(np.unique(np.concatenate([*of_parts, *of_blocks])).size)


@dataclass(frozen=True)
class FoundRun(RunBase):
    """One time integration at all its instants, gaps as the smallest of each contact."""

    dof: int
    time: FloatArray
    """(n_time,)"""
    force: FloatArray
    """(n_time, m)"""
    energy: FloatArray
    """(n_time, len(ENERGIES))"""
    energy_created_of_contact: float
    """Share of what contact took up (`verify.reliability`)."""
    closest: SingleArray
    """(n_time, n_contact) smallest gap of each contact or connector, in the order of `Findings.contacts`; 7 digits."""
    nearest: tuple[str, float, float] | None
    """Channel, time and gap of the closest approach; None without channels."""
    resting_channels: int
    """Channels that press from beginning to end."""
    contact_steps: int
    setup_s: float
    residual: float
    places: tuple[Place, ...]
    """Where it rattles or squeaks, the loudest first; where it was not heard, the hardest hit first."""
    resting: tuple[Place, ...]
    """Patches that press all the time."""
    verdict: Verdict | None
    """None: nothing judged it."""
    causes: tuple[dict[str, Any] | None, ...] = ()
    """Of each place, where they were looked for (`creak.studies.cause.effects`)."""

    @cached_property
    def history(self) -> History:
        """Forces and energy of the run; it holds neither gaps nor motion."""
        none = np.zeros((0, 0))
        return History(
            time=self.time,
            gap=none,
            force=self.force,
            slip=none,
            output_index=np.zeros(0, dtype=np.int64),
            displacement=none,
            energy=self.energy,
            contact_steps=self.contact_steps,
            setup_s=self.setup_s,
            residual=self.residual,
        )


@dataclass(frozen=True)
class FoundBand:
    """Up to which frequency there are modes, and how that was found."""

    f_max: float
    """Hz"""
    stages: tuple[Stage, ...] = ()
    """All models that were run; none where f_max was given."""
    why: str = ""
    """Why no further stage was made although more modes change the answer."""


@dataclass(frozen=True)
class FoundListener:
    """Who hears the contact, and what."""

    name: str
    position: tuple[float, ...]
    """x, y, z in the deck's axes, length."""
    given: bool
    """By the study."""
    parts: tuple[str, ...]
    """That it hears."""
    compact: tuple[str, ...]
    """Of those the ones that it hears as compact bodies at frequencies at which they are."""
    heard: tuple[Heard, ...]
    """Place by place of the run that was heard, last all contact together."""
    faces: tuple[float, ...] = ()
    """Direction in which its head looks; empty: it is a point in the air."""
    ear: str = ""
    """Of its ears the one that is told, "left" or "right": it hears all contact louder."""
    background: FloatArray | None = None
    """(28,) dB re 20 uPa of the third octaves that it hears besides; None: nothing."""


@dataclass(frozen=True)
class FoundSound(SoundBase):
    """What is heard of one run."""

    listeners: tuple[FoundListener, ...]
    pressure: SingleArray
    """(n_place + 1, n) Pa at the first listener from t = 0, in the order of the places; last all contact together."""
    power: dict[str, float]
    """Part -> dB re 1 pW of its mean equivalent radiated power over the window, loudest first."""


@dataclass(frozen=True)
class FoundTest:
    """What was measured over what was computed; None where the file has nothing of the kind."""

    name: str
    file: str
    modes: ModeFit | None
    frfs: FrfFit | None
    records: RecordFits | None


@dataclass(frozen=True)
class MeasuredRate:
    """What was measured of the materials of a contact that rubs."""

    material: str | None
    impulses: tuple[float, float] | None
    """Fewest and most per length of travel; None: nobody did."""


@dataclass(frozen=True)
class Note:
    """What the user should know of the answer."""

    text: str
    warns: bool
    """The user should act on it."""


@dataclass(frozen=True)
class Findings(ResultBase[FoundRun]):
    """Everything that a study found."""

    creak: str
    """The version that found it."""
    setup: FoundSetup
    gaps: Channels
    """Channels that were kept, contacts first, connectors after."""
    static: dict[str, Any] | None
    """What the runs start from; None: from rest without loads."""
    band: FoundBand | None
    """Of the reduced run; None: nothing was reduced by modes up to a frequency."""
    linear_gaps: FloatArray | None
    """(m,) smallest gap of each channel of the contacts in the pre-check, taken on to where its motion repeats; None:
    there was none."""
    measured_rates: dict[str, MeasuredRate]
    """Contact -> what was measured of its materials."""
    sound: FoundSound | None
    silence: str | None
    """Why there is no sound; None: there is, or nobody asked."""
    health: dict[str, Health]
    """Of each superelement, by name."""
    convergence: Convergence | None
    """What repeated runs and the unreduced model say; None: nobody asked."""
    tests: tuple[FoundTest, ...]
    """Measurements beside the run."""
    said: tuple[Note, ...]
    unanswered: str | None
    """Why the runs say nothing of rattle; None: they do."""
    other_units: str | None
    """Why figures are not in the units that they are labelled with; None: nothing says so."""
    provenance: tuple[tuple[str, str], ...]
    """Name and value: files with their digests, versions, machine."""

    @property
    def contacts(self) -> tuple[str, ...]:
        """Contacts and connectors that have a channel."""
        return tuple(dict.fromkeys(self.gaps.group))

    @property
    def places(self) -> tuple[Place, ...]:
        """Those of the main run."""
        return () if self.main is None else self.main.places

    @property
    def alarms(self) -> tuple[str, ...]:
        """What the user should act on, each once."""
        return tuple(dict.fromkeys(n.text for n in self.said if n.warns))

    @property
    def notes(self) -> tuple[str, ...]:
        """What else should be known."""
        return tuple(n.text for n in self.said if not n.warns)

    def heard(self, run: str) -> Mapping[int, Heard]:
        """Number of a place of a run -> its sound at the first listener; empty: it was not heard."""
        if self.sound is None or self.sound.run != run:
            return {}
        return dict(enumerate(self.sound.listeners[0].heard[:-1], start=1))
