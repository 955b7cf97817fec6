"""[damping] from_test: modes take the damping of their measured partners, all others the mean."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import creak
from creak.contact.gap_operator import join
from creak.errors import InputError
from creak.progress import silent
from creak.reduction.modal import ModalShares, modal_values
from creak.studies.file.reader import read_study
from creak.studies.models.deck_modes import model_modes
from creak.studies.models.reduced import reduce_model
from creak.studies.models.reference import build_reference
from creak.studies.prepare.setup import set_up
from creak.studies.warned import warnings_of
from helpers_decks import STUDY, write_strips
from helpers_modal import Test, csv_text, normal_mode, points_15

MEASURED = {0: 0.03, 2: 0.004, 3: 0.01}
"""Row of the mode -> damping."""
MEAN = np.mean([*MEASURED.values()])


def study_of(folder, damping: str):
    return read_study(write_strips(folder, study=f"{damping}\n{STUDY}"))


def strips_test(folder, rows=MEASURED) -> Test:
    """Some modes of the strips as the study moves and holds them, measured at every third node."""
    setup = set_up(study_of(folder, ""))
    system, found = model_modes(setup.model, setup.structure.driven, count=8)
    nodes = setup.model.nodes
    kept = np.arange(0, nodes.count, 3)
    labels = (6 * kept[:, None] + np.arange(3)).ravel()
    moves = np.isin(labels, system.labels)
    shapes = np.zeros((labels.size, found.omega2.size))
    shapes[moves] = system.rows(labels[moves])[0] @ found.shapes
    chosen = [*rows]
    return Test(
        nodes.ids[kept].tolist(),
        nodes.coords[kept],
        shapes.T.reshape(-1, kept.size, 3)[chosen],
        found.frequencies[chosen] * 1.04,
        np.array([*rows.values()]),
    )


def write(folder, t: Test):
    (folder / "modes.unv").write_text(points_15(t) + "".join(normal_mode(t, k) for k in range(len(t.frequencies))))


@pytest.fixture
def measured_study(tmp_path):
    write(tmp_path, strips_test(tmp_path))
    return study_of(tmp_path, 'damping.from_test = "modes.unv"')


def shares(system, found) -> np.ndarray:
    """phi' C phi / (2 omega)"""
    C, omega = system.damping, np.sqrt(found.omega2)
    other = (found.shapes * C.other(found.shapes)).sum(axis=0)
    return (C.beta * omega**2 + other) / (2.0 * omega)


def test_partners_have_the_measured_damping_and_others_their_mean(measured_study):
    setup = set_up(measured_study)
    reference = build_reference(setup.structure, setup.band, silent)
    found = shares(reference.system, reference.modes)
    expected = np.full(found.size, MEAN)
    expected[[*MEASURED]] = [*MEASURED.values()]
    assert found == pytest.approx(expected, rel=1e-9)
    assert found.size > 6
    assert any("3 modes of the model have that of their partners in modes.unv" in note for note in setup.notes)
    assert any("its mean, 1.47 % of critical" in note for note in setup.notes)


def test_the_reduced_model_has_the_same_damping(measured_study):
    setup = set_up(measured_study)
    reference = build_reference(setup.structure, setup.band, silent)
    reduced = reduce_model(setup.reduction, reference, join([setup.contacts, setup.connectors]), silent).system
    omega2, C = reduced.K.diagonal(), reduced.damping
    W = C.modal_shapes
    d = np.einsum("ij,j,ij->i", W, C.modal_values, W)
    elastic = np.flatnonzero(omega2 > 0.0)[:6]
    expected = np.array([MEASURED.get(k, MEAN) for k in range(6)])
    assert (d / (2.0 * np.sqrt(np.where(omega2 > 0.0, omega2, 1.0))))[elastic] == pytest.approx(expected, rel=1e-6)


def test_one_measured_damping_of_all_modes_is_modal_damping(tmp_path):
    """Forces and gaps of both runs are the same numbers, to round-off."""
    write(tmp_path, strips_test(tmp_path, dict.fromkeys(range(3), 0.02)))
    found = [
        creak.run(
            creak.change_study(study_of(tmp_path, line), {"time.periods": 0.5}), converge=False, record=False
        ).main.history.gap
        for line in ("damping.modal = 0.02", 'damping.from_test = "modes.unv"')
    ]
    assert found[1] == pytest.approx(found[0], abs=1e-9 * np.abs(found[0]).max())


def test_what_does_not_fit_is_told(tmp_path):
    """Pairs whose shapes or frequencies are others, modes without a partner, and damping in per cent are warned of."""
    t = strips_test(tmp_path)
    write(tmp_path, t)
    assert not warnings_of(set_up(study_of(tmp_path, 'damping.from_test = "modes.unv"')).notes)
    moved = replace(t, frequencies=t.frequencies * 1.5)
    write(tmp_path, moved)
    told = set_up(study_of(tmp_path, 'damping.from_test = "modes.unv"')).notes
    assert any("of its 3 modes 0 have no partner, and 3 have one that does not fit" in w for w in warnings_of(told))
    lost = t.shapes.copy()
    lost[1] = np.random.default_rng(1).normal(size=lost[1].shape)
    write(tmp_path, replace(t, shapes=lost))
    told = set_up(study_of(tmp_path, 'damping.from_test = "modes.unv"')).notes
    assert any("of its 3 modes 1 have no partner, and 0 have" in w for w in warnings_of(told))
    write(tmp_path, replace(t, damping=np.full(3, 0.5)))
    told = set_up(study_of(tmp_path, 'damping.from_test = "modes.unv"')).notes
    assert "damping of 50 % of critical: is it per cent that the file has?" in warnings_of(told)


def test_a_table_is_read_too(tmp_path):
    (tmp_path / "modes.csv").write_text(csv_text(strips_test(tmp_path)))
    setup = set_up(study_of(tmp_path, 'damping.from_test = "modes.csv"'))
    assert isinstance(setup.structure.modal, ModalShares)
    assert setup.structure.modal.zeta == pytest.approx([*MEASURED.values()])


def test_each_frequency_gives_its_damping_once():
    """Of two close modes the nearer one is the partner; a mode that is far from all has the mean."""
    known = ModalShares(np.array([10.0, 20.0]), np.array([0.03, 0.05]), 0.04)
    omega2 = (2.0 * np.pi * np.array([0.0, 9.9, 10.01, 20.5, 30.0])) ** 2
    assert known.at(omega2).tolist() == [0.04, 0.04, 0.03, 0.05, 0.04]
    beta, d = modal_values(omega2, known, beyond=True)
    total = beta * omega2 + d
    assert total == pytest.approx(2.0 * known.at(omega2) * np.sqrt(omega2))


def undamped(t: Test) -> str:
    t = replace(t, damping=np.zeros(len(t.damping)))
    return points_15(t) + "".join(normal_mode(t, k) for k in range(len(t.frequencies)))


def far(t: Test) -> str:
    return points_15(replace(t, points=t.points + 1e3, labels=[9000 + n for n in t.labels])) + normal_mode(
        replace(t, labels=[9000 + n for n in t.labels]), 0
    )


def partnerless(t: Test) -> str:
    """The one mode with damping has no partner."""
    odd = np.random.default_rng(2).normal(size=t.shapes[0].shape)
    rest = replace(t, damping=np.zeros(len(t.damping)))
    return points_15(t) + normal_mode(t, 0, odd) + "".join(normal_mode(rest, k) for k in range(1, 3))


WRONG = {
    "no damping": (undamped, "no mode in it has damping"),
    "of a mode without partner": (partnerless, "no mode in it that has a partner in the model has damping"),
    "over critical": (lambda t: points_15(t) + normal_mode(replace(t, damping=t.damping + 1.0), 0), "below 1"),
    "off the model": (far, "sensors are not on the model"),
    "no modes": (points_15, "no modes in it"),
}


@pytest.mark.parametrize("name", WRONG)
def test_files_that_cannot_be_used(tmp_path, name):
    text, words = WRONG[name]
    (tmp_path / "modes.unv").write_text(text(strips_test(tmp_path)))
    with pytest.raises(InputError, match=words) as raised:
        set_up(study_of(tmp_path, 'damping.from_test = "modes.unv"'))
    assert "modes.unv" in str(raised.value) or "study.toml" in str(raised.value)


def test_one_damping_at_a_time_and_a_file_that_is_there(tmp_path):
    with pytest.raises(InputError, match="give either modal or from_test, not both"):
        study_of(tmp_path, 'damping.modal = 0.02\ndamping.from_test = "modes.unv"')
    with pytest.raises(InputError, match="no such file"):
        set_up(study_of(tmp_path, 'damping.from_test = "absent.unv"'))


def test_a_curve_of_shares_goes_on_in_proportion_to_stiffness_without_a_step():
    """At the highest computed mode, 30 Hz, the curve is at .04; beyond it zeta grows as omega."""
    known, top = ModalShares(np.array([10.0, 50.0]), np.array([0.02, 0.06]), 0.5, curve=True), 2.0 * np.pi * 30.0
    beta, d = modal_values(np.array([(2.0 * np.pi * 5.0) ** 2, top**2]), known, beyond=True)
    assert beta * top == pytest.approx(2.0 * 0.04)
    np.testing.assert_allclose(d, [2.0 * 0.02 * 10.0 * np.pi - beta * (10.0 * np.pi) ** 2, 0.0], atol=1e-12)
