"""The histories of a run as results.h5 stores them, and what its places do in other runs of the model."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from creak.arrays import FloatArray
from creak.assembly.system import System, by_node, recovered
from creak.contact.gap_operator import GapOperator
from creak.dynamics.flow.march import flows
from creak.dynamics.history import ENERGIES, History
from creak.formats.stored.results import ContactRecord, Field, LineRecord, RunRecord
from creak.model.mesh import Nodes
from creak.signals.spectra import cell_means, cell_peaks
from creak.studies.converge.settling import Followed
from creak.studies.findings.places import Place, channels_at, events_at, resting_places
from creak.studies.findings.sound import heard_places
from creak.studies.prepare.marching import Marching, Scope
from creak.studies.prepare.reduction import Watch
from creak.studies.run.one_run import Run
from creak.studies.sound.ear import Ear, n5_of
from creak.studies.sound.heard import Sound, n5_of_less, share_apart
from creak.studies.sound.notes import WHAT
from creak.verify.matching import OF_PLACE
from creak.verify.peaks import peak_forces
from creak.verify.rubbing import Rub, rub_of

UNASKED = 32_000_000
"""Bytes that the motion of all nodes may take where the study does not ask for it; fewer instants then."""
MARGIN = 4
"""Instants before and after a touch that are stored with it."""
MOST_PLACES = 12
"""Places, the first ones, that are followed."""


def record_of(run: Run, nodes: Nodes, watch: Watch, marching: Marching) -> RunRecord:
    """What is stored of a run: most of it at its output times."""
    h, gaps, watched = run.history, run.gaps, watch.nodes
    at, friction = h.output_index, gaps.friction
    rubbing = np.zeros(0, dtype=np.int64) if friction is None else friction.channels
    touched = np.flatnonzero((h.force > 0.0).any(axis=0))
    # Instants at which anything presses, and `MARGIN` before and after.
    pressed = np.asarray((h.force > 0.0).any(axis=1))
    near = np.convolve(pressed, np.ones(2 * MARGIN + 1), mode="full")[MARGIN : MARGIN + pressed.size] > 0.5
    return RunRecord(
        time=h.time[at],
        gap=h.gap[at],
        normal_force=cell_means(h.time, h.force, h.time[at]),
        peak_force=cell_peaks(h.time, peak_forces(h, gaps), h.time[at]),
        slip=h.slip,
        friction_force=_means(h, h.tangential),
        slip_speed=_means(h, h.sliding),
        contact=ContactRecord(np.flatnonzero(near), h.time, touched, h.gap, h.force, rubbing, h.tangential, h.sliding),
        displacement=h.displacement.reshape(at.size, watched.size, 6),
        node_ids=nodes.ids[watched].astype(np.int64),
        node_names=[nodes.label(int(i)) for i in watched],
        channels=gaps.names,
        channel_nodes=nodes.ids[gaps.nodes_idx].astype(np.int64),
        energy=h.energy[at],
        energy_terms=ENERGIES,
        field=_field(run, nodes, marching),
        elines=_lines(run, watch.lines.points, nodes),
    )


def _lines(run: Run, points: GapOperator, nodes: Nodes) -> LineRecord | None:
    moved = run.line_motion
    if moved is None:
        return None
    return LineRecord(moved.time, moved.motion, points.names, nodes.ids[points.nodes_idx].astype(np.int64))


def _means(h: History, x: FloatArray) -> FloatArray:
    """Means over the output intervals of what only rubbing channels have."""
    return cell_means(h.time, x, h.time[h.output_index]) if x.size else np.zeros((h.output_index.size, 0))


def _field(run: Run, nodes: Nodes, marching: Marching) -> Field | None:
    """The motion of all nodes as the study asks for it; where it does not, around the hardest event."""
    h = run.history
    if h.whole_at.size:
        time, q = marching.ends[h.whole_at], h.coordinates
        s = marching.loads.support[0, marching.table.substeps * h.whole_at].T
    elif run.recording is not None and run.recording.motions:
        m = run.recording.motions[0]
        every = max(1, -(-m.time.size * 24 * nodes.count // UNASKED))
        time, q, s = m.time[::every], m.coordinates[:, ::every], m.supports[:, ::every]
    else:
        return None
    labels = run.system.labels
    blocks = ((here, by_node(u, labels, nodes.count)) for here, u in recovered(run.system, q, s))
    return Field(time, blocks, nodes.ids.astype(np.int64), nodes.coords)


@dataclass(frozen=True)
class _Places:
    """The places of the base run that are looked for in the repeated ones."""

    places: tuple[Place, ...]
    scope: Scope
    ear: Ear | None
    """Who hears them; None: there is no sound."""
    rub: tuple[Place, ...]
    """All places, and those that rest."""

    def figures(self, system: System, gaps: GapOperator, history: History) -> tuple[dict[str, float], ...]:
        """`OF_PLACE` of each place in a run; no N5 where there is no sound, or beyond what ISO 532-1 covers."""
        if not self.places:
            return ()
        groups = channels_at(self.places, self.scope.model, gaps, history)
        events = events_at(groups, self.scope, gaps, history)
        here = [replace(p, events=tuple(own)) for p, own in zip(self.places, events, strict=True)]
        heard: Sequence[float | None] = [None] * len(here)
        if self.ear is not None and flows(system):
            *heard, _ = n5_of(self.scope.window, system, gaps, history, groups, self.ear)
        return tuple(map(_figures, here, heard))

    def rubs(self, gaps: GapOperator, history: History) -> tuple[Rub, ...]:
        """Friction and lasting contact of each place in a run."""
        window, f_max = self.scope.window, self.scope.verification.f_max
        groups = channels_at(self.rub, self.scope.model, gaps, history)
        return tuple(rub_of(history, gaps, channels, window, f_max) for channels in groups)


def followed(scope: Scope, run: Run | None, sound: Sound | str | None) -> Followed:
    """The first places of the run that is repeated, ranked as they are told."""
    if run is None:
        return Followed()
    every = heard_places(scope, run, sound)
    places, rub = every[:MOST_PLACES], (*every, *resting_places(scope, run))
    ear, heard = None, list[float | None]([None] * len(places))
    band: tuple[float, ...] = ()
    ways: tuple[float, ...] = ()
    scatter: tuple[float, ...] = ()
    ends: tuple[float, str] | None = None
    if isinstance(sound, Sound) and sound.run == run.name:
        ear, heard = sound.ear, [h.rank[0] for h in sound.heard[0]]
        less = n5_of_less(sound, scope.window)[: len(places)]
        band = tuple(share_apart(a, b) for a, b in zip(heard, less, strict=False))
        ways, scatter = sound.ways[: len(places)], sound.scatter[: len(places)]
        ends = sound.band.high, WHAT[sound.band.limit]
    base = tuple(_figures(p, n5) for p, n5 in zip(places, heard, strict=False))
    here = _Places(places, scope, ear, rub)
    names, rubs = tuple((p.contact, p.number) for p in rub), tuple(p.rub for p in rub)
    impulses = tuple(tuple(e.impulse for e in p.events) for p in every)
    return Followed(
        base=base,
        of=here.figures,
        impulses=impulses,
        band=band,
        ways=ways,
        scatter=scatter,
        band_ends=ends,
        rub_names=names,
        rubs=rubs,
        rubs_of=here.rubs,
    )


def _figures(place: Place, n5: float | None) -> dict[str, float]:
    every = (float(len(place.events)), place.impulse, place.force, place.speed, n5)
    return {name: x for name, x in zip(OF_PLACE, every, strict=True) if x is not None and np.isfinite(x)}
