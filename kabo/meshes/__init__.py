"""The meshes room: triangle meshes as arrays and files, what is wrong with them, safe repairs.

The package does not depend on epsilon, convex parts, robots or scenes. A file that cannot be used is described in
one sentence; a file that was written is read back and compared bit by bit.
"""

from kabo.meshes.hulls import hull_faces, hull_of
from kabo.meshes.mesh import Mesh
from kabo.meshes.mesh_errors import mesh_of, refuse, require_numbers, unusable
from kabo.meshes.pieces import hollow_pieces
from kabo.meshes.reading import FORMATS, load_mesh
from kabo.meshes.repair import outwards, repaired
from kabo.meshes.requirements import require_closed, require_solid, units_warning
from kabo.meshes.rounding import Rounding
from kabo.meshes.soundness import Soundness, examine
from kabo.meshes.volumes import volume_of
from kabo.meshes.writing import WRITTEN, require_written, write_mesh, write_off, write_pieces

__all__ = [
    "FORMATS",
    "WRITTEN",
    "Mesh",
    "Rounding",
    "Soundness",
    "examine",
    "hollow_pieces",
    "hull_faces",
    "hull_of",
    "load_mesh",
    "mesh_of",
    "outwards",
    "refuse",
    "repaired",
    "require_closed",
    "require_numbers",
    "require_solid",
    "require_written",
    "units_warning",
    "unusable",
    "volume_of",
    "write_mesh",
    "write_off",
    "write_pieces",
]
