"""What the rows of all models say together."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np

from benchmarks.coverage.study import KEYS

OFF = 0.05
"""Share of total impulse or number of events from which a study is wrong."""
JUDGED = 0.01
"""The march's own error of a figure, as a share (of the event's duration for times), up to which it judges a bar."""
TIMES = ("start", "duration")
GOAL = 0.95

Row = Mapping[str, Any]


def summary(rows: Sequence[Row]) -> dict[str, Any]:
    """Coverage of each figure, shares of the verdicts, and the studies that are settled and wrong."""
    whole = [r for r in rows if "failed" not in r]
    good = [r for r in whole if r["own"]["settled"]]
    verdicts = Counter(str(r["verdict"]) for r in whole)
    settled = [r for r in good if r["verdict"] == "settled"]
    wrong = [r for r in settled if is_wrong(r)]
    return {
        "models": len(rows),
        "failed": {r["seed"]: r["failed"] for r in rows if "failed" in r},
        "own_not_settled": [r["seed"] for r in whole if not r["own"]["settled"]],
        "verdicts": {word: count / max(len(whole), 1) for word, count in sorted(verdicts.items())},
        "coverage": {
            "events of settled studies": coverage(settled),
            "events of all studies": coverage(good),
        },
        "settled": {"studies": len(settled), "off": len(wrong), "wrong": [case(r) for r in wrong]},
        "statistics": statistics(whole),
        "friction": friction(good),
        "reference": errors(good, "reference"),
        "reduced": errors(good, "reduced"),
        "cpu_s": {"own": mean(whole, lambda r: r["own"]["cpu_s"]), "creak": mean(whole, lambda r: r["cpu_s"])},
    }


def is_wrong(r: Row) -> bool:
    """Total impulse or number of events off by more than `OFF`."""
    own, found = r["own"], r["reduced"]
    count = abs(found["events"] - own["events"]) > OFF * max(own["events"], 1)
    return bool(count or abs(found["impulse"] - own["impulse"]) > OFF * max(own["impulse"], 1e-300))


def case(r: Row) -> dict[str, Any]:
    """A study in short."""
    own, found = r["own"], r["reduced"]
    return {
        "seed": r["seed"],
        "words": r["words"],
        "events": [own["events"], found["events"]],
        "impulse": found["impulse"] / own["impulse"] - 1.0 if own["impulse"] else np.inf,
    }


def coverage(rows: Sequence[Row]) -> dict[str, Any]:
    """Of each figure: bars that cover its error, bars, figures without one; error over bar, median and 95th percentile.

    A bar covers where error <= bar + the march's own error. Figures that the march does not know to `JUDGED` are left
    out. Events that only one of both has are counted beside.
    """
    found: dict[str, Any] = {}
    for name in KEYS:
        held, known, untold, ratios = 0, 0, 0, []
        for r in rows:
            for (error, bar, own), lasts in zip(r["reduced"]["figures"][name], r["reduced"]["durations"], strict=True):
                if own is None or own > JUDGED * (lasts if name in TIMES else 1.0):
                    continue
                if bar is None:
                    untold += 1
                    continue
                known += 1
                held += error <= bar + own
                ratios.append(error / max(bar + own, 1e-300))
        found[name] = {"covered": held, "bars": known, "without": untold, "share": held / known if known else None}
        if ratios:
            found[name] |= {"error_over_bar": np.percentile(ratios, [50.0, 95.0]).tolist()}
    found["missed"], found["extra"] = (sum(r["reduced"][key] for r in rows) for key in ("missed", "extra"))
    return found


def statistics(rows: Sequence[Row]) -> dict[str, Any]:
    """Studies called statistics, or that the march itself cannot repeat: whether both are alike as samples."""
    some = [r for r in rows if r["verdict"] == "statistics" or not r["own"]["settled"]]
    apart = [r for r in some if not r["reduced"]["alike"]]
    return {"studies": len(some), "apart": len(apart), "seeds": [r["seed"] for r in apart]}


def friction(rows: Sequence[Row]) -> dict[str, Any]:
    """Energy that sliding takes: what the reduced run has more than the march, over half of the impulses times closing
    speeds of its blows, median and largest share; studies that are settled and off by `OFF` of them.

    Where contact all but sticks, the heat itself is a few millionths of that, and its ratio says nothing.
    """
    some = [r for r in rows if r["own"]["friction_work"] > 0.0 and r["own"].get("blows", 0.0) > 0.0]
    shares = [abs(r["friction_work"] - r["own"]["friction_work"]) / r["own"]["blows"] for r in some]
    off = [r["seed"] for r, x in zip(some, shares, strict=True) if r["verdict"] == "settled" and x > OFF]
    return {
        "studies": len(some),
        "share": [float(np.median(shares)), max(shares)] if some else None,
        "settled_and_off": off,
    }


def errors(rows: Sequence[Row], run: str) -> dict[str, Any]:
    """Of a run of creak against the march: total impulse, and each figure; median and 95th percentile."""
    some = [r for r in rows if run in r and r["own"]["impulse"]]
    if not some:
        return {}
    totals = [abs(r[run]["impulse"] / r["own"]["impulse"] - 1.0) for r in some]
    counts = sum(r[run]["events"] != r["own"]["events"] for r in some)
    out: dict[str, Any] = {"studies": len(some), "other_count": counts}
    out["total_impulse"] = np.percentile(totals, [50.0, 95.0]).tolist()
    for name in KEYS:
        each = [f[0] for r in some for f in r[run]["figures"][name]]
        out[name] = np.percentile(each, [50.0, 95.0]).tolist() if each else None
    return out


def mean(rows: Sequence[Row], of: Callable[[Row], float]) -> float:
    """Over all rows."""
    return float(np.mean([of(r) for r in rows])) if rows else 0.0


def lines(found: Mapping[str, Any]) -> list[str]:
    """The summary as text."""
    failed, unsure = len(found["failed"]), len(found["own_not_settled"])
    said = [f"{found['models']} models, {failed} failed, {unsure} of which the march itself has not settled"]
    said.append("verdicts: " + ", ".join(f"{word} {share:.0%}" for word, share in found["verdicts"].items()))
    for title, of in found["coverage"].items():
        said.append(f"{title}: {of['missed']} missed, {of['extra']} extra")
        for name in KEYS:
            f = of[name]
            share = "-" if f["share"] is None else f"{f['share']:.0%}"
            tail = (
                ""
                if f["share"] is None
                else ", error over bar {:.2g} (median), {:.3g} (95 %)".format(*f["error_over_bar"])
            )
            said.append(
                f"  {name:<14} {f['covered']} of {f['bars']} bars cover ({share}), {f['without']} without{tail}"
            )
    settled = found["settled"]
    said.append(f"settled: {settled['studies']} studies, {settled['off']} off by more than {OFF:.0%}")
    said += [
        f"  seed {w['seed']:<4} events {w['events'][0]} -> {w['events'][1]}, impulse {w['impulse']:+.1%}  {w['words']}"
        for w in settled["wrong"]
    ]
    s = found["statistics"]
    said.append(
        f"as samples: {s['studies']} studies, {s['apart']} apart (seeds {', '.join(map(str, s['seeds'])) or '-'})"
    )
    f = found["friction"]
    if f["share"]:
        off = ", ".join(map(str, f["settled_and_off"])) or "-"
        said.append(
            f"friction's work off by {f['share'][0]:.2g} (median), {f['share'][1]:.2g} (largest) of the energy of the "
            f"blows, {f['studies']} studies; settled, off: {off}"
        )
    for run in ("reduced", "reference"):
        if found[run]:
            e = found[run]
            said.append(
                f"{run} run: total impulse off by {e['total_impulse'][0]:.2%} (median), "
                f"{e['total_impulse'][1]:.1%} (95 %); another number of events in {e['other_count']} of {e['studies']}"
            )
    said += [f"failed: seed {seed}: {why}" for seed, why in found["failed"].items()]
    said.append("CPU a model: {own:.1f} s the march, {creak:.1f} s creak".format(**found["cpu_s"]))
    return said
