"""Material pairs from a CSV file: by the keys of their tables, with source and conditions, and files that are wrong."""

from __future__ import annotations

import pytest

from creak.errors import InputError
from creak.studies.file.eline_tables import MaterialPairTable
from creak.studies.file.material_pairs import material_pairs
from creak.studies.file.reader import read_study
from helpers_decks import write_study

STUDY = 'material_pairs = "pairs.csv"\n[model]\ndeck = "strips.inp"\n'
GOOD = """\
# own rig, 2026
Name;Source;Impulse rate min [1/mm];Impulse rate max [1/mm];friction_static;Friction Kinetic;temperature [°C];humidity [%];normal force [N]
pvc-abs;own rig, report 12;0,5;2,1;0.42;0.28;23;50;10
leather-pp;own rig, report 13;1;3;;;-10;;
"""


def made(folder, text, study=STUDY):
    return material_pairs(read_study(write_study(folder, study, {"pairs.csv": text})).lines)


def test_a_row_is_what_a_table_of_the_study_is(tmp_path):
    found = made(tmp_path, GOOD)
    assert found == {
        "pvc-abs": MaterialPairTable(
            source="own rig, report 12",
            impulse_rate_min=0.5,
            impulse_rate_max=2.1,
            friction_static=0.42,
            friction_kinetic=0.28,
            normal_force=10.0,
            temperature=23.0,
            humidity=50.0,
        ),
        "leather-pp": MaterialPairTable(
            source="own rig, report 13", impulse_rate_min=1.0, impulse_rate_max=3.0, temperature=-10.0
        ),
    }
    own = '[material-pair.felt]\nsource = "rig"\nimpulse_rate_min = 1\nimpulse_rate_max = 2\n'
    assert list(made(tmp_path, GOOD, STUDY + own)) == ["pvc-abs", "leather-pp", "felt"]
    with pytest.raises(InputError, match=r"'pvc-abs' is in the study and in pairs\.csv"):
        made(tmp_path, GOOD, STUDY + own.replace("felt", "pvc-abs"))


HEAD = "name,source,impulse_rate_min,impulse_rate_max"
ROW = "pvc,rig,1,2"
WRONG = {
    "unknown": (f"{HEAD},friction_statik\n{ROW},.4\n", ["pairs.csv:1", "'friction_statik'", "'friction_static'?"]),
    "missing": ("name,source,impulse_rate_min\npvc,rig,1\n", ["pairs.csv:1", "no column impulse_rate_max", HEAD]),
    "no name": ("source,impulse_rate_min\nrig,1\n", ["pairs.csv:1", "the table starts with", HEAD]),
    "empty": ("", ["pairs.csv", "nothing", HEAD]),
    "no rows": (f"{HEAD}\n", ["pairs.csv", "no rows"]),
    "no source": (f"{HEAD}\npvc,,1,2\n", ["pairs.csv:2", "'pvc' has no source", "Fill it in"]),
    "nameless": (f"{HEAD}\n,rig,1,2\n", ["pairs.csv:2", "without a name"]),
    "twice": (f"{HEAD}\n{ROW}\n{ROW}\n", ["pairs.csv:3", "'pvc' has a second row"]),
    "text": (f"{HEAD}\npvc,rig,few,2\n", ["pairs.csv:2", "'few'", "impulse_rate_min", "a finite number"]),
    "rates": (f"{HEAD}\npvc,rig,3,2\n", ["pairs.csv:2", "impulse_rate_min = 3 is above"]),
    "negative": (f"{HEAD},speed\n{ROW},-1\n", ["pairs.csv:2", "speed", "greater than 0"]),
    "humid": (f"{HEAD},humidity\n{ROW},101\n", ["pairs.csv:2", "humidity", "less than or equal to 100"]),
    "units": (f"{HEAD},speed [m/s]\n{ROW},1\n", ["pairs.csv:1", "the unit of speed is 'm/s'", "mm/s", "Convert"]),
    "two columns": (f"{HEAD},pair\n{ROW},a\n", ["pairs.csv:1", "both name"]),
}


@pytest.mark.parametrize("case", WRONG)
def test_a_file_that_is_wrong_is_one_message(case, tmp_path):
    text, words = WRONG[case]
    with pytest.raises(InputError, match=r"\w") as error:
        made(tmp_path, text)
    for word in words:
        assert word in str(error.value)


def test_no_such_file(tmp_path):
    (tmp_path / "study.toml").write_text(STUDY)
    with pytest.raises(InputError, match=r"study\.toml:1.*no such file of material pairs"):
        material_pairs(read_study(tmp_path / "study.toml").lines)
