"""Trees of parts: a coarse cover of a shape, whose parts are refined one by one where a caller asks for it.

The children of a part cover what the part covers of the solid. They depend on the part, the shape and the finest
tolerance alone, not on what was refined before; they are kept in the cache.
"""

import hashlib
import logging
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass, replace
from pathlib import Path
from typing import NamedTuple

from kabo.arrays import Array
from kabo.errors import Diagnostic, MeshError
from kabo.geometry.bounding import stored_parts
from kabo.geometry.bounding.decomposition import finer_tolerance, refined_cover
from kabo.geometry.bounding.enclosing_union import Aims, TooManyCells, Undecided
from kabo.geometry.bounding.shapes import Shape
from kabo.geometry.bounding.stored_parts import Cover
from kabo.geometry.bounding.verified_parts import are_verified, record_proof
from kabo.geometry.parts import Enclosure

_LOG = logging.getLogger("kabo.geometry")


class Node(NamedTuple):
    """A part of a shape, and where its children stand among the nodes of its tree."""

    part: Array  # (V, 3)
    deviation: float  # at most `tolerance`
    tolerance: float
    first: int = 0
    many: int = 0


@dataclass(frozen=True, eq=False)
class CoverTree:
    """A cover of a shape with the children of some of its parts; those of a part stand one after the other."""

    shape: Shape
    aims: Aims  # of the finest parts
    name: str  # of the mesh, for errors
    cache: Path  # the folder of stored parts
    nodes: tuple[Node, ...]
    roots: int

    @classmethod
    def of(cls, shape: Shape, cover: Cover, aims: Aims, name: str, cache: Path) -> "CoverTree":
        """The tree of a cover, without children."""
        each = zip(cover.parts, cover.deviations, strict=True)
        nodes = tuple(Node(part, deviation, cover.tolerance) for part, deviation in each)
        return cls(shape, aims, name, cache, nodes, len(nodes))

    def enclosure(self) -> Enclosure:
        """The tree as an enclosure [m]; flat if all parts are as near as was asked."""
        shape, nodes = self.shape, self.nodes
        deviations = tuple(shape.metres(node.deviation) for node in nodes)
        parts = tuple(shape.placed(node.part) for node in nodes)
        leaves = max(own for own, node in zip(deviations, nodes, strict=True) if not node.many)
        if not any(self.is_open(i) for i in range(self.roots)):
            return Enclosure(parts, leaves, deviations=deviations)
        children = tuple((node.first, node.many) for node in nodes)
        return Enclosure(
            parts, leaves, deviations=deviations, children=children, roots=self.roots, finer=self._finer_enclosure
        )

    def is_open(self, i: int) -> bool:
        """Whether a part deviates more than the finest parts may."""
        return self.nodes[i].deviation > self.aims.tolerance

    def finer(self, i: int) -> "CoverTree":
        """The tree in which part i has children; the tree itself if it has some already, or is near enough.

        Raises:
            MeshError: what the part covers cannot be covered by finer parts.
        """
        node = self.nodes[i]
        if node.many or not self.is_open(i):
            return self
        found = self._children(node)
        added = tuple(Node(*each, found.tolerance) for each in zip(found.parts, found.deviations, strict=True))
        nodes = list(self.nodes)
        nodes[i] = node._replace(first=len(nodes), many=len(added))
        return replace(self, nodes=(*nodes, *added))

    def _finer_enclosure(self, i: int) -> Enclosure:
        finer = self.finer(i)
        return self.enclosure() if finer is self else finer.enclosure()

    def _children(self, node: Node) -> Cover:
        """The children of a part: from the cache, or computed."""
        aims = self.aims._replace(tolerance=finer_tolerance(node.tolerance, self.aims.tolerance))
        asked = stored_parts.METHOD_VERSION, self.shape.digest, tuple(aims)
        key = hashlib.sha256(repr(asked).encode() + node.part.tobytes()).hexdigest()
        path = self.cache / f"{key[:40]}.parts"
        return kept_or_made(self.shape, path, node.part, lambda: self._made(node.part, aims))

    def _made(self, part: Array, aims: Aims) -> Cover:
        try:
            return refined_cover(self.shape.solid, part, aims)
        except (TooManyCells, Undecided):
            said = f"a part of the mesh cannot be covered within {self.shape.metres(aims.tolerance):g} m"
            raise MeshError([Diagnostic(self.name, 1, 1, said, "ask for a larger epsilon")]) from None


def kept_or_made(shape: Shape, path: Path, within: Array | None, make: Callable[[], Cover]) -> Cover:
    """The proven cover in a file of the cache, or a new one, which is then kept there."""
    for found in stored_parts.read(path, shape.digest):
        if are_verified(shape.solid, found, within):
            _LOG.debug(
                "convex parts from the cache: %s", path, extra={"fields": {"cache": "hit", "file": str(path)}}
            )
            return found
    made = make()
    record_proof(shape.solid, made, within)
    with suppress(OSError):  # a read-only cache costs time, never an answer
        stored_parts.write(path, shape.digest, [made])
    return made
