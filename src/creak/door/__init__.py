"""The parametric front door that creak ships as its example."""

from creak.door.assembly import FINEST_MESH_SIZE, Door, build_door
from creak.door.study import AMPLITUDE
from creak.door.writer import write_door

__all__ = ["AMPLITUDE", "FINEST_MESH_SIZE", "Door", "build_door", "write_door"]
