"""The margins of a plan as a table: for each node and body how far it may be displaced from there on."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from itertools import product
from math import inf
from typing import Any

import numpy as np

from kabo.execution.margins import Margins
from kabo.plan import topological_order

DIRECTIONS = ("+x", "-x", "+y", "-y", "+z", "-z")
_VECTORS = [sign * axis for axis, sign in product(np.eye(3), (1.0, -1.0))]


@dataclass(frozen=True)
class BodyMargin:
    """How far a body may be displaced from a node on, all else being at its place; no proof is needed anew.

    Attributes:
        node, body: which ones.
        handled: whether a hand holds, takes or puts down the body in this node.
        radius: of each of its points in any direction [m], by a shift, a turn, or both.
        along: without a turn, in each of `DIRECTIONS` of the world [m].
        other, at: what comes nearest, and the node in whose motion; None: nothing comes nearer than `near`.
    """

    node: str
    body: str
    handled: bool
    radius: float
    along: tuple[float, ...]
    other: str | None = None
    at: str | None = None

    def to_dict(self) -> dict[str, Any]:
        """The margin as JSON values; null where nothing moves any more."""
        return {
            "node": self.node,
            "body": self.body,
            "handled": self.handled,
            "radius": _finite(self.radius),
            "along": dict(zip(DIRECTIONS, map(_finite, self.along), strict=True)),
            "other": self.other,
            "at": self.at,
        }


def body_margins(margins: Margins, bodies: Iterable[str]) -> tuple[BodyMargin, ...]:
    """The margins of bodies at each node of a plan, in an order in which no node is before its predecessors.

    Args:
        margins: of the plan, made with the report of its check.
        bodies: the bodies, as `Scene.movable`.

    Raises:
        ValueError: the margins were made without a report, or of a plan without a certificate.

    Example:
        >>> margins = kabo.execution.Margins(plan, kabo.verify(problem, plan))
        >>> margins.rest(plan.root).radius("o1").least
        0.00999...
    """
    names, found = tuple(bodies), []
    for node in topological_order(margins.plan) or []:
        tolerance = margins.rest(node)
        if tolerance is None:
            raise ValueError("nothing is proven of single bodies: the plan has no certificate that holds")
        for body in names:
            slack = tolerance.radius(body)
            along = tuple(tolerance.along(body, vector) for vector in _VECTORS)
            handled = body in margins.handled[node]
            found.append(BodyMargin(node, body, handled, slack.least, along, slack.other, slack.node))
    return tuple(found)


def least_margins(margins: Margins, node: str, bodies: Iterable[str]) -> dict[str, dict[str, Any]] | None:
    """How far bodies may be displaced in any way from a node on, as JSON values: `least` [m] and what is nearest.

    None without the report of a check; a body that nothing limits is left out.
    """
    tolerance = margins.rest(node)
    if tolerance is None:
        return None
    slacks = {body: tolerance.radius(body) for body in bodies}
    return {body: {"least": own.least, "other": own.other} for body, own in slacks.items() if own.least < inf}


def table_of(margins: Margins, found: Sequence[BodyMargin]) -> list[str]:
    """The margins as lines of text, in millimetres; a body is told again where something has changed."""
    rows: list[tuple[str, ...]] = [("node", "", "body", "any way", *DIRECTIONS, "nearest")]
    told: dict[str, tuple[object, ...]] = {}
    for each in found:
        node = margins.plan.nodes[each.node]
        what = (each.handled, each.radius, each.along, each.other, each.at)
        if node.kind == "goal" or told.get(each.body) == what:
            continue
        told[each.body] = what
        nearest = "" if each.other is None else f"{each.other} at {each.at}"
        does = " ".join([node.action or node.kind, *map(str, node.arguments.values())])
        sizes = [_millimetres(value, margins.far) for value in (each.radius, *each.along)]
        rows.append((each.node, does, each.body + (" in hand" if each.handled else ""), *sizes, nearest))
    widths = [max(map(len, column)) for column in zip(*rows, strict=True)]
    return [
        "  ".join(
            text.rjust(width) if 3 <= k <= 9 else text.ljust(width)
            for k, (text, width) in enumerate(zip(row, widths, strict=True))
        ).rstrip()
        for row in rows
    ]


def _millimetres(value: float, near: float) -> str:
    return "any" if value == inf else f"{1000 * value:.1f}" + ("+" if value >= near else "")


def _finite(value: float) -> float | None:
    return value if value < inf else None
