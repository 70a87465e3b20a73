"""What a plan's certificate says, for the page: clearances of segments, and the proof of every pair of bodies."""

from collections.abc import Mapping
from typing import Any

from kabo.plan import Certificate, Plan


def clearances_of(plan: Plan) -> Mapping[str, list[dict[str, Any]]]:
    """The proven clearance [m] of each node's segments, and of which pair; None where nothing is near."""
    found: dict[str, list[dict[str, Any]]] = {}
    for each in plan.certificate.segments if plan.certificate is not None else ():
        found.setdefault(each.node, []).append(
            {
                "segment": each.segment,
                "clearance": each.clearance,
                "between": None if each.between is None else list(each.between),
            }
        )
    return found


def proofs_of(plan: Plan) -> dict[str, Any] | None:
    """The proofs of a plan by node; None if it has none.

    `things` are the names that proofs refer to. Of each stretch of a node there are its `segments`, those of the node
    `before` with which it overlaps, and `pairs`: [first thing, second thing, place, walk]. The letters of a walk are
    those of the certificate: boxes, axes, and halvings of the path and of the parts.
    """
    if plan.certificate is None or not plan.certificate.proofs:
        return None
    numbers: dict[str, int] = {}
    nodes: dict[str, list[dict[str, Any]]] = {}
    for stretch in plan.certificate.proofs:
        pairs = [
            [
                numbers.setdefault(pair.first, len(numbers)),
                numbers.setdefault(pair.second, len(numbers)),
                pair.place,
                pair.walk,
            ]
            for pair in stretch.pairs
        ]
        nodes.setdefault(stretch.node, []).append(
            {"segments": list(stretch.segments), "before": list(stretch.before), "pairs": pairs}
        )
    return {"things": list(numbers), "nodes": nodes, "bodies": _bodies(plan.certificate)}


def _bodies(certificate: Certificate) -> dict[str, int]:
    """How many meshes, and convex parts around them, the proofs are about."""
    return {
        "meshes": len(certificate.bodies),
        "parts": sum(len(body.sizes) for body in certificate.bodies.values()),
    }
