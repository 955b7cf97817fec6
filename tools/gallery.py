"""The gallery of the site: each example with its text, figure and code.

`python -m tools.gallery` draws the figures into examples/figures, where the site finds them.
"""

from __future__ import annotations

import ast
import hashlib
import os
import runpy
import sys
from pathlib import Path

ROOT = Path(__file__).parents[1]
EXAMPLES = ROOT / "examples"
FOLDER = "gallery"
DRAWN = EXAMPLES / "figures"
QUICK = ("bar_on_wall", "craig_bampton_beam", "plate_modes", "stick_slip_belt", "two_strips")
"""Examples that take seconds; the others have no figure on the site."""


def header(name: str) -> str:
    """The docstring of an example: a page in Markdown that starts with a heading."""
    return ast.get_docstring(ast.parse(source(name))) or f"# {name}"


def source(name: str) -> str:
    """The example's code."""
    return (EXAMPLES / f"{name}.py").read_text(encoding="utf-8")


def titles() -> dict[str, str]:
    """Example -> its heading, in the order of names."""
    names = sorted(p.stem for p in EXAMPLES.glob("*.py"))
    return {name: header(name).splitlines()[0].removeprefix("# ") for name in names}


def pages() -> dict[str, str]:
    """Page -> Markdown: an overview, and a page for each example."""
    found = {f"{FOLDER}/{name}.md": _page(name) for name in titles()}
    return {f"{FOLDER}/index.md": _overview(), **found}


def pictures() -> dict[str, Path]:
    """Example -> figure, of those that were drawn from the example as it stands."""
    paths = {name: DRAWN / f"{name}-{_digest(name)}.png" for name in titles()}
    return {name: path for name, path in paths.items() if path.exists()}


def draw(name: str) -> Path:
    """Draw the figure of an example, unless the one that is there is of the same code."""
    path = DRAWN / f"{name}-{_digest(name)}.png"
    if not path.exists():
        DRAWN.mkdir(parents=True, exist_ok=True)
        for old in DRAWN.glob(f"{name}-*.png"):
            old.unlink()
        partial = path.with_suffix(".part.png")
        runpy.run_path(str(EXAMPLES / f"{name}.py"))["main"](str(partial))
        partial.rename(path)
    return path


def _digest(name: str) -> str:
    return hashlib.sha256(source(name).encode()).hexdigest()[:12]


def _overview() -> str:
    lines = [
        "# Examples",
        "",
        "Scripts that need nothing but creak with its extra `report`. Each draws a figure; the tests hold what it "
        "finds against closed forms or the unreduced model.",
        "",
    ]
    drawn = pictures()
    for name, title in titles().items():
        lines += [f"## [{title}]({name}.md)", "", f"`python examples/{name}.py`", ""]
        lines += [f"[![{title}]({name}.png)]({name}.md)", ""] if name in drawn else []
    return "\n".join([*lines, "`examples/door_sweep.toml` is a [sweep](../sweeps.md) of the door.", ""])


def _page(name: str) -> str:
    figure = f"![Figure of the example]({name}.png)" if name in pictures() else "The command below draws its figure."
    return "\n".join(
        [
            header(name),
            "",
            figure,
            "",
            "```text",
            f"python examples/{name}.py",
            "```",
            "",
            "```python",
            source(name).split('"""', 2)[2].strip(),
            "```",
            "",
        ]
    )


if __name__ == "__main__":
    os.environ.setdefault("MPLBACKEND", "Agg")
    for example in sys.argv[1:] or QUICK:
        sys.stdout.write(f"{draw(example)}\n")
