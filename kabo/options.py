"""The words by which a run is told how to plan: the searches, the geometries, when geometry is asked, the quality.

Each set of words stands here once, as a type; the tuple beside it lists the same words for parsers and messages.
"""

from typing import Final, Literal, TypeAlias, get_args

Search: TypeAlias = Literal["best", "greedy", "astar", "breadth-first", "depth-first", "iterative-deepening"]
Geometry: TypeAlias = Literal["bounding", "exact", "none"]
GeometryOrder: TypeAlias = Literal["adaptive", "lazy", "eager"]
Quality: TypeAlias = Literal["fast", "good"]

SEARCHES: Final[tuple[Search, ...]] = get_args(Search)
GEOMETRIES: Final[tuple[Geometry, ...]] = get_args(Geometry)
GEOMETRY_ORDERS: Final[tuple[GeometryOrder, ...]] = get_args(GeometryOrder)
QUALITIES: Final[tuple[Quality, ...]] = get_args(Quality)
