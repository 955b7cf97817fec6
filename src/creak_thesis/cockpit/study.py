"""The study that goes with the cockpit, as TOML, and both files in a folder."""

from __future__ import annotations

import math
from pathlib import Path

from creak import InputError, write_text
from creak_thesis.cockpit.deck import deck_text

_STUDY = """\
title = "Cockpit: glove box, decor trim and air duct on a rough road"

[model]
deck = "cockpit.inp"
units = "mm-t-s"

[[clip]]                              # hook of the latch: holds the lid once it has opened by its play
name = "latch"
type = "play"
nodes = ["LATCH_CARRIER", "LATCH_LID"]
axis = [0, 1, 0]
upper = 0.3                           # mm
stiffness = 200                       # N/mm
damping = 0.1                         # N s/mm
source = "example values, not measured"

[[clip]]                              # rubber bumpers behind the upper corners of the lid
name = "bumper_right"
type = "stop"
nodes = ["BUMPER_RIGHT_CARRIER", "BUMPER_RIGHT_LID"]
axis = [0, -1, 0]
gap = 0.4                             # mm
stiffness = 150
damping = 0.1
source = "example values, not measured"

[[clip]]
name = "bumper_left"                  # stands back a little
type = "stop"
nodes = ["BUMPER_LEFT_CARRIER", "BUMPER_LEFT_LID"]
axis = [0, -1, 0]
gap = 0.6
stiffness = 150
damping = 0.1
source = "example values, not measured"

[[clip]]                              # air duct before the steel beam, with a felt pad
name = "duct"
type = "stop"
nodes = ["BEAM_PAD", "DUCT_PAD"]
axis = [0, -1, 0]
gap = 0.4
stiffness = 50
damping = 0.01
source = "example values, not measured"

[[clip]]                              # card holder: a tongue inside the lid, with a soft edge
name = "card_holder"
type = "stop"
nodes = ["HOLDER_LID", "HOLDER_TIP"]
axis = [0, 1, 0]
gap = 0.4
stiffness = 10
damping = 0.003
source = "example values, not measured"

[contact.lid_rim]                     # upper edge of the lid between the bumpers
secondary = "LID_RIM"
main = "CARRIER_FACE"
method = "node-to-surface"
clearance = 0.8                       # mm, face to face
stiffness = 100                       # N/mm, each node

[contact.trim]                        # rib behind the decor trim, pressed on the carrier: it rubs
secondary = "TRIM_RIB"
main = "CARRIER_FACE"
method = "node-to-surface"
clearance = 0.0
stiffness = 300
friction = {{ static = 0.3, kinetic = 0.17, decay = 10 }}   # mm/s

[[static]]                            # what presses it on
force = -0.5                          # N
node_set = "TRIM_RIB"
dof = "y"

[excitation.road_y]                   # rough road at the mounts, fore and aft
node_set = "MOUNTS"
dof = "y"
kind = "acceleration"
signal = {{ type = "psd", unit = "g2/Hz", duration = 1, seed = {seed}, values = [{density_y}] }}

[excitation.road_z]                   # up and down
node_set = "MOUNTS"
dof = "z"
kind = "acceleration"
signal = {{ type = "psd", unit = "g2/Hz", duration = 1, seed = {other}, values = [{density_z}] }}

[damping]
rayleigh = {{ alpha = 8, beta = 1e-5 }}   # 4 % at 15 Hz, 1.4 % at 50 Hz, 1.7 % at 500 Hz

[reduction]
method = "craig-bampton"
f_max = "auto"                        # fixed-interface modes are added until the events settle

[time]
end = 1.5                             # s
accuracy = "settled"

[background]
file = "cabin.csv"                    # a quiet cabin: places are ranked by what they add to it

[limit]
n5 = "2 sone"

[listener.passenger]
position = [350, 650, 500]            # mm, in the deck's axes

[reference]
run = "spots"                         # single events of the unreduced model; "whole": all of its run; "none"

[eline.bumper_right]                  # each contact is a line by itself, a clip is not
main = "CARRIER_FACE"
secondary = "BUMPER_RIGHT_LID"
clearance = 0.4

[eline.bumper_left]
main = "CARRIER_FACE"
secondary = "BUMPER_LEFT_LID"
clearance = 0.6

[eline.duct]
main = "BEAM_FACE"
secondary = "DUCT_PAD"
clearance = 0.4

[eline.card_holder]
main = "LID_BACK"
secondary = "HOLDER_TIP"
clearance = 0.4

[eline.trim]
material = "abs-pp"

[material-pair.abs-pp]
source = "example values, not measured: put your own rig's here"
impulse_rate_min = 1.0                # 1/mm
impulse_rate_max = 4.0
"""

_CABIN = {
    25: 62,
    31.5: 60,
    40: 57,
    50: 54,
    63: 51,
    80: 48,
    100: 45,
    125: 42,
    160: 40,
    200: 38,
    250: 36,
    315: 34,
    400: 32,
    500: 30,
    630: 29,
    800: 28,
    1000: 27,
    1250: 26,
    1600: 25,
    2000: 24,
    2500: 22,
    3150: 21,
    4000: 20,
    5000: 18,
}
"""Third octave, Hz -> level in a quiet cabin, dB: example values."""


def background_text() -> str:
    """The steady sound of the cabin, third octaves."""
    return "frequency,level\n" + "".join(f"{f:g},{level}\n" for f, level in _CABIN.items())


def study_text(load: float = 1.0, seed: int = 1) -> str:
    """The study; `load` scales the acceleration."""

    def density(level: float) -> str:
        level *= load**2
        return ", ".join(f"[{f:g}, {level * share:.3g}]" for f, share in ((5, 0.3), (10, 1.0), (30, 1.0), (100, 0.02)))

    return _STUDY.format(density_y=density(0.002), density_z=density(0.002), seed=seed, other=seed + 1000)


FILES = ("cockpit.inp", "cockpit.toml", "cabin.csv")
SIZES = (4.0, 20.0)
"""Smallest and largest size of the elements, mm."""
LOADS = (0.01, 10.0)
"""Factors on the acceleration."""


def write_cockpit(mesh_size: float, out: Path, load: float = 1.0, seed: int = 1) -> list[Path]:
    """Write `FILES` into a folder and return their paths.

    Parameters
    ----------
    mesh_size : length of the elements' sides, mm, 4 to 20, rounded to 20 mm over a whole number; 10 for a first run.
    out : the folder; it is made if missing.
    load : factor on the road's acceleration, 0.01 to 10.
    seed : of its random phases.

    Raises
    ------
    InputError : a size or load out of range, a negative seed, or `out` is a file; nothing is written.
    """
    if out.exists() and not out.is_dir():
        raise InputError("this is a file", expected="a folder", where=out, fix="Give another folder.")
    for what, value, (low, high) in (("mesh size", mesh_size, SIZES), ("load", load, LOADS)):
        if not (math.isfinite(value) and low <= value <= high):
            raise InputError(
                f"{what} {value:g}", expected=f"a number from {low:g} to {high:g}", where=f"{what} of the cockpit"
            )
    if seed < 0:
        raise InputError(f"seed {seed}", expected="a whole number, 0 or more", where="seed of the cockpit")
    study = f"# written by creak example cockpit\n{study_text(load, seed)}"
    texts = dict(zip(FILES, (deck_text(mesh_size), study, background_text()), strict=True))
    out.mkdir(parents=True, exist_ok=True)
    for name, text in texts.items():
        write_text(out / name, text)
    return [out / name for name in texts]
