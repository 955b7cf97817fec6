"""creak: open squeak-and-rattle simulation with reduced finite element models."""

from __future__ import annotations

from importlib.metadata import PackageNotFoundError, version

try:
    __version__ = version("creak")
except PackageNotFoundError:
    __version__ = "0+unknown"
