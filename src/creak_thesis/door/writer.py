"""Write the door's deck and study."""

from __future__ import annotations

from pathlib import Path

from creak import InputError, write_text
from creak_thesis.door.assembly import build_door
from creak_thesis.door.deck import deck_text, hook_ends
from creak_thesis.door.study import LOAD, play_text, study_text


def write_door(
    mesh_size: float, out: Path, coarsen: int = 1, load: str = LOAD, hook_play: float | None = None
) -> list[Path]:
    """Write `door.inp` and `door.toml` into a folder and return their paths.

    Parameters
    ----------
    mesh_size : length of the elements' sides, mm, from 2 to 40; 20 for a first run.
    out : the folder; it is made if missing.
    coarsen : 1, 2 or 3 elements of the frame's flange merged into one along the contact line.
    load : name of one of `LOADS`.
    hook_play : play of the hooks between panel and frame to either side in y, mm; None: they are rigid.

    Raises
    ------
    InputError : the mesh size or `coarsen` is out of range, there is no such load, the play is negative, or `out` is a
        file; nothing is written.
    """
    if out.exists() and not out.is_dir():
        raise InputError("this is a file", expected="a folder", where=out, fix="Give another folder.")
    if hook_play is not None and not hook_play >= 0.0:
        raise InputError(f"play of the hooks {hook_play:g} mm", expected="zero or more", where="play of the hooks")
    study, door = study_text(load), build_door(mesh_size, coarsen)
    if hook_play is not None:
        study += play_text([(a.name, b.name) for _, a, b in hook_ends(door)], hook_play)
    texts = {
        "door.inp": deck_text(door, loose_hooks=hook_play is not None),
        "door.toml": f"# written by creak example door\n{study}",
    }
    out.mkdir(parents=True, exist_ok=True)
    return [_write(out / name, text) for name, text in texts.items()]


def _write(path: Path, text: str) -> Path:
    write_text(path, text)
    return path
