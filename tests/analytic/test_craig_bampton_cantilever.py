"""Craig-Bampton on the uniform cantilever, cut at mid-span."""

from __future__ import annotations

import numpy as np
import pytest

from creak.arrays import to_dense
from helpers_cantilever import N, accurate_frequencies, cantilever, full, reduced

RECORDED = {"section": "reduction", "source": "extended precision"}

BETA_L = np.array([1.87510406871196, 4.69409113297417, 7.85475743823761, 10.9955407348754])
TABLE = {
    0: (2.6066, 34.22),
    1: (6.756e-3, 0.6363, 10.90, 51.9),
    2: (2.78e-4, 3.379e-2, 5.661e-2, 1.419),
    3: (3.9e-5, 5.643e-3, 4.166e-3, 0.1829),
    4: (8e-6, 1.525e-3, 6.38e-4, 4.701e-2),
}
"""Error in % of f1 to f4 over the number of fixed-interface modes per half."""
LAST_DIGIT = {
    0: (1e-4, 1e-2),
    1: (1e-6, 1e-4, 1e-2, 1e-1),
    2: (1e-6, 1e-5, 1e-5, 1e-3),
    3: (1e-6, 1e-6, 1e-6, 1e-4),
    4: (1e-6, 1e-6, 1e-6, 1e-5),
}
TABLE_ROUND_OFF = 1.5e-6
"""%: f1 of the table's reference came from a double precision eigensolver, which is good to eps x cond(K) of
some 1e-8; against the reference in extended precision f1's column is 1.0e-6 to 1.8e-6 % too low throughout."""
FIRST = (2.60664973, 6.756984e-3, 2.793937e-4, 4.01950e-5, 9.8161e-6)
"""The column of f1 against a reference in extended precision, %."""


@pytest.fixture(scope="module")
def reference() -> np.ndarray:
    return accurate_frequencies(full(cantilever()), 4)


@pytest.fixture(scope="module")
def errors(reference) -> dict[int, np.ndarray]:
    """Number of modes per half -> error of each frequency in %."""
    out = {}
    for count in TABLE:
        system = reduced(cantilever(), count)
        omega = accurate_frequencies(system, min(4, system.n))
        out[count] = 100.0 * (omega / reference[: omega.size] - 1.0)
    return out


def test_unreduced_frequencies_have_the_known_error_of_cubic_elements(reference, measured):
    """omega_h / omega - 1 = (beta h)^4 / 1440: the consistent Hermite beam, to leading order."""
    exact = BETA_L**2 / N**2 / np.sqrt(420.0)
    theory = (BETA_L / N) ** 4 / 1440.0
    # The next term is smaller by (beta h)^2 < .02; eigenvalues are good to 1e-12.
    measured(
        "cantilever of 80 cubic beams: error of frequency {}",
        reference / exact - 1.0,
        theory,
        rel=0.02,
        abs=1e-12,
        source="Euler-Bernoulli, (beta h)^4 / 1440",
        section="beams and solids",
    )


@pytest.mark.parametrize("count", sorted(TABLE))
def test_error_table_of_the_cantilever(errors, count, measured):
    expected, digit = np.array(TABLE[count]), np.array(LAST_DIGIT[count])
    found = errors[count][: expected.size]
    # Half a unit of the last printed digit; f1 also carries the round-off of the table's own reference.
    allowed = 0.51 * digit + np.where(np.arange(expected.size) == 0, TABLE_ROUND_OFF, 0.0)
    measured(f"cantilever cut in two, {count} modes a half: error of f{{}}", found, expected, abs=allowed, unit="%")


def test_first_frequency_error_down_to_the_eighth_digit(errors, measured):
    # 2e-9 relative: eigenvalues and superelement matrices in double precision, f1 of a 1e9 conditioned K.
    for count, expected in enumerate(FIRST):
        measured(
            f"cantilever cut in two, {count} modes a half: error of f1, eight digits",
            errors[count][0],
            expected,
            abs=2e-7,
            unit="%",
        )


def test_reduced_frequencies_are_upper_bounds(errors, measured):
    # Rayleigh-Ritz; 1e-7 % is the round-off of the superelement matrices.
    measured(
        "cantilever cut in two: frequency below the full model's, worst",
        max(0.0, -min(e.min() for e in errors.values())),
        at_most=1e-7,
        unit="%",
        source="Rayleigh, Ritz",
    )


def test_errors_fall_with_every_mode_kept(errors, measured):
    for count in range(1, 5):
        shared = min(errors[count].size, errors[count - 1].size)
        assert (errors[count][:shared] < errors[count - 1][:shared]).all()
    for j in range(4):
        counts = [count for count in TABLE if len(TABLE[count]) > j]
        table = [TABLE[count][j] for count in counts]
        measured.curve("craig-bampton", f"f{j + 1}", counts, [errors[count][j] for count in counts], table)


@pytest.mark.parametrize(("ratio", "left"), [(2, 1e-2), (3, 1e-3), (5, 3e-4)])
def test_cut_off_above_the_highest_frequency_asked_for(ratio, left, measured):
    """Rule of thumb: modes kept to 2, 3, 5 x f_max leave about 1, .1, .03 % at f_max.

    Here f_max is each of f3 to f11 in turn: "about" is a factor of 1.5 for the middle one, and 3.5 for the worst.
    """
    exact = accurate_frequencies(full(cantilever()), 11)
    errors = []
    for k in range(2, 11):
        found = accurate_frequencies(reduced(cantilever(), f_max=1.001 * ratio * exact[k] / (2 * np.pi)), k + 1)
        errors.append((found / exact[: k + 1] - 1.0).max())
    assert np.median(errors) < 1.5 * left
    measured(
        f"cantilever cut in two, modes to {ratio} x f_max: worst frequency error",
        max(errors),
        at_most=3.5 * left,
        source="rule of thumb",
    )


def test_all_modes_kept_give_all_frequencies_of_the_full_model(measured):
    model = cantilever()
    a, b = full(model), reduced(model, count=2 * N)
    assert a.n == b.n
    # Round-off: eps x cond(K) = 2e-16 x 1e9 for the lowest, much less for the others.
    found, exact = accurate_frequencies(b, 20), accurate_frequencies(a, 20)
    measured(
        "cantilever cut in two, all modes: frequency over full, worst",
        found / exact,
        1.0,
        rel=1e-8,
        source="full model",
    )


def test_constraint_modes_alone_are_exact_for_static_loads_at_the_cut_and_the_tip(measured):
    from helpers_cantilever import HALF, TIP

    model = cantilever()
    a, b = full(model), reduced(model, 0, retain=(0, HALF, HALF + 1, TIP))
    loaded = np.array([6 * HALF + 1, 6 * HALF + 5, 6 * TIP + 1, 6 * TIP + 5])
    answers = []
    for system in (a, b):
        R = system.rows(loaded)[0]
        answers.append(np.asarray(R @ np.linalg.solve(to_dense(system.K), to_dense(R).T)))
    # Round-off: eps x cond(K) of some 1e9.
    np.testing.assert_allclose(answers[1], answers[0], rtol=1e-7)
    # Tip deflection under a unit tip load, L^3 / 3EI: Hermite beams are exact at the nodes.
    measured(
        "cantilever cut in two, no modes: tip deflection",
        answers[1][2, 2],
        N**3 / 3.0,
        rel=1e-7,
        unit="m",
        source="closed form",
    )
