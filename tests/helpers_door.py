"""Doors of every size that tests look at, each made once."""

from __future__ import annotations

from functools import cache

from creak_thesis.door import build_door

door = cache(build_door)
