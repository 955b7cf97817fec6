"""Units that the files of records and tables name, against those of the study."""

from __future__ import annotations

from collections.abc import Iterator

from creak.errors import InputError
from creak.formats.measured.modes import ACCELERANCE, MOBILITY, RECEPTANCE
from creak.formats.measured.unit_words import MOMENTS, MOTIONS, NEWTONS, PASCALS, PER_SECOND, SAME, TURNS, plain_unit
from creak.studies.file.case import Driving
from creak.studies.file.signals.course import RecordTable, TableTable
from creak.studies.file.tables import read_signal
from creak.studies.prepare.unit_check import SYSTEMS, UnitSystem
from creak.studies.warned import Warned

ORDERS = {"displacement": RECEPTANCE, "velocity": MOBILITY, "acceleration": ACCELERANCE}
LOUDER = 4.0
"""How many times what was measured a record may be taken, or a part of it, without it looking like a wrong unit."""
KNOWN = {*MOTIONS, *TURNS, *NEWTONS, *MOMENTS, *PASCALS}
"""Labels of units, of whatever they count."""
PRODUCTS = str.maketrans("", "", "*.-·")
"""Signs of a product, which units of moments are told with or without."""


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
    if size is None and not {word, word.translate(PRODUCTS)} & KNOWN:
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
    length = system.words[0]
    if kind == "force" and turning:
        own = system.force * system.length
        return "a moment", f"N {length}", {word: size / own for word, size in MOMENTS.items()}
    if kind == "force":
        return "a force", "N", {word: size / system.force for word, size in NEWTONS.items()}
    order, own = ORDERS[kind], 1.0 if turning else system.length
    sizes = {word: size / own for word, (of, size) in (TURNS if turning else MOTIONS).items() if of == order}
    what = f"an angular {kind}" if turning else f"an {kind}" if kind == "acceleration" else f"a {kind}"
    return what, f"{'rad' if turning else length}{PER_SECOND[order]}", sizes
