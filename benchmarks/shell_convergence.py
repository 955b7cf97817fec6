"""Convergence of the shells on the published cases: `python -m benchmarks.shell_convergence [--out FOLDER]`.

Cases of tests/benchmarks_shell.py on a row of meshes, quads and triangles: one figure of small multiples and a table in
Markdown. The slope is fitted without the reference: values = limit + C h^p, one p for all modes of a case.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.ticker import FixedLocator, FuncFormatter, NullLocator
from rich.console import Console

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "tests"))

import benchmarks_shell as shell

KINDS = {"quad": "#0b6fa4", "tri": "#c8641b"}
NAMES = {"quad": "4-node", "tri": "3-node"}
PLATES, ROOFS, BEAMS = (4, 8, 12, 16, 24, 32), (4, 8, 16, 32, 48), (1, 2, 4, 8, 16)
FITTED = {PLATES: 2, ROOFS: 1, BEAMS: 1}
"""Coarsest meshes of each row that are left out of the fit."""
ENOUGH = 0.05
"""Largest misfit, relative to the change between the meshes, of a fit whose slope is told."""


@dataclass(frozen=True)
class Case:
    """Computed over reference, of one or several values, for n elements along a side."""

    name: str
    compute: Callable[[int, str], np.ndarray | float]
    meshes: tuple[int, ...]
    shown: int
    """The mesh of the table."""
    size: str = "{n} x {n}"


def beam_case(name: str, solve: Callable[..., float], load: str, scale: float = 1.0) -> Case:
    """A strip of 6 n x n elements; `scale` turns the published ratio into one to the converged reference."""
    return Case(name, lambda n, kind: solve(load, kind=kind, n=6 * n, m=n) * scale, BEAMS, 4, "{n6} x {n}")


CASES = (
    beam_case("curved beam, in plane", shell.curved_beam, "in-plane", 0.08734 / 0.08852),
    beam_case("curved beam, out of plane", shell.curved_beam, "out-of-plane", 0.5022 / 0.49830),
    beam_case("twisted beam, in plane", shell.twisted_beam, "in-plane"),
    beam_case("twisted beam, out of plane", shell.twisted_beam, "out-of-plane"),
    Case("Scordelis-Lo roof", shell.scordelis_lo, ROOFS, 8),
    Case("pinched hemisphere", shell.hemisphere, ROOFS, 16),
    Case("pinched cylinder", shell.cylinder, ROOFS, 32),
    Case("FV12 free plate, 8 modes", shell.free_plate, PLATES, 16),
    Case("FV16 cantilevered plate, 6 modes", shell.cantilever_plate, PLATES, 16),
    Case(
        "FV32 tapered membrane, 6 modes",
        lambda n, kind: shell.tapered_membrane(2 * n, n, kind),
        PLATES,
        16,
        "{n2} x {n}",
    ),
    Case("simply supported thick plate, 4 modes", shell.thick_plate, PLATES, 16),
    *(
        Case(
            f"thin plate {edges}, {len(shell.THIN_PLATES[edges])} modes",
            lambda n, kind, edges=edges: shell.thin_plate(edges, n, kind),
            PLATES,
            16,
        )
        for edges in shell.THIN_PLATES
    ),
)


@dataclass(frozen=True)
class Measured:
    """One case with one element."""

    values: np.ndarray
    """(n_mesh, n_value) computed / reference."""
    slope: float
    limit: np.ndarray
    """(n_value,) extrapolated."""
    misfit: float

    @property
    def error(self) -> np.ndarray:
        """(n_mesh,) largest |computed / reference - 1|."""
        return np.abs(self.values - 1.0).max(axis=1)


def measure(case: Case, kind: str) -> Measured:
    """Run a case on its meshes."""
    values = np.array([np.atleast_1d(case.compute(n, kind)) for n in case.meshes])
    first = FITTED[case.meshes]
    return Measured(values, *shell.fitted_slope(np.array(case.meshes[first:]), values[first:]))


def main() -> None:
    """Measure, draw, print the table."""
    options = argparse.ArgumentParser(prog="python -m benchmarks.shell_convergence")
    options.add_argument("--out", type=Path, default=Path("build/shell_convergence"))
    out = options.parse_args().out
    out.mkdir(parents=True, exist_ok=True)
    found = {(case.name, kind): measure(case, kind) for case in CASES for kind in KINDS}
    table = table_of(found)
    (out / "shell_convergence.md").write_text(table, encoding="utf-8")
    draw(found, out / "shell_convergence.png")
    Console(width=200).print(table, markup=False)


def table_of(found: dict[tuple[str, str], Measured]) -> str:
    """Largest error at the mesh shown, slope and limit of quads, then of triangles."""
    lines = [
        "| case | mesh | 4-node, % | slope | limit, % | 3-node, % | slope | limit, % |",
        "|---|---|---|---|---|---|---|---|",
    ]
    for case in CASES:
        row = [case.name, case.size.format(n=case.shown, n2=2 * case.shown, n6=6 * case.shown)]
        for kind in KINDS:
            m = found[case.name, kind]
            clear = m.misfit < ENOUGH
            row += [worst(m.values[case.meshes.index(case.shown)])]
            row += [f"{m.slope:.1f}", worst(m.limit)] if clear else ["-", "-"]
        lines.append(f"| {' | '.join(row)} |")
    return "\n".join(lines) + "\n"


def worst(values: np.ndarray) -> str:
    """The value farthest from 1, as a difference in per cent with its sign."""
    return f"{100.0 * (values[np.abs(values - 1.0).argmax()] - 1.0):+.2f}"


def draw(found: dict[tuple[str, str], Measured], path: Path) -> None:
    """Small multiples: largest error against elements along a side, both logarithmic."""
    figure = Figure(figsize=(13.0, 10.6))
    FigureCanvasAgg(figure)
    axes = figure.subplots(4, 4, sharey=True).ravel()
    for axis, case in zip(axes, CASES, strict=False):
        panel(axis, case, [found[case.name, kind] for kind in KINDS])
    for axis in axes[::4]:
        axis.set_ylabel("error, %")
    for axis in axes[len(CASES) - 4 : len(CASES)]:
        axis.set_xlabel("elements along a side")
    for axis in axes[len(CASES) :]:
        axis.axis("off")
    handles, names = axes[0].get_legend_handles_labels()
    axes[-1].legend(handles, names, loc="center", frameon=False, fontsize=11)
    figure.suptitle("Shells against published references: largest error of a case", x=0.02, ha="left", fontsize=14)
    figure.tight_layout(rect=(0, 0, 1, 0.985))
    figure.savefig(path, dpi=110)


def panel(axis: Axes, case: Case, measured: Sequence[Measured]) -> None:
    """One case: both elements, a line at 1 %, a slope of 2."""
    for (kind, colour), m in zip(KINDS.items(), measured, strict=True):
        axis.loglog(
            case.meshes, 100 * m.error, "o-" if kind == "quad" else "s--", color=colour, ms=4, lw=1.4, label=NAMES[kind]
        )
    n = np.array(case.meshes, dtype=float)
    axis.loglog(n, 40.0 * (n[0] / n) ** 2, color="#999999", lw=0.8, label="slope 2")
    axis.axhline(1.0, color="#444444", lw=0.8, ls=":", label="1 %")
    told = [f"{NAMES[k]} {m.slope:.1f}" for k, m in zip(KINDS, measured, strict=True) if m.misfit < ENOUGH]
    axis.set_title(case.name + (", 6n x n" if case.meshes is BEAMS else ""), fontsize=10, loc="left")
    axis.text(
        0.97,
        0.95,
        "fitted slope\n" + "\n".join(told) if told else "no single slope",
        transform=axis.transAxes,
        ha="right",
        va="top",
        fontsize=8,
        color="#333333",
        bbox={"facecolor": "white", "edgecolor": "none", "alpha": 0.8, "pad": 1.5},
    )
    axis.set_ylim(8e-3, 120)
    axis.xaxis.set_major_locator(FixedLocator(list(case.meshes)))
    axis.xaxis.set_minor_locator(NullLocator())
    axis.xaxis.set_major_formatter(FuncFormatter(lambda v, _: f"{v:g}"))
    axis.yaxis.set_major_formatter(FuncFormatter(lambda v, _: f"{v:g}"))
    axis.grid(color="#e4e4e4", lw=0.6)
    axis.spines[["top", "right"]].set_visible(False)


if __name__ == "__main__":
    main()
