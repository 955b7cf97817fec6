"""Lets the tests in this folder import the benchmarks, which are no part of the package."""

import sys
from pathlib import Path

sys.path.append(str(Path(__file__).resolve().parents[3]))
