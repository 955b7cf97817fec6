"""Sensitivities by closed form and by differences of the whole model; a plate whose wrong numbers a test finds."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
import scipy.linalg as sla

from creak.errors import InputError
from creak.formats.decks import read_model
from creak.report.words.update import update_notes
from creak.studies.file.changes import with_changes
from creak.studies.file.reader import read_study
from creak.studies.models.trials import (
    Trial,
    UpdateCase,
    candidates,
    frequency_slopes,
    joined,
    read_parameters,
    slopes,
    tried,
)
from creak.studies.models.update import sensitivities, update, update_case
from creak.studies.prepare.structure import Structure, modes_up_to
from creak.verify.bounded_fit import bounded_fit
from creak.verify.mac import mac_matrix
from helpers_decks import STUDY, write_strips, write_study
from helpers_modal import csv_text, measured_strip, strip_deck
from helpers_update import KEYS, TRUE, true_modes, write_plate, write_plate_test

RECORDED = {"section": "models"}

BENDING = (0, 1, 3)
"""Modes of the strip that bend it across its plane; the others twist it or bend it in its plane."""
JOINTS = (
    '[nodes.TIP]\nlabels = [1013, 1026, 1039]\n[[connector]]\ntype = "play"\nname = "stop"\nnodes = "TIP"\ndof = "z"\n'
    "lower = -0.1\nupper = 0.2\nstiffness = 30.0\n"
)


def value_of(key):
    return TRUE[key.split(".")[-1]]


@pytest.fixture(scope="module")
def plate(tmp_path_factory):
    folder = tmp_path_factory.mktemp("plate")
    return read_study(write_plate(folder)), true_modes(folder), folder


def test_slopes_of_a_cantilever(tmp_path):
    """f ~ t / L^2 sqrt(E / rho) of a thin strip: 1, 1/2 and -1/2."""
    deck = strip_deck(tmp_path)
    deck.write_text(deck.read_text().replace("210000., 0.3", "210000., 0.0"))
    found, test = measured_strip(deck)
    path = write_study(tmp_path, '[model]\ndeck = "strip.inp"\n', {"test.csv": csv_text(test)})
    ranked = sensitivities(update_case(read_study(path), tmp_path / "test.csv"))
    of = dict(zip(ranked.keys, ranked.slopes.T, strict=True))
    assert [p.model for p in ranked.before.pairs] == [*range(len(found.frequencies))]
    np.testing.assert_allclose(of["section.S.thickness"][[*BENDING]], 1.0, atol=1e-3)
    np.testing.assert_allclose(of["material.STEEL.youngs_modulus"], 0.5, atol=1e-9)
    np.testing.assert_allclose(of["material.STEEL.density"], -0.5, atol=1e-9)
    assert np.abs(ranked.differences).max() < 1e-6


def test_slopes_of_a_plate_are_those_of_differences(plate, tmp_path):
    """Thickness, modulus and springs, every mode: frequencies of the whole model at p exp(+-h)."""
    study, true, folder = plate
    case = update_case(study, write_plate_test(true, folder / "exact.csv"))
    start = {p.key: p.start for p in read_parameters(study, case.model, KEYS)}
    trial, h = tried(case, {}), 2e-4
    own = slopes(case, trial, {}, start)
    for j, (key, value) in enumerate(start.items()):
        up, down = (np.log(tried(case, {key: value * math.exp(x)}, trial.joined).found.frequencies) for x in (h, -h))
        count = min(up.size, down.size)
        np.testing.assert_allclose(own[:count, j], (up[:count] - down[:count]) / (2.0 * h), atol=1e-5)


def test_what_matrices_are_linear_in_takes_one_assembly(plate, tmp_path, monkeypatch):
    study, true, folder = plate
    case = update_case(study, write_plate_test(true, folder / "exact.csv"))
    trial, made, real = tried(case, {}), [], Structure.joined
    monkeypatch.setattr(Structure, "joined", lambda *x: made.append(1) or real(*x))
    for key, count in (("material.ALU.youngs_modulus", 1), ("section.FEET.stiffness", 1), (KEYS[0], 2)):
        made.clear()
        slopes(case, trial, {}, {key: read_parameters(study, case.model, [key])[0].start})
        assert len(made) == count


def test_parts_that_do_not_change_are_not_assembled_again(tmp_path):
    study = read_study(write_strips(tmp_path))
    found = joined(_case(study), {})
    other = joined(_case(study), {"section.LOWER.thickness": 2.0}, found)
    same = [a is b for a, b in zip(found.parts, other.parts, strict=True)]
    assert sorted(same) == [False, True]


def _case(study, closed=()):
    return UpdateCase(study, read_model(study.places.sibling("strips.inp")), None, None, {}, (), closed)


@pytest.mark.slow
def test_a_plate_with_wrong_thickness_modulus_and_springs_is_found(plate, tmp_path, measured):
    """20, 14 and 40 % off at the start; 1 % noise in 40 frequencies, MAC .95."""
    study, true, _ = plate
    found = update(update_case(study, write_plate_test(true, tmp_path / "test.csv", seed=1)), KEYS)
    source = "the model that made the test"
    for e in found.estimates:
        measured(f"update of a plate from noisy modes: {e.key}", e.value, value_of(e.key), rel=0.01, source=source)
        assert e.low < value_of(e.key) < e.high
        assert e.high / e.low < 1.05
    before, after = found.unexplained
    assert before > 0.1
    assert after == pytest.approx(0.01, abs=0.002)
    assert found.foretold == pytest.approx(after, rel=0.1)
    assert found.lost == []
    assert len(found.gained) > 5
    assert found.study.config.section["LEFT"].thickness == pytest.approx(found.estimates[0].value, rel=1e-6)
    assert study.config.section == {}


@pytest.mark.slow
def test_without_noise_the_numbers_are_exact(plate, tmp_path):
    study, true, _ = plate
    found = update(update_case(study, write_plate_test(true, tmp_path / "test.csv", count=12)), KEYS)
    for e in found.estimates:
        assert e.value == pytest.approx(value_of(e.key), rel=1e-6)


def test_a_fit_needs_parameters_and_an_uncertainty(plate, tmp_path):
    study, true, _ = plate
    case = update_case(study, write_plate_test(true, tmp_path / "test.csv", count=5))
    with pytest.raises(InputError, match="no parameters; expected a key or more"):
        update(case, [])
    with pytest.raises(InputError, match="sigma = 0; expected a key or more that may change, and 0 < sigma < 1"):
        update(case, KEYS, sigma=0.0)


def test_the_spring_is_what_would_mend_most(plate, tmp_path):
    study, true, _ = plate
    ranked = sensitivities(update_case(study, write_plate_test(true, tmp_path / "test.csv", count=12)))
    assert ranked.keys[ranked.ranked[0]] == "section.FEET.stiffness"
    assert 1.3 < ranked.best_factors[ranked.ranked[0]] < 2.2
    assert sorted(ranked.keys) == sorted(candidates(study, update_case(study, tmp_path / "test.csv").model))


def test_modulus_and_density_of_a_free_hanging_part_are_not_told_apart(tmp_path):
    """f ~ sqrt(E / rho): only the ratio is determined."""
    _, test = measured_strip(strip_deck(tmp_path))
    path = write_study(
        tmp_path,
        '[model]\ndeck = "strip.inp"\n',
        {"test.csv": csv_text(replace(test, frequencies=1.1 * test.frequencies))},
    )
    found = update(
        update_case(read_study(path), tmp_path / "test.csv"),
        ["material.STEEL.youngs_modulus", "material.STEEL.density"],
    )
    assert [rows.tolist() for rows in found.fit.undetermined(math.log(2.0))] == [[0, 1]]
    (told,) = (note for note in update_notes(found) if "apart" in note)
    assert "it determines a combination of them only; of another one the 95 % interval is wider than" in told
    E, rho = (e.value / e.start for e in found.estimates)
    assert E / rho == pytest.approx(1.21, rel=1e-5)


def test_a_joint_that_stays_closed_is_a_spring(tmp_path):
    """A play with two limits, closed: its stiffness once, at each of three nodes."""
    study = read_study(write_strips(tmp_path, study=STUDY + JOINTS))
    case = _case(study, closed=("stop",))
    open_, closed = (joined(_case(study, names), {}).system for names in ((), ("stop",)))
    added = (closed.K - open_.K).diagonal()
    assert sorted(added[np.abs(added) > 1e-9].tolist()) == pytest.approx([30.0, 30.0, 30.0])
    trial, h = tried_up_to(case, 500.0), 1e-4
    own = slopes(case, trial, {}, {"connector.0.stiffness": 30.0})
    up, down = (
        modes_up_to(joined(case, {"connector.0.stiffness": 30.0 * math.exp(x)}).system, 500.0).frequencies
        for x in (h, -h)
    )
    np.testing.assert_allclose(own[:, 0], np.log(up / down) / (2.0 * h), atol=1e-6)
    assert own.max() > 0.05
    with pytest.raises(InputError, match=r"no contact, connector or clip 'stopp' that touches. Did you mean 'stop'\?"):
        joined(_case(study, ("stopp",)), {})
    with pytest.raises(InputError, match="tip has no stiffness with which it could stay closed"):
        joined(_case(with_changes(study, {"contact.tip.stiffness": "hard"}), ("tip",)), {})


def tried_up_to(case, f_max):
    made = joined(case, {})
    return Trial(made, modes_up_to(made.system, f_max))


class SmallPlate:
    """The plate in the shapes of its first modes: what 100 tests of it share.

    K and M are cubic in the thickness, and K is linear in modulus and springs. So six structures give them for all values.
    """

    def __init__(self, case, shapes: int = 90) -> None:
        t = np.array([0.7, 0.9, 1.1, 1.3]) * TRUE["thickness"]
        base = [joined(case, {KEYS[0]: float(x), KEYS[1]: value_of(KEYS[1]), KEYS[2]: value_of(KEYS[2])}) for x in t]
        V = modes_up_to(base[2].system, 9000.0).shapes[:, :shapes]
        more = {key: {**dict.fromkeys([KEYS[0]], float(t[0])), key: 2.0 * value_of(key)} for key in KEYS[1:]}
        for key, other in zip(KEYS[1:], reversed(KEYS[1:]), strict=True):
            more[key][other] = value_of(other)

        def small(A):
            return V.T @ np.asarray(A @ V)

        powers = np.linalg.inv(np.vander(t, 4, increasing=True))
        self.K, self.M = (
            np.tensordot(powers, np.stack([small(getattr(b.system, name)) for b in base]), 1) for name in "KM"
        )
        self.linear = [small(joined(case, more[key]).system.K - base[0].system.K) / value_of(key) for key in KEYS[1:]]
        self.truth = np.log([value_of(key) for key in KEYS])
        self.frequencies, self.shapes = self.at(self.truth)[:2]

    def at(self, x):
        """sqrt(omega^2), shapes and their slopes."""
        t, rest = math.exp(x[0]), np.exp(x[1:])
        grow = t ** np.arange(4)
        K = np.tensordot(grow, self.K, 1) + sum(
            (p - value_of(key)) * A for p, key, A in zip(rest, KEYS[1:], self.linear, strict=True)
        )
        M = np.tensordot(grow, self.M, 1)
        omega2, phi = sla.eigh(K, M)
        turned = np.arange(4) * grow
        columns = [frequency_slopes(np.tensordot(turned, self.K, 1), np.tensordot(turned, self.M, 1), phi, omega2)]
        columns += [frequency_slopes(p * A, 0.0 * A, phi, omega2) for p, A in zip(rest, self.linear, strict=True)]
        return np.sqrt(omega2), phi, np.column_stack(columns)

    def fitted(self, seed: int, count: int = 40, sigma: float = 0.01):
        test = self.frequencies[:count] * (1.0 + sigma * np.random.default_rng(seed).standard_normal(count))
        known = {}

        def paired(x):
            if x.tobytes() not in known:
                omega, phi, slope = self.at(x)
                like = mac_matrix(self.shapes[:, :count], phi).argmax(axis=1)
                known[x.tobytes()] = omega[like] / test, slope[like]
            return known[x.tobytes()]

        return bounded_fit(
            lambda x: (paired(x)[0] - 1.0) / sigma,
            lambda x: paired(x)[0][:, None] * paired(x)[1] / sigma,
            self.truth + np.log([1.05, 0.95, 0.9]),
            self.truth - 1.0,
            self.truth + 1.0,
        )


def test_intervals_of_the_plate_hold_the_truth_in_95_of_100_tests(plate, tmp_path, measured):
    study, true, _ = plate
    small = SmallPlate(update_case(study, write_plate_test(true, tmp_path / "test.csv", count=3)))
    np.testing.assert_allclose(small.frequencies[:20] / (2.0 * np.pi), true.frequencies[:20], rtol=2e-3)
    fits = [small.fitted(seed) for seed in range(100)]
    off = np.array([fit.x - small.truth for fit in fits])
    held = np.abs(off) <= np.array([fit.half_width for fit in fits])
    source = "100 tests with 1 % noise, seeds 0 to 99"
    for j, key in enumerate(KEYS):
        measured(
            f"update of a plate, {key}: truth within the 95 % interval, of 100",
            int(held[:, j].sum()),
            between=(90, 100),
            source=source,
        )
        measured(
            f"update of a plate, {key}: standard deviation from the truth",
            float(off[:, j].std()),
            at_most=0.012,
            source=source,
        )
    assert 0.92 <= held.mean() <= 0.99
