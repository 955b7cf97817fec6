"""The band in which a run's sound can be believed: modes kept, mesh, step in contact."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from creak.arrays import BoolArray, FloatArray
from creak.elements.shells.rigidity import areal_mass, bending_stiffness
from creak.model.dofs import nodes_of
from creak.model.faces import SHELL_FACETS
from creak.model.materials import GeneralShell, ShellSection
from creak.model.mesh import Model
from creak.model.skin import Skin
from creak.sound.forced import LOWEST
from creak.sound.rayleigh import AIR, HIGHEST
from creak.sound.room import Room
from creak.sound.zwicker_tables import RATE
from creak.studies.models.reduced import ReducedModel
from creak.studies.run.integrate import shortest_step
from creak.studies.run.one_run import Run
from creak.studies.sound.radiation import compact_bodies

PER_MODE = 2.0
"""First mode left out over the end of the band."""
PER_WAVE = 6.0
"""Elements per wavelength, of bending and in air."""
COARSE = 0.1
"""Share of the radiating area that may have longer elements."""
PER_PERIOD = 10.0
"""Steps in contact per period."""


@dataclass(frozen=True)
class Band:
    """Hz; inf where nothing of the kind limits it."""

    modes: float
    mesh: float
    step: float
    beyond: float = 0.0
    """Up to which the unreduced model tells what the modes do not; 0: it was not asked."""
    statistics: float = 0.0
    """Up to which statistical energy goes on from where all these end; 0: it does not."""

    @property
    def low(self) -> float:
        """Where hearing begins."""
        return LOWEST

    @property
    def high(self) -> float:
        """Where it ends."""
        return max(self.computed, self.statistics)

    @property
    def limit(self) -> str:
        """What ends it."""
        if self.statistics <= self.computed:
            return self.computed_limit
        return "step" if self.statistics >= self.step else "statistics"

    @property
    def computed(self) -> float:
        """Up to which each wave is computed, by modes and the unreduced model."""
        return min(self._limits.values())

    @property
    def computed_limit(self) -> str:
        """What ends that."""
        limits = self._limits
        return min(limits, key=lambda name: limits[name])

    @property
    def handover(self) -> float | None:
        """Hz where the modes end and the unreduced model goes on; None: it does not."""
        return self.modes if self.beyond > self.modes else None

    @property
    def _limits(self) -> dict[str, float]:
        own = {"mesh": self.mesh, "step": self.step, "rate": HIGHEST * RATE}
        return {**own, "modes": self.modes} if self.handover is None else {**own, "unreduced": self.beyond}


@dataclass(frozen=True, kw_only=True)
class SoundBase:
    """What is heard of one run, whatever is kept of it."""

    run: str
    band: Band
    """What is in it."""
    full_scale: float
    """Pa of full scale in every file made of it."""
    wall_s: float
    cpu_s: float
    """Without what is made once for a model and its listeners."""
    offline_cpu_s: float
    """That: rows of parts and listeners."""
    room: Room | None = None
    """Around the listeners; None: none is known."""


def band_of(
    model: Model, reduced: ReducedModel, f_max: float, run: Run, skin: Skin, sounding: BoolArray, metre: float
) -> Band:
    """The band of a reduced run. Only facets that are `sounding`, and their parts, end it; all if none are.

    * modes: the first fixed-interface mode left out (f_max where the assembly was reduced as a whole) over 2: free
      modes of a part are some 2 % high there at worst;
    * mesh: six elements per wavelength of bending in shells, 2 pi (D / m)^(1/4) / sqrt(omega), and of sound in air, but
      for a tenth of the area; a compact body needs no mesh;
    * step: ten steps in contact per period.
    """
    sounding = sounding if sounding.any() else ~sounding
    still = skin.nodes_idx[~sounding]
    heard = [r for r in reduced.superelements if not np.isin(nodes_of(r.substructure.part.labels), still).any()]
    first = min((r.system.stats.first_left_out for r in heard or reduced.superelements), default=f_max)
    if not math.isfinite(first):  # not looked for, or every mode kept
        first = f_max if reduced.modes else 0.0
    step = shortest_step(run.history)
    mesh = mesh_band(model, skin.select(sounding), metre)
    return Band(first / PER_MODE, mesh, 1.0 / (PER_PERIOD * step) if step > 0.0 else math.inf)


def finer_mesh(model: Model, skin: Skin, metre: float, high: float) -> float:
    """How many times shorter elements must be for a band that ends at `high`, Hz; 1 where they are short enough."""
    if not skin.count:
        return 1.0
    bending, air = _limits(model, skin, metre)
    # Bending waves shorten with the square root of the frequency, those in air with it.
    return max(1.0, -_but_coarse(skin, -np.maximum(np.sqrt(high / bending), high / air)))


def mesh_band(model: Model, skin: Skin, metre: float) -> float:
    """Hz up to which the elements are short enough."""
    if not skin.count:
        return math.inf
    bending, air = _limits(model, skin, metre)
    return _but_coarse(skin, np.minimum(bending, air))


def _limits(model: Model, skin: Skin, metre: float) -> tuple[FloatArray, FloatArray]:
    """(n_facet,) Hz up to which each facet is short enough for bending waves, and for sound in air."""
    size = skin.size
    stiffness = np.full(model.nodes.count, np.inf)
    for block in model.blocks:
        section = block.section
        if block.kind in SHELL_FACETS and isinstance(section, ShellSection | GeneralShell):
            # The slowest bending wave of the shells around each node.
            np.minimum.at(stiffness, block.nodes_idx.ravel(), _bending(section))
    waves = np.where(skin.solid, np.inf, stiffness[skin.nodes_idx].min(axis=1))
    air = AIR.speed / (PER_WAVE * metre * size)
    for body in compact_bodies(skin, metre):
        air = np.where(skin.part == body.part, np.maximum(air, body.highest), air)
    return np.sqrt(waves) * 2.0 * math.pi / (PER_WAVE * size) ** 2, air


def _but_coarse(skin: Skin, figure: FloatArray) -> float:
    """The least of a figure of the facets, but for `COARSE` of the area."""
    order, area = np.argsort(figure), np.linalg.norm(skin.areas, axis=1)
    passed = np.searchsorted(np.cumsum(area[order]), COARSE * area.sum())
    return float(figure[order[min(int(passed), order.size - 1)]])


def _bending(section: ShellSection | GeneralShell) -> float:
    """D / m, the smaller of both directions, length^4 / time^2."""
    mass, stiffness = float(areal_mass(section)[0]), min(bending_stiffness(section))
    return stiffness / mass if mass > 0.0 else math.inf
