"""The report on a certificate: what was proven, and how far each object may be displaced."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from kabo.plan import ProvenGap

MAX_SHOWN_OBJECTS = 12  # objects that the report's text names


@dataclass(frozen=True)
class ObjectClearance:
    """The clearance of one object: all proofs still hold if it is displaced by less than `distance` [m].

    `distance` is None where it exceeds the range of the proofs (`CertificateReport.near`). A rotation about the
    object's origin counts as its angle times `radius` [m].
    """

    name: str
    radius: float
    distance: float | None = None
    other: str | None = None
    node: str | None = None

    def to_dict(self) -> dict[str, Any]:
        """The clearance as JSON values."""
        return {
            "object": self.name,
            "radius": self.radius,
            "distance": self.distance,
            "other": self.other,
            "node": self.node,
        }

    def __str__(self) -> str:
        if self.distance is None:
            return self.name
        return f"{self.name} {1000 * self.distance:.2f} mm ({self.other}, {self.node})"


@dataclass(frozen=True)
class BranchClearance:
    """The clearances on one path from the root to a goal node: its outcomes, and each object's distance [m]."""

    outcomes: tuple[str, ...]
    distances: Mapping[str, float | None]

    def to_dict(self) -> dict[str, Any]:
        """The clearances as JSON values."""
        return {"outcomes": list(self.outcomes), "distances": dict(self.distances)}


@dataclass(frozen=True)
class CertificateReport:
    """The figures of a certificate check: counts of what was proven, and the clearances of objects.

    The counts are those of `stretches` of motion, of `pairs` that needed a proof, of `axes` that were evaluated,
    and of `meshes` whose parts were proven to cover them. No clearance above `near` [m] is reported. `branches` is
    None if the plan has too many branches. `gaps` are all margins below `FAR` times `near`, pair by pair.
    """

    proven: bool
    near: float
    stretches: int = 0
    pairs: int = 0
    axes: int = 0
    meshes: int = 0
    paranoid: bool = False
    objects: tuple[ObjectClearance, ...] = ()
    branches: tuple[BranchClearance, ...] | None = ()
    gaps: tuple[ProvenGap, ...] = field(default=(), compare=False, repr=False)

    def to_dict(self) -> dict[str, Any]:
        """The figures as JSON values, without findings, which the whole verification report lists."""
        return {
            "proven": self.proven,
            "near": self.near,
            "stretches": self.stretches,
            "pairs": self.pairs,
            "axes": self.axes,
            "meshes": self.meshes,
            "paranoid": self.paranoid,
            "clearance": [each.to_dict() for each in self.objects],
            "branches": None if self.branches is None else [each.to_dict() for each in self.branches],
        }

    def lines(self) -> list[str]:
        """The report as lines of text."""
        if not self.proven:
            return ["certificate: does not hold"]
        how = ", in exact arithmetic" if self.paranoid else ""
        figures = (
            f"{self.stretches} stretches of motion, {self.pairs} pairs by {self.axes} axes, the rest by boxes"
        )
        result = [f"certificate: holds{how}: {figures}; the parts of {self.meshes} meshes enclose them"]
        told = sorted((o for o in self.objects if o.distance is not None), key=lambda o: (o.distance, o.name))
        if told:
            more = f", {len(told) - MAX_SHOWN_OBJECTS} more" if len(told) > MAX_SHOWN_OBJECTS else ""
            result.append(f"may be displaced by less than: {', '.join(map(str, told[:MAX_SHOWN_OBJECTS]))}{more}")
        rest = [o.name for o in self.objects if o.distance is None]
        if rest:
            result.append(f"may be displaced by {1000 * self.near:.3g} mm: {', '.join(rest)}")
        return result
