"""Curves of the page against the instants of results.h5: extremes by pixels of time, and areas."""

from dataclasses import replace

import h5py
import numpy as np
import pytest
from scipy.integrate import trapezoid

from creak.formats.stored.tree import read_tree, write_tree
from creak.model.units import UNITS
from creak.report.figures.axes import COLUMNS, FULL, line, thinned
from creak.report.figures.gaps import gap_figure
from creak.report.figures.run import energy_figure, energy_terms, force_figure
from creak.studies.findings.gather import findings_of

UNIT = UNITS["mm-t-s"]
PIXELS = 1000
ROUNDING = 5e-6
"""Of a value: six digits of it are drawn."""


def flights(rng, end):
    """Instants of a run: some hits with many instants close to each other, little between them."""
    hits = np.sort(rng.uniform(0.02, 0.98, rng.integers(1, 60)))
    lasting = 10.0 ** rng.uniform(-5.0, -2.3, hits.size)
    share = 10.0 ** rng.uniform(-7.0, 0.0, (hits.size, rng.integers(5, 2000)))
    times = (hits[:, None] + lasting[:, None] * share).ravel()
    return end * np.unique(np.clip(np.concatenate([times, hits, np.linspace(0.0, 1.0, rng.integers(2, 200))]), 0, 1))


def course(rng, kind, t):
    """Force or gap over instants; nothing presses outside of the hits that its instants show."""
    s = (t - t[0]) / (t[-1] - t[0])
    if kind == "spikes":
        y = np.zeros(t.size)
        y[rng.integers(1, t.size - 1, 9)] = 10.0 ** rng.uniform(-3.0, 4.0, 9)
    elif kind == "steps":
        y = np.floor(7.0 * s) * np.sign(np.sin(40.0 * s))
    elif kind == "constant":
        y = np.full(t.size, -2.5)
    elif kind == "noise":
        y = rng.standard_normal(t.size) * 10.0 ** rng.uniform(-4, 4)
    elif kind == "pulses":
        fine = np.concatenate([[False], np.diff(t) < 1e-4 * np.ptp(t)])
        y = np.where(fine, np.abs(np.sin(3e3 * s)) + 0.01, 0.0)
        y[np.flatnonzero(fine[1:] & ~fine[:-1])] = 0.0
    else:
        y = 0.98 * np.sin(2 * np.pi * 37.0 * s) + 0.2 * np.cos(900.0 * s) + 3.7
    return y


def tops(t, y, end):
    """Highest and lowest value of the points in each pixel; not a number where there are none."""
    pixel = np.minimum((t - t[0]) / (end - t[0]) * PIXELS, PIXELS - 1).astype(int)
    found = np.full((2, PIXELS), np.nan)
    np.fmax.at(found[0], pixel, y)
    np.fmin.at(found[1], pixel, y)
    return found


def assert_drawn(trace, t, y):
    """The trace has the extremes of the record in each pixel of time, and its area."""
    x, shown = np.array(trace["x"]), np.array(trace["y"])
    assert (np.diff(x) >= 0.0).all()
    assert (x[0], x[-1]) == (t[0], t[-1])
    np.testing.assert_allclose(tops(x, shown, t[-1]), tops(t, y, t[-1]), rtol=ROUNDING)
    # The promise; the curve's own bound is a tenth of that.
    assert abs(trapezoid(shown, x) - trapezoid(y, t)) <= 0.01 * trapezoid(np.abs(y), t)


KINDS = ("spikes", "steps", "constant", "noise", "pulses", "motion")


@pytest.mark.parametrize("seed", range(20))
def test_a_curve_keeps_its_extremes_in_every_pixel_and_its_area(seed):
    rng = np.random.default_rng(seed)
    t = flights(rng, 10.0 ** rng.uniform(-6.0, 3.0))
    y = course(rng, KINDS[seed % len(KINDS)], t)
    trace = line(t, y, "a", "#000000")
    assert len(trace["x"]) <= max(FULL * COLUMNS, t.size)
    assert_drawn(trace, t, y)
    again = thinned(*thinned(t, y))
    assert all(np.array_equal(a, b) for a, b in zip(again, thinned(t, y), strict=True))


def test_a_long_record_is_thinned_and_a_burst_in_it_is_not_lost():
    rng = np.random.default_rng(1)
    t = np.unique(np.concatenate([np.linspace(0.0, 4.0, 4001), 3.0 + 1e-3 * np.sort(rng.uniform(size=200_000))]))
    y = np.where((t > 3.0) & (t < 3.001), 5.0 + np.sin(2e5 * t), 0.0)
    trace = line(t, y, "a", "#000000")
    assert 4000 < len(trace["x"]) <= FULL * COLUMNS
    assert_drawn(trace, t, y)


def with_instants(found, seed):
    """The same view with other instants, forces, gaps and energies."""
    rng = np.random.default_rng(seed)
    run = found.runs["reduced"]
    t = flights(rng, run.time[-1])
    kinds = [KINDS[(seed + j) % len(KINDS)] for j in range(4)]
    force = np.stack(
        [np.abs(course(rng, kinds[j % 2], t)) * rng.uniform(0.1, 1.0) for j in range(found.gaps.m)], axis=1
    )
    closest = np.stack([course(rng, kinds[2], t) for _ in found.contacts], axis=1).astype(np.float32)
    energy = np.stack([course(rng, kinds[3], t) for _ in range(run.energy.shape[1])], axis=1)
    other = replace(run, time=t, force=force, closest=closest, energy=energy)
    return replace(found, runs={"reduced": other}, events=None, window=(0.0, float(t[-1])))


@pytest.mark.parametrize("seed", [0, 3])
def test_the_page_draws_what_results_hold(result_of, tmp_path, seed):
    found = with_instants(findings_of(result_of("reduced only")), seed)
    with h5py.File(tmp_path / "results.h5", "w") as file:
        write_tree(file, found.runs["reduced"])
        held = read_tree(type(found.runs["reduced"]), file)
    force, gap = force_figure(found, UNIT).spec["data"], gap_figure(found, UNIT).spec["data"]
    assert_drawn(force[0], held.time, held.force.max(axis=1))
    assert force[0]["customdata"] == force[0]["y"]
    assert_drawn(gap[0], held.time, held.closest[:, 0].astype(float))
    for trace, values in zip(energy_figure(found, UNIT).spec["data"], energy_terms(held.history).values(), strict=True):
        assert_drawn(trace, held.time, values)
