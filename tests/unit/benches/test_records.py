"""Records that a benchmark writes and the package shows: each says where it comes from."""

import re

from benchmarks import unreduced
from benchmarks.stamp import command, stamp

from creak_thesis.report.numbers import million

FIELDS = {"creak", "commit", "date", "machine", "command"}


def test_a_stamp_has_no_empty_field():
    made = stamp()
    assert made.keys() == FIELDS
    assert all(made.values())
    assert re.fullmatch(r"[0-9a-f]{7,}\+?|unknown", made["commit"])
    assert re.fullmatch(r"\d{4}-\d\d-\d\d", made["date"])


def test_a_command_is_given_without_paths_of_the_interpreter():
    assert re.match(r"python (-m )?\S", command())


def test_the_record_of_million_dofs_has_what_the_benchmark_writes():
    """Field by field; a note may say what it could not know."""
    found = million()
    assert found is not None
    assert found.keys() == unreduced.record(stamp(), "a door", []).keys()
    assert found["made"].keys() - {"note"} == FIELDS
    assert all(found["made"].values())
    assert re.search(r"--out src/\S+/million\.json", found["made"]["command"])
    for run in found["runs"]:
        assert run["integrator"]
