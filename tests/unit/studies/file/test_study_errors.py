"""A wrong study is refused with the file, the line, what was found and what to do."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from creak.errors import InputError
from creak.studies.file.reader import read_study
from creak.studies.prepare.setup import set_up
from creak.studies.warned import warnings_of
from helpers_decks import write_study
from helpers_refusal import refusal

DECK = """*HEADING
one mass on a spring, one beside it
*NODE
1, 0., 0., 0.
2, 10., 0., 0.
3, 20., 0., 0.
*NSET, NSET=BASE
1,
*NSET, NSET=MASS
2,
*NSET, NSET=BOTH
2, 3
*ELEMENT, TYPE=MASS, ELSET=M
1, 2
2, 3
*MASS, ELSET=M
1e-3,
*ELEMENT, TYPE=SPRING2, ELSET=K
11, 1, 2
*SPRING, ELSET=K
1, 1
40.,
*ELEMENT, TYPE=SPRING1, ELSET=G
12, 3
*SPRING, ELSET=G
1,
60.,
*BOUNDARY
1, 2, 6
2, 2, 6
3, 2, 6
"""
STUDY = """title = "One mass"

[model]
deck = "mass.inp"

[[connector]]
type = "play"
nodes = ["MASS"]
dof = "x"
lower = -0.2
upper = 0.2
stiffness = 1e3

[excitation.base]
node_set = "BASE"
dof = "x"
kind = "displacement"
signal = { type = "sine", frequency = 20, amplitude = 1.5 }

[reduction]
f_max = 400

[time]
step = 1e-3
end = 0.2
"""
SINE = '{ type = "sine", frequency = 20, amplitude = 1.5 }'


def written(folder: Path, study: str, deck: str = DECK) -> Path:
    return write_study(folder, study, {"mass.inp": deck})


def line_of(text: str, wanted: str) -> int:
    return next(i for i, line in enumerate(text.splitlines(), start=1) if wanted in line)


def refused(folder: Path, study: str) -> str:
    path = written(folder, study)
    return str(refusal(lambda: set_up(read_study(path))))


def test_study_as_it_is_can_be_set_up(tmp_path):
    setup = set_up(read_study(written(tmp_path, STUDY)))
    assert setup.connectors.m == 2
    assert setup.loads.n_step == 200
    assert setup.structure.driven.names == ("base",)


MISTAKES = {
    "misspelt key": (
        "stiffness = 1e3",
        "stifness = 1e3",
        "stifness",
        r"unknown key.*stifness.*[Dd]id you mean 'stiffness'",
    ),
    "misspelt key of a table": (
        "step = 1e-3",
        "stepp = 1e-3",
        "stepp",
        r"unknown key 'time.stepp'.*Did you mean 'step'",
    ),
    "misspelt amplitude of a signal": (
        "amplitude = ",
        "amplitud = ",
        "amplitud =",
        r"unknown key 'excitation.base.signal.amplitud'. Did you mean 'amplitude'",
    ),
    "misspelt table of tables": (
        "[excitation.base]",
        "[excitaton.base]",
        "excitaton",
        r"unknown key 'excitaton'.*Did you mean 'excitation'",
    ),
    "misspelt table": ("[reduction]", "[reductoin]", "reductoin", r"unknown key 'reductoin'.*Did you mean 'reduction'"),
    "misspelt key of a signal": (
        "frequency = 20",
        "frequenzy = 20",
        "frequenzy",
        r"(unknown key|missing).*frequen[cz]y",
    ),
    "missing key": ('nodes = ["MASS"]\n', "", "[[connector]]", r"connector.*nodes' is missing\. Add it: "),
    "no direction": ('dof = "x"\nlower', "lower", "[[connector]]", r"connector.*either dof .* or axis"),
    "two directions": ("lower", "axis = [1, 0, 0]\nlower", "[[connector]]", r"connector.*either dof .* or axis"),
    "no length": ('dof = "x"', "axis = [0, 0, 0]", "[[connector]]", r"connector.*axis has length zero"),
    "friction of a turn": ('dof = "x"', 'dof = "rx"\nfriction = 0.3', "[[connector]]", r"connector.*turn about rx"),
    "another word than hard": ("stiffness = 1e3", 'stiffness = "stiff"', "stiffness", r"'stiff'.*hard"),
    "amplitude that is no number": ("amplitude = 1.5", "amplitude = nan", "amplitude", r"amplitude = nan.*finite"),
    "infinite amplitude": ("amplitude = 1.5", "amplitude = inf", "amplitude", r"amplitude = inf.*finite"),
    "text for a number": ("f_max = 400", 'f_max = "high"', "f_max", r"reduction.f_max = 'high'.*number"),
    "negative step": ("step = 1e-3", "step = -1e-3", "step = ", r"time.step = -0.001.*greater than 0"),
    "unknown signal": (
        'type = "sine"',
        'type = "sinus"',
        "sinus",
        r"type 'sinus'.*expected one of multisine, sine.*Did you mean 'sine'",
    ),
    "unknown dof": ('kind = "displacement"', 'kind = "jerk"', "jerk", r"kind = 'jerk'.*displacement"),
    "positive alpha": ("end = 0.2", "end = 0.2\nalpha = 0.1", "alpha", r"time.alpha = 0.1.*less than or equal to 0"),
    "periods and end": ("end = 0.2", "end = 0.2\nperiods = 3", "[time]", r"either periods or end, not both"),
    "two kinds of damping": (
        "[reduction]",
        "[damping]\nmodal = 0.02\nrayleigh = { alpha = 1 }\n[reduction]",
        "[damping]",
        r"either modal or rayleigh, not both",
    ),
    "a word that is none of a key that takes true, too": (
        "[reduction]",
        '[reference]\nrun = "spot"\n[reduction]',
        "run",
        r"reference\.run = 'spot': .*true or false, or 'spots', 'whole' or 'none'",
    ),
    "a number for true": (
        "[reduction]",
        "[reference]\nrun = 1\n[reduction]",
        "run",
        r"reference\.run = 1: .*true or false, or 'spots', 'whole' or 'none'",
    ),
    "f_max below the excitation": (
        "f_max = 400",
        "f_max = 15",
        "f_max",
        r"f_max = 15 Hz is not above the excitation.*20 Hz",
    ),
    "step too long for the excitation": ("step = 1e-3", "step = 0.04", "step = ", r"step = 0.04 s cannot follow"),
    "run of one step": ("end = 0.2", "end = 0.001", "step = ", r"has 1 step\(s\) of 0.001 s"),
    "run without end": ("end = 0.2", "end = 1e30", "step = ", r"has 1e\+33 step\(s\) of 0.001 s"),
    "unknown node set": ('node_set = "BASE"', 'node_set = "BASIS"', "BASIS", r"unknown node set 'BASIS'. Did you mean"),
    "unknown set of a connector": (
        'nodes = ["MASS"]',
        'nodes = ["MAS"]',
        "[[connector]]",
        r"unknown node set 'MAS'.*'MASS'",
    ),
    "three ends of a connector": (
        'nodes = ["MASS"]',
        'nodes = ["MASS", "BASE", "BOTH"]',
        "[[connector]]",
        r"names 3 sets, expected one .to ground. or two",
    ),
    "limits the wrong way round": (
        "lower = -0.2",
        "lower = 0.7",
        "[[connector]]",
        r"lower = 0.7 lies above upper = 0.2",
    ),
    "contact of unknown surfaces": (
        "[reduction]",
        '[contact.c]\nsecondary = "TOP"\nmain = "LOW"\n[reduction]',
        "[contact.c]",
        r"unknown surface or set 'TOP'",
    ),
    "missing table file": (
        SINE,
        '{ type = "table", file = "push.csv" }',
        "[excitation.base]|signal",
        r"no such table: .*push.csv",
    ),
    "output interval off the step": (
        "[reduction]",
        "[output]\ninterval = 1.5e-3\n[reduction]",
        "interval",
        r"interval = 0.0015 s.*multiple of the step",
    ),
    "output interval longer than the run": (
        "[reduction]",
        "[output]\ninterval = 0.3\n[reduction]",
        "interval",
        r"interval = 0.3 s is longer than the run, which ends at 0.2 s.*Shorten it",
    ),
    "output interval shorter than the step": (
        "[reduction]",
        "[output]\ninterval = 1e-5\n[reduction]",
        "interval",
        r"interval = 1e-05 s.*multiple of the step",
    ),
    "field interval longer than the run": (
        "[reduction]",
        "[output]\nfield_interval = 0.3\n[reduction]",
        "field_interval",
        r"field_interval = 0.3 s is longer than the run, which ends at 0.2 s",
    ),
    "field interval off the step": (
        "[reduction]",
        "[output]\nfield_interval = 1.5e-3\n[reduction]",
        "field_interval",
        r"field_interval = 0.0015 s.*multiple of the step",
    ),
    "field that starts after the run": (
        "[reduction]",
        "[output]\nfield_interval = 0.01\nfield_start = 3\n[reduction]",
        "field_start",
        r"field_start = 3 s.*the run, which ends at 0.2 s",
    ),
    "window of one output": (
        "[reduction]",
        "[output]\ninterval = 0.05\n[verification]\npairs = 'BOTH'\n[reduction]",
        "interval",
        r"interval = 0.05 s leaves fewer than two outputs in the 0.05 s that are compared.*at most 0.025 s",
    ),
    "no line in the spectra": (
        "[reduction]",
        "[verification]\npairs = 'BOTH'\nf_max = 19\n[reduction]",
        "f_max",
        r"f_max = 19 Hz lies below the first line .* 0.05 s that are compared; expected 20 Hz or more",
    ),
    "unknown set to leave unreduced": (
        "f_max = 400",
        "f_max = 400\nunreduced = ['NOWHERE']",
        "unreduced",
        r"unknown or empty element set 'NOWHERE'",
    ),
    "unknown substructure": (
        "f_max = 400",
        "f_max = 400\nsubstructures = ['NOWHERE']",
        "substructures",
        r"unknown or empty element set 'NOWHERE'",
    ),
    "unknown set to retain": (
        "f_max = 400",
        "f_max = 400\nretain = 'NOWHERE'",
        "retain",
        r"unknown node set 'NOWHERE'",
    ),
    "missing coarse deck": (
        "f_max = 400",
        "f_max = 400\ninterface = { type = 'coarse-mesh', deck = 'coarse.inp' }",
        "coarse",
        r"there is no deck .*coarse.inp. Check the path",
    ),
    "no line in a multisine": (
        SINE,
        '{ type = "multisine", f_min = 0.2, f_max = 0.4, amplitude = 1.0 }',
        "signal",
        r"lines at whole multiples of 1 Hz, none of them between",
    ),
    "friction": (
        "[reduction]",
        '[contact.c]\nsecondary = "A"\nmain = "B"\nfriction = -0.3\n[reduction]',
        "friction",
        r"friction.*-0.3.*greater than or equal to 0",
    ),
}


@pytest.mark.parametrize("mistake", MISTAKES)
def test_mistake_is_named(mistake, tmp_path):
    old, new, _, message = MISTAKES[mistake]
    assert old in STUDY
    study = STUDY.replace(old, new, 1)
    told = refused(tmp_path, study)
    assert re.search(message, told, re.DOTALL), told


WITH_LINE = [
    *("misspelt key of a table", "misspelt table", "text for a number", "negative step", "periods and end"),
    *("output interval longer than the run", "field interval off the step", "window of one output"),
    *("unknown substructure", "missing coarse deck", "amplitude that is no number", "unknown signal"),
    *("f_max below the excitation", "unknown node set", "friction"),
]


@pytest.mark.parametrize("mistake", WITH_LINE)
def test_message_gives_the_line(mistake, tmp_path):
    old, new, found_at, _ = MISTAKES[mistake]
    study = STUDY.replace(old, new, 1)
    told = refused(tmp_path, study)
    expected = line_of(study, found_at)
    assert f"study.toml:{expected}" in told, told


def test_broken_toml_is_explained_with_its_line(tmp_path):
    told = refused(tmp_path, STUDY.replace("f_max = 400", "f_max = = 400"))
    assert re.search(r"not valid TOML.*line 21", told), told


HEADERS = {
    "[time]\n": ("[[time]]\n", "[[time]] is not how such a table starts", "Write [time]."),
    "[excitation.base]": ("[excitation]", "[excitation] is not how such a table starts", "Write [excitation.NAME]."),
    'nodes = ["MASS"]': (
        "nodes = 1",
        "connector.0.nodes = 1: input should be a list in brackets",
        "Correct the value.",
    ),
    "[reduction]": ("[listener.a]\nposition = [1, 2]\n[reduction]", "listener.a.position has 2 value(s)", ""),
}


@pytest.mark.parametrize("header", HEADERS)
def test_a_value_of_another_kind_is_told_in_the_words_of_the_file(header, tmp_path):
    other, what, fix = HEADERS[header]
    assert header in STUDY
    error = refusal(lambda: read_study(written(tmp_path, STUDY.replace(header, other))))
    assert (error.what, error.fix) == (what, fix)


SLIPS = {
    "a unit": ("end = 0.2", 'end = "0.2 s"', "Write 0.2, without quotes and unit."),
    "a comma": ("end = 0.2", "end = 0,2  # s", "Write 0.2: decimals have a point."),
    "a capital": ('dof = "x"\nkind', 'dof = "X"\nkind', "Did you mean 'x'?"),
    "a letter": ("f_max = 400", 'f_max = "atuo"', "Did you mean 'auto'?"),
    "a deck": ('deck = "mass.inp"', 'deck = "mas.inp"', "Did you mean 'mass.inp'?"),
    "another deck": ('deck = "mass.inp"', 'deck = "class.inp"', "Check the path."),
    "no slip": ('deck = "mass.inp"', 'deck = "mass.inp"\nunits = "mm-kg-s"', "Correct the value."),
}


@pytest.mark.parametrize("slip", SLIPS)
def test_what_was_meant_is_told(slip, tmp_path):
    before, after, fix = SLIPS[slip]
    assert before in STUDY
    error = refusal(lambda: set_up(read_study(written(tmp_path, STUDY.replace(before, after)))))
    assert error.fix == fix


def test_missing_study_and_missing_deck(tmp_path):
    with pytest.raises(InputError, match="no such study file"):
        read_study(tmp_path / "none.toml")
    path = tmp_path / "study.toml"
    path.write_text(STUDY, encoding="utf-8")
    with pytest.raises(InputError, match=r"mass\.inp"):
        set_up(read_study(path))


def test_end_is_needed_without_a_period(tmp_path):
    study = STUDY.replace(SINE, '{ type = "step", amplitude = 1 }').replace("end = 0.2", "")
    assert re.search(r"\[time\].*the end of the run is not given.*Add end", refused(tmp_path, study))
    told = refused(tmp_path, study + "periods = 2\n")
    assert "periods without a periodic excitation" in told


def test_dof_driven_twice_is_refused(tmp_path):
    second = STUDY[STUDY.index("[excitation.base]") : STUDY.index("[reduction]")].replace(".base", ".again")
    told = refused(tmp_path, STUDY.replace("[reduction]", second + "[reduction]"))
    assert re.search(r"node 1 x is driven by 'base' and 'again'", told)


TABLES = {
    "nan": ("time,value\n0,0\n0.1,nan\n", r"push.csv:3: got '0.1,nan'"),
    "text": ("time,value\n0,0\n0.1,much\n", r"push.csv:3: got '0.1,much'"),
    "one column": ("time,value\n0\n1\n", r"push.csv:2"),
    "no header": ("0,0\n1,1\n", r"push.csv:1: .*expected the header time,value"),
    "backwards": ("time,value\n0,0\n0.2,1\n0.1,1\n", r"push.csv:4: time does not increase"),
    "one row": ("time,value\n0,0\n", r"1 row\(s\)"),
    "empty": ("", r"starts with nothing"),
    "blank lines and nan": ("time,value\n\n0,0\n\n0.1,inf\n", r"push.csv:5"),
}


@pytest.mark.parametrize("table", TABLES)
def test_table_file_with_a_mistake_names_its_line(table, tmp_path):
    content, message = TABLES[table]
    (tmp_path / "push.csv").write_text(content, encoding="utf-8")
    told = refused(tmp_path, STUDY.replace(SINE, '{ type = "table", file = "push.csv" }'))
    assert re.search(message, told), told


def test_record_must_be_sampled_evenly_and_faster_than_its_cut_off(tmp_path):
    record = '{ type = "record", file = "push.csv", high_pass = 7 }'
    (tmp_path / "push.csv").write_text("time,value\n0,0\n0.1,1\n0.2,1\n\n0.4,0\n0.5,1\n", encoding="utf-8")
    told = refused(tmp_path, STUDY.replace(SINE, record))
    assert re.search(
        r"push.csv:6: the time 0.4 s comes 0.2 s after .*, others 0.1 s.*even sampling.*a piece without the gap", told
    ), told
    (tmp_path / "push.csv").write_text("time,value\n0,0\n0.1,1\n0.2,0\n", encoding="utf-8")
    assert re.search(r"high_pass = 7 Hz.*below 5 Hz", refused(tmp_path, STUDY.replace(SINE, record)))


def test_part_that_nothing_holds_is_named(tmp_path):
    """A beam floating beside the mass."""
    beam = """*NODE
21, 0., 5., 0.
22, 10., 5., 0.
*ELEMENT, TYPE=B33, ELSET=FLOAT
31, 21, 22
*BEAM GENERAL SECTION, ELSET=FLOAT, DENSITY=7.8e-9
1., 1., 0., 1., 2.
0., 0., -1.
210000., 80000.
"""
    path = written(tmp_path, STUDY, DECK + beam)
    with pytest.raises(InputError, match=r"nothing holds part\(s\)"):
        set_up(read_study(path))


def test_outputs_too_rare_for_the_spectra_are_told(tmp_path):
    """One output in 5 ms holds 100 Hz."""
    pairs = "[damping]\nmodal = 0.02\n[verification]\npairs = 'BOTH'\nf_max = 100\n"
    sound = written(tmp_path, f"{STUDY}\n[output]\ninterval = 5e-3\n{pairs}")
    assert warnings_of(set_up(read_study(sound)).notes) == []
    rare = written(tmp_path, f"{STUDY}\n[output]\ninterval = 5e-3\n{pairs.replace('100', '120')}")
    (text,) = warnings_of(set_up(read_study(rare)).notes)
    assert "interval = 0.005 s holds frequencies up to 100 Hz: the spectra and their fit end there" in text


@pytest.mark.parametrize(
    ("signal", "kind", "told"),
    [
        ('type = "psd", unit = "g2/Hz", values = [[5, -1], [50, 1]]', "acceleration", "a density of -1 at 5 Hz"),
        ('type = "psd", unit = "g2/Hz", values = [[50, 1], [5, 1]]', "acceleration", "5 Hz does not come after 50 Hz"),
        ('type = "psd", unit = "g2/Hz", values = [[5, 1], [50, 1]]', "displacement", 'give kind = "acceleration"'),
        (
            'type = "psd", unit = "g2/Hz", values = [[5.2, 1], [5.8, 1]], duration = 1',
            "acceleration",
            "multiples of 1 Hz, none of them between 5.2 and 5.8 Hz",
        ),
        ('type = "psd", values = [[5, 1], [50, 1]]', "acceleration", "signal.unit"),
        ('type = "psd", unit = "g2/Hz"', "acceleration", "give either file or values"),
        ('type = "half-sine", amplitude = 1, duration = 0.01', "displacement", "has kinks"),
        ('type = "sweep", f_start = 0, f_end = 5, amplitude = 1, duration = 1', "displacement", "f_start = 0"),
    ],
)
def test_test_signals_that_cannot_be_are_told(tmp_path, signal, kind, told):
    table = f'[excitation.x]\nnode_set = "ROOT_UPPER"\ndof = "z"\nkind = "{kind}"\nsignal = {{ {signal} }}\n'
    with pytest.raises(InputError, match=re.escape(told)):
        read_study(written(tmp_path, f'[model]\ndeck = "x.inp"\n{table}'))
