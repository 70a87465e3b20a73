"""Bounding convex decompositions [K Def. 3]: convex parts proven to cover a solid and to stay within epsilon of it.

The parts are those of `kabo.geometry.bounding.decomposition`, with few vertices rather than few parts, and all of
them: what is refined on demand elsewhere is refined here at once.
"""

import logging
from dataclasses import dataclass
from pathlib import Path
from time import perf_counter
from typing import Literal, Protocol

import numpy as np

from kabo.arrays import Array, Integers
from kabo.compilation import cache_folder
from kabo.displays import counted, display
from kabo.geometry.bounding.bounding_mesh import MOST_EPSILON
from kabo.geometry.bounding.cover_tree import CoverTree
from kabo.geometry.bounding.decomposition import Request
from kabo.geometry.bounding.enclosing_union import Aims
from kabo.geometry.bounding.enclosure import aims_for, kept_cover, name_of
from kabo.geometry.bounding.shapes import shape_of
from kabo.given import require_choice, require_folder, require_number
from kabo.meshes import mesh_of
from kabo.options import require_seed
from kabo.phases import phase

_LOG = logging.getLogger("kabo.geometry")
MAX_CELLS = 1000  # above which parts are made coarsely first, and then refined one by one


class Triangles(Protocol):
    """The interface of a triangle mesh: vertices (V, 3) [m] and faces (F, 3)."""

    @property
    def vertices(self) -> Array:
        """The vertices (V, 3) [m]."""

    @property
    def faces(self) -> Integers:
        """The vertex indices (F, 3) of all faces."""


@dataclass(frozen=True, eq=False)
class Decomposition:
    """Convex parts whose union contains a solid, and whose points all lie near this solid."""

    parts: tuple[Array, ...]  # the corners of each, (V, 3) [m]
    deviations: tuple[float, ...]  # of each part: a proven bound of its greatest distance from the solid [m]
    epsilon: float  # [m]
    seconds: float  # spent on computing the parts, or on reading them

    def __repr__(self) -> str:
        return f"<Decomposition: {self._sizes()}, within {self._bound()}>"

    def _repr_html_(self) -> str:
        figures = {"size": self._sizes(), "distance": f"{self._bound()}, of {1000 * self.epsilon:g} mm allowed"}
        return display("Bounding decomposition", figures, self)

    def _sizes(self) -> str:
        corners = counted(sum(map(len, self.parts)), "vertex", "vertices")
        return f"{counted(len(self.parts), 'convex part')}, {corners}"

    def _bound(self) -> str:
        return f"{1000 * self.hausdorff_upper_bound:.3g} mm of the solid"

    @property
    def hausdorff_upper_bound(self) -> float:
        """A proven upper bound, at most `epsilon`, of the Hausdorff distance between union and solid [m]."""
        return max(self.deviations)

    @property
    def worst(self) -> int:
        """The index of the part with the greatest deviation."""
        return int(np.argmax(self.deviations))


def bounding_decomposition(
    mesh: Triangles,
    epsilon: float,
    *,
    parts: int | None = None,
    vertices_per_part: int | None = None,
    engine: Literal["kabo", "coacd"] = "kabo",
    seed: int = 0,
    cache: Path | None = None,
) -> Decomposition:
    """Few convex parts with few vertices that cover the solid inside a closed mesh, within `epsilon` of it [K 4.4].

    The same triangles and parameters give the same parts, whatever the order of vertices and faces.

    Args:
        mesh: a closed mesh with vertices (V, 3) [m], whose components may overlap.
        epsilon: the greatest permitted distance of any point of the parts from the solid [m].
        parts: the desired number of parts; more are made if epsilon requires it.
        vertices_per_part: the desired greatest number of vertices of a part; exceeded where it cannot be kept.
        engine: "coacd" cuts with CoACD instead; its hulls are widened until they are proven to cover the solid.
        seed: of CoACD; kabo's own method makes no random choices.
        cache: the folder of stored decompositions; None is the folder in kabo's cache.

    Raises:
        ArgumentError: epsilon is not a positive length, or a desired number is not positive.
        MeshError: the mesh is empty, not finite, open or too fine for epsilon, or has indices out of range.
    """
    began = perf_counter()
    own = mesh_of(mesh)
    require_number("epsilon", epsilon, above=0.0, most=MOST_EPSILON, unit="m")
    if parts is not None:
        require_number("parts", parts, 1, whole=True)
    if vertices_per_part is not None:
        require_number("vertices_per_part", vertices_per_part, 4, whole=True)
    require_choice("engine", engine, ("kabo", "coacd"))
    require_seed(seed)
    folder = cache_folder() / "parts" if cache is None else require_folder("cache", cache)
    shape, name = shape_of(own), name_of(own)
    aims = Aims(aims_for(shape, epsilon, name).tolerance, corners=vertices_per_part)
    request = Request(aims, parts, MAX_CELLS, engine, seed if engine == "coacd" else 0)
    with phase("making convex parts", log=_LOG):
        cover = kept_cover(shape, request, folder, name)
    tree = CoverTree.of(shape, cover, aims, name, folder)
    following = 0
    with phase("refining parts", log=_LOG) as step:
        while following < len(tree.nodes):
            tree = tree.finer(following)
            following += 1
            step()
    leaves = [node for node in tree.nodes if not node.many]
    return Decomposition(
        tuple(shape.placed(leaf.part) for leaf in leaves),
        tuple(shape.metres(leaf.deviation) for leaf in leaves),
        epsilon,
        perf_counter() - began,
    )
