"""From what a study ran to what it found: models and matrices stay behind."""

from __future__ import annotations

import platform
from collections.abc import Mapping, Sequence
from importlib.metadata import PackageNotFoundError
from importlib.metadata import version as installed
from pathlib import Path
from typing import Any

import numpy as np

from creak.arrays import FloatArray, IntArray, SingleArray
from creak.contact.gap_operator import GapOperator
from creak.digest import file_sha256
from creak.dynamics.history import History
from creak.formats.stored.run_identity import RunIdentity
from creak.model.dofs import dofs_of, node_dofs, nodes_of
from creak.model.mesh import Nodes
from creak.model.plain_mesh import plain_mesh
from creak.model.units import UNITS
from creak.studies.converge.settled import Verdict, verdict_of
from creak.studies.converge.settling import Convergence
from creak.studies.findings.elines import measured_rates
from creak.studies.findings.places import resting_places
from creak.studies.findings.sound import heard_places
from creak.studies.findings.tree import (
    Channels,
    Findings,
    FoundBand,
    FoundListener,
    FoundPart,
    FoundRun,
    FoundSetup,
    FoundSound,
    FoundStudy,
    FoundTest,
    MeasuredRate,
    Note,
)
from creak.studies.prepare.marching import Scope
from creak.studies.prepare.static_loads import StaticStart, static_gravity
from creak.studies.prepare.unit_check import other_units
from creak.studies.run.compared import ResultBase, RunBase, of_base
from creak.studies.run.job import StudyResult
from creak.studies.run.one_run import Run
from creak.studies.sound.band import SoundBase
from creak.studies.sound.heard import Sound
from creak.studies.warned import Warned
from creak.verify.events import resting
from creak.verify.reliability import created_of_contact
from creak.version import version

PACKAGES = ("numpy", "scipy", "numba", "pypardiso", "h5py", "plotly")
AXES = ("x", "y", "z", "rx", "ry", "rz")


def findings_of(
    result: StudyResult,
    convergence: Convergence | None = None,
    sound: Sound | str | None = None,
    causes: Mapping[int, dict[str, Any]] | None = None,
    tests: tuple[FoundTest, ...] = (),
) -> Findings:
    """What a study found; large arrays are those of the result, not copies.

    Parameters
    ----------
    convergence : of `creak.studies.converge.repeats`, where it was looked at.
    sound : of `creak.studies.sound.heard`, or why there is none; None: it was not asked for. Places are ranked by it.
    causes : of each place of the main run, by its number (`creak.studies.cause.effects`).
    tests : measurements beside it (`creak.studies.findings.measured`).
    """
    s, main, unanswered = result.setup, result.main, result.unanswered
    study, model, c = s.study, s.model, s.study.config
    stages = ((), "") if result.band is None else (result.band.stages, result.band.why)
    with_modes = "reduced" in result.runs and c.reduction.method != "guyan"

    def verdict(run: Run) -> Verdict | None:
        return verdict_of(run, s.study.course, unanswered, convergence, UNITS[c.model.units].length, stages[1])

    static, groups = None, [*s.contacts.group, *s.connectors.group]
    if s.static is not None:
        gravity = static_gravity(model, study.driving)
        static = static_figures(s.static, model.nodes, s.watch.nodes, groups, gravity)
    moved = [*s.structure.driven.labels.values(), *s.loads.force_labels]
    setup = FoundSetup(
        study=FoundStudy(Path(study.path.name), c, study.text, dict(study.places.changes)),
        model=plain_mesh(model),
        rayleigh=s.structure.rayleigh,
        contacts=_channels(s.contacts),
        connectors=_channels(s.connectors),
        pairs=s.watch.pairs,
        held=_nodes([f.nodes_idx for f in model.fixed]),
        driven=_nodes([nodes_of(a) for a in moved]),
        parts=tuple(
            FoundPart(p.name, int(part.nodes_idx.size), p.stats.elements, p.stats.mass)
            for p, part in zip(result.reference.parts, model.parts, strict=False)
        ),
        free_dof=result.reference.free_dof,
        mass=result.reference.system.stats.mass,
        unread=model.unread,
    )
    runs = {
        name: _run(run, result.scope, verdict(run), sound, (causes or {}) if run is main else None)
        for name, run in result.runs.items()
    }
    return Findings(
        **of_base(ResultBase, result) | {"runs": runs},
        creak=version(),
        setup=setup,
        gaps=_channels(result.gaps),
        static=static,
        band=FoundBand(s.band.f_max, *stages) if with_modes else None,
        linear_gaps=result.reference.linear_gaps,
        measured_rates={
            line.name: MeasuredRate(line.material, measured_rates(line, c.model.units))
            for line in s.watch.lines.lines
            if line.contact
        },
        sound=_sound(sound) if isinstance(sound, Sound) else None,
        silence=sound if isinstance(sound, str) else None,
        health=result.health,
        convergence=convergence,
        tests=tests,
        said=tuple(Note(str(text), isinstance(text, Warned)) for text in result.notes),
        unanswered=unanswered,
        other_units=other_units(model, c.model.units),
        provenance=tuple(_provenance(study.path, (study.places.sibling(c.model.deck), model.source), result.identity)),
    )


def _nodes(rows: list[IntArray]) -> IntArray:
    return np.unique(np.concatenate([np.zeros(0, dtype=np.int64), *rows]))


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


def _run(
    run: Run,
    scope: Scope,
    verdict: Verdict | None,
    sound: Sound | str | None,
    causes: Mapping[int, dict[str, Any]] | None,
) -> FoundRun:
    h, places, nearest = run.history, heard_places(scope, run, sound), None
    if h.gap.size:
        row, j = np.unravel_index(int(h.gap.argmin()), h.gap.shape)
        nearest = (run.gaps.names[int(j)], float(h.time[row]), float(h.gap[row, j]))
    return FoundRun(
        **of_base(RunBase, run),
        dof=run.system.n,
        time=h.time,
        force=h.force,
        energy=h.energy,
        energy_created_of_contact=created_of_contact(h),
        closest=_closest(h, run.gaps),
        nearest=nearest,
        resting_channels=int(resting(h).sum()),
        contact_steps=h.contact_steps,
        setup_s=h.setup_s,
        residual=h.residual,
        places=places,
        resting=resting_places(scope, run),
        verdict=verdict,
        causes=() if causes is None else tuple(causes.get(p.number) for p in places),
    )


def _closest(h: History, gaps: GapOperator) -> SingleArray:
    """(n_time, n_contact) smallest gap of each contact, in single precision."""
    row = {group: k for k, group in enumerate(dict.fromkeys(gaps.group))}
    closest = np.full((h.time.size, len(row)), np.inf)
    for j, group in enumerate(gaps.group):
        np.minimum(closest[:, row[group]], h.gap[:, j], out=closest[:, row[group]])
    return closest.astype(np.float32)


def _sound(sound: Sound) -> FoundSound:
    every = zip(sound.listeners, sound.compact, sound.heard, sound.backgrounds, strict=True)
    return FoundSound(
        **of_base(SoundBase, sound),
        listeners=tuple(
            FoundListener(
                name=x.name,
                position=tuple(x.position.tolist()),
                given=x.given,
                parts=x.parts,
                compact=compact,
                heard=heard,
                faces=() if x.looks is None else tuple(x.looks.tolist()),
                ear=x.ear,
                background=background,
            )
            for x, compact, heard, background in every
        ),
        pressure=sound.pressure[0],
        power=dict(sound.equivalent_power),
    )


def _provenance(study: Path, decks: Sequence[str | Path], identity: RunIdentity) -> list[tuple[str, str]]:
    """Name and value, for a table: files and their digests (of the decks the first there is), versions, machine."""
    rows = [("Run", identity.id), ("Study file", f"{study.name}, SHA-256 {identity.study_sha256}")]
    for path in map(Path, decks):
        if path.is_file():
            rows.append(("Deck", f"{path.name}, {path.stat().st_size:,} bytes, SHA-256 {file_sha256(path)}"))
            break
    if identity.files_sha256:
        rows.append(("Other files", f"SHA-256 {identity.files_sha256}"))
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


def static_figures(
    start: StaticStart, nodes: Nodes, watched: IntArray, groups: Sequence[str], gravity: FloatArray
) -> dict[str, Any]:
    """Sag of the watched nodes, channels that press, by contact, and the checks.

    Parameters
    ----------
    groups : contact or connector of each channel. gravity : (3,) length/time^2.
    """
    state = start.state
    u = start.at(node_dofs(watched)).reshape(-1, 6)
    translations = np.flatnonzero(dofs_of(start.labels) <= 3)
    top = translations[np.argmax(np.abs(start.displacement[translations]))]
    contacts, every = {}, np.array(groups)
    for name in dict.fromkeys(groups):
        mine = every == name
        pressing = mine & (state.force > 0.0)
        contacts[name] = {
            "force": float(state.force[mine].sum()),
            "friction": float(np.linalg.norm(state.held[mine], axis=1).sum()),
            "channels": {start.names[k]: float(state.force[k]) for k in np.flatnonzero(pressing)},
            "gap_min": float(state.gap[mine].min()),
        }
    return {
        "gravity": gravity.tolist(),
        "largest": {
            "node": nodes.label(int(nodes_of(start.labels[top]))),
            "dof": AXES[int(dofs_of(start.labels[top])) - 1],
            "displacement": float(start.displacement[top]),
        },
        "nodes": {
            nodes.label(int(n)): dict(zip(AXES, row, strict=True)) for n, row in zip(watched, u.tolist(), strict=True)
        },
        "contacts": contacts,
        "increments": state.increments,
        "residual": state.residual,
        "energy_error": state.energy_error,
        "strain_energy": state.strain,
        "contact_energy": state.contact,
    }
