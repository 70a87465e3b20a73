"""How far things may be from where the plan has them: the proven clearances of the rest of a plan."""

from collections.abc import Mapping
from functools import cached_property
from math import inf

from kabo.plan import Plan, topological_order


class Margins:
    """The proven clearances of a plan [m]; a plan without a certificate proves none."""

    def __init__(self, plan: Plan) -> None:
        self.plan = plan
        certificate = plan.certificate
        self.near = 0.0 if certificate is None else certificate.near or 0.0
        self._segments: dict[tuple[str, int], float] = {}
        for each in () if certificate is None else certificate.segments:
            self._segments[each.node, each.segment] = self.near if each.clearance is None else each.clearance

    def of_segment(self, node: str, segment: int) -> float:
        """The least proven distance between what moves in a segment and all else [m]; 0 if nothing is proven."""
        return self._segments.get((node, segment), 0.0)

    def of_rest(self, node: str) -> float:
        """The least one of all segments that may still come from a node on; infinite if nothing moves any more."""
        return self._rest[node]

    @cached_property
    def _rest(self) -> Mapping[str, float]:
        found: dict[str, float] = {}
        for name in reversed(topological_order(self.plan) or []):
            node = self.plan.nodes[name]
            own = min((self.of_segment(name, number) for number in range(len(node.motion))), default=inf)
            found[name] = min([own, *(found[after] for after in node.successors)])
        return found
