"""Memory told before a run: what grows with what, and what is said where it does not suffice."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
import scipy.sparse as sp

from creak.linalg.memory import OVERRIDE, OutOfMemory
from creak.linalg.mkl import has_pardiso
from creak.linalg.pencil import Pencil
from creak.linalg.pieces.dissection import cut_once_more, whole
from creak.linalg.pieces.factor import Pieces
from creak.studies.advise.choice import as_dict
from creak.studies.advise.memory import Memory, _reduction, memory, modes_below, runs_of
from creak.studies.advise.size import Counted, PartSize, sturm_counts
from creak.studies.file.reader import read_study
from creak.studies.models.of_parts import Room
from creak.studies.models.reference import ReferenceModel, build_reference
from creak.studies.prepare.setup import Setup, set_up
from helpers_advise import advice_on
from helpers_decks import STUDY, write_strips

WHOLE = Counted({3000.0: 12}, 0.1, 0.001, 40e6)


def part(name: str = "UPPER", scale: int = 1) -> PartSize:
    """Of 30,000 dofs, 300 modes below 3 kHz."""
    counted = Counted({1500.0: 100, 3000.0: 300}, 0.1, 0.001, 100e6)
    n = 30_000 * scale
    return PartSize(name, n, {"contact": 300}, counted, True, False, n - 300, 50 * n, 40 * n)


@pytest.fixture(scope="module")
def study(tmp_path_factory) -> tuple[Setup, ReferenceModel]:
    setup = set_up(read_study(write_strips(tmp_path_factory.mktemp("strips"))))
    return setup, build_reference(setup.structure, setup.band, lambda *_: None)


def told_of(setup: Setup, reference: ReferenceModel, whole: Counted, parts, unknowns: int, rows: int) -> Memory:
    runs = runs_of(setup.marching, setup.watch.nodes.size, rows, unreduced=setup.study.config.runs_unreduced)
    return memory(setup.reduction, reference, whole, parts, unknowns, runs)


def told(study: tuple[Setup, ReferenceModel], *parts: PartSize, method: str = "craig-bampton") -> Memory:
    setup, reference = study
    table = setup.study.config.reduction.model_copy(update={"method": method, "f_max": 3000.0})
    return told_of(setup.with_tables(reduction=table), reference, WHOLE, parts, 800, 40)


def test_modes_between_and_beyond_what_was_counted():
    counted = part().modes
    assert modes_below(counted, 3000.0) == 300
    assert modes_below(counted, 6000.0) == pytest.approx(900)  # three times for twice the frequency
    assert modes_below(Counted({100.0: 0, 200.0: 8}, 0.0, 0.0), 400.0) == pytest.approx(16)
    assert modes_below(Counted({100.0: 0}, 0.0, 0.0), 400.0) == 0


@pytest.mark.parametrize("grown", ["dofs", "modes", "factor"])
def test_the_peak_is_a_reduction_and_grows_with_all_that_the_part_has(study, grown):
    """Never less than the vectors of its modes and two factors of it."""
    small, large = part(), part("LOWER", scale=2)
    if grown == "modes":
        large = replace(part("LOWER"), modes=replace(small.modes, below={1500.0: 200, 3000.0: 600}))
    if grown == "factor":
        large = replace(part("LOWER"), modes=replace(small.modes, memory=300e6))
    found = told(study, large)
    assert found.reduce_peak.what == "LOWER: reduction"
    assert found.reduce_peak.gb > told(study, small).reduce_peak.gb
    assert found.reduce_peak.gb > (8.0 * large.inner * large.modes.below[3000.0] + 2.0 * large.factor) / 1e9
    assert "modes" in found.reduce_peak.why


def test_what_a_part_leaves_is_held_while_the_next_is_reduced(study):
    """Its modes, unless they are so large that they are read from the part's file; in `creak run` a small factor too,
    for the check."""
    one, two = told(study, part()), told(study, part(), part("LOWER"))
    assert two.reduce_peak.what == "LOWER: reduction"
    assert two.reduce_peak.gb - one.reduce_peak.gb > 8.0 * part().inner * part().modes.below[3000.0] / 1e9
    large = replace(part(), modes=replace(part().modes, memory=400e6))
    small, without = told(study, part(), part("LOWER")), told(study, large, part("LOWER"))
    held, less = (next(s.gb for s in each.run if s.what == "run") for each in (small, without))
    assert held - less > part().factor / 1e9
    assert small.reduce[-1].gb == without.reduce[-1].gb  # `creak reduce` has checked and saved the part by then
    huge = told(study, part(scale=10), part("LOWER"))
    assert huge.reduce[-2].gb < two.reduce[-2].gb


def test_other_methods(study):
    """Guyan has no modes; modes of the assembly take no part; without a reduction only the runs are left."""
    assert told(study, part(), method="guyan").reduce_peak.gb < told(study, part()).reduce_peak.gb
    assert [s.what for s in told(study, part(), method="gap-modes").reduce][2:] == ["modes for the reduction"]
    none = told(study, part(), method="none")
    assert len(none.reduce) == 2
    assert [s.what for s in none.run][2:] == ["run", "reference run"]


@pytest.mark.parametrize(
    ("time", "gigabytes", "factors"),
    [
        ({}, 100.0, 6),
        ({}, 4.9, 4),
        ({"integrator": "hht", "substeps": 1}, 6.0, 1),
        ({"integrator": "hht", "substeps": 20}, 6.0, 2),
    ],
)
def test_an_unreduced_run_holds_the_factors_of_its_flights(tmp_path, monkeypatch, time, gigabytes, factors):
    """Of order 9 five beside that of the steps in contact, of order 5 three where memory holds no more; a forced
    scheme has one for each length of its steps."""
    monkeypatch.setenv(OVERRIDE, str(gigabytes))
    monkeypatch.setattr("creak.studies.advise.memory.held_bytes", lambda: 0.0)
    setup = set_up(read_study(write_strips(tmp_path, study=STUDY.replace("step = 5e-4\n", ""))))
    table = setup.study.config.time.model_copy(update=time)
    reference = build_reference(setup.structure, setup.band, lambda *_: None)
    setup = setup.with_tables(time=table, reduction=setup.study.config.reduction.model_copy(update={"method": "none"}))
    none, one = (told_of(setup, reference, replace(WHOLE, memory=m), [], 800, 40).run[-1] for m in (0.0, 1e9))
    assert one.what == "reference run"
    assert one.gb - none.gb == pytest.approx(factors, rel=0.1)  # GB: one each
    assert ("factors" in one.why) == (factors > 1)


def test_answers_that_are_not_kept_are_not_counted(study):
    """Beyond 2 GB the responses of the channels are solved for, a block at a time."""
    setup, reference = study
    rows = round(0.75e9 / (8 * reference.system.n))
    gb = [told_of(setup, reference, WHOLE, [], 0, k * rows).run[-1].gb for k in (1, 2, 4, 5)]
    assert (gb[1] - gb[0]) - (gb[3] - gb[2]) == pytest.approx(0.75, rel=0.1)  # what else channels take is the same


def test_a_study_that_does_not_fit_is_told_with_what_to_do(study, monkeypatch):
    setup, _ = study
    assert not any(w.startswith("memory") for w in advice_on(setup).warnings)
    monkeypatch.setenv(OVERRIDE, "0.0005")
    monkeypatch.setattr("creak.studies.advise.memory.held_bytes", lambda: 0.0)
    monkeypatch.setattr("creak.linalg.factor.require", lambda *_: None)
    monkeypatch.setattr("creak.studies.models.of_parts.only_parts_fit", lambda *_: False)
    advice = advice_on(setup)
    said = next(w for w in advice.warnings if w.startswith("memory"))
    assert "0.0005 GB are free: lower f_max" in said
    data = as_dict(advice)["memory"]
    assert data["run_gb"] == max(s["gb"] for s in data["stages"]) >= data["reduce_gb"] > data["free_gb"]


@pytest.fixture(scope="module")
def alone(tmp_path_factory) -> Setup:
    """Without an unreduced run and a forced step: parts may do."""
    text = STUDY.replace("step = 5e-4\n", "") + "\n[reference]\nrun = false\n"
    return set_up(read_study(write_strips(tmp_path_factory.mktemp("alone"), study=text)))


def test_bounces_are_not_looked_at_where_no_step_is_forced(study, alone, monkeypatch):
    """They cost a back-substitution per channel and step."""
    forced, _ = study
    asked = []
    monkeypatch.setattr("creak.studies.advise.facts.bounces", lambda *_: asked.append(1) or (None, None))
    assert as_dict(advice_on(alone))["advice"]["step"] is None
    assert not asked
    advice_on(forced)
    assert asked


def test_where_the_whole_does_not_fit_parts_are_advised(alone, monkeypatch):
    """Same channels, retained dofs and modes of the parts; nothing is said of what takes the whole model."""
    whole = advice_on(alone)
    monkeypatch.setattr("creak.studies.models.of_parts.only_parts_fit", lambda *_: True)
    found = advice_on(alone)
    assert found.facts.channels.kept == whole.facts.channels.kept
    assert found.facts.sizes.unknowns(3000.0) == whole.facts.sizes.unknowns(3000.0)
    assert {o.method for o in found.facts.options} == {"craig-bampton"}
    assert found.option is not None
    assert found.option.method == "craig-bampton"
    assert any("memory does not hold a factor of the whole" in text for text in found.because)
    data = as_dict(found)
    assert data["unreduced"] is None
    assert [s["what"] for s in data["memory"]["stages"]] == [
        "assemble",
        *(f"{name}: what joins it" for name in ("UPPER", "LOWER")),
        *(f"{name}: reduction" for name in ("UPPER", "LOWER")),
        "couple and diagonalise",
        "run",
        "check of the superelements",
    ]


@pytest.mark.parametrize(
    ("change", "advised"),
    [
        ({"reference": {"run": True}}, {"reference.run": "spots"}),
        ({"reduction": {"method": "none"}}, {"reduction.method": "craig-bampton"}),
        (
            {"reference": {"run": True}, "reduction": {"method": "gap-modes"}},
            {"reference.run": "spots", "reduction.method": "craig-bampton"},
        ),
    ],
)
def test_what_takes_the_whole_is_advised_away(change, advised, alone, monkeypatch):
    """Memory for parts alone: a run is refused, advice says with what lines it would not be."""
    monkeypatch.setattr("creak.studies.models.of_parts.room", lambda *_: Room(3e9, 2e9, "UPPER"))
    monkeypatch.setenv(OVERRIDE, "2.5")
    tables = {name: getattr(alone.study.config, name).model_copy(update=new) for name, new in change.items()}
    found = advice_on(alone.with_tables(**tables))
    assert {c.key: c.new for c in found.changes}.items() >= advised.items()
    assert found.facts.unreduced is None


@pytest.mark.parametrize(("until", "advised"), [(None, {"spots"}), (1e-3, set())])
def test_an_unreduced_run_that_the_study_ends_early_is_left_alone(alone, monkeypatch, until, advised):
    """`until` beside other proofs is refused: advice that leads to a refusal is none."""
    monkeypatch.setattr("creak.studies.advise.choice.LONG_S", 0.0)
    reference = alone.study.config.reference.model_copy(update={"run": "whole", "until": until})
    found = advice_on(alone.with_tables(reference=reference))
    assert found.facts.unreduced is not None
    assert {c.new for c in found.changes if c.key == "reference.run"} == advised


def test_what_does_not_fit_is_refused_as_the_run_is(alone, monkeypatch):
    monkeypatch.setattr("creak.studies.models.of_parts.room", lambda *_: Room(3e9, 2e9, "UPPER"))
    monkeypatch.setenv(OVERRIDE, "1.5")
    with pytest.raises(OutOfMemory, match=r"does not hold the reduction of part UPPER: at least 2 GB are needed"):
        advice_on(alone)


def test_less_memory_takes_one_factor_files_and_pieces(study, monkeypatch):
    """Part of 30,000 dofs, factor of 100 MB, 300 modes: .2 GB for two factors, .13 GB for vectors, .1 for matrices."""

    def peak(gigabytes: float, cut: float = 0.0) -> tuple[float, str]:
        monkeypatch.setenv(OVERRIDE, str(gigabytes))
        stage = _reduction(replace(part(), cut=cut), 300, 3e8)
        return stage.gb, stage.why

    (plenty, two), (less, one), (least, pieces) = peak(10.0), peak(0.14), peak(0.1, 20e6)
    assert "two factors 0.2 GB" in two
    assert "factor 0.1 GB" in one
    assert "two" not in one
    assert "pieces of a factor 0.02 GB" in pieces
    assert plenty > less + 0.2
    assert less > least + 0.05


@pytest.mark.skipif(not has_pardiso(), reason="SuperLU does not tell what it will need")
def test_modes_are_counted_in_pieces_too(monkeypatch):
    """Sylvester: the inertia of a matrix in pieces is that of the whole."""
    line = sp.diags([-1.0, 2.0, -1.0], [-1, 0, 1], shape=(40, 40))
    K, M = sp.csr_matrix(sp.kronsum(line, line)), sp.identity(1600, format="csr")
    cut = cut_once_more(sp.csr_matrix(abs(K) + abs(M)), whole(K.shape[0]), len)
    assert cut is not None
    frequencies = [0.05, 0.2, 0.3]
    found = sturm_counts(Pencil(K, M, Pieces(cut, (1e9, 1e9), 1e9)), frequencies)
    eigenvalues = np.linalg.eigvalsh(K.toarray())
    assert list(found.below.values()) == [np.count_nonzero(eigenvalues < (2.0 * np.pi * f) ** 2) for f in frequencies]
    assert 0 < found.below[0.05] < found.below[0.3]
