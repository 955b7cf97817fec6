"""Pages made of the record of `benchmarks.evidence`: guidelines, accuracy of reductions, convergence of contact.

`python -m tools.evidence_pages` (`make evidence` measures first). The texts are in tools/pages; every figure in them is
one of the record, and a sentence that the figures do not bear out any more is an error.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import jinja2
from tools.accuracy_picture import draw

from creak.studies.advise.evidence import ROUND_OFF, case, doors, record

DOCS, TEXTS = Path(__file__).parents[1] / "docs", Path(__file__).parent / "pages"
PAGES = ("guidelines.md", "reduction.md", "contact_convergence.md")


def page(name: str, found: Mapping[str, Any]) -> str:
    """A page from a record.

    Raises
    ------
    ValueError : a sentence says what the figures do not.
    """
    texts = jinja2.Environment(
        loader=jinja2.FileSystemLoader(TEXTS),
        undefined=jinja2.StrictUndefined,
        keep_trailing_newline=True,
        trim_blocks=True,
        lstrip_blocks=True,
        autoescape=False,
    )
    texts.globals |= {
        "r": found,
        "case": lambda name, fine=False: case(found, name, fine),
        "two": lambda name, key, style="pc": two(found, name, key, style),
        "holds": holds,
    }
    texts.filters |= STYLES
    lines = texts.get_template(f"{name}.j2").render().splitlines()
    return "\n".join(line.rstrip() for line in lines) + "\n"


def holds(condition: object, sentence: str) -> str:
    """The sentence, as long as it is true."""
    if not condition:
        raise ValueError(f"the record does not bear out: {sentence}")
    return sentence


def per_cent(x: float | None, digits: int = 2) -> str:
    """A share in per cent, `.14`, `2.6`, `18`."""
    return "-" if x is None else short(100.0 * x if abs(x) > ROUND_OFF else 0.0, digits)


def signed(x: float | None, digits: int = 2) -> str:
    """The same with its sign."""
    return "-" if x is None else f"{'-' if x < 0.0 else '+'}{short(abs(100.0 * x), digits)}"


def short(x: float | None, digits: int = 3) -> str:
    """So many digits, no zero before the point."""
    if x is None:
        return "-"
    if x == 0.0 or not math.isfinite(x):
        return f"{x:g}"
    rounded = float(f"{x:.{digits - 1}e}")
    text = f"{rounded:,.{max(0, digits - 1 - math.floor(math.log10(abs(rounded))))}f}"
    return text.replace("0.", ".", 1) if text.lstrip("-").startswith("0.") else text


def count(x: float) -> str:
    return f"{x:,.0f}"


def milliseconds(x: float | None) -> str:
    return "-" if x is None else short(1e3 * x, 2)


def microseconds(x: float | None) -> str:
    return "-" if x is None else short(1e6 * x, 2)


STYLES: dict[str, Callable[..., str]] = {
    "pc": per_cent,
    "signed": signed,
    "n": count,
    "g": short,
    "s": lambda x: short(x, 2),
    "plain": lambda x: f"{x:g}",
    "ms": milliseconds,
    "us": microseconds,
}
"""Of numbers, by the names that the texts use."""


def two(found: Mapping[str, Any], name: str, key: str, style: str) -> str:
    """A figure of a reduction on all doors, `1.8 / 1.4`; `-` where it was not measured on the finer one."""
    rows = [next((row for row in door["reductions"] if row["name"] == name), None) for door in doors(found)]
    return " / ".join("-" if row is None else STYLES[style](row[key]) for row in rows)


def main() -> None:
    """Write the pages, then the picture; none where a sentence is not true."""
    made = {name: page(name, record()) for name in PAGES}
    for name, text in made.items():
        (DOCS / name).write_text(text, encoding="utf-8")
    draw([row for row in record()["door"]["reductions"] if "failed" not in row], DOCS / "accuracy.png")


if __name__ == "__main__":
    main()
