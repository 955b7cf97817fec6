"""Read damaged decks and studies by the thousand: python -m benchmarks.fuzz --count 10000."""

from __future__ import annotations

import argparse
import resource
import sys
import time
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "tests"))

from fuzz_decks import Tally, fuzz
from fuzz_files import fuzz_files

KINDS = ("abaqus", "nastran", "lsdyna", "study", "sweep", "files")


def main() -> None:
    """Damage `count` files: 3 in 10 Abaqus and Nastran each, 2 stored ones, 1 LS-DYNA, the rest studies, sweeps.

    Exit 1 on a fault.
    """
    parser = argparse.ArgumentParser(prog="python -m benchmarks.fuzz")
    parser.add_argument("--count", type=int, default=10000, help="files in all")
    parser.add_argument("--first", type=int, default=0, help="first seed")
    parser.add_argument("--kind", choices=KINDS, help="only this kind")
    given = parser.parse_args()
    shares = {given.kind: given.count} if given.kind else _shares(given.count)
    faults = 0
    for kind, count in shares.items():
        start = time.perf_counter()
        tally = fuzz_files(given.first, count) if kind == "files" else fuzz(kind, given.first, count)
        _show(kind, count, tally, time.perf_counter() - start)
        faults += len(tally.faults)
    sys.exit(1 if faults else 0)


def _shares(count: int) -> dict[str, int]:
    tenth = count // 10
    sweep = (count - 9 * tenth) // 2
    decks = {"abaqus": 3 * tenth, "nastran": 3 * tenth, "lsdyna": tenth}
    return {**decks, "files": 2 * tenth, "sweep": sweep, "study": count - 9 * tenth - sweep}


def _show(kind: str, count: int, tally: Tally, seconds: float) -> None:
    ended = ", ".join(f"{end} {n}" for end, n in sorted(tally.ended.items()))
    took = f"{count} files in {seconds:.1f} s, the longest {tally.longest:.2f} s"
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1e6
    print(f"{kind}: {took}: {ended}; {len(tally.faults)} faults; peak memory {peak:.2f} GB", flush=True)
    for fault in tally.faults[:40]:
        print(f"  {fault}")


if __name__ == "__main__":
    main()
