"""The parametric front door that creak ships as its example."""

from creak.door.assembly import FINEST_MESH_SIZE, Door, build_door
from creak.door.study import LOAD, LOADS
from creak.door.writer import write_door

__all__ = ["FINEST_MESH_SIZE", "LOAD", "LOADS", "Door", "build_door", "write_door"]
