"""The motion of all nodes in results.h5 -> a series for ParaView: a .pvd with the times, a VTU for each instant."""

from __future__ import annotations

import os
import re
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path
from xml.sax.saxutils import quoteattr

import h5py
import numpy as np

from creak.arrays import FloatArray
from creak.errors import InputError
from creak.formats.complete_file import partial_folder, write_text
from creak.formats.destination import destination
from creak.formats.stored.results import check_beside, reading, require_run
from creak.formats.stored.run_identity import RunIdentity, identity_in
from creak.formats.stored.sealed import opened_hdf5
from creak.formats.stored.tree import read_tree
from creak.formats.vtu import MeshText, mesh_text, write_instant
from creak.model.plain_mesh import PlainMesh

BLOCK = 4_000_000
"""Numbers read at a time."""


@dataclass(frozen=True)
class MotionField:
    """The recovered motion of one run, left in its file."""

    path: Path
    run: str
    time: FloatArray
    """(n_field,) s"""
    mesh: PlainMesh
    of: RunIdentity | None = None
    """What wrote the file."""

    def instants(self) -> Iterator[tuple[float, FloatArray]]:
        """Time and displacement (n_node, 3) of each instant, some instants read at a time."""
        few = max(1, BLOCK // max(3 * self.mesh.nodes.count, 1))
        for first in range(0, self.time.size, few):
            some = slice(first, min(first + few, self.time.size))
            with reading(self.path), h5py.File(self.path, "r") as file:
                if identity_in(file) != self.of:
                    raise InputError(f"{self.path} was replaced by another run meanwhile", fix="Convert it again.")
                block = file[f"runs/{self.run}/field/displacement"][some]
            yield from zip(self.time[some].tolist(), block, strict=True)


def motion_field(path: Path, run: str | None = None) -> MotionField:
    """The motion that a results.h5 holds.

    Parameters
    ----------
    run : reduced or reference; None: the one that has the motion, the reduced one first.

    Raises
    ------
    InputError : the file is missing or not whole, has no such run, no motion of it, or no mesh.
    """
    with reading(path), opened_hdf5(path) as file:
        check_beside(path, file)
        runs = {str(name): "field" in file["runs"][name] for name in file["runs"]}
        if run is None:
            run = max(runs, key=lambda name: (runs[name], name == "reduced"), default="")
        require_run(path, run, runs)
        if not runs[run]:
            raise InputError(
                f"{path} does not hold the motion of the {run} run",
                expected="motion of all nodes: of a run whose parts touch, or with [output] field_interval",
                fix="Add field_interval, s, to [output] of the study and run it again.",
            )
        if "model" not in file:
            by = file.attrs.get("creak", "another program")
            raise InputError(f"{path}, written by creak {by}, does not keep the mesh", fix="Run the study again.")
        time, mesh = file[f"runs/{run}/field/time"][()], read_tree(PlainMesh, file["model"])
        return MotionField(path, run, time, mesh, identity_in(file))


def write_series(field: MotionField, out: Path, progress: Callable[[int, int], None] | None = None) -> Path:
    """Write `out`, a ParaView collection, and a folder of its name beside it with a VTU for each instant.

    Files appear when all of them are written; a longer series that was there before leaves none of its own.

    Parameters
    ----------
    out : motion.pvd makes motion/motion_0000.vtu and so on. progress : instants done, and of how many.

    Returns
    -------
    The folder with the files of the instants.
    """
    folder, digits = out.with_suffix(""), max(4, len(str(field.time.size - 1)))
    names = [f"{out.stem}_{k:0{digits}d}.vtu" for k in range(field.time.size)]
    old = re.compile(rf"{re.escape(out.stem)}_\d{{4,}}\.vtu")
    earlier = [path for path in folder.glob("*.vtu") if old.fullmatch(path.name)]
    for path in (out, *earlier):
        destination(path, stream=False)
    out.parent.mkdir(parents=True, exist_ok=True)
    text = mesh_text(field.mesh)
    with partial_folder(out) as unfinished:
        _write_instants(field, unfinished, names, text, progress)
        folder.mkdir(exist_ok=True)
        out.unlink(missing_ok=True)
        for path in earlier:
            path.unlink()
        for name in names:
            os.replace(unfinished / name, folder / name)
    write_text(out, _collection(folder.name, names, field.time))
    return folder


def _write_instants(
    field: MotionField, folder: Path, names: list[str], mesh: MeshText, progress: Callable[[int, int], None] | None
) -> None:
    for k, (time, displacement) in enumerate(field.instants()):
        write_instant(folder / names[k], mesh, time, np.asarray(displacement))
        if progress is not None:
            progress(k + 1, len(names))


def _collection(folder: str, names: list[str], time: FloatArray) -> str:
    """A ParaView data file: paths relative to it, by time (VTK file formats)."""
    lines = [
        f'<DataSet timestep="{t!r}" group="" part="0" file={quoteattr(f"{folder}/{name}")}/>'
        for name, t in zip(names, time.tolist(), strict=True)
    ]
    return "\n".join(
        [
            '<?xml version="1.0"?>',
            '<VTKFile type="Collection" version="1.0" byte_order="LittleEndian">',
            "<Collection>",
            *lines,
            "</Collection>",
            "</VTKFile>",
            "",
        ]
    )
