"""Scales of colours: the hardest node has the last colour, what is untouched the first, whatever the numbers."""

import base64
import warnings
from dataclasses import replace

import numpy as np
import pytest

from creak.model.units import UNITS
from creak.report.figures import picture
from creak.report.figures.gaps import precheck_figure
from creak.report.figures.palette import limits, shares
from creak.report.figures.scene import scene
from creak.studies.findings.gather import findings_of
from helpers_findings import to_draw


def test_the_largest_of_any_values_has_the_last_share_and_zero_alone_the_first():
    rng = np.random.default_rng(3)
    for largest in (10.0 ** rng.uniform(-300.0, 300.0, 2000)).tolist():
        found = shares(largest * np.array([0.0, 1e-12, 0.5, 1.0, 1.0 - 1e-16, -1.0, np.nan]))
        # Half of 255, rounded up.
        assert found.tolist() == [0, 1, 128, 255, 255, 0, 0]


@pytest.mark.parametrize(
    ("values", "expected"),
    [
        ([], []),
        ([0.0, 0.0], [0, 0]),
        ([-3.0, -1.0], [0, 0]),
        ([np.nan, np.nan], [0, 0]),
        ([7.3, 7.3, 7.3], [255, 255, 255]),
        ([5e-324, 0.0], [255, 0]),
        ([1e-320, 1e10], [1, 255]),
        ([np.inf, 2.0], [255, 1]),
    ],
)
def test_scales_of_odd_values(values, expected):
    assert shares(np.array(values, dtype=float)).tolist() == expected


def test_ends_of_a_scale_of_any_sign_are_never_the_same():
    assert limits(np.array([-2.0, np.nan, 3.0])) == (-2.0, 3.0)
    assert limits(np.array([-4e-6, -4e-6])) == (-4e-6, 0.0)
    for values in ([0.0], [np.nan], []):
        assert limits(np.array(values, dtype=float)) == (0.0, 1.0)


def pressed_by(found, factor):
    """The view with all forces times a factor."""
    run = found.runs["reduced"]
    return replace(found, runs={"reduced": replace(run, force=run.force * factor)})


def test_the_hardest_node_of_the_page_is_painted_as_such(result_of):
    found, drawn = to_draw(result_of("reduced only"))
    rng = np.random.default_rng(5)
    for factor in rng.uniform(0.1, 10.0, 60).tolist():
        told = scene(pressed_by(found, factor), drawn)["impulse"]
        shares = np.frombuffer(base64.b64decode(told["shares"]), dtype=np.uint8)
        assert shares.min() > 0
        assert shares[int(np.argmax(told["values"]))] == 255
        assert told["largest"] == pytest.approx(max(told["values"]), rel=5e-6)  # six digits


def test_pictures_of_values_that_are_no_numbers_all_the_same_or_none(result_of):
    found = findings_of(result_of("reduced only"))
    model, nodes = found.setup.model, np.unique(found.gaps.nodes_idx)
    for value in (0.0, np.nan, -1.0, 2.5, 1e-300):
        loaded = picture.Loaded(nodes, np.full(nodes.size, value), "impulse", "N s")
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            assert picture.contact_picture(model, loaded, np.array([0.0, 0.0, 1.0]))
    for value in (np.nan, -1e-3, 0.0):
        same = replace(found, linear_gaps=np.full(found.setup.contacts.m, value))
        marker = precheck_figure(same, None, UNITS["mm-t-s"]).spec["data"][-1]["marker"]
        assert marker["cmin"] < marker["cmax"]
