"""Good decks and studies that the fuzzer damages: together they hold nearly every keyword and card that creak reads."""

from __future__ import annotations

from fuzz_more_samples import FASTENED, LAYERS, OPTISTRUCT, STARTED, SWEEP
from helpers_decks import STUDY, two_strips
from helpers_dynamic_decks import stop_deck
from helpers_same_model import abaqus_deck, mesh, nastran_deck

STRIPS = two_strips()

INSTANCES = """\
*Heading
*Part, name=Frame
*Node, nset=ALL
 130, 20., 10., 0.
 10, 0., 0., 0.
 20, 10., 0., 0.
 30, 20., 0., 0.
 110, 0., 10., 0.
 120, 10., 10., 0.
*Element, type=S4R, elset=SKIN
 7, 10, 20, 120, 110
 5, 20, 30, 130, 120
*Nodal Thickness
 ALL, 0.7
*Shell Section, elset=SKIN, material=Steel, nodal thickness, offset=SPOS
 0.7, 5
*End Part
*Part, name=Panel
*System
 0., 0., 0., 1., 0., 0.
*Node, system=C
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
*Orientation, name=O, system=CYLINDRICAL
 0., 0., 0., 0., 0., 1.
 3, 20.
*Shell Section, elset=PANEL, composite, orientation=O, symmetric
 0.4, 3, Carbon, 45.
 0.2, 3, Plastic, -10.
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
 903, 25., 13.7, 5.
*Element, type=MASS, elset=BALLAST
 91, 902
*Element, type=ROTARYI, elset=BALLAST_I
 96, 902
*Element, type=SPRING2, elset=CLIP
 92, Frame-1.130, Panel-1.203
*Element, type=SPRINGA, elset=STRUT
 93, 901, Panel-1.203
*Element, type=DASHPOT1, elset=DAMPER
 94, 902
*Element, type=CONN3D2, elset=BUSH
 95, 902, 903
*Element, type=B31, elset=BAR
 97, 901, 903
*Mass, elset=BALLAST, alpha=2.
 1.e-4
*Rotary Inertia, elset=BALLAST_I
 1e-3, 1e-3, 1e-3
*Spring, elset=CLIP, orientation=R
 2, 2
 100.
*Spring, elset=STRUT

 50.
*Dashpot, elset=DAMPER
 3
 0.5
*Connector Section, elset=BUSH, behavior=RUBBER
 Bushing,
 R,
*Connector Behavior, name=RUBBER
*Connector Elasticity, component=1
 10.,
*Connector Elasticity, component=5
 70.,
*Connector Damping, component=1
 .1,
*Orientation, name=R
 1., 1., 0., 0., 1., 0.
 3, 0.
*Beam Section, elset=BAR, material=Steel, section=BOX
 6., 4., .5, .6, .5, .6
 0., 1., 0.
*Transform, nset=PAIRS, type=C
 0., 0., 0., 0., 0., 1.
*Nset, nset=PAIRS
 Panel-1.203, Frame-1.130, Frame-1.20
*Elset, elset=_END_E2, internal, instance=Frame-1
 5,
*Nset, nset=TIP, instance=Panel-1, generate
 203, 206, 3
*Surface, type=ELEMENT, name=FRAME_END
 _END_E2, E2
*Surface, type=NODE, name=EDGE
 Panel-1.203, 2.
 Panel-1.206,
 Panel-1.202, 1.5
*Surface, name=FLANGE
 Frame-1.SKIN, SPOS
*Coupling, constraint name=C1, ref node=901, surface=FRAME_END
*Kinematic
*Coupling, constraint name=C2, ref node=902, surface=Door.EDGE, influence radius=100.
*Distributing
 1, 3
*MPC
 BEAM, 903, 901
*Equation
 2
 TIP, 1, 1., 902, 1, -1.
*Nonstructural Mass, elset=Frame-1.SKIN, units=TOTAL MASS
 1e-6
*End Assembly
*Boundary
 Frame-1.10, ENCASTRE
 PAIRS, 2, 3
*Initial Conditions, type=VELOCITY
 PANEL_NODES, 2, -1000.
*Material, name=Steel
*Elastic
 210000., 0.3
*Density
 7.85e-9,
*Damping, alpha=1.5, beta=2.e-5
*Material, name=Plastic
*Elastic, type=ENGINEERING CONSTANTS
 3500., 3000., 2500., .25, .2, .2, 900., 800.,
 700.
*Density
 8.3D-10
*Material, name=Carbon
*Elastic, type=LAMINA
 140000., 10000., 0.3, 5000., 5000., 3500.
*Density
 1.6e-9
*Step
*Boundary
 Frame-1.30, 1, 1
*End Step
"""

SOLIDS = """\
*NODE
 1, 0., 0., 0.
 2, 2., 0., 0.
 3, 2., 2., 0.
 4, 0., 2., 0.
 5, 0., 0., 3.
 6, 2., 0., 3.
 7, 2., 2., 3.
 8, 0., 2., 3.
 9, 4., 0., 0.
 10, 4., 0., 3.
 11, 0., 0., 5.
 12, 1., 1., 7.
 21, 0., 0., 9.
 22, 2., 0., 9.
 23, 2., 2., 9.
 24, 0., 2., 9.
*ELEMENT, TYPE=C3D8R, ELSET=BODY
 1, 1, 2, 3, 4, 5,
 6, 7, 8
*ELEMENT, TYPE=C3D6, ELSET=BODY
 2, 2, 9, 3, 6, 10, 7
*ELEMENT, TYPE=C3D4, ELSET=BODY
 3, 5, 6, 7, 11
*ELEMENT, TYPE=T3D2, ELSET=ROD
 4, 11, 12
*ELEMENT, TYPE=S4, ELSET=SKIN
 5, 1, 4, 8, 5
*ELEMENT, TYPE=S4, ELSET=LID
 6, 21, 22, 23, 24
*ELEMENT, TYPE=B33, ELSET=POST
 7, 12, 21, 9
*SOLID SECTION, ELSET=BODY, MATERIAL=WOOD, ORIENTATION=O
*SOLID SECTION, ELSET=ROD, MATERIAL=STEEL
 0.5
*SHELL SECTION, ELSET=SKIN, MATERIAL=STEEL
 0.1
*SHELL GENERAL SECTION, ELSET=LID, DENSITY=1E-9
 1000., 300., 1000., 0., 0., 350., 0., 0.,
 0., 90., 0., 0., 0., 27., 90., 0.,
 0., 0., 0., 0., 31.
*TRANSVERSE SHEAR STIFFNESS
 300., 300., 0.
*BEAM GENERAL SECTION, ELSET=POST, SECTION=GENERAL, DENSITY=1E-9
 2., 3., 0.5, 4., 5.
 1., 0., 0.
 1000., 400.
*CENTROID
 0.1, 0.2
*SHEAR CENTER
 0.2, 0.1
*ORIENTATION, NAME=O
 1., .2, 0., 0., 1., .1
 3, 10.
*MATERIAL, NAME=STEEL
*ELASTIC
 210000., 0.3
*DENSITY
 1e-3
*MATERIAL, NAME=WOOD
*ELASTIC, TYPE=ORTHOTROPIC
 10., 2., 8., 2., 2., 6., 3., 2.,
 1.
*DENSITY
 1e-3
*SURFACE, NAME=TOP
 1, S2
 3, S1
*SURFACE, NAME=UNDER
 LID, SNEG
*SURFACE, NAME=FREE
 BODY
*TIE, NAME=GLUE, POSITION TOLERANCE=20., ADJUST=NO
 UNDER, TOP
*RIGID BODY, REF NODE=1, PIN NSET=PINS
*NSET, NSET=PINS
 2, 9
*MPC
 LINK, 4, 12
 TIE, 3, 8
*KINEMATIC COUPLING, REF NODE=10
 6, 1, 3
*BOUNDARY
 1, PINNED
"""

CARDS = """\
SOL 103
CEND
SPC = 1
MPC = 1
IC = 3
SET 1 = 1, 3 THRU 6
BEGIN BULK
CORD2C,6,,0.,0.,0.,0.,0.,1.
,1.,0.,0.
CORD1R,7,1,2,3
GRDSET,,,,,,,
GRID,1,,0.,0.,0.
GRID,2,,1.,0.,0.,6
GRID,3,6,1.,45.,0.
GRID,4,,0.,1.,0.,,4
GRID,5,,0.,0.,1.
GRID,6,,1.,0.,1.
GRID,7,,1.,1.,1.
GRID,8,,0.,1.,1.
SPOINT,20,THRU,22
MAT1,1,2.+5,,.3,1.-9,,,.01
MAT2,2,2.+5,6.+4,0.,2.+5,0.,7.+4,1.-9
MAT8,8,1.+5,1.+4,.3,5.+3,4.+3,3.+3,1.-9
MAT9,9,5.,1.,1.,0.,0.,0.,5.
,1.,0.,0.,0.,5.,0.,0.,0.
,2.,0.,0.,2.,0.,2.,1.-9
PSHELL,1,1,.1,1,,1
PSHELL,11,2,.1,2,,1,,1.-9
PCOMP,2,,,,,,,SYM
,8,.1,45.,,1,.2
CQUAD4,1,1,1,2,3,4,30.,.1
,,1,1.,1.,1.,1.
CTRIA3,2,2,5,6,7,6
CQUAD4,21,11,5,6,7,8,6
PBAR,3,1,1.,1.,1.,1.,.1
,,,,,,,,
,.5,.5,.1
CBAR,3,3,1,5,1.,0.,0.
,,45,0.,.1
BAROR,,3,,,0.,1.,0.
PBEAM,4,1,1.,1.,1.,,1.,
,1.,1.,1.,1.,1.,1.,1.,1.
,YESA,1.0
,.5,.5
CBEAM,4,4,2,6,1
PBARL,5,1,,BOX
,1.,2.,.1,.1
CBAR,5,5,3,7,5
CROD,6,6,4,8
PROD,6,1,1.,1.
CONROD,7,4,7,1,1.
PSOLID,8,9,6
CHEXA,8,8,1,2,3,4,5,6
,7,8
CTETRA,9,8,1,2,3,5
CELAS1,10,10,2,1,20
PELAS,10,5.,,,11,3.
CELAS2,11,5.,2,2,3,2
CDAMP2,12,5.,2,2
CMASS2,13,5.,2,2
CBUSH,14,14,1,2,0.,1.,0.
PBUSH,14,K,1.,2.,3.,4.,5.,6.
,B,1.
CONM2,15,2,6,1.,.1,.2,.3
,1.,.1,1.,.1,.1,1.
CONM1,16,3,6,1.,2.
RBE2,1,1,123,2,3
RBE3,2,,4,123456,1.,123,5,6
,7,1.,456,8
,UM,4,123456
RBAR,3,5,6
RROD,5,7,8
RBE1,4,1,123456
,UM,8,12
MPC,1,7,1,1.,20,,1.
,,3,2,.5
SPC1,1,12,1,THRU,3
SPC,1,5,3,.1,6,4
SPCADD,2,1
TIC,3,2,2,,1.
SET1,4,1,2,THRU,5
SET3,5,ELEM,1,THRU,5,BY,2
ASET1,123,1,2
SUPORT,1,123
PARAM,WTMASS,.5
PARAM,COUPMASS,1
PARAM,G,.02
PARAM,W3,500.
EIGRL,1,,,10
ENDDATA
"""

FIXED_FIELD = """\
$ A strip in small and large fixed fields
GRID           1              0.      0.      0.
GRID           2             10.      0.      0.
GRID           3             20.      0.      0.
GRID*                  4                              0.             10.+a
*a                    0.
GRID           5             10.     10.      0.
GRID           6             20.     10.      0.
CQUAD4         1       7       1       2       5       4
CQUAD4         2       7       2       3       6       5
$ Femap Property 7 : Skin
PSHELL         7       1      1.       1               1
MAT1           1 210000.              .3 7.85-9
CONM2         30       6          1.-5
SPC1           1  123456       1       4
"""

REDUCED = """title = "Reduced"

[model]
deck = "strips.inp"

[contact.tip]
secondary = "UNDER"
main = "OVER"
method = "node-to-surface"
stiffness = 100.0
friction = { static = 0.3, kinetic = 0.2 }
clearance = 0.1

[[connector]]
type = "play"
nodes = ["TIP_UPPER", "TIP_LOWER"]
dof = "z"
lower = -0.2
upper = 0.3
stiffness = 50.0
damping = 0.01

[excitation.root]
node_set = "ROOT_UPPER"
dof = "z"
kind = "acceleration"
signal = { type = "table", values = [[0.0, 0.0], [0.1, 1.0], [0.3, -1.0]], rounding = 0.2 }

[excitation.push]
node_set = "TIP_UPPER"
dof = "y"
kind = "force"
signal = { type = "periodic", frequency = 5.0, cosine = [1.0, 0.5], mean = 0.1 }

[reduction]
method = "craig-bampton"
f_max = 4000
keep_out = 20.0
interface = { type = "spacing", n = 2 }
substructures = ["UPPER"]
retain = "TIP_UPPER"

[time]
step = 5e-4
end = 0.2
integrator = "generalised-alpha"
rho_inf = 0.8
substeps = 2

[reference]
run = false

[output]
nodes = "TIP_UPPER"
interval = 1e-3
field_interval = 0.01

[precheck]
enabled = false

[damping]
modal = 0.01
"""

ABAQUS = [INSTANCES, SOLIDS, abaqus_deck(mesh()), STRIPS, stop_deck(), LAYERS, FASTENED]
NASTRAN = [CARDS, CARDS, FIXED_FIELD, nastran_deck(mesh()), STARTED, OPTISTRUCT]
STUDIES = [STUDY, REDUCED]
SWEEPS = [SWEEP]
