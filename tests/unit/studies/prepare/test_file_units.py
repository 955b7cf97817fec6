"""Units that files of courses tell, and amounts of records and tables, against factors and peaks worked out by hand."""

from __future__ import annotations

import math

import numpy as np
import pytest

from creak.errors import InputError
from creak.studies.file.reader import read_study
from creak.studies.prepare.amount_check import file_unit_notes
from creak.studies.prepare.setup import set_up
from creak.studies.warned import Warned, warnings_of
from helpers_decks import STUDY, write_strips
from helpers_rpc3 import rpc3

SINES = 'type = "multisine", f_min = 5, f_max = 60, amplitude = 0.05, period = 0.2, seed = 3'


def study_of(kind, signal, units="mm-t-s", dof="z"):
    """The strips' study with another signal, over 0.4 s."""
    text = STUDY.replace('deck = "strips.inp"', f'deck = "strips.inp"\nunits = "{units}"').replace(SINES, signal)
    text = text.replace('dof = "z"', f'dof = "{dof}"').replace('kind = "displacement"', f'kind = "{kind}"')
    return text.replace("periods = 2", "end = 0.4")


def notes(folder, units="mm-t-s", unit="g", kind="acceleration", dof="z", more="", type_="table"):
    """What is told of the first channel of an RPC III file in a unit."""
    (folder / "road.rsp").write_bytes(rpc3(**{"UNITS.CHAN_1": unit}))
    signal = f'type = "{type_}", file = "road.rsp", channel = "Acc_X"{more}'
    return file_unit_notes(read_study(write_strips(folder, study=study_of(kind, signal, units, dof))).driving)


OTHERS = [
    ("mm-t-s", "g", "acceleration", "z", 9806.65, "mm/s^2"),
    ("m-kg-s", "G", "acceleration", "z", 9.80665, "m/s^2"),
    ("m-kg-s", "mm/s^2", "acceleration", "z", 1e-3, "m/s^2"),
    ("mm-t-s", "m/s**2", "acceleration", "x", 1e3, "mm/s^2"),
    ("mm-t-s", "m/s", "velocity", "z", 1e3, "mm/s"),
    ("m-kg-s", "in", "displacement", "z", 0.0254, "m"),
    ("mm-t-s", "kN", "force", "z", 1e3, "N"),
    ("m-kg-s", "lbf", "force", "z", 4.44822, "N"),
    ("mm-t-s", "Nm", "force", "rx", 1e3, "N mm"),
    ("m-kg-s", "N*mm", "force", "ry", 1e-3, "N m"),
    ("mm-t-s", "in-lbf", "force", "ry", 112.985, "N mm"),
    ("mm-t-s", "deg", "displacement", "rz", math.pi / 180.0, "rad"),
    ("mm-t-s", "rpm", "velocity", "rz", math.pi / 30.0, "rad/s"),
    ("m-kg-s", "degrees/s^2", "acceleration", "rz", math.pi / 180.0, "rad/s^2"),
    ("in-lbf-s", "g", "acceleration", "z", 386.0886, "in/s^2"),
    ("in-lbf-s", "N", "force", "z", 0.2248089, "lbf"),
    ("in-lbf-s", "Nm", "force", "rx", 8.850746, "lbf in"),
]


@pytest.mark.parametrize(("units", "unit", "kind", "dof", "factor", "own"), OTHERS)
def test_another_unit_is_refused_with_its_factor(tmp_path, units, unit, kind, dof, factor, own):
    with pytest.raises(InputError, match="expected a") as refused:
        notes(tmp_path, units, unit, kind, dof)
    said = str(refused.value)
    assert f"is in {unit}; expected a" in said
    assert f" in {own}, as [model] units = '{units}' says" in said
    assert f"Add factor = {factor:.6g} to the signal." in said
    assert "[excitation.root.signal]" in said
    for sign in (1.0, -1.0):
        assert notes(tmp_path, units, unit, kind, dof, f", factor = {sign * factor:.6g}") == []
    for wrong in (1.0, 2.0 * factor):
        (told,) = notes(tmp_path, units, unit, kind, dof, f", factor = {wrong!r}")
        assert isinstance(told, Warned) == (not 0.25 <= wrong / factor <= 4.0)
        assert f"factor = {factor:.6g} makes {own}; factor = {wrong:g} is given" in told


@pytest.mark.parametrize(
    ("units", "unit", "kind", "dof"),
    [
        ("mm-t-s", "mm/s^2", "acceleration", "z"),
        ("m-kg-s", "m/s/s", "acceleration", "z"),
        ("mm-t-s", "N", "force", "z"),
        ("mm-t-s", "rad", "displacement", "rz"),
        ("in-lbf-s", "lbf", "force", "z"),
        ("in-lbf-s", "in/s^2", "acceleration", "z"),
        ("in-lbf-s", "in-lbf", "force", "ry"),
        ("mm-t-s", "", "acceleration", "z"),
        ("mm-t-s", "NONE", "acceleration", "z"),
    ],
)
def test_the_own_unit_and_none_are_quiet(tmp_path, units, unit, kind, dof):
    assert notes(tmp_path, units, unit, kind, dof) == []


def test_the_rounded_factor_of_gravity_is_one(tmp_path):
    assert notes(tmp_path, more=", factor = 9810") == []


def test_an_unknown_unit_is_a_note(tmp_path):
    (told,) = notes(tmp_path, unit="furlong/s^2")
    assert not isinstance(told, Warned)
    assert "is in furlong/s^2, a unit that is not known: 1 times its values count as mm/s^2" in told


def test_the_unit_of_something_else(tmp_path):
    with pytest.raises(InputError, match=r"is in mm; expected an acceleration in mm/s\^2.*another channel or kind"):
        notes(tmp_path, unit="mm")
    (told,) = notes(tmp_path, unit="mm", more=", factor = 1")
    assert isinstance(told, Warned)
    assert "which counts no acceleration" in told


def test_a_record_is_an_acceleration_whatever_it_moves(tmp_path):
    more = ", high_pass = 5"
    assert notes(tmp_path, unit="mm/s^2", kind="displacement", more=more, type_="record") == []
    with pytest.raises(InputError, match="an acceleration"):
        notes(tmp_path, unit="mm", kind="displacement", more=more, type_="record")


def test_a_column_in_g_moves_as_one_in_its_unit(tmp_path):
    """The same motion in both, refused in g without a factor."""
    time = np.linspace(0.0, 1.0, 501)
    rows = [f"{t:.6f},{3.0 * math.sin(50.0 * t):.12g},{3.0 * 9806.65 * math.sin(50.0 * t):.12g}" for t in time]
    (tmp_path / "road.csv").write_text("\n".join(["time,acc [g],acc (mm/s^2)", *rows]))

    def moved(column, more=""):
        signal = f'type = "table", file = "road.csv", channel = "{column}"{more}'
        return set_up(read_study(write_strips(tmp_path, study=study_of("acceleration", signal)))).loads.support

    with pytest.raises(InputError, match=r"channel 'acc \[g\]' of road.csv is in g.*Add factor = 9806.65"):
        moved("acc [g]")
    plain = moved("acc (mm/s^2)")
    assert np.abs(plain[2]).max() > 2.9 * 9806.65
    np.testing.assert_allclose(moved("acc [g]", ", factor = 9806.65"), plain, rtol=1e-9, atol=1e-9 * plain.max())


def test_the_only_column_needs_no_name(tmp_path):
    """As loggers write it: times and one column with its unit, which is asked about."""
    time = np.linspace(0.0, 1.0, 501)
    (tmp_path / "road.csv").write_text(
        "\n".join(["Time [ms],Acc_Z [g]", *(f"{1e3 * t:.3f},{math.sin(t)}" for t in time)])
    )

    def support(more=""):
        signal = f'type = "table", file = "road.csv"{more}'
        return set_up(read_study(write_strips(tmp_path, study=study_of("acceleration", signal)))).loads.support

    with pytest.raises(InputError, match=r"road.csv is in g.*Add factor = 9806.65"):
        support()
    found = support(", factor = 9806.65")
    np.testing.assert_array_equal(found, support(', factor = 9806.65, channel = "Acc_Z [g]"'))


def test_several_columns_are_to_be_chosen_from(tmp_path):
    (tmp_path / "road.csv").write_text("Time [s],Acc_X [g],Acc_Z [g]\n0,0,0\n1,1,1\n")
    study = study_of("acceleration", 'type = "table", file = "road.csv"')
    with pytest.raises(InputError, match=r"starts with Time \[s\],Acc_X \[g\],Acc_Z.*channel = 'Acc_X \[g\]'"):
        set_up(read_study(write_strips(tmp_path, study=study)))


@pytest.mark.parametrize("type_", ["sine", "record", "table"])
@pytest.mark.parametrize(
    ("kind", "amplitude", "words"),
    [
        ("acceleration", 1.5e7, "up to 1.5e+04 m/s2"),
        ("acceleration", 1e4, ""),
        ("acceleration", 3.0, "no more than 0.003 m/s2"),
        ("displacement", 500.0, "accelerates by up to"),
        ("displacement", 0.5, ""),
    ],
)
def test_records_and_tables_are_judged_as_a_sine_of_their_amount(tmp_path, type_, kind, amplitude, words):
    """30 Hz; a record is always an acceleration, amplitude (2 pi 30)^2 of a displacement."""
    omega = 2.0 * math.pi * 30.0
    own = amplitude * (omega**2 if (type_, kind) == ("record", "displacement") else 1.0)
    time = np.arange(2001) / 2000.0
    rows = [f"{t!r},{own * math.sin(omega * t)!r}" for t in time.tolist()]
    (tmp_path / "road.csv").write_text("\n".join(["time,value", *rows]))
    signal = {
        "sine": f'type = "sine", frequency = 30, amplitude = {amplitude}',
        "record": 'type = "record", file = "road.csv", high_pass = 5',
        "table": 'type = "table", file = "road.csv"',
    }[type_]
    study = write_strips(tmp_path, study=study_of(kind, signal))
    found = [text for text in warnings_of(set_up(read_study(study)).notes) if "accelerates by" in text]
    assert [words in text for text in found] == ([True] if words else [])


@pytest.mark.parametrize("kind", ["displacement", "velocity", "acceleration"])
def test_a_weak_record_is_told_whatever_it_moves(tmp_path, kind):
    rows = [f"{t!r},{3.0 * math.sin(200.0 * t)!r}" for t in (np.arange(2001) / 2000.0).tolist()]
    (tmp_path / "road.csv").write_text("\n".join(["time,value", *rows]))
    study = study_of(kind, 'type = "record", file = "road.csv", high_pass = 5')
    said = warnings_of(set_up(read_study(write_strips(tmp_path, study=study))).notes)
    assert any("accelerates by no more than 0.003 m/s2" in text for text in said)


def test_a_corner_of_a_displacement_by_points_is_no_amount(tmp_path):
    """0.2 mm within 0.1 ms: 4e4 m/s^2 and more at the points, of a motion that moves next to nothing."""
    signal = 'type = "table", values = [[0, 0], [0.1, 0], [0.1001, 0.2], [0.2, 0.2], [0.3, 0.2]]'
    setup = set_up(read_study(write_strips(tmp_path, study=study_of("displacement", signal))))
    assert not any("accelerates by" in text for text in warnings_of(setup.notes))
