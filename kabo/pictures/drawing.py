"""What a picture shows, as data: solids where they stand, glass over them, lines, and labels with their anchors.

Nothing here draws; `rendering` does. Lengths are in metres, in the world's frame.
"""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field, replace

import numpy as np

from kabo.arrays import Array
from kabo.meshes.mesh import Faces, Vertices

Colour = str  # such as "#3f7fbf"
MAX_FITTED_POINTS = 400  # of a solid, beside its extreme ones: more would not move the camera


@dataclass(frozen=True)
class Solid:
    """A mesh in its own frame, and where it stands: `pose` (4, 4) is world_T_mesh.

    `weight` says how much it matters that it is seen: at 0 a picture need not hold it, as a floor. `distances` (V,) [m]
    colour it instead of `colour`; `edges` is the mesh whose edges are drawn over it.
    """

    name: str
    vertices: Vertices
    faces: Faces
    colour: Colour
    pose: Array = field(default_factory=lambda: np.eye(4))
    weight: float = 1.0
    smooth: bool = True
    edges: tuple[Vertices, Faces] | None = None
    distances: Array | None = None

    @property
    def world_points(self) -> Array:
        """Points (N, 3) that span the solid in the world: its extreme vertices, and some of the others."""
        step = max(1, len(self.vertices) // MAX_FITTED_POINTS)
        extreme = np.concatenate([self.vertices.argmin(axis=0), self.vertices.argmax(axis=0)])
        points = np.concatenate([self.vertices[::step], self.vertices[extreme]])
        return np.asarray(points @ self.pose[:3, :3].T + self.pose[:3, 3])


@dataclass(frozen=True)
class Glass:
    """Solids that are seen through: only their first surface is drawn, so that many inside each other stay clear."""

    solids: tuple[Solid, ...]
    opacity: float


@dataclass(frozen=True)
class Line:
    """A line through points (N, 3) [m] in the world, drawn over everything."""

    points: Array
    colour: Colour


@dataclass(frozen=True)
class Label:
    """A name, where it points to (3,) [m], and the colour of its border. Labels of lower rank are placed first.

    `about` are the solids that it names: the label points to where they are seen. Where they are not it is left out, or,
    if it is to stand `always`, points to its anchor and says so. Without solids it points to its anchor.
    """

    text: str
    anchor: Array
    colour: Colour
    rank: int = 0
    about: frozenset[str] = frozenset()
    always: bool = False


@dataclass(frozen=True)
class Drawing:
    """All that one picture, or one panel of a picture, shows."""

    solids: tuple[Solid, ...]
    glass: tuple[Glass, ...] = ()
    lines: tuple[Line, ...] = ()
    labels: tuple[Label, ...] = ()

    @property
    def everything(self) -> tuple[Solid, ...]:
        """All solids, those of glass last."""
        return (*self.solids, *(solid for glass in self.glass for solid in glass.solids))

    @property
    def points(self) -> Array:
        """Points (N, 3) that span the drawing.

        Raises:
            ValueError: nothing is drawn.
        """
        held = [solid for solid in self.everything if solid.weight > 0.0] or self.everything
        if not held:
            raise ValueError("nothing is drawn")
        return np.concatenate([*(solid.world_points for solid in held), *(line.points for line in self.lines)])

    def moved(self, poses: Mapping[str, Array]) -> "Drawing":
        """The drawing with the solids of some names at other poses (4, 4)."""

        def at(solids: Iterable[Solid]) -> tuple[Solid, ...]:
            return tuple(
                replace(solid, pose=poses[solid.name]) if solid.name in poses else solid for solid in solids
            )

        return replace(self, solids=at(self.solids))
