"""Clearances: the distance by which each object may be displaced before the proof fails, along every branch.

An axis separates two bodies by a margin. If one of them is displaced by a vector shorter than the margin, the axis
still separates them, wherever on the path they are. Boxes that are apart are separated by an axis, too. So an
object, held or standing, may be translated by any distance below the least margin of all claims about it, and
rotated by any angle [rad] that, multiplied by the object's radius, is below this margin.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from kabo.plan import Plan, ProvenGap, plan_statistics
from kabo.scene import Scene
from kabo.verify.certificate_report import BranchClearance, ObjectClearance

FAR = 2.0  # times `near`: the distance below which gaps are told, though plans give no proofs for them
MAX_BRANCHES = 64  # of a plan whose branches are reported one by one

LeastMargins = dict[str, tuple[float, str]]  # object -> its least margin [m], and to what


@dataclass
class Margins:
    """The least margins [m] of the bodies at each node and of each segment, without margins of `near` or more."""

    near: float
    nodes: dict[str, LeastMargins] = field(default_factory=dict)
    segments: dict[tuple[str, int], tuple[float, tuple[str, str]]] = field(default_factory=dict)
    gaps: list[ProvenGap] = field(default_factory=list)

    def add(self, gap: ProvenGap) -> None:
        """Records what is proven of two bodies, and their margin unless a smaller one is recorded already."""
        self.gaps.append(gap)
        if gap.least >= self.near:
            return
        least = self.nodes.setdefault(gap.node, {})
        for name, other in (gap.names, gap.names[::-1]):
            least[name] = min(least.get(name, (np.inf, "")), (gap.least, other), key=lambda each: each[0])
        for i in gap.segments:
            own = gap.least, gap.names
            self.segments[gap.node, i] = min(self.segments.get((gap.node, i), own), own, key=lambda each: each[0])


def of_objects(scene: Scene, margins: Margins, order: Sequence[str]) -> tuple[ObjectClearance, ...]:
    """The clearance of each movable object: its least margin over all nodes of the plan."""
    result = []
    for name in scene.movable:
        radius = float(np.linalg.norm(scene.bodies[name].mesh.vertices, axis=1).max(initial=0.0))
        found = [(*margins.nodes[node][name], node) for node in order if name in margins.nodes.get(node, {})]
        least = min(found, key=lambda entry: entry[0], default=(None, None, None))
        result.append(ObjectClearance(name, radius, *least))
    return tuple(result)


def of_branches(plan: Plan, scene: Scene, margins: Margins) -> tuple[BranchClearance, ...] | None:
    """The clearances along each path from the root to a goal node; None for more than `MAX_BRANCHES` paths."""
    if plan_statistics(plan).plan_leaves > MAX_BRANCHES:
        return None
    result = []
    ahead: list[tuple[str, tuple[str, ...], dict[str, float]]] = [(plan.root, (), {})]
    while ahead:
        name, outcomes, before = ahead.pop()
        node = plan.nodes[name]
        here = {each: margin for each, (margin, _) in margins.nodes.get(name, {}).items()}
        least = {each: min(before.get(each, np.inf), here.get(each, np.inf)) for each in {**before, **here}}
        if node.kind == "goal":
            result.append(BranchClearance(outcomes, {each: least.get(each) for each in scene.movable}))
        elif node.branches:
            ahead.extend(
                (after, (*outcomes, f"{node.on}: {outcome}"), least)
                for outcome, after in reversed(list(node.branches.items()))
            )
        elif node.next is not None:
            ahead.append((node.next, outcomes, least))
    return tuple(result)
