"""The study that goes with the door, as TOML; door and study in files."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from types import MappingProxyType

from creak import InputError, write_text
from creak_thesis.door.assembly import build_door
from creak_thesis.door.deck import deck_text, hook_ends

LOADS: Mapping[str, float] = MappingProxyType({"A1": 4e-6, "A2": 0.005, "A3": 0.0057, "A4": 0.0067})
"""Name of a load -> amplitude of every sine of the multisine that drives the upper hinge, mm.

At 20 mm and at 10 mm they give none, 4 to 6, 8 to 12 and 13 to 17 contact events per second, as the loads A1 to A4
of the thesis do (its table 3.4; docs/door.md has the counts)."""
LOAD = "A3"
"""The load of the study unless another is asked for."""

_STUDY = """\
title = "Front door: trim panel against frame"

[model]
deck = "door.inp"
units = "mm-t-s"

[contact.flange]
secondary = "PANEL_EDGE"              # edge of the panel: two rows of elements
main = "FRAME_FLANGE"                 # flat band of the frame behind it
method = "surface-to-surface"         # or "node-to-surface"
stiffness = "auto"                    # from the shells; or MPa/mm
friction = 0.0

[excitation.hinge]
node_set = "F"                        # upper front hinge
dof = "z"                             # up and down, as on a rough road
kind = "displacement"

[excitation.hinge.signal]
type = "multisine"                    # sines of equal amplitude and random phase
f_min = 1                             # Hz
f_max = 100                           # Hz
amplitude = {amplitude:<17g} # mm, of each sine: load {load}; {others}
period = 1.0                          # s
seed = 1                              # of the phases

[reduction]
method = "craig-bampton"
f_max = "auto"                        # modes are added until the events stay as they are; or Hz

[precheck]
enabled = true                        # keep contact only where a linear run closes the gap
margin = 0.5                          # mm of gap left that still counts as closing

[time]
periods = 5
accuracy = "settled"                  # or "quick", "fine"; steps follow from it

[reference]
run = "spots"                         # single events of the unreduced model; "whole": all of its run; "none"

[verification]
pairs = "PAIRS"                       # 44 pairs in the contact area; "PAIRS15": 15 around the flange
f_max = 500                           # Hz, spectra and low-passed forces
mac_f_max = 100                       # Hz, mode shapes
event_tolerance = 0.010               # s, events this close are the same
"""


_PLAY = """
[[connector]]
type = "play"                         # hook between panel and frame: free within its limits, then stiff
name = "{name}"
nodes = ["{first}", "{second}"]
dof = "y"
lower = {lower:g}                         # mm
upper = {upper:g}
stiffness = {stiffness:g}                      # N/mm
"""
HOOK_STIFFNESS = 1000.0
"""Of a hook once its play is used up, N/mm."""


def play_text(ends: Sequence[tuple[str, str]], play: float) -> str:
    """Connectors with `play` mm to either side between the node sets of each hook."""
    return "".join(
        _PLAY.format(
            name=first.rsplit("_", 1)[0].lower(),
            first=first,
            second=second,
            lower=-play,
            upper=play,
            stiffness=HOOK_STIFFNESS,
        )
        for first, second in ends
    )


def study_text(load: str = LOAD) -> str:
    """The study file for one of `LOADS`.

    Raises
    ------
    InputError : there is no such load.
    """
    if load not in LOADS:
        raise InputError(
            f"there is no load {load!r}",
            expected=", ".join(LOADS),
            where="load of the door",
            fix=f"Take {LOAD}, or change the amplitude in door.toml.",
        )
    others = ", ".join(f"{name} {value:g}" for name, value in LOADS.items() if name != load)
    return _STUDY.format(load=load, amplitude=LOADS[load], others=others)


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
