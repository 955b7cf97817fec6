"""What fits between a model and a test, modes and frequency response functions, in a sentence and as rows."""

from __future__ import annotations

import math

from creak.formats.measured.modes import ACCELERANCE, MOBILITY, RECEPTANCE
from creak.report.words.text import NONE, fixed, number, plural
from creak.studies.findings.beside_records import RecordFits
from creak.studies.models.frfs import FrfFit, FrfPair
from creak.verify.mode_fit import GOOD_HZ, GOOD_MAC, ModeFit, ModePair
from creak.words import first_few

GOOD_FRAC, GOOD_DB, GOOD_DEGREES = 0.8, 3.0, 30.0
"""The same of a function: FRAC, and level and phase of the factor between test and model."""
SHORT = {RECEPTANCE: "x/F", MOBILITY: "v/F", ACCELERANCE: "a/F"}
NAMED = 6
"""Modes that a sentence names."""


def sentence(found: ModeFit) -> str:
    """What fits and what does not."""
    count, good = found.frequencies_test.size, sum(p.fits for p in found.pairs)
    near = f"frequency within {100.0 * GOOD_HZ:g} %"
    if found.of_one_channel:
        blind = "at one channel MAC is 1 of any two shapes, so the shapes are not compared"
        said = f"{good} of {plural(count, 'measured mode')} have a partner by frequency alone ({near}): {blind}"
    else:
        said = f"{good} of {plural(count, 'measured mode')} fit (MAC of {GOOD_MAC:g} or more, {near})"
    off = [_off(p) for p in found.pairs if not p.fits]
    alone = [f"{found.frequencies_test[k]:g} Hz" for k in found.alone_test]
    extra = [f"{found.frequencies_model[k]:.6g} Hz" for k in found.alone_model]
    parts = [said]
    if off:
        parts.append(f"not so {first_few(off, NAMED)}")
    if alone:
        parts.append(f"without partner in the model: {first_few(alone, NAMED)}")
    if extra:
        parts.append(f"in the model alone: {first_few(extra, NAMED)}")
    return "; ".join(parts) + "."


def pair_rows(found: ModeFit) -> list[list[str]]:
    """Header, and a row for each measured mode."""
    damped = any(math.isfinite(p.damping_model) for p in found.pairs)
    head = ["no", "test Hz", "mode", "model Hz", "diff %", "MAC", "damp %"]
    head += [*(["model %"] if damped else []), "real"]
    partner = {p.test: p for p in found.pairs}
    rows = [head]
    for k, (hz, zeta, real) in enumerate(
        zip(
            found.frequencies_test.tolist(),
            found.damping_test.tolist(),
            found.collinearity.tolist(),
            strict=True,
        )
    ):
        p = partner.get(k)
        rows.append(
            [
                str(k + 1),
                f"{hz:.6g}",
                NONE if p is None else str(p.model + 1),
                NONE if p is None else f"{p.frequency_model:.6g}",
                NONE if p is None else signed(100.0 * p.difference),
                NONE if p is None else fixed(p.mac, 3),
                fixed(100.0 * zeta, 3),
                *([NONE if p is None else fixed(100.0 * p.damping_model, 3)] if damped else []),
                fixed(real, 3),
            ]
        )
    return rows


def frf_fits(p: FrfPair) -> bool:
    """Whether shape, level and phase of two functions fit."""
    return p.frac >= GOOD_FRAC and abs(p.level) <= GOOD_DB and abs(p.phase) <= GOOD_DEGREES


def frf_sentence(found: FrfFit) -> str:
    """Which functions fit and which do not."""
    count = plural(len(found.pairs), "frequency response function")
    bar = f"FRAC of {GOOD_FRAC:g} or more, level within {GOOD_DB:g} dB, phase within {GOOD_DEGREES:g} degrees"
    off = [
        f"{p.measured.name} (FRAC {p.frac:.2f}, {signed(p.level)} dB, {fixed(p.phase, 0)} degrees)"
        for p in found.pairs
        if not frf_fits(p)
    ]
    more = f"; not so {first_few(off, NAMED)}" if off else ""
    return f"{len(found.pairs) - len(off)} of {count} fit ({bar}){more}."


def frf_rows(found: FrfFit) -> list[list[str]]:
    """Header, and a row for each function."""
    coherent = any(p.measured.coherence is not None for p in found.pairs)
    more = [*(["FRAC red."] if found.reduced else []), *(["coh."] if coherent else [])]
    rows = [["function", "kind", "from Hz", "to Hz", "FRAC", "dB", "phase", *more]]
    for k, p in enumerate(found.pairs):
        f, coherence = p.measured.freq, p.measured.coherence
        mean = NONE if coherence is None else fixed(float(coherence.mean()), 3)
        ends = [f"{f[0]:.5g}", f"{f[-1]:.5g}", fixed(p.frac, 3), signed(p.level), fixed(p.phase, 0)]
        reduced = [fixed(found.reduced[k].frac, 3)] if found.reduced else []
        rows.append([p.measured.name, SHORT[p.measured.order], *ends, *reduced, *([mean] if coherent else [])])
    return rows


def _off(p: ModePair) -> str:
    return f"{number(p.frequency_test)} Hz ({signed(100.0 * p.difference)} %, MAC {p.mac:.2f})"


def signed(value: float) -> str:
    """One decimal, with its sign."""
    text = fixed(value, 1)
    return f"+{text}" if value > 0.0 and float(f"{value:.1f}") else text


def record_sentence(found: RecordFits) -> str:
    """The best and the worst channel."""
    order = sorted(found.pairs, key=lambda p: p.fit.fit)
    said = f"{plural(len(order), 'channel')} beside the run"
    if len(order) == 1:
        return f"{said}: {order[0].name} with a fit of {fixed(order[0].fit.fit, 2)} (1: the same)."
    ends = [f"{p.name} with a fit of {fixed(p.fit.fit, 2)}" for p in (order[-1], order[0])]
    return f"{said}: best {ends[0]}, worst {ends[1]} (1: the same, 0: no better than a constant)."


def record_rows(found: RecordFits) -> list[list[str]]:
    """Header, and a row for each channel."""
    rows = [["channel", "unit", "fit", "corr.", "rms test", "model", "events", "model"]]
    for p in found.pairs:
        counts = [NONE, NONE] if p.fit.events is None else [str(len(e)) for e in p.fit.events]
        figures = [fixed(p.fit.fit, 3), fixed(p.fit.correlation, 3), *(number(x) for x in p.fit.rms)]
        rows.append([p.name, p.unit, *figures, *counts])
    return rows
