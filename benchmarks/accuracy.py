"""Accuracy against size for every reduction: `python -m benchmarks.accuracy [--mesh-size H] [--out FOLDER]`.

One reference run; then each reduction of the same door: frequencies and MAC to 100 Hz, events and forces of the last
period, times. A table (CSV) and a plot are written.
"""

from __future__ import annotations

import argparse
import csv
import tempfile
import time
from pathlib import Path

import numpy as np
from matplotlib import colormaps
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.ticker import NullFormatter
from rich.console import Console

from benchmarks.door import silent
from creak.contact.step_problem import compile_kernels
from creak.door import write_door
from creak.studies.file.config import ReductionTable
from creak.studies.file.reader import read_study
from creak.studies.models.reduced import reduce_model
from creak.studies.prepare.output_steps import excitation_window
from creak.studies.prepare.setup import Setup, set_up
from creak.studies.run.compared import compare_events
from creak.studies.run.forced_step import limited
from creak.studies.run.job import compare_modes, march_run, prepare

CASES: dict[str, dict[str, object]] = {
    "Guyan": {"method": "guyan"},
    **{f"Craig-Bampton {f}": {"f_max": f} for f in (300, 700, 1500)},
    "D8": {"keep_out": 8},
    "D8 spacing 2": {"keep_out": 8, "interface": {"type": "spacing", "n": 2}},
    "D8 participation .35": {"keep_out": 8, "interface": {"type": "participation", "eta": 0.35}},
    "D8 interpolation 2": {"keep_out": 8, "interface": {"type": "interpolation", "n": 2}},
    "D8 interpolation 4": {"keep_out": 8, "interface": {"type": "interpolation", "n": 4}},
    "D8 characteristic 200": {"keep_out": 8, "interface": {"type": "characteristic", "n": 200}},
    **{f"gap modes {f}": {"method": "gap-modes", "f_max": f} for f in (300, 700)},
    **{f"massless {f}": {"method": "massless-boundary", "f_max": f} for f in (300, 700)},
}
HEAD = (
    "reduction",
    "retained",
    "unknowns",
    "worst_frequency_error",
    "lowest_mac",
    "events_matched",
    "events_missed",
    "events_extra",
    "mean_force_error",
    "mean_impulse_error",
    "offline_s",
    "online_s",
)


def main() -> None:
    """Run all cases."""
    options = argparse.ArgumentParser(prog="python -m benchmarks.accuracy")
    options.add_argument("--mesh-size", type=float, default=20.0, help="mm")
    options.add_argument("--out", type=Path, default=Path("build/accuracy"))
    given = options.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        write_door(given.mesh_size, Path(folder))
        setup = set_up(read_study(Path(folder) / "door.toml"))
    rows = study(setup)
    given.out.mkdir(parents=True, exist_ok=True)
    with (given.out / "accuracy.csv").open("w", newline="") as file:
        csv.writer(file).writerows([HEAD, *rows])
    plot(rows, given.out / "accuracy.png")


def study(setup: Setup) -> list[list[object]]:
    """One row a reduction."""
    compile_kernels()
    console = Console(width=200)
    reference, gaps, _ = prepare(with_reduction(setup, {"method": "gap-modes"}), silent)  # keeps its factor
    gaps, _ = limited(setup, reference, gaps)
    full = march_run("reference", setup, reference.system, gaps, silent, None)
    window = excitation_window(setup.study, setup.loads.time)
    console.print(*HEAD)
    rows: list[list[object]] = []
    for name, change in CASES.items():
        case = with_reduction(setup, change)
        started = time.perf_counter()
        model = reduce_model(case, reference, gaps, silent)
        offline = time.perf_counter() - started
        run = march_run("reduced", case, model.system, gaps, silent, model)
        modes = compare_modes(case, reference, model, gaps)
        tolerance = case.study.config.verification.event_tolerance
        match = compare_events({"reference": full, "reduced": run}, tolerance, window)
        assert modes is not None
        assert match is not None
        partner = modes.pairs.partner
        paired = np.where(partner >= 0, modes.freq_reduced[np.maximum(partner, 0)], np.inf)
        worst = float(np.abs(paired / modes.freq_reference - 1.0).max())
        rows.append(
            [
                name,
                model.retained,
                model.system.n,
                worst,
                float(modes.pairs.mac.min()),
                len(match.pairs),
                len(match.missed),
                len(match.extra),
                less_one(match.amplitude_ratio_mean),
                less_one(match.impulse_ratio_mean),
                round(offline, 1),
                round(run.cost.wall_s, 2),
            ]
        )
        console.print(*(f"{x:.3g}" if isinstance(x, float) else x for x in rows[-1]))
    return rows


def with_reduction(setup: Setup, change: dict[str, object]) -> Setup:
    """The same study, reduced otherwise."""
    return setup.with_tables(reduction=ReductionTable.model_validate(change))


def less_one(ratio: float | None) -> float:
    """Error of a ratio; infinite where no event was matched."""
    return float("inf") if ratio is None else ratio - 1.0


def plot(rows: list[list[object]], path: Path) -> None:
    """Worst frequency error and mean impulse error over the number of unknowns, offline and online time beside them.

    Cases that miss or add events are hollow; errors below 1e-6 are drawn there.
    """
    figure = Figure(figsize=(11.0, 4.6), layout="constrained")
    FigureCanvasAgg(figure)
    panels = (
        (2, 3, "unknowns of the reduced model", "worst frequency error to 100 Hz"),
        (2, 9, "unknowns of the reduced model", "mean impulse error of matched events"),
        (10, 11, "offline time, s", "online time, s"),
    )
    axes, colours = figure.subplots(1, 3), colormaps["tab20"]
    for ax, (across, up, x_label, y_label) in zip(axes, panels, strict=True):
        for number, row in enumerate(rows):
            x, y = (max(abs(float(str(row[c]))), 1e-6) for c in (across, up))
            whole = not int(str(row[6])) + int(str(row[7]))
            if np.isfinite(y):
                face = colours(number) if whole else "white"
                ax.loglog(x, y, "o", ms=9, mec=colours(number), mfc=face, mew=2, label=f"{number + 1} {row[0]}")
                ax.annotate(str(number + 1), (x, y), fontsize=7, xytext=(6, 4), textcoords="offset points")
        ax.set_xlabel(x_label)
        ax.set_ylabel(y_label)
        ax.xaxis.set_minor_formatter(NullFormatter())
        ax.grid(alpha=0.3)
    handles = [Line2D([], [], marker="o", ls="", color=colours(k), label=f"{k + 1} {r[0]}") for k, r in enumerate(rows)]
    figure.legend(handles=handles, loc="outside right upper", fontsize=8, frameon=False)
    figure.savefig(path, dpi=120)


if __name__ == "__main__":
    main()
