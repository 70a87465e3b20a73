"""Bounding meshes: meshes of few vertices on one side of an original mesh, proven close to it [K 4.3].

Edges are contracted, cheapest first, to points that lie behind no face of the edge's star: then the solid only
grows, by tetrahedra of non-negative volume, and no enclosed point is lost. The signs are exact. The cost only
orders contractions; a contraction is made if two distances are proven: of every new face from the original, and of
every original triangle from the new faces.
"""

import logging
import time
from dataclasses import dataclass
from pathlib import Path
from typing import Literal, Protocol, get_args

import numpy as np
from numpy.typing import NDArray

from kabo.arrays import Array, Integers
from kabo.displays import counted, display
from kabo.geometry.bounding import contraction_state as state
from kabo.geometry.bounding.hausdorff import hausdorff_bound
from kabo.geometry.bounding.kernels import contraction, quadrics
from kabo.geometry.bounding.kernels.bundles import ContractionSettings, Evidence
from kabo.geometry.bounding.kernels.carried_triangles import start
from kabo.geometry.bounding.kernels.star import MIN_COORDINATE, prepare
from kabo.geometry.triangles.component_groups import groups_without_crossings
from kabo.geometry.triangles.kernels.octree import octree_of
from kabo.geometry.triangles.triangle_trees import tree_of
from kabo.given import refuse, require_choice, require_flag, require_number
from kabo.meshes import Mesh, mesh_of, require_solid
from kabo.phases import phase

_LOG = logging.getLogger("kabo.geometry")
MOST_EPSILON = 1e6  # m: what squares of distances stand
Side = Literal["outer", "inner"]
Borders = Literal["refuse", "keep"]
Cost = Literal["memoryless", "planes", "adapted", "triangles", "diagonal"]

COSTS: dict[str, int] = {
    "memoryless": quadrics.MEMORYLESS,
    "planes": quadrics.PLANES,
    "adapted": quadrics.ADAPTED,
    "triangles": quadrics.TRIANGLES,
    "diagonal": quadrics.DIAGONAL,
}
ACCEPTED_COST_GROWTH = 1.2  # factor by which an edge may turn out more expensive than estimated and still be next
# What is tried one after the other: the least cosine between a face's old and new normal, and which part of a quadric's
# trace pulls a new point to its edge's middle, where the quadric alone would leave it free.
FACING_AND_REGULARISATION = ((0.0, 1e-6), (-1.0, 1e-4), (-1.0, 1e-2), (-1.0, 1.0))
RELATIVE_ROUNDING = 2.0**-45  # of the largest coordinate: far more than the rounding of any distance
COUNTER_NAMES = (
    "contractions",
    "solved",
    "topology",
    "facing",
    "sides",
    "far",
    "uncovered",
    "crossing",
    "popped",
    "passes",
    "postponed",
)


class TriangleMesh(Protocol):
    """Vertices (V, 3) [m] and faces (F, 3), counter-clockwise seen from outside."""

    @property
    def vertices(self) -> Array: ...  # noqa: D102

    @property
    def faces(self) -> Integers: ...  # noqa: D102


@dataclass(frozen=True, eq=False)
class BoundingMesh:
    """A mesh that encloses another (outer) or lies inside it (inner), with proven bounds.

    The winding number of the enclosing mesh around any point is at least that of the enclosed mesh.
    """

    vertices: Array  # (V, 3) [m]
    faces: Integers  # (F, 3)
    side: Side
    epsilon: float  # as given [m]
    hausdorff_upper_bound: float  # of both directions [m]
    contractions: int
    contraction_seconds: float  # of contractions with their proofs, without checks of input and result
    seconds: float  # of everything
    counts: dict[str, int]  # of contractions, and of rejections by their reason
    one_sided: Literal[True] = True

    def __repr__(self) -> str:
        return f"<BoundingMesh {self.side}: {self._sizes()}, within {self._bound()}>"

    def _repr_html_(self) -> str:
        figures = {
            "size": self._sizes(),
            "distance": f"{self._bound()}, of {1000 * self.epsilon:g} mm allowed",
            "contractions": f"{self.contractions} in {self.seconds:.2f} s",
        }
        return display(f"Bounding mesh, {self.side}", figures, self)

    def _sizes(self) -> str:
        return f"{counted(len(self.vertices), 'vertex', 'vertices')}, {counted(len(self.faces), 'face')}"

    def _bound(self) -> str:
        return f"{1000 * self.hausdorff_upper_bound:.3g} mm of the original"


def bounding_mesh(
    mesh: TriangleMesh,
    epsilon: float,
    side: Side = "outer",
    *,
    vertices: int | None = None,
    cost: Cost = "memoryless",
    certify: bool = True,
    borders: Borders = "refuse",
) -> BoundingMesh:
    """A mesh of few vertices on one side of `mesh`, proven within `epsilon` of it in both directions.

    Args:
        mesh: a closed, orientable manifold. It may have several components, which may overlap. Where faces of one
            component intersect already, they may still do so in an outer result; an inner one is refused.
        epsilon: the greatest permitted distance [m].
        side: "outer" encloses the mesh, "inner" is enclosed by it.
        vertices: contraction stops at this number of vertices.
        cost: the sum of squared distances by which contractions are ordered [K 4.3.3]:
            "memoryless": to the planes of the present neighbouring faces;
            "planes": to the planes of the original faces [K Eq. 4.5];
            "adapted": as "planes", but a contraction reduces the constant of the sum [K Eq. 4.5 ff.];
            "diagonal": as "planes", but an approximation that is diagonal in the principal axes [K Eq. 4.6, 4.7];
            "triangles": to the centres of triangles, which keeps convex meshes nearly convex [K A.2].
        certify: whether a contraction is made only after a proof that the distance is kept and no new
            intersections arise. False is faster: contraction stops where the cost exceeds epsilon squared
            [K Algorithm 2]; the bound in the result is still proven, but may exceed epsilon.
        borders: "refuse" accepts closed meshes only; "keep" accepts open ones, and does not change borders.

    Raises:
        MeshError: the mesh is not usable; the message says why, with counts, and what to do.
        ArgumentError: epsilon is not positive, too small for the coordinates' rounding, or an option is unknown.
    """
    begin = time.perf_counter()
    given = mesh_of(mesh)
    _require_options(epsilon, side, vertices, cost, certify, borders)
    points, faces = np.array(given.vertices, order="C"), np.ascontiguousarray(given.faces)
    points[np.abs(points) < MIN_COORDINATE] = 0.0
    require_solid(Mesh(points, faces, getattr(mesh, "path", None)), borders=borders)
    rounding = RELATIVE_ROUNDING * float(np.abs(points).max())
    limit = epsilon * (1.0 - 1e-9) - rounding
    if limit < 0.5 * epsilon:
        told = f"epsilon is {epsilon:g} m, less than rounding allows so far from the origin ({rounding:g} m)"
        refuse("epsilon", told)
    settings = _settings(points, epsilon, limit, vertices or 0, COSTS[cost], certify)
    start_of_contraction = time.perf_counter()
    if side == "outer":
        new, new_faces, counts = _contracted(points, faces, settings, _on_border(points, faces))
    else:
        new, new_faces, counts = _contracted_within(points, faces, settings, getattr(mesh, "path", None))
    contraction_seconds = time.perf_counter() - start_of_contraction
    bound = rounding
    if counts["contractions"]:
        with phase("measuring the distance", log=_LOG):
            ceiling = epsilon - 2.0 * rounding
            bound = hausdorff_bound(points, faces, new, new_faces, ceiling=ceiling)[1] + rounding
    if certify:  # the contractions' own certificate holds in any case
        bound = min(bound, limit + rounding)
    return BoundingMesh(
        vertices=new,
        faces=new_faces,
        side=side,
        epsilon=epsilon,
        hausdorff_upper_bound=bound,
        contractions=counts["contractions"],
        contraction_seconds=contraction_seconds,
        seconds=time.perf_counter() - begin,
        counts=counts,
    )


def _require_options(
    epsilon: object, side: object, vertices: object, cost: object, certify: object, borders: object
) -> None:
    require_number("epsilon", epsilon, above=0.0, most=MOST_EPSILON, unit="m")
    require_choice("side", side, get_args(Side))
    if vertices is not None:
        require_number("vertices", vertices, 0, whole=True)
    require_choice("cost", cost, COSTS)
    require_flag("certify", certify)
    require_choice("borders", borders, get_args(Borders))


def _settings(
    points: Array, epsilon: float, limit: float, vertices: int, cost: int, certify: bool
) -> ContractionSettings:
    low, high = points.min(axis=0), points.max(axis=0)
    diagonal, middle = float(np.linalg.norm(high - low)), 0.5 * (low + high)
    return ContractionSettings(
        cost=cost,
        certify=certify,
        vertices=vertices,
        alive=len(points),
        epsilon=float(epsilon),
        limit=limit,
        dearest=float(np.finfo(np.float64).max) if certify else float(epsilon) ** 2,
        facing=FACING_AND_REGULARISATION[0][0],
        patience=ACCEPTED_COST_GROWTH,
        regular=FACING_AND_REGULARISATION[0][1],
        slack=1e-12 * diagonal + 2.0**-48 * float(np.abs(points).max()),
        diagonal=diagonal,
        x=float(middle[0]),
        y=float(middle[1]),
        z=float(middle[2]),
    )


def _on_border(points: Array, faces: Integers) -> NDArray[np.bool_]:
    """(V,) whether a vertex is an end of a border edge."""
    edges = np.sort(faces[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2), axis=1)
    different, count = np.unique(edges, axis=0, return_counts=True)
    locked = np.zeros(len(points), np.bool_)
    locked[different[count == 1]] = True
    return locked


def _contracted_within(
    points: Array, faces: Integers, settings: ContractionSettings, path: Path | None
) -> tuple[Array, Integers, dict[str, int]]:
    """The vertices and faces within the mesh, and the counts; overlapping components are contracted one by one.

    Raises:
        MeshError: a component crosses itself.
    """
    whole = np.zeros((0, 3)), np.zeros((0, 3), np.int64), dict.fromkeys(COUNTER_NAMES, 0)
    for group in groups_without_crossings(points, faces, "mesh" if path is None else str(path)):
        used, index = np.unique(group[:, ::-1], return_inverse=True)
        own, turned = np.ascontiguousarray(points[used]), np.ascontiguousarray(index.reshape(-1, 3), np.int64)
        target = -(-settings.vertices * len(used) // len(points))
        now = settings._replace(vertices=target, alive=len(used))
        new, new_faces, counts = _contracted(own, turned, now, _on_border(own, turned))
        whole = (
            np.vstack([whole[0], new]),
            np.vstack([whole[1], new_faces[:, ::-1] + len(whole[0])]),
            {name: whole[2][name] + count for name, count in counts.items()},
        )
    return np.ascontiguousarray(whole[0]), np.ascontiguousarray(whole[1]), whole[2]


def _contracted(
    points: Array, faces: Integers, settings: ContractionSettings, locked: NDArray[np.bool_]
) -> tuple[Array, Integers, dict[str, int]]:
    """The remaining vertices and faces, and the counts."""
    count, certify = len(faces), settings.certify
    tree = tree_of(points, faces)
    triangle_of_face = np.empty(count, np.int64)
    triangle_of_face[tree.order] = np.arange(count)
    kept_quadrics = 1 if settings.cost == quadrics.MEMORYLESS else len(points)
    net = state.net_of(points, faces, locked, triangle_of_face, kept_quadrics)
    octree = octree_of(
        points.min(axis=0) - settings.epsilon, points.max(axis=0) + settings.epsilon, count if certify else 1
    )
    carried = state.carried_of(count, 3 * count + 10_000 if certify else count)
    draft = state.draft_of(count, 2 * count + 10_000 if certify else 1)
    counters = np.zeros(len(COUNTER_NAMES), np.int64)
    prepare(net, settings)
    start(carried, triangle_of_face)
    if certify:
        contraction.enter_all(net, octree)
    star, queue = state.star_of(count), state.queue_of(6 * count + 1000, 4 * count + 100)
    evidence = Evidence(tree, octree, carried, draft, state.work_of(count))
    rounds = FACING_AND_REGULARISATION if certify else FACING_AND_REGULARISATION[:1]
    with phase("contracting edges", len(rounds), "rounds", log=_LOG) as step:
        for facing, regular in rounds:
            now = settings._replace(facing=facing, regular=regular)
            contraction.contract_all(net, star, queue, evidence, now, counters)
            step()
    left = net.faces[net.faces[:, 0] >= 0]
    used, index = np.unique(left, return_inverse=True)
    counts = dict(zip(COUNTER_NAMES, counters.tolist(), strict=True))
    return np.ascontiguousarray(net.vertices[used]), np.ascontiguousarray(index.reshape(-1, 3)), counts
