"""Advice before a run: counts against the reductions themselves, estimates against closed forms, changes that fit."""

from __future__ import annotations

import json
import math
import re
import tomllib
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from creak.dynamics.scheme import HHT
from creak.linalg.pencil import Pencil
from creak.model.skin import skin_of
from creak.progress import silent
from creak.sound.rayleigh import AIR
from creak.studies.advise.choice import as_dict, changes_toml, choose
from creak.studies.advise.contact import bounces, numerical_damping, period_error, rounded_step, substeps_for
from creak.studies.advise.evidence import measured, points, rule_of_thumb
from creak.studies.advise.facts import Facts, gather
from creak.studies.advise.size import sizes, sturm_counts
from creak.studies.file.config import StudyConfig
from creak.studies.file.reader import read_study
from creak.studies.models.reduced import reduce_model
from creak.studies.models.reference import build_reference
from creak.studies.prepare.excitation import excitation_of
from creak.studies.prepare.setup import Setup, set_up
from creak.studies.sound.band import finer_mesh
from helpers_advise import advice_on, settings_of
from helpers_core import chain, channels, system_of
from helpers_decks import STUDY, two_strips, write_strips


@pytest.fixture(scope="module")
def setup(tmp_path_factory: pytest.TempPathFactory) -> Setup:
    """Every channel is kept."""
    study = STUDY + "[precheck]\nmargin = 0.5\n"
    return set_up(read_study(write_strips(tmp_path_factory.mktemp("strips"), None, study)))


@pytest.fixture(scope="module")
def facts(setup: Setup) -> Facts:
    return gather(setup, silent)


def changed(setup: Setup, changes: dict[str, Any]) -> Setup:
    """The setup with tables of the study replaced."""
    data = setup.study.config.model_dump(exclude_unset=True)
    for name, table in changes.items():
        data[name] = {**data.get(name, {}), **table}
    return replace(setup, study=replace(setup.study, config=StudyConfig.model_validate(data)))


@pytest.mark.parametrize("f_max", [6000.0, 20000.0])
def test_counted_size_is_that_of_the_reduced_model(setup, facts, f_max):
    """No mode is computed for the count, so nothing but equality will do."""
    reference = build_reference(setup.structure, setup.band, silent)
    study = changed(setup, {"reduction": {"f_max": f_max}})
    few = facts.gaps.select(np.array([0, 12, 38]))
    found = sizes(study.reduction, reference, few, [f_max], silent)
    made = reduce_model(study.reduction, reference, few, silent)
    assert made.coupled is not None
    assert found.unknowns(f_max) == made.coupled.n
    assert sum(p.boundary for p in found.parts) == made.retained
    assert {p.name: p.modes.below[f_max] for p in found.parts} == {
        r.system.name: r.system.stats.modes for r in made.superelements
    }
    assert made.modes > 0


def test_every_retained_dof_has_a_reason(facts):
    """Counted once, by the strongest reason: the watched nodes are contact nodes already."""
    upper, lower = facts.sizes.parts
    assert upper.retained["loads"] == 3  # z of the three nodes at its root
    assert upper.retained["supports"] == 15  # the other five dofs there
    assert lower.retained["supports"] == 18
    assert upper.retained["contact"] == lower.retained["contact"] == 3 * 36  # translations of all nodes but the root's
    assert set(upper.retained) | set(lower.retained) == {"loads", "supports", "contact"}


def test_sturm_count_of_a_fixed_chain():
    """Against the dense eigenvalues."""
    M, K = chain(40)
    f = np.sqrt(np.linalg.eigvalsh(np.linalg.solve(M, K)).clip(0.0)) / (2.0 * np.pi)
    between = [float(0.5 * (f[k] + f[k + 1])) for k in (4, 17)]
    assert list(sturm_counts(Pencil(K, M), between).below.values()) == [5, 18]


def test_errors_at_the_measured_multiples_are_the_measured_ones():
    for method, known in points().items():
        for p in known:
            found = measured(method, p.multiple)
            assert found is not None
            assert found.impulse_error == pytest.approx(p.impulse_error, rel=1e-12)
        assert measured(method, 0.9 * known[0].multiple) is None
        assert measured(method, 1.1 * known[-1].multiple) is None
    low, high = points()["gap-modes"][-2:]
    between = measured("gap-modes", math.sqrt(low.multiple * high.multiple))  # halfway on a logarithmic axis
    assert between is not None
    assert between.impulse_error == pytest.approx(math.sqrt(low.impulse_error * high.impulse_error), rel=1e-12)


def test_rule_of_thumb_ends_where_it_was_measured():
    assert [rule_of_thumb(x) for x in (1.9, 2.0, 3.0, 5.0, 15.0)] == pytest.approx([math.inf, 1e-2, 1e-3, 3e-4, 3e-4])


@pytest.mark.parametrize(
    ("alpha", "longer", "ratio"), [(-0.05, 0.0361, 1.18e-3), (1.0 - math.sqrt(2.0), 0.0458, 3.64e-3)]
)
def test_period_error_and_damping_of_hht(alpha, longer, ratio):
    """Published at h / T = .1, to three digits."""
    angle = 2.0 * math.pi * 0.1
    assert period_error(HHT(alpha), angle) == pytest.approx(longer, rel=2e-2)
    assert numerical_damping(HHT(alpha), angle) == pytest.approx(ratio, rel=2e-2)


def test_a_free_mass_bounces_for_half_a_period():
    mass, k = 2.0, 1e4
    system = system_of(np.diag([mass]), np.zeros((1, 1)))
    gaps = channels(np.array([[1.0]]), 1.0, k)
    automatic, fixed = bounces(system, gaps, np.zeros((1, 3)), HHT(), 1e-4)
    assert automatic is None
    assert fixed is not None
    # S = M where there is neither spring nor damper: the mass is exact
    assert fixed.shortest_s == pytest.approx(math.pi * math.sqrt(mass / k), rel=1e-12)
    assert substeps_for(1e-3, fixed) == 1  # 44 steps a bounce
    assert substeps_for(1e-2, fixed) == 3  # 100 ms / 44.4 ms


@pytest.mark.parametrize(
    ("h", "rounded"), [(1e-3, 1e-3), (9.9e-4, 5e-4), (2.6e-4, 2.5e-4), (4.2e-5, 4e-5), (0.03, 0.025)]
)
def test_rounded_steps(h, rounded):
    assert rounded_step(h) == pytest.approx(rounded, rel=1e-12)


HARD = {"contact": {"tip": {"secondary": "UNDER", "main": "OVER", "stiffness": "hard"}}}
THINNED = {"reduction": {"keep_out": 12.0, "interface": {"type": "participation", "eta": 0.35}}}
VARIANTS: list[tuple[dict[str, Any], str]] = [
    ({}, "gap-modes"),
    (THINNED, "gap-modes"),
    ({"reduction": {"interface": {"type": "characteristic", "n": 4}}}, "gap-modes"),
    (HARD, "craig-bampton"),
    ({"reduction": {"unreduced": ["LOWER"], "keep_out": 5.0}}, "craig-bampton"),
    ({"reduction": {"method": "none"}}, "none"),
    ({"time": {"step": 2e-3, "integrator": "generalised-alpha"}, "precheck": {"enabled": False}}, "gap-modes"),
]


@pytest.mark.parametrize(("changes", "method"), VARIANTS)
def test_the_lines_to_change_make_a_valid_study(setup, facts, changes, method):
    varied = changed(setup, changes)
    choice = choose(settings_of(varied), facts)
    assert ("none" if choice.option is None else choice.option.method) == method
    data = varied.study.config.model_dump(exclude_unset=True)
    for table, lines in tomllib.loads(changes_toml(choice.changes)).items():
        data[table] = {**data.get(table, {}), **lines}
    config = StudyConfig.model_validate(data)
    assert config.reduction.method == method
    assert config.precheck.enabled
    assert config.time.step <= 1.0 / (40.0 * 60.0)  # the multisine ends at 60 Hz
    assert config.reduction.keep_out == 0.0
    assert config.time.integrator == varied.study.config.time.integrator
    assert config.reduction.f_max >= 7.0 * 60.0
    assert choose(settings_of(replace(varied, study=replace(varied.study, config=config))), facts).changes == ()


def test_a_number_for_the_stiffness_asks_for_substeps(setup):
    stiff = HARD["contact"]["tip"] | {"stiffness": 1e4}
    study = replace(setup.study, config=changed(setup, {"contact": {"tip": stiff}}).study.config)
    varied = set_up(study)
    found = gather(varied, silent)
    choice = choose(settings_of(varied), found)
    assert choice.step.fixed is not None
    assert choice.step.automatic is None
    assert choice.substeps > 1
    assert (
        choice.step.step / choice.substeps <= 0.1 * choice.step.fixed.shortest_s * (1 + 1e-9) or choice.substeps == 100
    )
    assert {c.key: c.new for c in choice.changes}["time.substeps"] == choice.substeps


def other(tmp_path: Any, study: str, deck: str | None = None) -> Setup:
    return set_up(read_study(write_strips(tmp_path, deck, study)))


def warnings_of(setup: Setup) -> str:
    return "\n".join(advice_on(setup).warnings)


def test_a_load_that_closes_nothing_is_told(tmp_path):
    said = warnings_of(other(tmp_path, STUDY, two_strips(gap=20.0)))
    assert re.search(r"no channel closes: the smallest gap of the linear run is 1\S+ mm, the margin .* %", said)


def test_contact_everywhere_is_told(tmp_path):
    said = warnings_of(other(tmp_path, STUDY + "[precheck]\nmargin = 5.0\n"))
    assert "contact everywhere: 39 of 39 channels stay" in said


def test_an_unknown_excitation_is_told(tmp_path):
    line = STUDY[STUDY.index("signal =") : STUDY.index("[reduction]")]
    study = STUDY.replace(line, 'signal = { type = "step", amplitude = 0.1 }\n\n').replace("periods = 2", "end = 0.1")
    study = study.replace('kind = "displacement"', 'kind = "force"').replace("ROOT_UPPER", "TIP_UPPER")
    deck = two_strips().replace("ROOT_UPPER, 1, 2\nROOT_UPPER, 4, 6", "ROOT_UPPER, 1, 6")
    loaded = other(tmp_path, study, deck)
    assert excitation_of(loaded.study.driving, loaded.loads, 100.0).source == "assumed"
    assert "500 Hz, the verification's mac_f_max" in warnings_of(loaded)


def test_a_table_tells_its_frequency_by_its_samples(tmp_path):
    t = np.linspace(0.0, 0.4, 801)
    points = ", ".join(f"[{a:.6f}, {b:.9f}]" for a, b in zip(t, 0.1 * np.sin(2 * np.pi * 20.0 * t), strict=True))
    line = STUDY[STUDY.index("signal =") : STUDY.index("[reduction]")]
    study = STUDY.replace(line, f'signal = {{ type = "table", values = [{points}] }}\n\n').replace(
        "periods = 2", "end = 0.4"
    )
    setup = other(tmp_path, study)
    found = excitation_of(setup.study.driving, setup.loads, 100.0)
    assert found.source == "sampled"
    assert found.frequency == pytest.approx(20.0, abs=5.0)  # lines every 2.5 Hz, and the start bends the record


def test_everything_fits_into_a_json_file(setup, facts):
    data = as_dict(choose(settings_of(setup), facts))
    again = json.loads(json.dumps(data, allow_nan=False))
    assert again == data
    assert again["channels"]["contacts"] == 39
    assert [r["method"] for r in again["reductions"]].count("craig-bampton") == 5
    assert all(s["unreduced_s"] > 0.0 and s["reduced_s"] > 0.0 for s in again["steps"])


def test_bounds_are_above_what_the_door_left(facts):
    """The bound holds for any model, so for the measured one too."""
    for option in facts.options:
        if option.method == "craig-bampton" and option.door is not None:
            assert option.door.frequency_error < option.bound


def test_what_a_band_of_sound_takes(setup):
    """Twice the band in modes; waves of bending shorten with the square root of the frequency, those in air with it."""
    sound = gather(setup, silent, 30_000.0).sound
    D, m = 210_000.0 * 1.0**3 / (12.0 * (1.0 - 0.3**2)), 7.85e-9  # of the thinner strip
    assert sound.mesh == pytest.approx(math.sqrt(D / m) * 2.0 * math.pi / (6.0 * 10.0) ** 2, rel=0.01)
    air = 6.0 * 10.0e-3 / AIR.speed
    skin = skin_of(setup.model)
    assert finer_mesh(setup.model, skin, 1e-3, 5_000.0) == pytest.approx(math.sqrt(5_000.0 / sound.mesh), rel=1e-6)
    assert finer_mesh(setup.model, skin, 1e-3, 0.9 * sound.mesh) == 1.0
    assert sound.finer == pytest.approx(30_000.0 * air, rel=1e-6)
    assert sound.option.f_max == 60_000.0
    assert sound.dof_times == pytest.approx(sound.finer**2)
    assert sound.modes == 1500.0
    less = gather(setup, silent, 2_500.0).sound.beyond
    assert 2 < less.frequencies < sound.beyond.frequencies
    assert less.solves < less.share  # a small model: always in reach
