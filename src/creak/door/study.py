"""The study that goes with the door, as TOML."""

AMPLITUDE = 0.0115
"""Amplitude of every sine of the multisine that drives the upper hinge, mm."""

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
amplitude = {amplitude:g}                      # mm, of each sine
period = 1.0                          # s
seed = 1                              # of the phases

[reduction]
method = "craig-bampton"
f_max = 1500                          # Hz, fixed-interface modes kept

[precheck]
enabled = true                        # keep contact only where a linear run closes the gap
margin = 0.5                          # mm of gap left that still counts as closing

[time]
step = 1e-3                           # s
periods = 5
integrator = "hht"
alpha = -0.05                         # slight numerical damping

[reference]
run = true                            # also run the unreduced model

[verification]
pairs = "PAIRS"                       # node sets PAIRS_MAIN and PAIRS_SECONDARY
f_max = 500                           # Hz, spectra and low-passed forces
mac_f_max = 100                       # Hz, mode shapes
event_tolerance = 0.010               # s, events this close are the same
merge = 0.005                         # s, contact lost for less is one event
"""


def study_text(amplitude: float = AMPLITUDE) -> str:
    """The study file for an amplitude (mm) of the sines."""
    return _STUDY.format(amplitude=amplitude)
