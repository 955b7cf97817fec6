"""The parametric front door that creak ships as its example."""

from creak_thesis.door.assembly import FINEST_MESH_SIZE, Door, build_door
from creak_thesis.door.writer import LOAD, LOADS, write_door

__all__ = ["FINEST_MESH_SIZE", "LOAD", "LOADS", "Door", "build_door", "write_door"]
