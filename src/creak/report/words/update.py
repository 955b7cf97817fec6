"""What an update of a study beside a test has found, in a sentence, as rows, and what of it cannot be believed."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence

from creak.report.words.correlation import NAMED, signed
from creak.report.words.text import NONE, fixed, number, plural
from creak.studies.models.update import Estimate, ModelUpdate, Sensitivities
from creak.verify.mode_fit import ModePair
from creak.words import first_few

TWICE = math.log(2.0)
"""Half width of an interval of ln p beyond which a parameter counts as not determined."""
ALIKE = 0.9
"""Correlation from which two parameters are nearly one."""
MORE = 1.5
"""Times the uncertainty of the test from which the rest needs another reason."""
SHOWN = 12
"""Keys that the table of sensitivities has at most; the file for machines has all."""
NOTHING = 1e-6
"""Share of a frequency that is told as 0."""
FAR = 10.0
"""Factor beyond which a first-order change says nothing."""


def sensitivity_sentence(found: Sensitivities) -> str:
    """Which key would mend most, and what it would leave."""
    now = _percent(_rms([p.difference for p in found.before.pairs]))
    said = f"The frequencies of {plural(len(found.before.pairs), 'pair')} are {now} % off (root mean square)"
    if not found.keys:
        return f"{said}; the study and its deck have no number that they could be brought nearer by."
    best = found.ranked[0]
    return (
        f"{said}; {found.keys[best]} alone would leave {_percent(float(found.left[best]))} %, to first order. "
        "Nothing was changed."
    )


def sensitivity_rows(found: Sensitivities) -> list[list[str]]:
    """Header, and a row for each key, the one that would mend most first."""
    rows = [["key", "value", "best", "left %", "slope", "at Hz"]]
    for k in found.ranked[:SHOWN]:
        slopes = found.slopes[:, k]
        most = int(abs(slopes).argmax())
        best = float(found.best_factors[k])
        told = signed(100.0 * (best - 1.0)) + " %" if 1.0 / FAR < best < FAR else "far"
        largest = [fixed(float(slopes[most]), 3), f"{found.before.pairs[most].frequency_test:.5g}"]
        rows.append([found.keys[k], f"{found.values[k]:.5g}", told, _percent(float(found.left[k])), *largest])
    return rows


def update_sentence(found: ModelUpdate) -> str:
    """What was changed, what it brings, and what stays unexplained."""
    changes = "; ".join(_change(e) for e in found.estimates)
    before, after = (_percent(x) for x in found.unexplained)
    worst = max(found.after.pairs, key=lambda p: abs(p.difference))
    return (
        f"{changes}. The frequencies of {plural(len(found.off[0]), 'pair')} go from {before} to {after} % off (root "
        f"mean square); the farthest is {number(worst.frequency_test)} Hz with {signed(100.0 * worst.difference)} %."
    )


def parameter_rows(found: ModelUpdate) -> list[list[str]]:
    """Header, and a row for each parameter."""
    rows = [["key", "before", "after", "change %", "95 %"]]
    for e in found.estimates:
        within = "at its bound" if e.on_bound else f"{e.low:.4g} to {e.high:.4g}"
        rows.append([e.key, f"{e.start:.5g}", f"{e.value:.5g}", signed(100.0 * (e.value / e.start - 1.0)), within])
    return rows


def mode_rows(found: ModelUpdate) -> list[list[str]]:
    """Header, and a row for each measured mode, before and after."""
    before, after = ({p.test: p for p in c.pairs} for c in (found.before, found.after))
    rows = [["no", "test Hz", "before Hz", "diff %", "after Hz", "diff %", "MAC"]]
    for k, hz in enumerate(found.after.measured.frequencies.tolist()):
        p = after.get(k)
        mac = NONE if p is None else fixed(p.mac, 3)
        rows.append([str(k + 1), f"{hz:.6g}", *_hz(before.get(k)), *_hz(p), mac])
    return rows


def update_notes(found: ModelUpdate) -> list[str]:
    """What of an update cannot be believed, and why."""
    return [*_lost(found), *_parameter_notes(found), *_fit_notes(found)]


def gained_note(found: ModelUpdate) -> list[str]:
    """Measured modes that joined the fit on the way."""
    return [f"measured modes that have found a partner: {_hz_of(found, found.gained)}"] if found.gained else []


def file_head(found: ModelUpdate, study: str, test: str) -> str:
    """The comment above the changed study."""
    lines = [f"# {study}, written by creak with what `creak update` found beside {test}:"]
    lines += [f"# {e.key}: {e.value:.6g} in place of {e.start:.6g}" for e in found.estimates]
    return "\n".join(lines) + "\n\n"


def _lost(found: ModelUpdate) -> Iterator[str]:
    if found.lost:
        yield f"measured modes that have lost their partner: {_hz_of(found, found.lost)}"
    if not found.settled:
        yield "each fit leads to other pairs than it was made of: the values hang on which modes count"


def _hz_of(found: ModelUpdate, tests: Sequence[int]) -> str:
    return first_few([f"{found.after.measured.frequencies[k]:g} Hz" for k in tests], NAMED)


def _parameter_notes(found: ModelUpdate) -> Iterator[str]:
    for e in found.estimates:
        if e.on_bound:
            yield f"{e.key} has stopped at its bound, {e.value:g}: the test asks for more, or for another change"
    together = [rows.tolist() for rows in found.fit.undetermined(TWICE)]
    for rows in together:
        if len(rows) == 1:
            yield f"the test does not determine {_names(found, rows)}: its 95 % interval is wider than a factor of 2"
        else:
            yield (
                f"the test does not tell {_names(found, rows)} apart: it determines a combination of them only; of "
                "another one the 95 % interval is wider than a factor of 2"
            )
    correlation = found.fit.correlation
    for i in range(len(found.estimates)):
        for j in range(i):
            told = any({i, j} <= set(rows) for rows in together)
            if not told and abs(correlation[i, j]) >= ALIKE:
                yield f"{_names(found, [j, i])} are nearly one parameter: correlation {correlation[i, j]:.2f}"


def _fit_notes(found: ModelUpdate) -> Iterator[str]:
    m, n, foretold = len(found.tracked), len(found.estimates), found.foretold
    if m - n < n:
        yield f"over-fitted: {plural(n, 'parameter')} from {plural(m, 'mode')}, with {m - n} left to check by"
    elif math.isnan(foretold):
        yield "over-fitted: a parameter hangs on one mode alone, which nothing checks"
    elif foretold >= found.unexplained[0]:
        yield (
            f"over-fitted: a mode as the others foretell it is {_percent(foretold)} % off (root mean square), no less "
            "than before the update"
        )
    if found.fit.scatter > MORE:
        yield (
            f"what is left is {found.fit.scatter:.2g} times the uncertainty of the test, {100.0 * found.sigma:g} %: "
            "something else differs too, and the intervals are wider by that factor"
        )


def _change(e: Estimate) -> str:
    within = "at its bound" if e.on_bound else f"95 %: {_told(e.low)} to {_told(e.high)}"
    return f"{e.key} from {_told(e.start)} to {_told(e.value)} ({within})"


def _told(value: float) -> str:
    return number(float(f"{value:.4g}"))


def _hz(p: ModePair | None) -> list[str]:
    return [NONE, NONE] if p is None else [f"{p.frequency_model:.6g}", signed(100.0 * p.difference)]


def _names(found: ModelUpdate, rows: Sequence[int]) -> str:
    return " and ".join(found.estimates[k].key for k in rows)


def _percent(share: float) -> str:
    return "0" if share < NOTHING else f"{100.0 * share:.2g}"


def _rms(values: Sequence[float]) -> float:
    return math.sqrt(sum(x * x for x in values) / len(values))
