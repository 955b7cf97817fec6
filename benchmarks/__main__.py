"""Run the benchmarks and print one table."""

from __future__ import annotations

import argparse

from rich.console import Console
from rich.table import Table

from benchmarks.door import door
from benchmarks.reduction import craig_bampton_cost
from benchmarks.stepping import against_plain_newton, full_order, reduced_order


def main() -> None:
    """Measure on the door of a given mesh size."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks")
    parser.add_argument("--mesh-size", type=float, default=20.0, help="mm")
    model = door(parser.parse_args().mesh_size)
    table = Table("what", "measured", "against", title=f"Door, {model.reference.system.n:,} free dofs")
    for rows in (full_order, against_plain_newton, reduced_order, craig_bampton_cost):
        for row in rows(model):
            table.add_row(*row)
        table.add_section()
    Console(width=130).print(table)


if __name__ == "__main__":
    main()
