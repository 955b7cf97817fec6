"""The layering of ARCHITECTURE.md, read from the syntax trees: imports point down, numerics do not draw or print."""

from __future__ import annotations

import ast
import importlib
from dataclasses import dataclass
from functools import cache
from pathlib import Path

import pytest

import creak
import creak_thesis
from helpers_source import nodes_of

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
EVERYWHERE = {"errors", "arrays", "digest", "given", "jit", "later", "progress", "version", "words", ""}
"""The ground (`creak.errors` and its like) and the bare package may be imported by anyone."""
BESIDE = {"linalg": set(), "signals": set(), "sound": set(), "formats": {"model"}}
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


@cache
def folder_of(path: Path) -> str:
    relative = path.relative_to(ROOT)
    return relative.parts[0] if len(relative.parts) > 1 else relative.stem


@cache
def files() -> list[Path]:
    return sorted(ROOT.rglob("*.py"))


def imports_of(path: Path) -> list[Import]:
    """All imports of a file, also those inside functions; `from a import b` counts as a.b where that is a module."""
    found = []
    for node in nodes_of(path):
        if isinstance(node, ast.Import):
            found += [Import(path, node.lineno, alias.name) for alias in node.names]
        elif isinstance(node, ast.ImportFrom):
            assert node.level == 0, f"{path}:{node.lineno}: relative import; write creak.… in full"
            assert node.module
            for alias in node.names:
                full = f"{node.module}.{alias.name}"
                found.append(Import(path, node.lineno, full if module_file(full) else node.module))
    return found


@cache
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


@cache
def imports() -> tuple[Import, ...]:
    return tuple(i for path in files() for i in imports_of(path))


def told(problems: list[Import], rule: str) -> str:
    return "\n".join([rule, *map(str, problems)])


def test_every_folder_has_a_place_in_the_tower():
    known = {*LAYERS, *BESIDE}
    folders = {p.name for p in ROOT.iterdir() if p.is_dir() and any(p.glob("**/*.py"))}
    assert folders <= known, f"no layer is given for {sorted(folders - known)}"


def test_imports_point_down():
    """cli > api > report > studies > verify > dynamics > contact > reduction > assembly > elements > model."""
    height = {name: len(LAYERS) - i for i, name in enumerate(LAYERS)}
    upward = [i for i in imports() if i.owner in height and i.target in height and height[i.target] > height[i.owner]]
    assert not upward, told(upward, "imports must point down: " + " > ".join(LAYERS))


@pytest.mark.parametrize("folder", sorted(BESIDE))
def test_folders_beside_the_tower_keep_to_themselves(folder):
    allowed = {folder, *BESIDE[folder]} | EVERYWHERE
    bad = [i for i in imports() if i.owner == folder and i.target is not None and i.target not in allowed]
    assert not bad, told(bad, f"{folder} may import only {sorted(allowed - {''})}")


def test_the_ground_imports_nothing_of_creak():
    ground = ("errors", "arrays", "digest", "given", "jit", "later", "progress", "version")
    bad = [i for i in imports() if i.owner in ground and i.target not in (None, "errors")]
    assert not bad, told(bad, f"{', '.join(ground)} are the ground: they import no other module of creak but errors")


def test_only_the_command_line_knows_the_command_line():
    """Nothing but cli (and python -m creak) imports cli; only the bare package and cli import api; only cli, api and
    report import report."""
    bad = [i for i in imports() if i.target == "cli" and i.owner not in ("cli", "__main__")]
    bad += [i for i in imports() if i.target == "api" and i.owner not in ("cli", "api", "__init__")]
    bad += [i for i in imports() if i.target == "report" and i.owner not in ("cli", "api", "report", "report_tools")]
    assert not bad, told(bad, "numerics and studies must not know report, api or cli")


def test_no_import_cycles_between_modules():
    graph: dict[Path, set[Path]] = {path: set() for path in files()}
    for i in imports():
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
    bad = [i for i in imports() if i.owner in NUMERICS and i.module.split(".")[0] in DRAWING]
    assert not bad, told(bad, "only report and cli draw; progress goes through a callback")


def test_numerics_do_not_print():
    bad = []
    for path in files():
        if folder_of(path) not in NUMERICS:
            continue
        for node in nodes_of(path):
            if isinstance(node, ast.Call) and isinstance(node.func, ast.Name) and node.func.id in ("print", "input"):
                bad.append(f"{path.relative_to(ROOT.parent)}:{node.lineno}: {node.func.id}()")
    assert not bad, "\n".join(["numerics never print", *bad])


def test_numerics_do_not_open_files():
    bad = []
    for path in files():
        if folder_of(path) not in NUMERICS:
            continue
        for node in nodes_of(path):
            if isinstance(node, ast.Call) and isinstance(node.func, ast.Name) and node.func.id == "open":
                bad.append(f"{path.relative_to(ROOT.parent)}:{node.lineno}: open()")
    assert not bad, "\n".join(["numerics never call open: linalg/memory has temporary files", *bad])


def test_no_star_imports():
    bad = [
        f"{path.relative_to(ROOT.parent)}:{node.lineno}: from {node.module} import *"
        for path in files()
        for node in nodes_of(path)
        if isinstance(node, ast.ImportFrom) and any(a.name == "*" for a in node.names)
    ]
    assert not bad, "\n".join(bad)


def test_no_deck_format_imports_another():
    """What formats share stands in formats/deck, which knows none of them."""
    rooms = {p.parent.name for p in (ROOT / "formats").glob("*/reader.py")}
    assert rooms == {"abaqus", "lsdyna", "nastran"}, f"formats of decks: {sorted(rooms)}"
    bad = []
    for i in imports():
        names = i.module.split(".")
        if i.owner == "formats" and names[:2] == ["creak", "formats"] and len(names) > 2:
            room = i.path.relative_to(ROOT / "formats").parts[0]
            if (room in rooms and names[2] in rooms - {room}) or (room == "deck" and names[2] != "deck"):
                bad.append(i)
    assert not bad, told(bad, "a format of decks imports no other; what they share stands in formats/deck")


ROOMS = (
    "sweep",
    "robust",
    "propose",
    "advise",
    "evaluate",
    "cause",
    "spots",
    "findings",
    "sound",
    "converge",
    "run",
    "models",
    "prepare",
    "design",
    "file",
    "tasks",
)
"""Rooms of studies/, the highest first; `evaluate` is one file."""


def test_rooms_of_studies_import_those_below_them():
    studies = ROOT / "studies"
    rooms = {p.name for p in studies.iterdir() if p.is_dir() and any(p.glob("*.py"))}
    assert {*rooms, "evaluate"} == set(ROOMS), f"rooms without a place in the order: {sorted(rooms ^ set(ROOMS))}"
    height = {name: len(ROOMS) - i for i, name in enumerate(ROOMS)}
    upward = []
    for i in imports():
        names = i.module.split(".")
        if i.owner == "studies" and names[:2] == ["creak", "studies"] and len(names) > 2 and names[2] in height:
            room = i.path.relative_to(studies).parts[0].removesuffix(".py")
            if room not in height or height[names[2]] > height[room]:
                upward.append(i)
    assert not upward, told(upward, "rooms of studies import those below them: " + " > ".join(ROOMS))


def test_no_name_repeats_its_folder():
    """shells/quad4, not shells/shell_quad4."""
    bad = [
        p.relative_to(ROOT).as_posix()
        for p in files()
        if p.parent != ROOT and p.stem.startswith((f"{p.parent.name}_", f"{p.parent.name.rstrip('s')}_"))
    ]
    assert not bad, bad


# --- the companion --------------------------------------------------------------------------------------------------

COMPANION = Path(creak_thesis.__file__).parent
KNOWS_IT = {"cli/example.py", "cli/thesis.py", "api/decks.py"}
"""Files of creak that may import creak_thesis, where they are called."""


def module_level(path: Path) -> set[int]:
    """Lines of the imports that run when a file is imported."""
    tree = ast.parse(path.read_text(encoding="utf-8"))
    inside = {n for f in ast.walk(tree) if isinstance(f, ast.FunctionDef) for n in ast.walk(f)}
    types = {n for b in tree.body if isinstance(b, ast.If) and "TYPE_CHECKING" in ast.dump(b.test) for n in ast.walk(b)}
    return {
        n.lineno
        for n in ast.walk(tree)
        if isinstance(n, ast.Import | ast.ImportFrom) and n not in inside and n not in types
    }


def test_creak_knows_its_companion_only_where_it_is_called():
    found = [i for i in imports() if i.module.split(".")[0] == "creak_thesis"]
    assert {i.path.relative_to(ROOT).as_posix() for i in found} == KNOWS_IT
    early = [i for i in found if i.line in module_level(i.path)]
    assert not early, told(early, "creak works without creak_thesis until its door or page is asked for")


PUBLIC = {"creak.report_tools", "creak.stepping"}
"""Public modules besides `creak`: each lists its names."""


def private_names(path: Path) -> set[str]:
    """What a file takes of creak that is neither a name of `import creak` nor one of its public modules."""
    found: set[str] = set()
    for node in nodes_of(path):
        if isinstance(node, ast.Import):
            found |= {a.name for a in node.names if a.name.startswith("creak.")}
        elif isinstance(node, ast.ImportFrom) and node.module == "creak":
            found |= {a.name for a in node.names if a.name not in creak.__all__}
        elif isinstance(node, ast.ImportFrom) and (node.module or "").startswith("creak."):
            offered = getattr(importlib.import_module(str(node.module)), "__all__", ()) if node.module in PUBLIC else ()
            found |= {f"{node.module}.{a.name}" for a in node.names if a.name not in offered}
        elif isinstance(node, ast.Attribute) and isinstance(node.value, ast.Name) and node.value.id == "creak":
            found |= {node.attr} - {*creak.__all__, "__version__"}
    return found


def test_the_companion_lives_on_the_public_names():
    assert {name for path in COMPANION.rglob("*.py") for name in private_names(path)} == set()


def test_a_private_name_is_found_wherever_it_is_taken(tmp_path):
    path = tmp_path / "page.py"
    path.write_text(
        "import creak\nimport creak.api.study\nfrom creak import run, formats\nfrom creak.report_tools import Table, cut_up\n"
        "def late():\n    from creak.linalg.factor import factor\n    return creak.verify, creak.run, creak.__version__\n",
        encoding="utf-8",
    )
    found = {"creak.api.study", "formats", "creak.report_tools.cut_up", "creak.linalg.factor.factor", "verify"}
    assert private_names(path) == found


# --- labels of degrees of freedom -----------------------------------------------------------------------------------


def made_of_six(path: Path) -> set[str]:
    """Expressions of a file that make or read 6 node + dof - 1: 6 * x + y, x // 6, x % 6, divmod(x, 6)."""

    def six(node: ast.expr) -> bool:
        return isinstance(node, ast.Constant) and node.value == 6 and isinstance(node.value, int)

    found: set[str] = set()
    for node in nodes_of(path):
        match node:
            case ast.BinOp(left=left, op=ast.FloorDiv() | ast.Mod(), right=right) if six(right):
                read = not isinstance(left, ast.Constant)
            case ast.BinOp(left=ast.BinOp(left=a, op=ast.Mult(), right=b), op=ast.Add()):
                read = (six(a) or six(b)) and not isinstance(a, ast.List)
            case ast.Call(func=ast.Attribute(attr="divmod") | ast.Name(id="divmod"), args=[*_, last]):
                read = six(last)
            case _:
                read = False
        found |= {ast.unparse(node)} if read else set()
    return found


SIXES = {"formats/matrices/op4_file.py": {"len(record) // 6"}}
"""What is no degree of freedom."""


def test_labels_of_dofs_are_made_in_one_place():
    found = {p.relative_to(ROOT).as_posix(): made_of_six(p) for p in files()}
    assert {name: made for name, made in found.items() if made} == SIXES


def test_a_label_is_found_however_it_is_made(tmp_path):
    made = {"6 * node + dof - 1", "labels // 6", "labels % 6", "divmod(x, 6)", "nodes[:, None] * 6 + np.arange(3)"}
    path = tmp_path / "made.py"
    path.write_text("\n".join([*made, "6 * n", "6.0 * x + 1", "[i] * 6 + [d]"]), encoding="utf-8")
    assert made_of_six(path) == made - {"6 * node + dof - 1"} | {"6 * node + dof"}


def test_the_balance_of_energies_is_closed_in_one_place():
    """Compiled marches and general ones keep the same book."""

    def holding(text: str) -> set[str]:
        folder = ROOT / "dynamics"
        return {p.relative_to(folder).as_posix() for p in folder.rglob("*.py") if text in p.read_text(encoding="utf-8")}

    assert holding("[SCHEME] = ") == {"books.py"}
    assert holding("balance(e)") == {"books.py", "energy.py", "flow/books.py"}
