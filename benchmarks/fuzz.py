"""Read damaged decks and studies by the thousand: python -m benchmarks.fuzz --count 10000."""

from __future__ import annotations

import argparse
import sys
import time
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "tests"))

from fuzz_decks import Tally, fuzz

KINDS = ("abaqus", "nastran", "study")


def main() -> None:
    """Damage `count` files, two fifths of them Abaqus, two fifths Nastran, one fifth studies; exit 1 on any fault."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks.fuzz")
    parser.add_argument("--count", type=int, default=10000, help="files in all")
    parser.add_argument("--first", type=int, default=0, help="first seed")
    parser.add_argument("--kind", choices=KINDS, help="only this kind")
    given = parser.parse_args()
    shares = {given.kind: given.count} if given.kind else _shares(given.count)
    faults = 0
    for kind, count in shares.items():
        start = time.perf_counter()
        tally = fuzz(kind, given.first, count)
        _show(kind, count, tally, time.perf_counter() - start)
        faults += len(tally.faults)
    sys.exit(1 if faults else 0)


def _shares(count: int) -> dict[str, int]:
    deck = 2 * count // 5
    return {"abaqus": deck, "nastran": deck, "study": count - 2 * deck}


def _show(kind: str, count: int, tally: Tally, seconds: float) -> None:
    ended = ", ".join(f"{end} {n}" for end, n in sorted(tally.ended.items()))
    took = f"{count} files in {seconds:.1f} s, the longest {tally.longest:.2f} s"
    print(f"{kind}: {took}: {ended}; {len(tally.faults)} faults", flush=True)
    for fault in tally.faults[:40]:
        print(f"  {fault}")


if __name__ == "__main__":
    main()
