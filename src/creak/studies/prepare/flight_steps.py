"""What a study does not say and its run does: how often motion is written, flight steps, and up to which frequency."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np

from creak.arrays import FloatArray, IntArray
from creak.contact.facets import confined_modulus
from creak.contact.gap_operator import GapOperator
from creak.dynamics.flow.march import SAMPLES
from creak.dynamics.flow.resolution import FINE, QUICK, SETTLED, Resolution
from creak.model.constraints import held_nodes
from creak.model.faces import FACES, face_numbers, faces_of, facet_areas, volumes
from creak.model.materials import SolidSection
from creak.model.mesh import Model
from creak.studies.file.case import Course, Driving
from creak.studies.file.config import VerificationTable
from creak.studies.file.reader import Study
from creak.studies.file.signals.course import PER_FLANK, columns
from creak.studies.file.signals.tables import RecordTable, TableTable
from creak.studies.file.signals.vibration import LOBE
from creak.studies.file.tables import read_signal
from creak.studies.prepare.excitation import highest_frequency
from creak.studies.warned import Warned

WRITTEN_PER_PERIOD = 2.0
"""Instants written in a period of the verification's f_max."""
FASTEST = 100.0
"""Longest flight step over the shortest, where no frequency is stated: closer samples are followed no closer."""
STEEPEST = 25.0
"""The same of flanks: what is left of a jump is when it comes, to half a step."""
PER_PERIOD = 10.0
"""Flight steps in a period of the excitation, and of the modes that are compared: a cubic through four samples is then
within 1e-4 of a sine."""
WRITTEN = 1000.0
"""Instants written of a short run."""
EVEN = 0.5
"""Share of the median spacing of points below which some stand closer than the others."""
LEAST = 1e-3
"""Height of a lobe that is followed, as a share of all that a signal spans."""
FEW = 20
"""Lobes that are followed one by one."""
MANY, UNEVEN = 50, 4.0
"""Points from which on they may be those of a record, and how far its spacing differs: nine tenths to one tenth."""
PLATEAUS = 0.2
"""Share of the pieces that rest from which on uneven points draw a shape."""
TRAVEL = 0.02
"""Share of all that a signal spans, by which it goes in the time that tells how steep it is."""
PER_LOBE, FEWEST = 10.0, 2.5
"""Flight steps in a lobe at half its height, and how few of them are told."""
EDGES = 0.15
"""Of a shock, in place of all of it: steps leave flanks that they do not follow off by a sixth of a step, and the
impulse by 1 % where a step is a seventeenth of the shock."""
RESOLUTIONS: dict[str, Resolution] = {"quick": QUICK, "settled": SETTLED, "fine": FINE}
SHORTER = {"fine": 4.0}
"""How finely contact is resolved by [time] accuracy, in shares of a flight step, and how much shorter these are."""
IN_A_RUN = 10.0
"""Periods of the low-pass that a run has at least: over fewer it is no mean force, but what its ends make of it."""
PER_WAVE = 10.0
"""Steps of the mesh in a wave of compression that it carries."""


def with_flight_steps(study: Study) -> tuple[Study, list[str]]:
    """The study with the steps that its accuracy asks for, and warnings of what they do not follow; one with a forced
    step is returned as it is.

    `[time] step` becomes the flight step, `substeps` its samples of the loads, `[output] interval` a number.

    Raises
    ------
    InputError : no end of the run.
    """
    c = study.config
    if not c.time.exact:
        return study, []
    points, course = _wanted(study.driving), study.course
    shown = _resolved(study.driving, c.verification, [one.told for one in points.values()])
    wanted = min(shown, _resolved(study.driving, c.verification, [one.step for one in points.values()], STEEPEST))
    interval = c.output.interval
    if interval is None:
        most = min(shown, course.end / WRITTEN)
        whole = c.output.field_interval or min(course.period or course.end, course.end)
        interval = whole / math.ceil(whole / most * (1.0 - 1e-9))
    step = interval / math.ceil(interval / wanted * SHORTER.get(c.time.accuracy, 1.0) * (1.0 - 1e-9))
    tables = {
        "time": c.time.model_copy(update={"integrator": "exact", "step": step, "substeps": SAMPLES}),
        "output": c.output.model_copy(update={"interval": interval}),
    }
    return study.with_tables(**tables), _unfollowed(study.driving, step, points)


def _unfollowed(driving: Driving, step: float, points: Mapping[str, Wanted]) -> list[str]:
    """Excitations that change faster than flight steps follow."""
    return [
        Warned(
            f"[excitation.{name}] changes within {PER_LOBE * wanted.told:.2g} s, which flight steps of {step:.2g} s do "
            "not follow: what this moves may be wrong; a higher [verification] f_max makes them shorter"
        )
        for name, wanted in points.items()
        if FEWEST * step > PER_LOBE * wanted.told
    ]


def _resolved(driving: Driving, v: VerificationTable, points: Sequence[float], fastest: float = FASTEST) -> float:
    """s of a flight step that follows what is compared and the excitations: their highest frequency, their `points`."""
    longest = min(1.0 / (WRITTEN_PER_PERIOD * v.f_max), 1.0 / (PER_PERIOD * v.mac_f_max))
    some, all_of_it = highest_frequency(driving), highest_frequency(driving, stated=True)
    step = max(min([longest, *([1.0 / (PER_PERIOD * some)] if some else []), *points]), longest / fastest)
    return min(step, 1.0 / (PER_PERIOD * all_of_it)) if all_of_it else step


class Wanted(NamedTuple):
    """s of the longest flight step that follows an excitation."""

    step: float
    told: float
    """The same of what is told where no flight step follows it: of a jump these say no more than when it comes."""


def _wanted(driving: Driving) -> dict[str, Wanted]:
    """Those of each excitation whose frequencies do not tell them."""
    found = {}
    for name, table in driving.excitations.items():
        signal = table.signal
        if signal.resolving is not None:
            told = EDGES * LOBE / (signal.highest * PER_LOBE) if signal.highest else 0.0  # of a shock
            found[name] = Wanted(signal.resolving, max(signal.resolving, told))
        elif isinstance(signal, TableTable) and signal.values is not None:
            found[name] = _between_points(*columns(signal.values))
        elif isinstance(signal, TableTable | RecordTable) and signal.file is not None:
            path, where = driving.places.sibling(signal.file), driving.places.where("excitation", name, "signal")
            read = read_signal(path, signal.channel, where)
            found[name] = _between_points(read.time, read.value)
    return found


def _between_points(time: FloatArray, value: FloatArray) -> Wanted:
    """Flight steps that follow straight lines between points.

    Many points that are nearly even, or between which the signal hardly ever rests, are those of a record: the median
    of their spacing follows them. So it does where some stand closer, but for a few lobes and flanks that are narrower.
    Other points draw a shape: its lobes are followed, and the flank in which it goes by `TRAVEL` of all that it spans
    in the shortest time.
    """
    if time.size < 2 or not np.ptp(value):
        return Wanted(np.inf, np.inf)
    between, span = np.diff(time), float(np.ptp(value))
    median = float(np.median(between))
    lobes = _narrow_lobes(time, value) if between.min() <= EVEN * median else []
    told = min(lobes) / PER_LOBE if 0 < len(lobes) <= FEW else median
    some, most = np.quantile(between, (0.1, 0.9))
    plateaus = float(np.mean(np.abs(np.diff(value)) <= LEAST * span))
    if time.size < MANY or (most > UNEVEN * some and plateaus > PLATEAUS):
        return Wanted(min(told, _shortest_travel(time, value, TRAVEL * span) / (TRAVEL * PER_FLANK)), told)
    flanks = between[(between < EVEN * median) & (np.abs(np.diff(value)) > TRAVEL * span)]
    return Wanted(min(told, flanks.min() / PER_FLANK) if 0 < flanks.size <= FEW else told, told)


def _narrow_lobes(time: FloatArray, value: FloatArray) -> list[float]:
    """Widths at half height of lobes that are narrower than the median spacing, s."""
    from scipy.signal import find_peaks, peak_widths  # half a second that other studies need not wait for

    first, last, median = 2.0 * time[0] - time[1], 2.0 * time[-1] - time[-2], float(np.median(np.diff(time)))
    time, value = np.concatenate([[first], time, [last]]), np.concatenate([[0.0], value, [0.0]])
    narrow, least = list[float](), LEAST * float(np.ptp(value))
    for side in (value, -value):
        peaks, _ = find_peaks(side, prominence=least)
        _, _, *ends = peak_widths(side, peaks)
        left, right = (np.interp(at, np.arange(time.size), time) for at in ends)
        narrow += (right - left)[right - left < median].tolist()
    return narrow


def _shortest_travel(time: FloatArray, value: FloatArray, way: float) -> float:
    """s in which straight lines between points go by `way`, up and down together, at the fastest."""
    gone = np.concatenate([[0.0], np.cumsum(np.abs(np.diff(value)))])
    if gone[-1] <= way:
        return float(time[-1] - time[0])
    least = np.inf
    for t, g in ((time, gone), (-time[::-1], gone[-1] - gone[::-1])):  # from each point on, and up to each
        from_ = np.flatnonzero(g + way <= g[-1])
        end = np.searchsorted(g, g[from_] + way, side="left")
        share = (g[from_] + way - g[end - 1]) / (g[end] - g[end - 1])
        least = min(least, float((t[end - 1] + share * (t[end] - t[end - 1]) - t[from_]).min()))
    return least


def bandwidth(
    table: VerificationTable, course: Course, model: Model, contacts: GapOperator
) -> tuple[VerificationTable, list[str]]:
    """[verification] with the f_max that a run and the mesh at its contacts can tell, and notes.

    One that is given stays. A run shorter than ten periods of it has a higher one; a mesh of solids at the
    contacts that does not carry it a lower one (`carried`): touches which follow each other faster are of the mesh.

    Raises
    ------
    InputError : no end of the run.
    """
    if "f_max" in table.model_fields_set or not course.time.exact:
        return table, []
    highest = carried(model, contacts.retained_nodes)
    f_max = min(max(table.f_max, IN_A_RUN / course.end), highest)
    if f_max == table.f_max:
        return table, []
    given = {**table.model_dump(exclude_unset=True), "f_max": f_max}
    why = f"the run is {course.end:.3g} s long"
    if f_max == highest:
        why = f"the solids at the contacts are too coarse for more ({PER_WAVE:g} steps of the mesh in a wave)"
    return VerificationTable.model_validate(given), [
        f"forces are low-passed at {f_max:.3g} Hz, and touches closer than half a "
        f"period of it are one blow: {why}; [verification] f_max sets another"
    ]


def carried(model: Model, nodes_idx: IntArray) -> float:
    """Hz, of waves of compression that the mesh of the solids at some nodes carries; inf where there are none.

    c / (10 h) with c^2 = E_c / rho of confined compression and h the least way from node to node across an element: the
    median of the elements of each block that have one of the nodes and are not held, the lowest of all blocks.
    """
    touched, held = np.zeros(model.nodes.count, dtype=bool), np.zeros(model.nodes.count, dtype=bool)
    touched[nodes_idx], held[held_nodes(model.fixed)] = True, True
    found = [math.inf]
    for block in model.blocks:
        if block.kind not in FACES or not isinstance(block.section, SolidSection):
            continue
        nodes = block.nodes_idx[touched[block.nodes_idx].any(axis=1) & ~held[block.nodes_idx].all(axis=1)]
        material = block.section.material
        if nodes.size and material.density > 0.0:
            c = math.sqrt(confined_modulus(material) / material.density)
            found.append(c / (PER_WAVE * float(np.median(_spacing(model.nodes.coords, block.kind, nodes)))))
    return min(found)


def _spacing(coords: FloatArray, kind: str, nodes: IntArray) -> FloatArray:
    """(n,) length: the least height of elements, from node to node."""
    x, face = coords[faces_of(kind, nodes)], face_numbers(kind)
    largest = (facet_areas(x) @ (face[:, None] == np.arange(1, face.max() + 1))).max(axis=1)
    middle = face.size > np.unique(face).size
    return np.abs(volumes(x)) / np.maximum(largest, 1e-300) / (2.0 if middle else 1.0)
