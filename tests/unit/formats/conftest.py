"""Small decks: a frame and a panel, once flat and once with parts and instances."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest

from creak.formats.abaqus.reader import read_deck
from creak.model.mesh import Model

MATERIALS = """\
*Material, name=Steel
*Elastic
 210000., 0.3
*Density
 7.85e-9,
*Damping, alpha=1.5, beta=2.e-5
*Material, name=Plastic
*Elastic, type=ISOTROPIC
 3500., .25
*Density
 8.3D-10
"""

FLAT = f"""\
*HEADING
A frame and a panel, mm-t-s
** comment
*NODE, NSET=FRAME_NODES
 130, 20., 10., 0.
 10, 0., 0., 0.
 20, 10., 0., 0.
 30, 20., 0., 0.
 110, 0., 10., 0.
 120, 10., 10., 0.
*NODE
 201, 0., 13.7, 0.
 202, 10., 13.7, 0.
 203, 20., 13.7, 0.
 204, 0., 13.7, 10.
 205, 10., 13.7, 10.
 206, 20., 13.7, 10.
 901, 20., 5., 0.
 902, 20., 13.7, 5.
*ELEMENT, TYPE=S4R,
 ELSET=FRAME
 7, 10, 20, 120, 110
 5, 20, 30, 130, 120
*ELEMENT, TYPE=S4, ELSET=PANEL
 41, 201, 202, 205, 204
*ELEMENT, TYPE=S3, ELSET=PANEL
 42, 202, 203, 206
 43, 202, 206, 205
*ELEMENT, TYPE=MASS, ELSET=BALLAST
 91, 902
*ELEMENT, TYPE=SPRING2, ELSET=CLIP
 92, 130, 203
*ELSET, ELSET=ALL, GENERATE
 41, 43
*ELSET, ELSET=ALL
 FRAME, BALLAST
*NSET, NSET=PAIRS
 203, 130, 20
*NSET, NSET=PANEL_NODES, ELSET=PANEL
*SHELL SECTION, ELSET=FRAME, MATERIAL=STEEL
 0.7, 5
*SHELL SECTION, ELSET=PANEL, MATERIAL=plastic
 1.8
*MASS, ELSET=BALLAST
 1.e-4
*SPRING, ELSET=CLIP
 2, 2
 100.
*SURFACE, NAME=FLANGE
 FRAME, SPOS
*SURFACE, NAME=EDGE, TYPE=NODE
 203, 2.0
 206,
*SURFACE, NAME=FRAME_END
 5, E2
*COUPLING, CONSTRAINT NAME=C1, REF NODE=901, SURFACE=FRAME_END
*KINEMATIC
*COUPLING, CONSTRAINT NAME=C2, REF NODE=902, SURFACE=EDGE
*DISTRIBUTING
 1, 3
*MPC
 BEAM, 902, 901
*BOUNDARY
 10, ENCASTRE
 110, 2, 3
*INITIAL CONDITIONS, TYPE=VELOCITY
 PANEL_NODES, 2, -1000.
{MATERIALS}*CONTACT PAIR, INTERACTION=SOFT
 EDGE, FLANGE
*STEP
*DYNAMIC
 0.001, 1.
*BOUNDARY
 30, 1, 1
 110, 1, 1, 1.9
*END STEP
"""

PARTS = f"""\
*Heading
*Part, name=Frame
*Node, nset=FRAME_NODES
 130, 20., 10., 0.
 10, 0., 0., 0.
 20, 10., 0., 0.
 30, 20., 0., 0.
 110, 0., 10., 0.
 120, 10., 10., 0.
*Element, type=S4R, elset=SKIN
 7, 10, 20, 120, 110
 5, 20, 30, 130, 120
*Shell Section, elset=SKIN, material=Steel
 0.7, 5
*End Part
*Part, name=Panel
*Node
 201, 12.7, -2., -3.
 202, 12.7, -12., -3.
 203, 12.7, -22., -3.
 204, 12.7, -2., 7.
 205, 12.7, -12., 7.
 206, 12.7, -22., 7.
*Element, type=S4, elset=PANEL
 41, 201, 202, 205, 204
*Element, type=S3, elset=PANEL
 42, 202, 203, 206
 43, 202, 206, 205
*Nset, nset=PANEL_NODES, elset=PANEL
*Shell Section, elset=PANEL, material=Plastic
 1.8
*End Part
*Assembly, name=Door
*Instance, name=Frame-1, part=Frame
*End Instance
*Instance, name="Panel-1", part=Panel
 1., 2., 3.
 0., 0., 0., 0., 0., 1., 90.
*End Instance
*Node
 901, 20., 5., 0.
 902, 20., 13.7, 5.
*Element, type=MASS, elset=BALLAST
 91, 902
*Element, type=SPRING2, elset=CLIP
 92, Frame-1.130, Panel-1.203
*Mass, elset=BALLAST
 1.e-4
*Spring, elset=CLIP
 2, 2
 100.
*Nset, nset=PAIRS
 Panel-1.203, Frame-1.130, Frame-1.20
*Elset, elset=_END_E2, internal, instance=Frame-1
 5,
*Nset, nset=TIP, instance=Panel-1
 203, 206
*Surface, type=ELEMENT, name=FRAME_END
 _END_E2, E2
*Surface, type=NODE, name=EDGE
 Panel-1.203, 2.
 Panel-1.206,
*Surface, name=FLANGE
 Frame-1.SKIN, SPOS
*Coupling, constraint name=C1, ref node=901, surface=FRAME_END
*Kinematic
*Coupling, constraint name=C2, ref node=902, surface=Door.EDGE
*Distributing
 1, 3
*MPC
 BEAM, 902, 901
*End Assembly
*Boundary
 Frame-1.10, ENCASTRE
 Frame-1.110, 2, 3
*Initial Conditions, type=VELOCITY
 PANEL_NODES, 2, -1000.
{MATERIALS}*Step
*Boundary
 Frame-1.30, 1, 1
*End Step
"""

Reader = Callable[[str], Model]


@pytest.fixture
def flat() -> str:
    return FLAT


@pytest.fixture
def parts() -> str:
    return PARTS


@pytest.fixture
def read(tmp_path: Path) -> Reader:
    """Write a deck to a file and read it."""

    def reader(text: str) -> Model:
        path = tmp_path / "deck.inp"
        path.write_text(text)
        return read_deck(path)

    return reader
