"""Cases of a sweep: combinations, names, studies, identities."""

from __future__ import annotations

import tomllib
from pathlib import Path

import pytest

from creak.errors import InputError
from creak.studies.file.changes import STRIDE, UNSEEDED, changed, short_keys, value_words
from creak.studies.file.reader import read_study
from creak.studies.file.signals.tables import MultisineTable
from creak.studies.file.signals.vibration import PsdTable
from creak.studies.sweep.cases import Case, combinations, folder_names, resolve, unique
from creak.studies.sweep.file import read_sweep
from creak.studies.sweep.job import columns, waiting
from helpers_decks import STUDY, write_strips
from helpers_refusal import refusal


def cases_of(folder: Path, text: str, out: str = "out") -> list[Case]:
    if not (folder / "study.toml").exists():
        write_strips(folder)
    path = folder / "sweep.toml"
    path.write_text(f'base = "study.toml"\n{text}', encoding="utf-8")
    return resolve(read_sweep(path), folder / out)


def test_grid_cases_and_seeds_are_combined(tmp_path):
    cases = cases_of(
        tmp_path,
        """seeds = [1, 2]
[grid]
"reduction.f_max" = [300.0, 1500]
"excitation.root.signal.amplitude" = [0.01, 0.02]
[[case]]
name = "D40"
changes = { "reduction.keep_out" = 40 }
[[case]]
changes = { "contact.tip.friction" = 0.5 }
""",
    )
    names = [c.name for c in cases]
    assert len(set(names)) == len(names) == 2 * 2 * 2 * 2
    assert names[0] == "D40,f_max=300,amplitude=0.01,seed=1"
    assert names[-1] == "friction=0.5,f_max=1500,amplitude=0.02,seed=2"
    assert cases[0].changes == {
        "reduction.f_max": 300.0,
        "excitation.root.signal.amplitude": 0.01,
        "reduction.keep_out": 40.0,
        "contact.tip.friction": 0.0,
    }
    assert [c.seed for c in cases[:2]] == [1, 2]
    assert len({c.id for c in cases}) == len(cases)


CHANGED_TABLES = {
    "reduction.interface": '{ type = "spacing", n = 2 }',
    "excitation.root.signal": '{ type = "psd", unit = "unit2/Hz", values = [[5, 1], [50, 1]] }',
    "contact.tip": '{ secondary = "UNDER", main = "OVER", friction = { static = 0.5, kinetic = 0.3 } }',
    "output.nodes": '["TIP", "ROOT"]',
}


@pytest.mark.parametrize("key", CHANGED_TABLES)
def test_a_table_as_a_value_is_shown_without_the_keys_that_it_lacks(tmp_path, key):
    cases = cases_of(tmp_path, f'[[case]]\nname = "base"\n[[case]]\nchanges = {{ "{key}" = {CHANGED_TABLES[key]} }}')
    for case, cell in zip(cases, columns([waiting(case) for case in cases])[key], strict=True):
        assert tomllib.loads(f"value = {cell}")["value"] == case.changes[key]


def test_keys_are_shortened_as_far_as_they_stay_apart():
    assert short_keys(["reduction.f_max", "verification.f_max", "time.step"]) == {
        "reduction.f_max": "reduction.f_max",
        "verification.f_max": "verification.f_max",
        "time.step": "step",
    }
    assert short_keys(["excitation.root.signal.seed"]) == {"excitation.root.signal.seed": "signal.seed"}


@pytest.mark.parametrize(
    ("value", "words"),
    [
        (0.1, "0.1"),
        (1e-5, "1e-05"),
        (123456.789, "123456.789"),
        (True, "true"),
        ("auto", "auto"),
        ({"type": "spacing", "n": 2}, "spacing+2"),
        ([1, 2.5], "1+2.5"),
    ],
)
def test_values_in_words(value, words):
    assert value_words(value) == words


def test_names_stay_apart():
    assert unique(["a", "A", "b", "a"]) == ["a", "A#2", "b", "a#3"]
    names = folder_names(["../x", "a/b", "a_b", "superelements", "n" * 300, "n" * 301])
    assert names[1:3] == ["a_b", "a_b#2"]
    assert names[3] != "superelements"
    assert len({n.lower() for n in names}) == 6
    assert all("/" not in n and not n.startswith(".") and len(n) < 130 for n in names)


def test_changes_replace_what_is_there():
    base = {"reduction": {"interface": {"type": "spacing", "n": 3}}, "connector": [{"lower": 1.0}, {"lower": 2.0}]}
    out = changed(base, {"reduction.interface": {"type": "full"}, "connector.1.lower": 5.0, "time.step": 1.0}, None)
    assert out["reduction"]["interface"] == {"type": "full"}
    assert [c["lower"] for c in out["connector"]] == [1.0, 5.0]
    assert out["time"] == {"step": 1.0}
    assert base["connector"][1]["lower"] == 2.0


def test_a_row_has_one_name():
    """Else two changes of it could not be told from changes of two rows."""
    base = {"connector": [{"lower": -1.0}, {"lower": -2.0}]}
    for key in ("connector.00.lower", "connector.01.lower", "connector.01"):
        with pytest.raises(InputError, match=r"the study has 2 \[\[connector\]\]; expected connector.0 to connector.1"):
            changed(base, {key: -3.0}, None)


def test_seeds_reach_every_multisine():
    multisine = {"signal": {"type": "multisine", "seed": 1}}
    base = {"excitation": {"a": multisine, "b": multisine, "c": {"signal": {"type": "sine"}}}}
    signals = [t["signal"] for t in changed(base, {}, 7)["excitation"].values()]
    assert [s.get("seed") for s in signals] == [7, 7, None]


def test_seeds_leave_independent_signals_independent():
    """Equal seeds of the base stay equal, others stay apart, in their order; one that is wrong is left to the check."""
    seeds = {"a": 9, "b": 7, "c": 9, "d": None, "e": 8, "f": "x"}
    kinds = {"a": "psd", "b": "multisine"}
    base = {
        "excitation": {
            name: {"signal": {"type": kinds.get(name, "psd"), **({} if one is None else {"seed": one})}}
            for name, one in seeds.items()
        }
    }
    signals = [t["signal"]["seed"] for t in changed(base, {}, 5)["excitation"].values()]
    assert signals == [5 + 3 * STRIDE, 5 + STRIDE, 5 + 3 * STRIDE, 5, 5 + 2 * STRIDE, "x"]


@pytest.mark.parametrize("table", [MultisineTable, PsdTable])
def test_a_signal_that_says_no_seed_has_that_of_its_table(table):
    assert table.model_fields["seed"].default == UNSEEDED


def test_the_seed_of_a_case_is_the_sweeps_with_independent_axes_too(tmp_path):
    study = write_strips(tmp_path)
    root = study.read_text().partition("[excitation.root]")[2].partition("\n[")[0]
    more = root.replace("seed = 3", "seed = 4").replace('"z"', '"y"')
    study.write_text(f"{study.read_text()}\n[excitation.more]{more}\n")
    assert [c.seed for c in cases_of(tmp_path, "seeds = [5, 6]")] == [5, 6]
    assert [c.seed for c in cases_of(tmp_path, '[[case]]\nname = "as it is"')] == [None]


@pytest.mark.parametrize(
    ("text", "words"),
    [
        (
            '[grid]\n"reduction.f_mx" = [3000]',
            ["sweep.toml:3", "case f_mx=3000", "unknown key", "Did you mean 'f_max'?"],
        ),
        ('[grid]\n"reduction.f_max" = [3000, -1]', ["sweep.toml:3", "case f_max=-1", "greater than 0"]),
        ('[grid]\n"time.step" = [1e-4]\n"contact.tp.friction" = [0.1]', ["sweep.toml:4", "no [contact.tp]", "'tip'"]),
        ('[grid]\n"title.x" = [1]', ["sweep.toml:3", "title is not a table"]),
        ('[grid]\n"connector.0.lower" = [1]', ["sweep.toml:3", "connector"]),
        ('[grid]\n"model.deck" = ["strips.inp", "none.inp"]', ["none.inp"]),
        (
            '[grid]\n"section.UPPER.thickness" = [1.0, 1.2]\n"section.LOWR.thickness" = [1.5]',
            ["sweep.toml:4", "case ", "no section 'LOWR'", "Did you mean 'LOWER'?"],
        ),
        ('[grid]\n"excitation.root.signal.type" = ["sine"]', ["sweep.toml:3", "case type=sine"]),
        (
            '[grid]\n"model.units" = ["mm-t-s"]\n"time.accuracy" = ["fine"]\n"time.step" = [1e-3]',
            ["sweep.toml:4", "accuracy = 'fine' chooses the steps itself", "step would force them"],
        ),
    ],
)
def test_wrong_changes_are_explained_before_anything_runs(tmp_path, text, words):
    said = str(refusal(cases_of, tmp_path, text))
    for word in words:
        assert word in said


PLAY = """
[[connector]]
type = "play"
nodes = "TIP_UPPER"
dof = "z"
lower = -0.1
upper = 0.1
stiffness = 5
[[clip]]
type = "play"
nodes = "TIP_UPPER"
axis = [0, 0, 1]
lower = -0.1
upper = 0.1
stiffness = 5
name = "hook"
"""
REFUSED_BY_A_RUN = {
    "connector.0.lower": ("0.2", "lower = 0.2 lies above upper = 0.1"),
    "connector.0.preload": ("1", "a preload and two limits"),
    "connector.0.name": ('"hook"', "the name 'hook' is taken"),
    "clip.0.upper": ("-0.2", "lower = -0.1 lies above upper = -0.2"),
    "contact.tip.overclosure": ("[[0, 0], [1, 2], [2, 1]]", "does not rise"),
    "reduction.f_max": ("10", "is not above the excitation"),
    "excitation.root.signal": ('{ type = "step", amplitude = 1 }', "periods without a periodic excitation"),
    "time.periods": ("1e-4", "step(s) of"),
}


@pytest.mark.parametrize("key", REFUSED_BY_A_RUN)
def test_what_a_run_refuses_of_the_study_alone_is_told_before_anything_runs(tmp_path, key):
    study = write_strips(tmp_path)
    study.write_text(study.read_text() + PLAY)
    value, told = REFUSED_BY_A_RUN[key]
    assert len(cases_of(tmp_path, '[[case]]\nname = "base"')) == 1
    said = str(refusal(cases_of, tmp_path, f'[[case]]\nchanges = {{ "time.substeps" = 2, "{key}" = {value} }}'))
    assert said.startswith(f"{tmp_path / 'sweep.toml'}:3: case ")
    assert told in said


def test_seeds_without_a_multisine_are_an_error(tmp_path):
    study = write_strips(tmp_path)
    signal = 'signal = { type = "sine", frequency = 20, amplitude = 0.1 }\n'
    lines = [signal if line.startswith("signal") else line for line in study.read_text().splitlines(keepends=True)]
    study.write_text("".join(lines).replace("periods = 2", "end = 0.4"))
    with pytest.raises(InputError, match="no excitation of the base study is a multisine"):
        cases_of(tmp_path, "seeds = [1]")


def test_studies_of_cases_read_back_from_the_folder_of_the_sweep(tmp_path):
    out = tmp_path / "deep" / "out"
    (case,) = cases_of(tmp_path, "seeds = [9]", "deep/out")
    out.mkdir(parents=True)
    (out / "case.toml").write_text(case.text)
    study = read_study(out / "case.toml")
    assert study.places.sibling(study.config.model.deck) == tmp_path / "strips.inp"
    assert study.config.excitation["root"].signal.seed == 9


def ids(folder: Path, text: str = "seeds = [1]") -> tuple[str, str, str, str]:
    case = cases_of(folder, text)[0]
    return case.id, case.study_hash, case.deck_hash, case.reference_key


def test_an_identity_is_that_of_content(tmp_path):
    a, b = tmp_path / "a", tmp_path / "b"
    a.mkdir()
    b.mkdir()
    first = ids(a)
    assert ids(b) == first  # another place
    study = b / "study.toml"
    study.write_text(
        study.read_text().replace("Two strips", "Another title") + "\n[reduction.interface]\ntype = 'full'\n"
    )
    assert ids(b) == first  # another title, a default spelled out
    study.write_text(study.read_text().replace("merge", "") + "\n[precheck]\nmargin = 0.4\n")
    assert ids(b)[0] != first[0]
    assert ids(b)[2] == first[2]


@pytest.mark.parametrize("name", ["strips.inp", "strips.deck"])
def test_an_identity_covers_included_files_and_tables(name, tmp_path):
    study = write_strips(tmp_path)
    deck = (tmp_path / "strips.inp").rename(tmp_path / name)
    (tmp_path / "clearance.csv").write_text("node,clearance\n13,0.4\n")
    text = study.read_text().replace("strips.inp", name)
    study.write_text(text.replace('main = "OVER"', 'main = "OVER"\nclearance = "clearance.csv"'))
    (tmp_path / "more.inp").write_text("** nothing\n")
    deck.write_text(deck.read_text() + "*INCLUDE, INPUT=more.inp\n")
    first = ids(tmp_path)
    (tmp_path / "more.inp").write_text("** something\n")
    second = ids(tmp_path)
    assert second[0] != first[0]
    assert second[2] != first[2]
    (tmp_path / "clearance.csv").write_text("node,clearance\n13,0.3\n")
    third = ids(tmp_path)
    assert third[1] != second[1]
    assert third[2] == second[2]
    assert third[3] != second[3]  # the run of the unreduced model depends on it too


def test_cases_that_differ_in_the_reduction_alone_share_their_reference(tmp_path):
    cases = cases_of(
        tmp_path,
        """[grid]
"excitation.root.signal.amplitude" = [0.04, 0.05]
"reduction.f_max" = [2000, 3000]
"reference.run" = [true, false]
""",
    )
    keys = [c.reference_key for c in cases]
    assert keys[1::2] == [None] * 4
    assert keys[0] == keys[2] != keys[4] == keys[6]


def test_cases_share_a_reference_that_ends_where_theirs_does(tmp_path):
    """`run` says that there is one, `until` where it ends."""
    ends = """[grid]
"reduction.f_max" = [2000, 3000]
"reference.until" = [0.1, 0.2]
"reference.run" = [true, "whole"]
"""
    keys = [c.reference_key for c in cases_of(tmp_path, ends)]
    assert keys[0] == keys[1] == keys[4] == keys[5]
    assert keys[2] == keys[3] == keys[6] == keys[7] != keys[0]


@pytest.mark.parametrize(
    "damping", ["modal = 0.02", 'from_test = "modes.csv"', "rayleigh = { alpha = 1.0, beta = 1e-6 }"]
)
def test_a_reference_with_modal_damping_hangs_on_the_modes_that_are_damped(damping, tmp_path):
    write_strips(tmp_path, study=f"{STUDY}\n[damping]\n{damping}\n")
    (tmp_path / "modes.csv").write_text("frequency,damping\n30,0.02\n")
    bands = """[grid]
"reduction.f_max" = [2000, 3000]
"reduction.retain" = [[], ["TIP"]]
"reference.run" = ["whole"]
"""
    keys = [c.reference_key for c in cases_of(tmp_path, bands)]
    assert keys[0] == keys[1]
    assert keys[2] == keys[3]
    assert (keys[0] == keys[2]) == ("rayleigh" in damping)


def test_variants_need_no_files(tmp_path):
    write_strips(tmp_path)
    (tmp_path / "sweep.toml").write_text('base = "study.toml"\n[[case]]\nname = "as it is"\n')
    (tmp_path / "strips.inp").unlink()
    assert [v.name for v in combinations(read_sweep(tmp_path / "sweep.toml"))] == ["as it is"]
