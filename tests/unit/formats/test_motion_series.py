"""The motion of a run as a series of VTU files, read back."""

from __future__ import annotations

import xml.etree.ElementTree as ET

import numpy as np
import pytest

from creak.errors import InputError
from creak.formats.complete_file import complete_file
from creak.formats.measured import motion_series
from creak.formats.measured.motion_series import motion_field, write_series
from creak.formats.stored.sealed import hdf5_file
from creak.formats.stored.tree import write_tree
from creak.model.mesh import Nodes, Part
from creak.model.plain_mesh import PlainBlock, PlainMesh
from helpers_stored import changed_hdf5
from helpers_vtu import arrays

TIME = np.array([0.0, 0.125, 0.3])


@pytest.fixture
def mesh():
    coords = np.array([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0], [2.0, 2.0, 2.0]])
    blocks = (
        PlainBlock("quad4", np.array([7]), np.array([[0, 1, 2, 3]]), 0),
        PlainBlock("beam2", np.array([9]), np.array([[2, 4]]), -1),
    )
    return PlainMesh(Nodes(np.array([10, 20, 30, 40, 50]), coords), blocks, (Part("PLATE", np.arange(4)),))


@pytest.fixture
def motion():
    return np.random.default_rng(5).standard_normal((3, 5, 3))


@pytest.fixture
def results(mesh, motion, tmp_path):
    path = tmp_path / "results.h5"
    with complete_file(path) as partial, hdf5_file(partial) as unfinished:
        file = unfinished.file
        file.create_group("runs/reduced")
        file["runs/reference/field/time"] = TIME
        file["runs/reference/field/displacement"] = motion
        write_tree(file.create_group("model"), mesh)
    return path


@pytest.mark.parametrize("block", [1, 30, 10**6])  # one instant, two, or all of them at a time
def test_series_holds_times_mesh_and_motion(results, mesh, motion, tmp_path, monkeypatch, block):
    monkeypatch.setattr(motion_series, "BLOCK", block)
    out = tmp_path / "new folder" / "motion.pvd"
    told = []
    folder = write_series(motion_field(results), out, lambda done, total: told.append((done, total)))
    sets = [s.attrib for s in ET.parse(out).iter("DataSet")]
    assert [float(s["timestep"]) for s in sets] == TIME.tolist()
    assert told == [(1, 3), (2, 3), (3, 3)]
    for s, time, u in zip(sets, TIME, motion, strict=True):
        found = arrays(out.parent / s["file"])
        assert found["TimeValue"] == time
        np.testing.assert_allclose(found["displacement"], u, rtol=6e-8)  # half a digit of single precision
        np.testing.assert_array_equal(found["Points"], mesh.nodes.coords)
        np.testing.assert_array_equal(found["node"], mesh.nodes.ids)
        assert found["connectivity"].tolist() == [0, 1, 2, 3, 2, 4]
        assert found["types"].tolist() == [9, 3]
        assert found["element"].tolist() == [7, 9]
    assert sorted(p.name for p in out.parent.iterdir()) == ["motion", "motion.pvd"]
    assert len(list(folder.iterdir())) == 3


def test_a_shorter_series_leaves_nothing_of_a_longer_one(results, tmp_path):
    out = tmp_path / "motion.pvd"
    folder = write_series(motion_field(results), out)
    (folder / "mine.txt").write_text("kept")
    with changed_hdf5(results) as file:
        del file["runs/reference/field/time"]
        file["runs/reference/field/time"] = TIME[:1]
    write_series(motion_field(results), out)
    assert sorted(p.name for p in folder.iterdir()) == ["mine.txt", "motion_0000.vtu"]


def test_a_failure_on_the_way_leaves_nothing(results, tmp_path):
    with changed_hdf5(results) as file:
        del file["runs/reference/field/displacement"]
    field = motion_field(results)
    with pytest.raises(InputError, match="damaged"):
        write_series(field, tmp_path / "motion.pvd")
    assert [p.name for p in tmp_path.iterdir()] == ["results.h5"]


def test_what_is_not_there_is_said(results, tmp_path):
    with pytest.raises(InputError, match=r"does not hold the motion of the reduced run.*field_interval"):
        motion_field(results, "reduced")
    with pytest.raises(InputError, match=r"no run 'other'.*reduced, reference"):
        motion_field(results, "other")
    with pytest.raises(InputError, match="no such results"):
        motion_field(tmp_path / "none.h5")
    with changed_hdf5(results) as file:
        del file["model"]
    with pytest.raises(InputError, match="does not keep the mesh"):
        motion_field(results)
    results.write_bytes(results.read_bytes()[:1000])
    with pytest.raises(InputError, match="cut short"):
        motion_field(results)
