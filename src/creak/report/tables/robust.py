"""What `creak robust` found, as rows for terminal and page, and all draws as CSV."""

from __future__ import annotations

import csv
import io
from pathlib import Path

import numpy as np

from creak.formats.complete_file import write_text
from creak.model.units import UNITS
from creak.report.words.text import NONE, number
from creak.studies.file.changes import short_keys
from creak.studies.robust.findings import SHOWN, Robustness
from creak.studies.robust.shared_model import CREATED, FAILED, FIGURES, LEFT_OUT
from creak.verify.odds import Odds

WHOLE = 1e-9
"""Of a run, that may be missing from all of it."""


def odds_words(odds: Odds) -> str:
    """`12 % (8 to 17)`."""
    return f"{100.0 * odds.p:.3g} % ({100.0 * odds.low:.3g} to {100.0 * odds.high:.3g})"


def place_rows(found: Robustness) -> list[list[str]]:
    """Header and a row for each place."""
    units = UNITS[found.draws.setup.study.config.model.units]
    target = found.draws.setup.study.config.scatter.target
    head = ["place", "rattles", "events", f"impulse, {units.force} s", f"force, {units.force}"]
    rows = [[*head, f"gap for {100.0 * target:g} %, {units.length}"]]
    for p in found.places:
        spreads = (f"{number(s['median'])} (to {number(s['p95'])})" for s in (p.events, p.impulse, p.force))
        odds, need = odds_words(p.rattle), _need_words(found, p.name)
        if p.rattle.p + p.before_alone.p > p.rattle.high:
            odds += f", and before the window in {100.0 * p.before_alone.p:.3g} % more"
            need += "" if need == NONE else ", in the window alone"
        rows.append([p.name, odds, *spreads, need])
    return rows


def _need_words(found: Robustness, place: str) -> str:
    need = next(p.need for p in found.places if p.name == place)
    if need is None or not np.isfinite(need.shift):
        return NONE
    short, with_it = short_keys([*need.numbers]), ""
    if any(x != need.gap for x in need.numbers.values()):
        with_it = "".join(f", {short[key]} = {number(x)}" for key, x in need.numbers.items())
    if need.gap is not None:
        top = need.gap - need.shift + need.high
        return f"{number(need.gap)}" + (f" (to {number(top)})" if np.isfinite(top) else "") + with_it
    return f"{need.shift:+.3g} everywhere{with_it}"


def index_rows(found: Robustness) -> list[list[str]]:
    """Header and two rows for each cause: its indices alone and with others, and how far they are certain."""
    names = [name for name in SHOWN if name in found.indices]
    rows = [["cause", *names]]
    for cause in found.draws.design.causes:
        own = [found.indices[name][cause.key] for name in names]
        rows.append([f"{cause.key}, alone", *(_share_words(i.first, i.first_bounds) for i in own)])
        rows.append(["    with others", *(_share_words(i.total, i.total_bounds) for i in own)])
    return rows


def _share_words(share: float, bounds: tuple[float, float]) -> str:
    """By the farther bound: one may be cut."""
    return f"{share:.2f} ± {max(share - bounds[0], bounds[1] - share):.2f}"


def sentence(found: Robustness) -> str:
    """The answer in one line."""
    d = found.draws
    more = ""
    if found.rattle.foretold and d.further is not None:
        tried = f" ({d.further.rows.size} of these were marched to see how well)" if d.further.rows.size else ""
        more = f" and {found.rattle.foretold} more that motion without contact foretells{tried}"
    text = f"it rattles in {odds_words(found.rattle)} of {found.rattle.n} draws{more}{_window_words(found)}"
    causes = found.indices.get("force") or found.indices.get("rattle") or {}
    if len(causes) > 1:
        first = max(causes, key=lambda key: causes[key].total)
        lowest = causes[first].total_bounds[0]
        leading = [key for key, i in causes.items() if key == first or i.total_bounds[1] >= lowest]
        alike = "" if len(leading) == 1 else ", alike within their bounds"
        text += f"; most of the scatter comes from {' or '.join(leading)}{alike}"
    some = "all" if d.taken == d.design.total else f"{d.taken} of them"
    before = f", {some} from before" if d.taken else ""
    few = "" if d.marched == d.design.total else f", of which {d.marched} had to be marched"
    return f"{text}; {d.design.total} runs{few}{before}"


def _window_words(found: Robustness) -> str:
    """What of each run counts, where that is not all of it."""
    setup = found.draws.setup
    (start, end), last = setup.marching.window, float(setup.loads.time[-1])
    if start <= 0.0 and end >= last * (1.0 - WHOLE):
        return ""
    return f" (what touches from {start:.4g} to {end:.4g} s of {last:.4g} s counts)"


def write_draws(found: Robustness, path: Path) -> None:
    """A row for each run: its block, the values that were drawn, and what came of it."""
    d, text = found.draws, io.StringIO()
    values = d.drawn.means()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(["run", "block", *values, *(f"{p}.{f}" for p in d.places for f in FIGURES), "failed", "unreliable"])
    half = d.design.n // 2
    names = ["A", "B", *(f"A with {c.key} of B" for c in d.design.causes)]
    for k in range(d.design.total):
        figures = [repr(float(x)) for x in d.figures[k].ravel()]
        drawn = [repr(float(v[k])) for v in values.values()]
        marks = [int(d.state[k] == FAILED), int(d.state[k] in (CREATED, LEFT_OUT))]
        writer.writerow([k, names[k // half], *drawn, *figures, *marks])
    write_text(path, text.getvalue())
