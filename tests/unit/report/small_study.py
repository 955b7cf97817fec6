"""Small studies for the report: two plates above each other, and a mass on a spring."""

from pathlib import Path

from creak.studies.file.reader import read_study
from creak.studies.prepare.setup import set_up
from creak.studies.run.job import StudyResult, run_study
from helpers_decks import write_study

NX, NY = 4, 2


def plates() -> str:
    """Deck of two clamped strips, 80 x 20 mm, 0.5 mm apart between their faces."""
    lines = ["*HEADING", "two plates"]
    for part, (z, first) in {"LOWER": (0.0, 0), "UPPER": (1.5, 100)}.items():
        lines += [f"*NODE, NSET=ALL_{part}"]
        nodes = [(i, j) for j in range(NY + 1) for i in range(NX + 1)]
        lines += [f"{first + 1 + i + (NX + 1) * j}, {20.0 * i}, {10.0 * j}, {z}" for i, j in nodes]
        lines += [f"*ELEMENT, TYPE=S4, ELSET={part}"]
        for j in range(NY):
            for i in range(NX):
                a = first + 1 + i + (NX + 1) * j
                lines.append(f"{first + 1 + i + NX * j}, {a}, {a + 1}, {a + NX + 2}, {a + NX + 1}")
        lines += [f"*SHELL SECTION, ELSET={part}, MATERIAL=STEEL", "1.0"]
        lines += [f"*NSET, NSET=ROOT_{part}"]
        lines += [", ".join(str(first + 1 + (NX + 1) * j) for j in range(NY + 1))]
        lines += [f"*SURFACE, NAME=FACE_{part}", f"{part}, SPOS" if part == "LOWER" else f"{part}, SNEG"]
    lines += ["*NSET, NSET=PAIRS_MAIN", "5, 10, 15", "*NSET, NSET=PAIRS_SECONDARY", "105, 110, 115"]
    lines += ["*NSET, NSET=TIP", "110", "*NSET, NSET=TIP_LOWER", "10"]
    lines += ["*MATERIAL, NAME=STEEL", "*ELASTIC", "210000., 0.3", "*DENSITY", "7.85e-9"]
    lines += ["*DAMPING, ALPHA=20., BETA=1e-6"]
    lines += ["*BOUNDARY", "ROOT_LOWER, 1, 6", "ROOT_UPPER, 1, 2", "ROOT_UPPER, 4, 6"]
    return "\n".join(lines) + "\n"


def mass_on_spring() -> str:
    """Deck of one mass on a spring along x, without any shell."""
    return """*HEADING
one mass
*NODE
1, 0., 0., 0.
*NSET, NSET=MASS
1
*ELEMENT, TYPE=MASS, ELSET=M
1, 1
*MASS, ELSET=M
1e-3
*ELEMENT, TYPE=SPRING1, ELSET=K
2, 1
*SPRING, ELSET=K
1
40.
*BOUNDARY
1, 2, 6
"""


CONTACT = '[contact.tip]\nsecondary = "FACE_UPPER"\nmain = "FACE_LOWER"\n'
PLAY = """[[connector]]
type = "play"
nodes = ["TIP_LOWER", "TIP"]
dof = "z"
lower = -0.2
upper = 0.2
stiffness = 100.0
"""
PAIRS = 'pairs = "PAIRS"\n'


def study_text(
    *,
    contact: str = CONTACT,
    amplitude: float = 0.8,
    reference: bool = True,
    method: str = "craig-bampton",
    pairs: str = PAIRS,
    mac_f_max: float = 500.0,
) -> str:
    """A shaken upper strip: 80 steps of 0.5 ms of a sine at 50 Hz."""
    return f"""title = "Two plates <test>"
[model]
deck = "plates.inp"
{contact}
[excitation.base]
node_set = "ROOT_UPPER"
dof = "z"
kind = "displacement"
signal = {{ type = "sine", frequency = 50, amplitude = {amplitude} }}
[reduction]
method = "{method}"
f_max = 20000
[precheck]
margin = 5.0
[time]
step = 5e-4
end = 0.04
[reference]
run = {str(reference).lower()}
[verification]
{pairs}
f_max = 400
mac_f_max = {mac_f_max}
merge = 0.001
"""


SINGLE_MASS = """[model]
deck = "plates.inp"
[[connector]]
type = "play"
nodes = "MASS"
dof = "x"
upper = 0.5
stiffness = 1e3
[excitation.push]
node_set = "MASS"
dof = "x"
kind = "force"
signal = { type = "sine", frequency = 20, amplitude = 10 }
[reduction]
method = "none"
[time]
step = 1e-3
end = 0.1
[verification]
mac_f_max = 1.0
"""


def run_small(folder: Path, study: str, deck: str | None = None) -> StudyResult:
    """Run a study written into a folder."""
    study_path = write_study(folder, study, {"plates.inp": plates() if deck is None else deck})
    return run_study(set_up(read_study(study_path)), lambda stage, done, total: None)
