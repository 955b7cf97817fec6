"""Mode shapes and motion -> VTU (VTK unstructured grid, XML), which ParaView, VisIt and PyVista open."""

from __future__ import annotations

import base64
import io
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TextIO
from xml.sax.saxutils import quoteattr

import numpy as np

from creak.arrays import FloatArray
from creak.formats.complete_file import complete_file
from creak.model.faces import HEX20
from creak.model.plain_mesh import Mesh

CELLS = {
    "quad4": 9,
    "tri3": 5,
    "quad8": 23,
    "tri6": 22,
    "beam2": 3,
    "beam3": 4,
    "truss2": 3,
    "hex8": 12,
    "wedge6": 13,
    "pyramid5": 14,
    "coh6": 13,
    "coh8": 12,
    "tet4": 10,
    "tet10": 24,
    **dict.fromkeys(HEX20, 25),
    "wedge15": 26,
}
"""VTK cell types; every other kind is a vertex or a line, by its number of nodes."""
VERTEX, LINE = 1, 3
TYPES = {"f4": "Float32", "f8": "Float64", "i8": "Int64", "u1": "UInt8"}


def write_vtu(path: Path, model: Mesh, frequencies: Sequence[float], shapes: Iterable[FloatArray]) -> None:
    """Write the mesh and one displacement vector per mode.

    Point arrays: `mode_001_12.34_Hz`, ... (n_node, 3) in single precision, `node` (label of the deck), and `instance`
    (row of the instance, -1 for none) in decks with instances. Cell arrays: `element` (label), `part` (row, -1 for
    elements between parts). Field array: `frequency`, Hz. All nodes of the model are points.

    Parameters
    ----------
    frequencies : (n_mode,) Hz. shapes : (n_node, 3) for each mode in turn; taken one at a time.

    XML with inline base64 arrays, little-endian, 8-byte headers (VTK file formats, version 1.0).
    """
    digits = max(3, len(str(len(frequencies))))
    named = zip([f"mode_{i:0{digits}d}_{f:.6g}_Hz" for i, f in enumerate(frequencies, start=1)], shapes, strict=True)
    with complete_file(path) as partial, partial.open("w", encoding="ascii") as file:
        _write(file, mesh_text(model), {"frequency": frequencies} if len(frequencies) else {}, named)


def write_instant(path: Path, mesh: MeshText, time: float, displacement: FloatArray) -> None:
    """Write the mesh and its motion at one instant: point array `displacement` (n_node, 3) in single precision.

    The file is one of a folder that is complete or absent (`creak.formats.measured.motion_series`).

    Parameters
    ----------
    mesh : of `mesh_text`, one for all instants. time : s, the field array `TimeValue`, from which ParaView takes it.
    """
    with path.open("w", encoding="ascii") as file:
        _write(file, mesh, {"TimeValue": [time]}, iter([("displacement", displacement)]))


def write_points(path: Path, xyz: FloatArray, arrays: Mapping[str, FloatArray]) -> None:
    """Write points (n, 3), a vertex each, with figures (n,) in double precision."""
    count, rows, head = len(xyz), np.arange(len(xyz)), io.StringIO()
    head.write(f'<Piece NumberOfPoints="{count}" NumberOfCells="{count}">\n<Points>\n')
    _array(head, "Points", xyz.astype("<f8"))
    head.write("</Points>\n<Cells>\n")
    _array(head, "connectivity", rows.astype("<i8"))
    _array(head, "offsets", (rows + 1).astype("<i8"))
    _array(head, "types", np.full(count, VERTEX, dtype="u1"))
    head.write("</Cells>\n")
    figures = io.StringIO()
    for name, values in arrays.items():
        _array(figures, name, values.astype("<f8"))
    with complete_file(path) as partial, partial.open("w", encoding="ascii") as file:
        _write(file, MeshText(head.getvalue(), figures.getvalue()), {}, iter(()))


@dataclass(frozen=True)
class MeshText:
    """What files of one mesh have in common, as they say it."""

    head: str
    """The opening of the piece, points and cells."""
    labels: str
    """Point arrays `node` and `instance`."""


def mesh_text(model: Mesh) -> MeshText:
    """Points, cells and labels of a model."""
    head, labels = io.StringIO(), io.StringIO()
    head.write(f'<Piece NumberOfPoints="{model.nodes.count}" NumberOfCells="{model.n_elements}">\n')
    head.write("<Points>\n")
    _array(head, "Points", model.nodes.coords.astype("<f8"))
    head.write("</Points>\n")
    blocks = model.blocks
    sizes = [np.full(b.ids.size, b.nodes_idx.shape[1]) for b in blocks]
    types = [np.full(b.ids.size, CELLS.get(b.kind, VERTEX if b.nodes_idx.shape[1] == 1 else LINE)) for b in blocks]
    parts = [np.full(b.ids.size, b.part) for b in blocks]
    head.write("<Cells>\n")
    _array(head, "connectivity", _joined([b.nodes_idx.ravel() for b in blocks], "<i8"))
    _array(head, "offsets", np.cumsum(_joined(sizes, "<i8")).astype("<i8"))
    _array(head, "types", _joined(types, "u1"))
    head.write("</Cells>\n<CellData>\n")
    _array(head, "element", _joined([b.ids for b in blocks], "<i8"))
    _array(head, "part", _joined(parts, "<i8"))
    head.write("</CellData>\n")
    _array(labels, "node", model.nodes.ids.astype("<i8"))
    if model.nodes.instance:
        _array(labels, "instance", model.nodes.instance_idx.astype("<i8"))
    return MeshText(head.getvalue(), labels.getvalue())


def _write(
    file: TextIO, mesh: MeshText, fields: Mapping[str, Sequence[float]], vectors: Iterable[tuple[str, FloatArray]]
) -> None:
    """A whole file: arrays of the field as doubles, vectors at the points as floats."""
    file.write(
        '<?xml version="1.0"?>\n<VTKFile type="UnstructuredGrid" version="1.0" byte_order="LittleEndian" '
        'header_type="UInt64">\n<UnstructuredGrid>\n'
    )
    if fields:
        file.write("<FieldData>\n")
        for name, numbers in fields.items():
            _array(file, name, np.asarray(numbers, dtype="<f8"), tuples=True)
        file.write("</FieldData>\n")
    file.write(f"{mesh.head}<PointData>\n{mesh.labels}")
    for name, vector in vectors:
        _array(file, name, vector.astype("<f4"))
    file.write("</PointData>\n</Piece>\n</UnstructuredGrid>\n</VTKFile>\n")


def _joined(arrays: list[np.ndarray], dtype: str) -> np.ndarray:
    return np.concatenate([np.zeros(0, dtype=np.int64), *arrays]).astype(dtype)


def _array(file: TextIO, name: str, values: np.ndarray, *, tuples: bool = False) -> None:
    """One array: 8 bytes with its length and the values, base64 each in one piece."""
    width = f' NumberOfComponents="{values.shape[1]}"' if values.ndim == 2 else ""
    width += f' NumberOfTuples="{values.shape[0]}"' if tuples else ""
    raw = np.ascontiguousarray(values).tobytes()
    kind = TYPES[values.dtype.str[1:]]
    file.write(f'<DataArray type="{kind}" Name={quoteattr(name)}{width} format="binary">\n')
    file.write(base64.b64encode(len(raw).to_bytes(8, "little") + raw).decode("ascii"))
    file.write("\n</DataArray>\n")
