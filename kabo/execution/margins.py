"""How far things may be from where the plan has them, by what the plan's certificate proves.

An axis separates two things by a gap, wherever in its stretch they are. It does so still if they are displaced, as long as
their displacements use up less than the gap. Of a body that stands only what its points are displaced along the axis
counts. What a hand holds turns with it, and nobody knows how a displacement goes on in a hand: there its length counts.
"""

from collections.abc import Callable, Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from math import ceil, inf

import numpy as np
from scipy.spatial import ConvexHull, QhullError

from kabo.arrays import Array, Integers
from kabo.errors import Diagnostic, InputError
from kabo.execution.displacements import Displacement
from kabo.plan import Plan, ProvenGap, topological_order
from kabo.verify import Report

FEW_CLAIMS = 24  # of a pair in a stretch, of which all are kept
ROUNDING = 1e-9  # share of a gap
_Key = tuple[str, str, bool, bool]  # two things, and of which of them directions count


@dataclass(frozen=True)
class Slack:
    """How much more a thing may be displaced [m], negative if nothing proves that it is free; and what comes nearest."""

    least: float
    other: str | None = None
    node: str | None = None


@dataclass(frozen=True, eq=False)
class Tolerance:
    """What may be displaced by how much during a part of a plan, by all proofs of this part.

    Each row is a claim about two things: along `axes` the first is ahead of the second by `gaps`.

    Attributes:
        near: pairs without a row are farther apart than this [m].
        moves: whether anything moves in this part; if not, nothing can be met.
        names: the two things of each row (R, 2). nodes: of each row the node of its motion (R,).
        axes: (R, 3) directions of the world. gaps: (R,) [m].
        directed: (R, 2) whether a thing's displacement counts along the axis only, not with its whole size.
        robots: of each row the robots whose tracking errors count, one for each side that a robot moves; none where
            only a gripper moves one thing relative to the other.
    """

    near: float
    moves: bool
    names: Sequence[tuple[str, str]] = ()
    nodes: Sequence[str] = ()
    axes: Array = field(default_factory=lambda: np.zeros((0, 3)))
    gaps: Array = field(default_factory=lambda: np.zeros(0))
    directed: Array = field(default_factory=lambda: np.zeros((0, 2), bool))
    robots: Sequence[tuple[str, ...]] = ()

    @cached_property
    def _index(self) -> dict[str, int]:
        return {name: i for i, name in enumerate(dict.fromkeys(name for pair in self.names for name in pair))}

    @cached_property
    def _ends(self) -> Integers:
        return np.array([[self._index[name] for name in pair] for pair in self.names], np.int64).reshape(-1, 2)

    def left(self, displaced: Mapping[str, Displacement], tracking: Mapping[str, float] | None = None) -> Array:
        """What is left of the gap of each row (R,) if things are displaced, and robots are off their paths [m]."""
        count, most = len(self._index), max((len(each.moves) for each in displaced.values()), default=1)
        moves, errors, sizes = np.zeros((count, most, 3)), np.zeros(count), np.zeros(count)
        for name, each in displaced.items():
            if (i := self._index.get(name)) is not None:
                moves[i], errors[i], sizes[i] = each.moves[0], each.error, each.size
                moves[i, : len(each.moves)] = each.moves
        left = self.gaps.copy()
        for side, sign in enumerate((1.0, -1.0)):
            rows = np.flatnonzero(sizes[self._ends[:, side]] > 0.0)
            own, axes = self._ends[rows, side], sign * self.axes[rows]
            along = np.einsum("rk,rjk->rj", axes, moves[own]).min(axis=1, initial=np.inf) - errors[own]
            left[rows] += np.where(self.directed[rows, side], along, -sizes[own])
        return left - self._lost(tracking) if tracking else left

    def _lost(self, tracking: Mapping[str, float]) -> Array:
        return np.array([sum(tracking.get(robot, 0.0) for robot in robots) for robots in self.robots])

    def slacks(
        self, displaced: Mapping[str, Displacement], tracking: Mapping[str, float] | None = None
    ) -> dict[str, Slack]:
        """How much more each displaced body may be displaced, the others and robots being where they are.

        Args:
            displaced: the bodies that are not at their places. tracking: how far robots may be off their paths [m].
        """
        if not self.moves:
            return dict.fromkeys(displaced, Slack(inf))
        left, found = self.left(displaced, tracking), {}
        off = sum((tracking or {}).values())
        for name, each in displaced.items():
            others = max((other.size for key, other in displaced.items() if key != name), default=0.0)
            least, row = self.near - each.size - others - off, -1
            if (i := self._index.get(name)) is not None:
                own = np.flatnonzero((self._ends == i).any(axis=1))
                best = int(own[np.argmin(left[own])])
                if left[best] < least:
                    least, row = float(left[best]), best
            found[name] = Slack(least) if row < 0 else Slack(least, self._other(row, name), self.nodes[row])
        return found

    @cached_property
    def least(self) -> float:
        """The least gap of all pairs [m]."""
        return min(self.near, float(self.gaps.min(initial=inf)))

    def together(
        self, displaced: Mapping[str, Displacement], lost: Callable[[str, str], float]
    ) -> tuple[float, tuple[str, str]]:
        """The least that is left of the gap of any two things that have a row [m], and which they are.

        Args:
            displaced: the bodies that are not at their places. lost: how much nearer to each other robots have brought two
                things than the plan has them, at most [m].
        """
        if not len(self.gaps):
            return inf, ("", "")
        known = {pair: lost(*pair) for pair, robots in zip(self.names, self.robots, strict=True) if robots}
        left = self.left(displaced) - np.array([known.get(pair, 0.0) for pair in self.names])
        row = int(np.argmin(left))
        return float(left[row]), self.names[row]

    def radius(self, body: str, tracking: Mapping[str, float] | None = None) -> Slack:
        """How far a body may be displaced in any direction, everything else being at its place."""
        return self.slacks({body: Displacement(np.zeros(3))}, tracking)[body]

    def along(self, body: str, direction: Array) -> float:
        """How far a body may be shifted in a direction (3,) of the world [m], everything else being at its place.

        It is at least `radius`: the polyhedron {d : -axis_i · d <= gap_i} of the body's rows is larger than the ball in it.
        """
        if not self.moves:
            return inf
        direction, least = direction / np.linalg.norm(direction), self.near
        i = self._index.get(body)
        for side, sign in enumerate((1.0, -1.0)) if i is not None else ():
            own = np.flatnonzero(self._ends[:, side] == i)
            spent = np.where(self.directed[own, side], -sign * self.axes[own] @ direction, 1.0)
            counts = spent > 0.0
            least = min(least, float((self.gaps[own][counts] / spent[counts]).min(initial=inf)))
        return least

    def _other(self, row: int, name: str) -> str:
        first, second = self.names[row]
        return second if first == name else first


@dataclass(frozen=True)
class Lacking:
    """A clearance that is proven, the one that is needed [m], and where, as the rest of a sentence."""

    proven: float
    needed: float
    where: str = ""


class Margins:
    """The proven clearances of a plan; a plan without a certificate proves none.

    Args:
        plan: the plan.
        report: of `kabo.verify` about this plan. With it each body and direction has a tolerance of its own; without
            it, or where the certificate does not hold, there is only the least clearance that the plan states.
    """

    def __init__(self, plan: Plan, report: Report | None = None) -> None:
        self.plan = plan
        certificate = plan.certificate
        self.near = 0.0 if certificate is None else certificate.near or 0.0
        self._segments: dict[tuple[str, int], float] = {}
        for each in () if certificate is None else certificate.segments:
            self._segments[each.node, each.segment] = self.near if each.clearance is None else each.clearance
        checked = None if report is None else report.certificate
        self.gaps = checked.gaps if report is not None and report.ok and checked is not None else None
        self._tolerances: dict[str, Tolerance] = {}
        self._essential: dict[int, tuple[tuple[Array, float], ...]] = {}

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

    def lacking(self, errors: Mapping[str, float]) -> "Lacking | None":
        """Where less clearance is proven than robots may be off their paths; None: nowhere.

        With the report of a check a robot counts where it moves, and only for what it moves nearer to: not where a hand
        alone moves, and two robots that move count with both errors.

        Args:
            errors: of each robot [m].
        """
        greatest = max(errors.values(), default=0.0)
        if self.gaps is None:
            least = self.of_rest(self.plan.root)
            return Lacking(least, greatest) if least < greatest else None
        worst: Lacking | None = None
        for gap in self.gaps:
            needed = sum(errors.get(robot, 0.0) for robot in robots_of(gap))
            if gap.least < needed and (worst is None or gap.least - needed < worst.proven - worst.needed):
                where = f" between {gap.names[0]} and {gap.names[1]} in {gap.node}"
                worst = Lacking(gap.least, needed, where)
        together = sum(sorted(errors.values())[-2:])
        if worst is None and self._rest[self.plan.root] < inf and self.near < together:
            return Lacking(self.near, together)
        return worst

    def require(self, errors: Mapping[str, float]) -> None:
        """Checks that robots have the clearance that they need.

        Args:
            errors: how far each may be off its path [m].

        Raises:
            InputError: less is proven somewhere.
        """
        lacking = self.lacking(errors)
        if lacking is None:
            return
        needed = f"{1000 * lacking.needed:.3g} mm"
        text = f"a clearance of {1000 * lacking.proven:.3g} mm is proven{lacking.where}"
        text += f", and robots are up to {needed} off their paths"
        hint = f"plan with --clearance {ceil(1e4 * lacking.needed) / 10:g}mm, or carry it out --despite-margins"
        raise InputError([Diagnostic("plan", 1, 1, text, hint)])

    # ----------------------------------------------------------------------------------------------- by pair
    def rest(self, node: str) -> Tolerance | None:
        """What may be displaced from a node on, whatever is sensed; None without the report of a check."""
        if self.gaps is None:
            return None
        if node not in self._tolerances:
            rows = [(key, numbers) for key, numbers in self._keys[node].items()]
            self._tolerances[node] = self._made(rows, self._rest[node] < inf)
        return self._tolerances[node]

    def during(self, running: Collection[tuple[str, int]]) -> Tolerance | None:
        """What may be displaced while segments, named by node and number, are followed; None as above."""
        if self.gaps is None:
            return None
        nodes = {node for node, _ in running}
        rows: list[tuple[_Key, Collection[int]]] = []
        for node in sorted(nodes):
            own = {segment for each, segment in running if each == node}
            for number in self._of_node.get(node, ()):
                gap = self.gaps[number]
                if own & set(gap.segments) and (not gap.before or len(nodes) > 1):
                    rows.append(((*gap.names, *self._directed(gap, self.handled[node])), (number,)))
        return self._made(rows, moves=True)

    @cached_property
    def _of_node(self) -> Mapping[str, list[int]]:
        found: dict[str, list[int]] = {}
        for number, gap in enumerate(self.gaps or ()):
            found.setdefault(gap.node, []).append(number)
        return found

    @cached_property
    def handled(self) -> Mapping[str, frozenset[str]]:
        """The bodies that hands hold, take or put down in each node, with all that is attached to them."""
        plan = self.plan
        parents: dict[str, dict[str, set[str]]] = {}
        start = {} if plan.start is None else plan.start.objects
        order = topological_order(plan) or []
        if order:
            parents[order[0]] = {name: {own.parent} for name, own in start.items()}
        found: dict[str, frozenset[str]] = {}
        for name in order:
            node, here = plan.nodes[name], parents[name]
            changed = {} if node.after is None else node.after.objects
            touched = {body for segment in node.motion for body, _ in segment.attach} | set(changed)
            held = {body for body, own in here.items() if any("." in each for each in own)} | touched
            while more := {body for body, own in here.items() if own & held} - held:
                held |= more
            found[name] = frozenset(held)
            after = {body: {changed[body].parent} if body in changed else own for body, own in here.items()}
            for following in node.successors:
                theirs = parents.setdefault(following, {})
                for body, own in after.items():
                    theirs.setdefault(body, set()).update(own)
        return found

    def _directed(self, gap: ProvenGap, handled: Collection[str]) -> tuple[bool, bool]:
        """Of which things the displacement is one vector: bodies that stand, and that the plan says where."""
        known = {} if self.plan.start is None else self.plan.start.objects
        first, second = (
            gap.in_world and hand is None and name in known and name not in handled
            for name, hand in zip(gap.names, gap.hands, strict=True)
        )
        return first, second

    @cached_property
    def _keys(self) -> Mapping[str, Mapping[_Key, frozenset[int]]]:
        """For each node the numbers of the gaps of all nodes from there on; directions count until a body is handled."""
        found: dict[str, dict[_Key, frozenset[int]]] = {}
        for name in reversed(topological_order(self.plan) or []):
            handled = self.handled[name]
            own: dict[_Key, frozenset[int]] = {}
            for number in self._of_node.get(name, ()):
                gap = self.gaps[number]  # type: ignore[index]
                key = (*gap.names, *self._directed(gap, handled))
                own[key] = own.get(key, frozenset()) | {number}
            for after in self.plan.nodes[name].successors:
                for (first, second, a, b), numbers in found[after].items():
                    key = first, second, a and first not in handled, b and second not in handled
                    own[key] = own.get(key, frozenset()) | numbers
            found[name] = own
        return found

    def _claims(self, number: int) -> tuple[tuple[Array, float], ...]:
        """The claims of a gap that count; its least gap along no axis if there are none."""
        gap = (self.gaps or ())[number]
        if number not in self._essential:
            self._essential[number] = essential(gap.claims) if gap.claims else ((np.zeros(3), gap.least),)
        return self._essential[number]

    def _made(self, rows: Iterable[tuple[_Key, Collection[int]]], moves: bool) -> Tolerance:
        gaps = self.gaps or ()
        made: list[tuple[tuple[str, str], str, Array, float, tuple[bool, bool], tuple[str, ...]]] = []
        for (first, second, a, b), numbers in rows:
            for number in sorted(numbers):
                gap = gaps[number]
                claims = self._claims(number) if a or b else ((np.zeros(3), gap.least),)
                directed = (a, b) if gap.claims else (False, False)
                for axis, size in claims:
                    made.append(((first, second), gap.node, axis, size, directed, robots_of(gap)))
        if not made:
            return Tolerance(self.near, moves)
        names, nodes, axes, sizes, directed, robots = zip(*made, strict=True)
        return Tolerance(
            self.near, moves, names, nodes, np.array(axes), np.array(sizes), np.array(directed), robots
        )


def essential(claims: tuple[tuple[Array, float], ...]) -> tuple[tuple[Array, float], ...]:
    """The claims (u, g) that imply all others, for any displacement d with u · d + c <= g and any c >= 0.

    They are the corners of the hull of all u / g and the origin: another u / g is a sum of shares of these, together at
    most 1, so that its g is at least the mean of theirs by these shares; and as |u| = 1, c counts there no less.
    """
    least: dict[bytes, tuple[Array, float]] = {}
    for axis, gap in claims:
        known = least.get(axis.tobytes())
        if known is None or gap < known[1]:
            least[axis.tobytes()] = axis, gap
    claims = tuple(least.values())
    if len(claims) <= FEW_CLAIMS:
        return claims
    points = np.array([axis / gap for axis, gap in claims])
    try:
        kept = ConvexHull(np.vstack([points, np.zeros(3)])).vertices
    except QhullError:  # all in a plane
        return claims
    # What is closer to the hull than rounding is not a corner of it.
    return tuple((claims[k][0], (1.0 - ROUNDING) * claims[k][1]) for k in sorted(kept) if k < len(claims))


def robots_of(gap: ProvenGap) -> tuple[str, ...]:
    """The robots whose tracking errors use up a gap, once for each side that they move."""
    first, second = gap.hands
    return () if first == second else tuple(hand[0] for hand in gap.hands if hand is not None)
