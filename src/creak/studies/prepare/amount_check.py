"""What a study should hear of its amounts before it runs: units that are not meant, in tables and in files; of its
measured records when they move something, how well, and which of their samples are wrong."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from creak.arrays import FloatArray, IntArray
from creak.assembly.coupling import Driven
from creak.dynamics.loads import Loads
from creak.errors import InputError
from creak.formats.measured.modes import ACCELERANCE, MOBILITY, RECEPTANCE
from creak.formats.measured.unit_words import MOMENTS, MOTIONS, NEWTONS, PASCALS, PER_SECOND, SAME, TURNS, plain_unit
from creak.model.constraints import held_labels
from creak.model.dofs import dofs_of
from creak.model.mesh import Model
from creak.model.units import GRAVITY, UNITS
from creak.signals import faults
from creak.signals.sources import Record
from creak.studies.file.case import Driving, Touching
from creak.studies.file.excitation_tables import ExcitationTable
from creak.studies.file.signals.tables import PeriodicTable, RecordTable, SineTable, TableTable
from creak.studies.file.signals.vibration import SweepTable
from creak.studies.file.table import DOFS
from creak.studies.file.tables import read_signal
from creak.studies.prepare.excitation import records_of
from creak.studies.prepare.unit_check import SYSTEMS, UnitSystem, across
from creak.studies.warned import Warned
from creak.words import percent

WIDE = 0.1
"""Share of the model's size above which a clearance can hardly be meant; above all of it none is."""
ROUGH = 1e-6
"""m: clearances below this are less than the roughness of surfaces."""
NOTHING = 1e-9
"""m/s^2: what is left of a record that stands still."""
WEAK, HARD = 0.02, 1e4
"""m/s^2: peaks of 2 mg and 1000 g, beyond which no vibration of a vehicle or a shaker lies; shocks do."""

INSTEAD = (
    "Give its displacement, or take a multisine, which is faded in and has none; one line will do, with f_min = f_max"
)
ROUND_OFF = 1e-12
"""Share of its largest displacement up to which a support starts at zero."""
STOPPED = 0.01
"""Share of its highest speed below which what a table moves has come to rest where it was to go."""
CARRIED = 0.5
"""Mean of a motion over its vibration above which it goes away: 1 of a velocity sin(w t) from rest."""
ORDERS = {"displacement": RECEPTANCE, "velocity": MOBILITY, "acceleration": ACCELERANCE}
LOUDER = 4.0
"""How many times what was measured a record may be taken, or a part of it, without it looking like a wrong unit."""
TOLD = {*MOTIONS, *TURNS, *NEWTONS, *MOMENTS, *PASCALS}
"""Labels of units, of whatever they count."""
PRODUCTS = str.maketrans("", "", "*.-·")
"""Signs of a product, which units of moments are told with or without."""


def clearance_warnings(model: Model, touching: Touching) -> list[str]:
    """Clearances as large as a good part of the model, or smaller than surfaces are rough.

    Raises
    ------
    InputError : one larger than the model.
    """
    size, system = across(model), SYSTEMS[touching.units]
    unit, found = system.words[0], []
    for name, t in touching.contacts.items():
        if not isinstance(t.clearance, int | float):
            continue
        wide, asked = abs(t.clearance), f"is it in {unit}, as [model] units = {touching.units!r} says?"
        if size and wide > size:
            raise InputError(
                f"clearance = {t.clearance:g} {unit} is more than the whole model, {size:.3g} {unit} across",
                where=touching.places.where("contact", name, "clearance"),
                expected=f"a gap between the two surfaces, in {unit}",
                fix=f"Is it in another unit? In {touching.units} lengths are in {unit}.",
            )
        if size and wide > WIDE * size:
            found.append(
                f"[contact.{name}] clearance = {t.clearance:g} {unit} is {percent(wide / size)} of the model's size: "
                f"{asked}"
            )
        elif 0.0 < wide * system.length < ROUGH:
            found.append(
                f"[contact.{name}] clearance = {t.clearance:g} {unit} is less than surfaces are rough: {asked} 0 says "
                "that they touch"
            )
    return [Warned(text) for text in found]


def motion_warnings(driving: Driving, loads: Loads) -> list[str]:
    """Prescribed vibration far beyond, or as an acceleration far below, what vehicles and shakers do."""
    system, found = SYSTEMS[driving.units], []
    for j, (name, t) in enumerate(driving.moving.items()):
        if t.dof not in ("x", "y", "z") or not (t.signal.stated or isinstance(t.signal, RecordTable | TableTable)):
            continue
        peak = system.length * _peak(t, loads.support[2, :, j])
        if peak > HARD or _is_weak(t, peak):
            in_g = f" A record in g takes factor = {GRAVITY / system.length:.6g}" * isinstance(t.signal, RecordTable)
            found.append(
                f"[excitation.{name}] accelerates by {'up to' if peak > HARD else 'no more than'} {peak:.2g} m/s2: are "
                f"its amounts in {system.words[0]} and s, as [model] units = {driving.units!r} says?"
                f"{in_g * (peak < WEAK)}"
            )
    return [Warned(text) for text in found]


def weak_drive(driving: Driving, loads: Loads) -> str | None:
    """Why a run in which nothing touches says nothing, where accelerations drive it that no vehicle and no shaker has
    so small: they are in another unit. None: something else drives it."""
    system, moving = SYSTEMS[driving.units], driving.moving
    peaks = [system.length * _peak(t, loads.support[2, :, j]) for j, t in enumerate(moving.values())]
    if driving.forcing or driving.statics or not all(map(_is_weak, moving.values(), peaks)) or not moving:
        return None
    return (
        f"what drives the model accelerates by less than {WEAK:g} m/s2, so nothing can rattle: give the factor from "
        f"its unit to {system.words[0]}/s^2 (of a record in g factor = {GRAVITY / system.length:.6g})"
    )


def _is_weak(t: ExcitationTable, peak: float) -> bool:
    """Whether it is an acceleration of a peak (m/s^2) that is no vibration of a vehicle or a shaker."""
    return t.values_of == "acceleration" and t.dof in ("x", "y", "z") and NOTHING < peak < WEAK


def drift_warnings(model: Model, driving: Driving, driven: Driven, loads: Loads) -> list[str]:
    """Supports that a vibration from rest carries away from what stays where it is.

    The integral of A sin(w t) from rest has the mean A / w: a velocity of this kind moves its nodes by A / w to another
    place, an acceleration drives them away at that speed, and so does what a sensor adds to a measured one given
    as a table. Where all supports go the same way, it changes nothing.
    """
    length, found = SYSTEMS[driving.units].words[0], []
    held = dofs_of(np.setdiff1d(held_labels(model.fixed), driven.every))
    dofs = [other.dof for other in driving.moving.values()]
    for j, (name, t) in enumerate(driving.moving.items()):
        table = isinstance(t.signal, TableTable) and t.kind == "acceleration"
        if t.kind == "displacement" or not (table or isinstance(t.signal, SineTable | SweepTable | PeriodicTable)):
            continue
        u, speed = loads.support[0, :, j], loads.support[1, :, j]
        if table and abs(speed[-1]) < STOPPED * np.abs(speed).max():
            continue
        line = np.polynomial.Polynomial.fit(loads.time, u, 1)
        away, vibration = float(np.abs(u).max()), float(np.abs(u - line(loads.time)).max())
        others = [k for k, dof in enumerate(dofs) if dof == t.dof]
        apart = np.ptp(loads.support[0][:, others], axis=1).max() > vibration
        if abs(u.mean()) > CARRIED * vibration and (apart or (held == DOFS.index(t.dof) + 1).any()):
            unit = length if t.dof in ("x", "y", "z") else "rad"
            found.append(
                f"[excitation.{name}] carries its nodes {away:.3g} {unit} away, beside a vibration of {vibration:.3g}, "
                f"and others stay: from rest, the {t.kind} of a {t.signal.type} keeps a mean. "
                + ('A measured one is a type = "record", with a high_pass' if table else INSTEAD)
            )
    return [Warned(text) for text in found]


def jump_warnings(names: Sequence[str], motion: FloatArray) -> list[str]:
    """Prescribed displacements (n_time, n_support) that are not zero, but for round-off, when the run starts."""
    largest = np.abs(motion).max(axis=0, initial=0.0)
    return [
        Warned(
            f"{name} is {value:g} at the start, where the structure is at rest: it jumps, and what that closes presses "
            "from the start, so it is no event. Let it begin at zero"
        )
        for name, value, most in zip(names, motion[0].tolist(), largest.tolist(), strict=True)
        if abs(value) > ROUND_OFF * most
    ]


def _peak(t: ExcitationTable, acceleration: FloatArray) -> float:
    """Of an acceleration (n,). That of displacements and velocities given by points shows the corners at the points,
    and counts as that of the sine of its mean square."""
    if isinstance(t.signal, TableTable) and t.kind != "acceleration":
        return float(np.sqrt(2.0 * np.mean(acceleration**2)))
    return float(np.abs(acceleration).max(initial=0.0))


def file_unit_notes(driving: Driving) -> list[str]:
    """Units that files tell of their own courses, where they are not those of the study or not known.

    Raises
    ------
    InputError : a file tells another unit than the study's, and no `factor` is given.
    """
    return [text for name in driving.excitations for text in _file_unit(driving, name)]


def _file_unit(driving: Driving, name: str) -> Iterator[str]:
    t = driving.excitations[name]
    s = t.signal
    if not isinstance(s, RecordTable | TableTable) or s.file is None:
        return
    where = driving.places.where("excitation", name, "signal")
    unit = read_signal(driving.places.sibling(s.file), s.channel, where).unit
    if not (word := plain_unit(unit)):
        return
    what, label, sizes = _counted(t.values_of, t.dof.startswith("r"), SYSTEMS[driving.units])
    told = f"{s.file if s.channel is None else f'channel {s.channel!r} of {s.file}'} is in {unit}"
    size = sizes.get(word, sizes.get(word.translate(PRODUCTS)))
    if size is None and not {word, word.translate(PRODUCTS)} & TOLD:
        yield f"[excitation.{name}] {told}, a unit that is not known: {s.factor:g} times its values count as {label}"
    elif "factor" not in s.model_fields_set and (size is None or abs(size - 1.0) > SAME):
        raise InputError(
            told,
            where=where,
            expected=f"{what} in {label}, as [model] units = {driving.units!r} says",
            fix="Name another channel or kind; where the file is wrong, factor = 1 takes its values as they are."
            if size is None
            else f"Add factor = {size:.6g} to the signal.",
        )
    elif size is None:
        yield Warned(f"[excitation.{name}] {told}, which counts no {what.split()[-1]}: is it the right channel?")
    elif abs(abs(s.factor) / size - 1.0) > SAME:
        far = not 1.0 / LOUDER <= abs(s.factor) / size <= LOUDER
        text = (
            f"[excitation.{name}] {told}, of which factor = {size:.6g} makes {label}; factor = {s.factor:g} is given: "
            f"{abs(s.factor) / size:.3g} times what was measured"
        )
        yield Warned(text) if far else text


def _counted(kind: str, turning: bool, system: UnitSystem) -> tuple[str, str, dict[str, float]]:
    """What an excitation is, the label of its unit in a system, and labels of units -> what they are in that."""
    length, force = UNITS[system.name].length, UNITS[system.name].force
    if kind == "force" and turning:
        own = system.force * system.length
        return "a moment", f"{force} {length}", {word: size / own for word, size in MOMENTS.items()}
    if kind == "force":
        return "a force", force, {word: size / system.force for word, size in NEWTONS.items()}
    order, own = ORDERS[kind], 1.0 if turning else system.length
    sizes = {word: size / own for word, (of, size) in (TURNS if turning else MOTIONS).items() if of == order}
    what = f"an angular {kind}" if turning else f"an {kind}" if kind == "acceleration" else f"a {kind}"
    return what, f"{'rad' if turning else length}{PER_SECOND[order]}", sizes


STANDS = 0.02
"""Share of a run that a record may leave out at its beginning and at its end: it may be a few samples."""
KNOWN = 0.02
"""Share of its displacement up to which a record is known in its middle."""


def record_warnings(driving: Driving, loads: Loads) -> list[str]:
    """Records that cover another time than the run, are too short for the displacement that is made of them, or whose
    samples are not what was to be measured."""
    end, names = float(loads.time[-1]), list(driving.moving)
    texts = [text for name, r in records_of(driving, driving.forcing).items() for text in _of_force(name, r, end)]
    for name, record in records_of(driving, driving.moving).items():
        moves = loads.time[loads.support[:, :, names.index(name)].any(axis=0)]
        begins, ends = float(record.time[0]), float(record.time[-1])
        if not np.ptp(record.value):
            texts.append(
                f"the record of [excitation.{name}] moves nothing: it is {record.value[0] + 0.0:.4g} throughout. Name "
                "another channel or file"
            )
            continue
        texts += [f"the record of [excitation.{name}] {text}" for text in _faults(record)]
        if not moves.size:
            texts.append(
                f"[excitation.{name}] is zero throughout the run: its record holds {begins:.4g} to {ends:.4g} s, the "
                f"run 0 to {end:.4g} s. Shift its times to begin at 0"
            )
            continue
        if moves[0] > STANDS * end:
            texts.append(
                f"the record of [excitation.{name}] begins at {begins:.4g} s: nothing moves before, and rates are "
                f"those of the whole run to {end:.4g} s. Shift its times to begin at 0"
            )
        if moves[-1] < (1.0 - STANDS) * end:
            texts.append(
                f"the record of [excitation.{name}] ends at {ends:.4g} s, the run at {end:g} s: the motion fades "
                "out there, and nothing moves it any more"
            )
        if (share := record.wrapped) > KNOWN:
            texts.append(
                f"the displacement made of the record of [excitation.{name}] is off by some {100.0 * share:.2g} % in "
                f"its middle, and by more near its ends: it is {(ends - begins) * record.high_pass:.3g} / high_pass "
                "long, and its ends do not meet. Take a longer record, or one of whole periods"
            )
    return texts


def evened_notes(driving: Driving) -> list[str]:
    """Records whose samples were put on even times; a warning where that may tell."""
    found = list[str]()
    for name, record in {**records_of(driving, driving.forcing), **records_of(driving, driving.moving)}.items():
        if record.evened:
            text = (
                f"the record of [excitation.{name}] has uneven times and was put on even ones {record.step:.4g} s "
                f"apart, by cubic splines: its values are off by up to {100.0 * record.evened:.2g} % of their rms"
            )
            cure = ". Filter it lower before it is exported, or export it at a fixed rate"
            found.append(Warned(text + cure) if record.evened > KNOWN else text)
    return found


def _of_force(name: str, record: Record, end: float) -> Iterator[str]:
    """Of a force, which outside its record stays at the first and the last sample."""
    first, last = record.value[[0, -1]]
    if record.time[0] > STANDS * end and abs(first) > STANDS * np.abs(record.value).max():
        yield (
            f"the record of [excitation.{name}] begins at {record.time[0]:.4g} s with a force of {first:.4g}, which "
            "acts from 0 on. Shift its times to begin at 0, or let it begin with zero"
        )
    if record.time[-1] < (1.0 - STANDS) * end and abs(last) > STANDS * np.abs(record.value).max():
        yield (
            f"the record of [excitation.{name}] ends at {record.time[-1]:.4g} s with a force of {last:.4g}, which acts "
            f"on until the run ends at {end:g} s. Let the run end with it, or let it end with zero"
        )


def _faults(record: Record) -> Iterator[str]:
    x = record.value
    if (still := faults.dropouts(x)).size:
        yield (
            f"stands still {_longest(record, still)}, and jumps there: the sensor may have dropped out. Take "
            "a stretch without it, or measure again"
        )
    if (cut := faults.cut_off(x)).size:
        yield (
            f"is cut off {_longest(record, cut)}: the sensor or its amplifier was at its limit, and the peaks "
            "were higher. Measure again with a larger range"
        )
    if (alone := faults.spikes(x)).size:
        yield (
            f"has {alone.size} sample{'s' * (alone.size > 1)} far beyond all others, the first {x[alone[0]]:.4g} at "
            f"{record.time[alone[0]]:.6g} s: no motion is that short. Replace by the mean of the samples beside"
        )
    elif faults.reaches_top(x):
        yield (
            f"reaches up to the {0.5 / record.step:.4g} Hz that samples {record.step:.4g} s apart can hold: what "
            "vibrated faster is missing, or was folded into lower frequencies if no filter kept it out. Sample faster, "
            "or filter it where it is the noise of the sensor"
        )


def _longest(record: Record, stretches: IntArray) -> str:
    first, last = stretches[np.diff(stretches)[:, 0].argmax()]
    often = "once," if len(stretches) == 1 else f"{len(stretches)} times, longest"
    return f"{often} at {record.value[first]:.4g} from {record.time[first]:.6g} to {record.time[last]:.6g} s"
