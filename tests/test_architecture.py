"""The layering of ARCHITECTURE.md, read from the syntax trees: imports point down, numerics do not draw or print."""

from __future__ import annotations

import ast
from dataclasses import dataclass
from pathlib import Path

import pytest

import creak

ROOT = Path(creak.__file__).parent
LAYERS = (
    "cli",
    "api",
    "report",
    "studies",
    "verify",
    "dynamics",
    "contact",
    "reduction",
    "assembly",
    "elements",
    "model",
)
EVERYWHERE = {"errors", "arrays", ""}
"""`creak.errors`, `creak.arrays` and the bare package (its version) may be imported by anyone."""
BESIDE = {"linalg": set(), "signals": set(), "sound": set(), "formats": {"model"}, "door": {"formats"}}
"""What the folders beside the tower may import."""
NUMERICS = ("model", "elements", "assembly", "linalg", "reduction", "contact", "dynamics", "signals", "sound", "verify")
DRAWING = {"matplotlib", "plotly", "rich", "typer", "pyvista", "jinja2", "logging"}


@dataclass(frozen=True)
class Import:
    path: Path
    line: int
    module: str
    """Dotted name of what is imported."""

    def __str__(self) -> str:
        return f"{self.path.relative_to(ROOT.parent)}:{self.line}: import of {self.module}"

    @property
    def owner(self) -> str:
        return folder_of(self.path)

    @property
    def target(self) -> str | None:
        """Folder (or top-level module) of creak that is imported; None for other packages."""
        names = self.module.split(".")
        if names[0] != "creak":
            return None
        return names[1] if len(names) > 1 else ""


def folder_of(path: Path) -> str:
    relative = path.relative_to(ROOT)
    return relative.parts[0] if len(relative.parts) > 1 else relative.stem


def files() -> list[Path]:
    return sorted(ROOT.rglob("*.py"))


def imports_of(path: Path) -> list[Import]:
    """All imports of a file, also those inside functions; `from a import b` counts as a.b where that is a module."""
    found = []
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"), filename=str(path))):
        if isinstance(node, ast.Import):
            found += [Import(path, node.lineno, alias.name) for alias in node.names]
        elif isinstance(node, ast.ImportFrom):
            assert node.level == 0, f"{path}:{node.lineno}: relative import; write creak.… in full"
            assert node.module
            for alias in node.names:
                full = f"{node.module}.{alias.name}"
                found.append(Import(path, node.lineno, full if module_file(full) else node.module))
    return found


def module_file(module: str) -> Path | None:
    """File of a creak module, None for anything else."""
    names = module.split(".")
    if names[0] != "creak":
        return None
    base = ROOT.joinpath(*names[1:])
    for candidate in (base.with_suffix(".py"), base / "__init__.py"):
        if len(names) > 1 and candidate.exists():
            return candidate
    return None


IMPORTS = [i for path in files() for i in imports_of(path)]


def told(problems: list[Import], rule: str) -> str:
    return "\n".join([rule, *map(str, problems)])


def test_every_folder_has_a_place_in_the_tower():
    known = {*LAYERS, *BESIDE}
    folders = {p.name for p in ROOT.iterdir() if p.is_dir() and any(p.glob("**/*.py"))}
    assert folders <= known, f"no layer is given for {sorted(folders - known)}"


def test_imports_point_down():
    """cli > api > report > studies > verify > dynamics > contact > reduction > assembly > elements > model."""
    height = {name: len(LAYERS) - i for i, name in enumerate(LAYERS)}
    upward = [i for i in IMPORTS if i.owner in height and i.target in height and height[i.target] > height[i.owner]]
    assert not upward, told(upward, "imports must point down: " + " > ".join(LAYERS))


@pytest.mark.parametrize("folder", sorted(BESIDE))
def test_folders_beside_the_tower_keep_to_themselves(folder):
    allowed = {folder, *BESIDE[folder]} | EVERYWHERE
    bad = [i for i in IMPORTS if i.owner == folder and i.target is not None and i.target not in allowed]
    assert not bad, told(bad, f"{folder} may import only {sorted(allowed - {''})}")


def test_errors_and_arrays_import_nothing_of_creak():
    bad = [i for i in IMPORTS if i.owner in ("errors", "arrays") and i.target is not None]
    assert not bad, told(bad, "errors and arrays are the ground: they import no other module of creak")


def test_only_the_command_line_knows_the_command_line():
    """Nothing but cli (and python -m creak) imports cli; only the bare package and cli import api; only cli, api and
    report import report."""
    bad = [i for i in IMPORTS if i.target == "cli" and i.owner not in ("cli", "__main__")]
    bad += [i for i in IMPORTS if i.target == "api" and i.owner not in ("cli", "api", "__init__")]
    bad += [i for i in IMPORTS if i.target == "report" and i.owner not in ("cli", "api", "report")]
    assert not bad, told(bad, "numerics and studies must not know report, api or cli")


def test_no_import_cycles_between_modules():
    graph: dict[Path, set[Path]] = {path: set() for path in files()}
    for i in IMPORTS:
        target = module_file(i.module)
        if target is not None and target != i.path:
            graph[i.path].add(target)
    done: set[Path] = set()
    trail: list[Path] = []

    def visit(path: Path) -> None:
        if path in trail:
            cycle = [*trail[trail.index(path) :], path]
            raise AssertionError("import cycle: " + " -> ".join(str(p.relative_to(ROOT)) for p in cycle))
        if path in done:
            return
        trail.append(path)
        for other in sorted(graph[path]):
            visit(other)
        done.add(trail.pop())

    for path in graph:
        visit(path)


def test_numerics_do_not_draw_log_or_show_progress():
    bad = [i for i in IMPORTS if i.owner in NUMERICS and i.module.split(".")[0] in DRAWING]
    assert not bad, told(bad, "only report and cli draw; progress goes through a callback")


def test_numerics_do_not_print():
    bad = []
    for path in files():
        if folder_of(path) not in NUMERICS:
            continue
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            if isinstance(node, ast.Call) and isinstance(node.func, ast.Name) and node.func.id in ("print", "input"):
                bad.append(f"{path.relative_to(ROOT.parent)}:{node.lineno}: {node.func.id}()")
    assert not bad, "\n".join(["numerics never print", *bad])


def test_numerics_do_not_open_files():
    bad = []
    for path in files():
        if folder_of(path) not in NUMERICS:
            continue
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            if isinstance(node, ast.Call) and isinstance(node.func, ast.Name) and node.func.id == "open":
                bad.append(f"{path.relative_to(ROOT.parent)}:{node.lineno}: open()")
    assert not bad, "\n".join(["numerics never open files", *bad])


def test_no_star_imports():
    bad = [
        f"{path.relative_to(ROOT.parent)}:{node.lineno}: from {node.module} import *"
        for path in files()
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8")))
        if isinstance(node, ast.ImportFrom) and any(a.name == "*" for a in node.names)
    ]
    assert not bad, "\n".join(bad)


ROOMS = ("thesis", "sweep", "propose", "advise", "results", "sound", "converge", "run", "models", "prepare", "file")
"""Rooms of studies/, the highest first."""


def test_rooms_of_studies_import_those_below_them():
    studies = ROOT / "studies"
    rooms = {p.name for p in studies.iterdir() if p.is_dir() and any(p.glob("*.py"))}
    assert rooms == set(ROOMS), f"rooms without a place in the order: {sorted(rooms ^ set(ROOMS))}"
    height = {name: len(ROOMS) - i for i, name in enumerate(ROOMS)}
    upward = []
    for i in IMPORTS:
        names = i.module.split(".")
        if i.owner == "studies" and names[:2] == ["creak", "studies"] and len(names) > 2 and names[2] in height:
            room = i.path.relative_to(studies).parts[0]
            if room not in height or height[names[2]] > height[room]:
                upward.append(i)
    assert not upward, told(upward, "rooms of studies import those below them: " + " > ".join(ROOMS))


def test_no_room_is_a_drawer():
    """About a dozen files to a folder under studies/."""
    full = {str(d): n for d in (ROOT / "studies").iterdir() if d.is_dir() and (n := len(list(d.glob("*.py")))) > 14}
    assert not full, f"folders with too many files: {full}"
