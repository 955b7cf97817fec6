"""Superelements in any file format: which reader and writer goes with which name and file ending."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from creak.digest import file_stem
from creak.errors import InputError, suggest
from creak.formats.deck.command_files import plain_file
from creak.formats.matrices.abaqus_mtx import read_abaqus, write_matrix_output, write_user_element
from creak.formats.matrices.calculix import read_calculix
from creak.formats.matrices.matrix_market import ENDINGS, read_matrix_market, write_matrix_market
from creak.formats.matrices.nastran_dmig import read_dmig, write_dmig
from creak.formats.matrices.nastran_op4 import read_op4, write_op4
from creak.formats.matrices.npz import read_npz, write_npz
from creak.model.superelement import Superelement


@dataclass(frozen=True)
class Format:
    """A way to write superelements."""

    write: Callable[[Superelement, Path], list[Path]]
    ending: str
    """What follows the superelement's name in the path given to `write`."""
    what: str
    beside: tuple[str, ...] = ()
    """What follows it in the other files that may be written."""


FORMATS = {
    "op4": Format(write_op4, ".op4", "Nastran external superelement: .op4 and .asm", (".asm",)),
    "dmig": Format(write_dmig, ".pch", "Nastran DMIG bulk data"),
    "abaqus": Format(
        write_user_element, ".mtx", "Abaqus *SUBSTRUCTURE MATRIX OUTPUT: *USER ELEMENT text", ("_dofs.csv",)
    ),
    "abaqus-matrix-output": Format(
        write_matrix_output,
        "",
        "Abaqus *MATRIX OUTPUT: one entry per line",
        ("_STIF1.mtx", "_MASS1.mtx", "_DMPV1.mtx", "_STIF1_dofs.csv"),
    ),
    "matrix-market": Format(write_matrix_market, "", "Matrix Market: _K.mtx, _M.mtx, _dofs.csv", ENDINGS),
    "npz": Format(write_npz, ".npz", "NumPy"),
}
_NASTRAN = (".pch", ".asm", ".dmig", ".bdf", ".dat", ".nas", ".blk")
_READABLE = (".op4", ".pch", ".dmig", ".bdf", ".dat", ".nas", ".mtx", ".sti", ".npz")


def read_superelement(path: Path, map_file: Path | None = None) -> Superelement:
    """Read a superelement; the format follows from the file's ending and, for .mtx, its first line.

    Parameters
    ----------
    path : .op4, .pch/.dmig/.bdf/.dat/.nas (DMIG), .mtx (Abaqus or Matrix Market), .sti (CalculiX) or .npz.
    map_file : what belongs to the rows where the file does not say it: .asm of Nastran, or a table node,dof,x,y,z.
        Files beside (NAME.asm, NAME_dofs.csv) are found by themselves.

    Raises
    ------
    InputError : the file or the map is missing, damaged or does not fit, or the ending is not known.
    """
    path, map_file = Path(path), None if map_file is None else Path(map_file)
    ending = path.suffix.lower()
    try:
        plain_file(path)
    except FileNotFoundError:
        raise InputError("there is no such file", where=path, fix="Check the path") from None
    except OSError as error:
        raise InputError(f"cannot read {path}: {error.strerror}", fix="Check the path.") from error
    if ending == ".op4":
        return read_op4(path, map_file)
    if ending in _NASTRAN:
        return read_dmig(path, map_file)
    if ending == ".npz":
        return read_npz(path)
    if ending == ".mtx":
        with path.open("rb") as file:
            market = file.read(14).lower() == b"%%matrixmarket"
        return read_matrix_market(path, map_file) if market else read_abaqus(path, map_file)
    if ending in (".sti", ".mas"):
        return read_calculix(path, map_file)
    raise InputError(f"the ending {ending!r} is none of a superelement", where=path, expected=", ".join(_READABLE))


def files_of(name: str, format: str) -> list[str]:
    """Names of all files that `write_superelement` may write of a superelement."""
    of = FORMATS[format]
    return [f"{file_stem(name)}{ending}" for ending in filter(None, (of.ending, *of.beside))]


def write_superelement(superelement: Superelement, folder: Path, format: str) -> list[Path]:
    """Write a superelement to files named after it; returns them.

    Raises
    ------
    InputError : the format is not known, or the superelement does not fit it.
    """
    if format not in FORMATS:
        raise InputError(f"there is no format {format!r}", expected=", ".join(FORMATS), fix=suggest(format, FORMATS))
    folder = Path(folder)
    folder.mkdir(parents=True, exist_ok=True)
    return FORMATS[format].write(superelement, folder / f"{file_stem(superelement.name)}{FORMATS[format].ending}")
