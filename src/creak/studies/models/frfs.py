"""Frequency response functions of a deck beside measured ones: at the same points, along the same directions."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field, replace
from functools import partial
from typing import Any

import numpy as np
import scipy.linalg as sla

from creak.arrays import ComplexArray, to_dense
from creak.assembly.system import System
from creak.errors import InputError
from creak.formats.measured.modes import PER_METRE, QUANTITIES, MeasuredFrf, MeasuredFrfs
from creak.formats.measured.unit_words import mixed_up
from creak.linalg.diagonal import Diagonal
from creak.progress import Progress, silent
from creak.reduction.modal import ModalDamping, ModalShares, shares_at
from creak.reduction.transfer_modes import TransferModel, modal_transfer, receptances, transfer_model
from creak.studies.models.correlation import Correlation, WithModes, sensor_notes
from creak.studies.models.deck_modes import DeckModes
from creak.studies.prepare.measured_damping import channel_rows, damping_notes, damping_shares
from creak.studies.prepare.sensors import Sensors
from creak.studies.prepare.unit_check import likely_units
from creak.studies.warned import Warned
from creak.verify.mac import frac

ALIKE = 0.8
"""FRAC from which a difference in level or sign is looked for a reason."""
LEVEL, PHASE = 6.0, 45.0
"""dB and degrees that damping makes of a function that is the same."""
OPPOSITE = 150.0
"""Degrees from which two functions have opposite signs."""


@dataclass(frozen=True)
class FrfPair:
    """A measured function with that of the model, over the frequencies that both have."""

    measured: MeasuredFrf
    """Its values in m, s and N."""
    model: ComplexArray
    """(n,) the same of the model."""
    frac: float
    """Frequency response assurance criterion, 0 to 1; nan where one of them is zero."""
    level: float
    """Level of the model above the test, dB: of the factor that fits best."""
    phase: float
    """Degrees of that factor, -180 to 180."""


@dataclass(frozen=True)
class FrfFit:
    """A model's frequency response functions beside a test's."""

    pairs: tuple[FrfPair, ...]
    error: float
    """Of the functions of the model, against the unreduced model at a frequency that was not fitted."""
    notes: tuple[str, ...]
    reduced: tuple[FrfPair, ...] = ()
    """The same functions of a reduced model; none where there is none."""

    @property
    def figures(self) -> list[dict[str, Any]]:
        """What tells the agreement of each function."""
        return [
            {
                "function": p.measured.name,
                "quantity": QUANTITIES[p.measured.order][0],
                "unit": QUANTITIES[p.measured.order][1],
                "frac": p.frac,
                "level_db": p.level,
                "phase": p.phase,
                **({} if less is None else {"frac_reduced": less.frac, "level_db_reduced": less.level}),
            }
            for p, less in self._both
        ]

    @property
    def _both(self) -> Iterator[tuple[FrfPair, FrfPair | None]]:
        return zip(self.pairs, self.reduced or [None] * len(self.pairs), strict=True)

    def as_dict(self) -> dict[str, Any]:
        """As plain numbers, for JSON: magnitudes in m, s and N, phases in degrees."""
        functions = [
            {
                **figures,
                "frequency": p.measured.freq.tolist(),
                "test": _polar(p.measured.values),
                "model": _polar(p.model),
                **({} if less is None else {"reduced": _polar(less.model)}),
                "coherence": None if p.measured.coherence is None else p.measured.coherence.tolist(),
            }
            for figures, (p, less) in zip(self.figures, self._both, strict=True)
        ]
        return {"functions": functions, "error": self.error, "notes": list(self.notes)}


@dataclass(frozen=True)
class FrfComparison(FrfFit):
    """The functions of a deck beside a test's, with the test."""

    measured: MeasuredFrfs = field(kw_only=True)
    sensors: Sensors = field(kw_only=True)


def _polar(values: ComplexArray) -> dict[str, list[float]]:
    return {"magnitude": np.abs(values).tolist(), "phase": np.degrees(np.angle(values)).tolist()}


def compare_frfs(
    found: DeckModes,
    measured: MeasuredFrfs,
    sensors: Sensors,
    top: float,
    *,
    modes: Correlation | None = None,
    progress: Progress = silent,
) -> FrfComparison:
    """The functions of the model at the sensors of a test, up to `top` Hz.

    Parameters
    ----------
    found : the modes of the deck up to somewhat above `top`. modes : those of the same test, whose damping is taken.
    sensors : of the test; functions have the units that their file tells, else those of the test and N, else the
        model's.

    Raises
    ------
    InputError : supports hold a sensor; no function has two frequencies up to `top`.
    """
    shares, said = _measured_damping(modes), ["damping is that of the deck"]
    if shares is not None and modes is not None:
        said = damping_notes(shares, modes.measured, [p.fits for p in modes.pairs])
    elif found.damped is None:
        said = ["neither test nor deck tells damping: the functions of the model have none"]
    fit = fit_frfs(found, measured, sensors, top, (shares, said), progress=progress)
    return FrfComparison(fit.pairs, fit.error, fit.notes, measured=measured, sensors=sensors)


def fit_frfs(
    found: WithModes,
    measured: MeasuredFrfs,
    sensors: Sensors,
    top: float,
    damping: tuple[ModalDamping | None, Sequence[str]],
    *,
    reduced: System | None = None,
    progress: Progress = silent,
) -> FrfFit:
    """The agreement of all functions up to `top` Hz.

    Parameters
    ----------
    damping : share of critical of every mode, None: that of `found.damped`; and where it comes from, for the notes.
    reduced : in modes, with its damping.

    Raises
    ------
    InputError : supports hold a sensor; no function has two frequencies up to `top`.
    """
    kept = [cut for f in measured.functions if (cut := _up_to(f, top)) is not None]
    if not kept:
        raise InputError(
            f"no function has two frequencies between 0 and {top:g} Hz", where=measured.path, fix="Raise --f-max."
        )
    shares, said = damping
    damped = None if shares is not None else found.damped
    rows = _rows(found, measured, sensors)
    response, reference = (np.array([getattr(f, end) for f in kept]) for end in ("response", "reference"))
    loads = min(np.unique(reference), np.unique(response), key=len)  # H = H': forces at the fewer ones
    omega2 = (2.0 * np.pi * np.array(found.frequencies)) ** 2
    modal = transfer_model(damped or found.system, (omega2, found.shapes), rows, loads, top, progress)
    if shares is not None:
        modal = replace(modal, C=np.diag(2.0 * shares_at(shares, modal.omega2) * np.sqrt(modal.omega2)))
    system, test_units = likely_units(found.model, sensors.units), sensors.test_units
    length, force = (1.0 / PER_METRE[test_units], 1.0) if test_units else (system.length, system.force)
    scales, to_si = (1.0, length / force), system.length / system.force
    inside = [replace(f, values=f.values * scales[not f.has_units]) for f in kept]

    def pairs_of(model: TransferModel) -> tuple[FrfPair, ...]:
        return tuple(_pair(f, H * to_si) for f, H in zip(inside, _synthesised(model, kept), strict=True))

    pairs, small = pairs_of(modal), None if reduced is None else _in_modes(reduced, measured, sensors)
    notes = (
        *measured.notes,
        *sensor_notes(found.model, measured, sensors),
        *said,
        *_unit_notes(kept, test_units),
        *_level_notes(pairs),
        *_course_notes(pairs),
    )
    return FrfFit(pairs, modal.error, notes, () if small is None else pairs_of(small))


def _in_modes(system: System, measured: MeasuredFrfs, sensors: Sensors) -> TransferModel | None:
    """The transfer of a small System in all of its modes; None where a coordinate has no mass."""
    mass, rows = np.asarray(system.M.diagonal()), channel_rows(system, measured, sensors)
    if not (mass > 0.0).all():
        return None
    if isinstance(system.M, Diagonal) and isinstance(system.K, Diagonal):
        modes = system.K.d / mass, np.diag(1.0 / np.sqrt(mass))
    else:
        modes = sla.eigh(to_dense(system.K), to_dense(system.M))
    return modal_transfer(system, modes, np.zeros((system.n, 0)), rows)


def _up_to(f: MeasuredFrf, top: float) -> MeasuredFrf | None:
    """The function without what is above the frequency; None where less than two are left."""
    n = int(np.searchsorted(f.freq, top * (1.0 + 1e-9)))
    coherence = None if f.coherence is None else f.coherence[:n]
    return replace(f, freq=f.freq[:n], values=f.values[:n], coherence=coherence) if n > 1 else None


def _rows(found: WithModes, measured: MeasuredFrfs, sensors: Sensors) -> Any:
    """(n_channel, n) motion of every channel, each of which can move."""
    rows = channel_rows(found.system, measured, sensors)
    still = np.flatnonzero(abs(rows).sum(axis=1) == 0.0)
    if still.size:
        k = int(still[0])
        raise InputError(
            f"node {found.model.nodes.label(int(sensors.nodes_idx[k]))} of sensor {measured.sensors[k]} cannot move "
            "along the direction of its function",
            where=next(f.where for f in measured.functions if k in (f.response, f.reference)),
            expected="a node that supports leave free there",
            fix="Correct node or direction, or the supports of the deck.",
        )
    return rows


def _measured_damping(modes: Correlation | None) -> ModalShares | None:
    """The damping that the modes of the test tell; None: they tell none."""
    if modes is None:
        return None
    partner = np.full(modes.measured.frequencies.size, -1, dtype=np.int64)
    partner[[p.test for p in modes.pairs]] = [p.model for p in modes.pairs]
    return damping_shares(modes.measured, partner, np.array(modes.found.frequencies))


def _synthesised(modal: TransferModel, kept: list[MeasuredFrf]) -> list[ComplexArray]:
    """The functions in the units of the model, those of the same frequencies together."""
    found: dict[int, ComplexArray] = {}
    alike: dict[bytes, list[int]] = {}
    for k, f in enumerate(kept):
        alike.setdefault(f.freq.tobytes(), []).append(k)
    for rows in alike.values():
        freq = kept[rows[0]].freq
        response, reference = (np.array([getattr(kept[k], end) for k in rows]) for end in ("response", "reference"))
        H = receptances(modal, freq, response, reference)
        found |= {k: H[:, j] * (2j * np.pi * freq) ** kept[k].order for j, k in enumerate(rows)}
    return [found[k] for k in range(len(kept))]


def _pair(f: MeasuredFrf, model: ComplexArray) -> FrfPair:
    size = float(np.vdot(f.values, f.values).real)
    factor = complex(np.vdot(f.values, model)) / size if size else math.nan
    level = 20.0 * math.log10(abs(factor)) if abs(factor) > 0.0 else math.nan
    return FrfPair(f, model, frac(f.values, model), level, float(np.degrees(np.angle(factor))))


def _unit_notes(kept: list[MeasuredFrf], test_units: str | None) -> Iterator[str]:
    if not all(f.has_units for f in kept):
        yield f"the file tells no units of its functions: they are taken in {test_units or 'the units of the deck'}"


def _level_notes(pairs: Sequence[FrfPair]) -> Iterator[str]:
    """What a common factor or a sign may come from."""
    alike = [p for p in pairs if p.frac >= ALIKE]
    if alike:
        level = float(np.median([p.level for p in alike]))
        side = "above" if level > 0.0 else "below"
        for factor, what in mixed_up(10.0 ** (level / 20.0)):
            yield f"the model is {abs(level):.1f} dB {side} the test, a factor of {factor:g}: are {what} mixed up?"
    turned = [p.measured.name for p in alike if abs(p.phase) >= OPPOSITE]
    if turned:
        more = f" and {len(turned) - 1} more" if len(turned) > 1 else ""
        yield f"test and model have opposite signs at {turned[0]}{more}: is the sign of the direction right?"


def _course_notes(pairs: Sequence[FrfPair]) -> Iterator[Warned]:
    """As what else most functions would be those of the model, where as they are told they are not."""
    most = 0.5 * len(pairs)
    if sum(map(_is_alike, pairs)) > most:
        return
    ways: dict[str, Callable[[FrfPair], ComplexArray]] = {"are conjugate": lambda p: p.measured.values.conj()}
    told = pairs[0].measured.order
    for other, (name, _) in QUANTITIES.items():
        if other != told:
            ways[f"are {name}, not {QUANTITIES[told][0]}"] = partial(_differentiated, times=told - other)
    for what, way in ways.items():
        alike = sum(_is_alike(_pair(replace(p.measured, values=way(p)), p.model)) for p in pairs)
        if alike > most:
            yield Warned(
                f"{alike} of {len(pairs)} functions of the test would be those of the model if they {what}: check how "
                "they were written"
            )


def _is_alike(p: FrfPair) -> bool:
    """Whether course, level and phase are the same, whatever the damping."""
    return p.frac >= ALIKE and abs(p.level) <= LEVEL and abs(p.phase) <= PHASE


def _differentiated(p: FrfPair, times: int) -> ComplexArray:
    """The measured function so many times differentiated in time, 0 at 0 Hz."""
    moving = p.measured.freq > 0.0
    omega = 2j * np.pi * np.where(moving, p.measured.freq, 1.0)
    return np.asarray(np.where(moving, p.measured.values * omega**times, 0.0))
