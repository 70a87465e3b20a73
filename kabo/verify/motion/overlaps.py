"""Checks motions that begin before the preceding motion has ended, and proves that the bodies of both never meet.

Every moment of the last `overlap` seconds of the preceding motion is proven apart from every moment of the motion
that begins early, so that a delay of either motion does no harm.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from kabo.arrays import Array
from kabo.plan import Node, Plan
from kabo.verify.motion.scene_model import SceneModel
from kabo.verify.motion.surfaces import hull_depth, hull_gap, mesh_distance
from kabo.verify.motion.sweep import (
    CONTACT_DISTANCE,
    MIN_STEP_SHARE,
    Contact,
    Pair,
    Path,
    SweptBody,
    stations,
    weights,
)
from kabo.verify.motion.windows import rest_of
from kabo.verify.report import Finding

OVERLAP_TOLERANCE = 2e-6  # [s] by which rounded times may exceed a bound


@dataclass(frozen=True)
class Sweep:
    """The bodies that move along a path, and the indices of the segments that run meanwhile."""

    path: Path
    things: Sequence[SweptBody]
    segments: tuple[int, ...] = ()

    def since(self, time: float) -> "Sweep | None":
        """The part of the sweep after a time [s]; None if the sweep has ended by this time."""
        if self.path.times[-1] <= time:
            return None
        if self.path.times[0] >= time:
            return self
        return Sweep(rest_of(self.path, time), self.things, self.segments)


@dataclass(frozen=True)
class Meeting:
    """Two sweeps that may run at the same time, at any offset; the second is of `node`, which begins early."""

    node: str
    first: Sweep
    second: Sweep


@dataclass(frozen=True)
class Motion:
    """A checked motion: its sweeps, and the objects that it moves or that its call names."""

    sweeps: Sequence[Sweep]
    moved: frozenset[str]
    named: frozenset[str]


def duration(node: Node) -> float:
    """The duration of a node's motion [s]."""
    return max((segment.times[-1] for segment in node.motion), default=0.0)


def sharing_time(plan: Plan) -> set[str]:
    """The ids of the nodes that begin early, and of the nodes directly before them."""
    early = {name for name, node in plan.nodes.items() if node.overlap > 0.0}
    return early | {name for name, node in plan.nodes.items() if early & set(node.successors)}


def all_meetings(plan: Plan, order: Sequence[str], motions: Mapping[str, Motion]) -> list[Meeting]:
    """The meetings of all nodes that begin early and whose motion and preceding motion were both checked."""
    found = []
    for name in order:
        before = [other for other in order if name in plan.nodes[other].successors]
        if plan.nodes[name].overlap > 0.0 and name in motions and len(before) == 1 and before[0] in motions:
            found += meetings(plan, name, before[0], motions)
    return found


def check_overlaps(
    plan: Plan, order: Sequence[str], motions: Mapping[str, Motion], world: SceneModel
) -> Iterator[Finding]:
    """The findings about motions that begin early.

    Args:
        plan: the plan.
        order: the ids of its nodes.
        motions: the checked motions, by id, of the nodes that `sharing_time` returns.
        world: the scene.
    """
    for name in order:
        if plan.nodes[name].overlap > 0.0:
            before = [other for other in order if name in plan.nodes[other].successors]
            wrong = list(_check_times(plan, name, before))
            yield from wrong
            if not wrong and name in motions and before[0] in motions:
                yield from _check_apart(name, plan, before[0], motions, world)


def _check_times(plan: Plan, name: str, before: Sequence[str]) -> Iterator[Finding]:
    node = plan.nodes[name]
    if len(before) != 1 or plan.nodes[before[0]].next != name:
        yield Finding(name, "begins early, but not after exactly one node that goes on with it alone")
        return
    first = plan.nodes[before[0]]
    if not node.motion or not first.motion:
        yield Finding(name, f"begins before {before[0]} has ended, but one of the two does not move")
        return
    for other, lasts in ((before[0], duration(first)), (name, duration(node))):
        if node.overlap > lasts + OVERLAP_TOLERANCE:
            text = f"begins {node.overlap:g} s before {before[0]} ends, but {other} lasts {lasts:g} s only"
            yield Finding(name, text)
    if first.overlap > 0.0 and first.overlap + node.overlap > duration(first) + OVERLAP_TOLERANCE:
        yield Finding(name, f"begins before what comes before {before[0]} has ended")


def _check_apart(
    name: str, plan: Plan, before: str, motions: Mapping[str, Motion], world: SceneModel
) -> Iterator[Finding]:
    first, second = motions[before], motions[name]
    robots = {r for s in first.sweeps for r in s.path.arms} & {r for s in second.sweeps for r in s.path.arms}
    objects = first.moved & (second.moved | second.named) | second.moved & first.named
    for shared in sorted(robots | objects):
        yield Finding(name, f"begins before {before} has ended, but both move or use {shared}", bodies=(shared,))
    if robots:
        return
    told: set[tuple[str, str]] = set()
    for meeting in meetings(plan, name, before, motions):
        for pair, contact in _contacts(meeting.first, meeting.second, world):
            if pair not in told:
                told.add(pair)
                text = f"{pair[0]} and {pair[1]} can meet, as it begins before {before} has ended"
                yield Finding(name, text, contact.time, pair, contact.depth)


def meetings(plan: Plan, name: str, before: str, motions: Mapping[str, Motion]) -> list[Meeting]:
    """The pairs of one sweep of the node `before` and one of the node `name` that may run at the same time."""
    begin = duration(plan.nodes[before]) - plan.nodes[name].overlap
    tails = [tail for tail in (sweep.since(begin) for sweep in motions[before].sweeps) if tail is not None]
    return [Meeting(name, tail, sweep) for tail in tails for sweep in motions[name].sweeps]


def _contacts(first: Sweep, second: Sweep, world: SceneModel) -> Iterator[tuple[tuple[str, str], Contact]]:
    """The pairs of bodies, one of each sweep, that are not proven apart, and the time in the second sweep."""
    balls = [[_balls(sweep.path, thing) for thing in sweep.things] for sweep in (first, second)]
    for i, a in enumerate(first.things):
        for j, b in enumerate(second.things):
            if not world.may_meet(a.name, b.name):
                continue
            (centres, radius), (others, other_radius) = balls[0][i], balls[1][j]
            gaps = np.linalg.norm(centres[:, None] - others[None], axis=2) - radius - other_radius
            contact = (
                None if gaps.min() > CONTACT_DISTANCE else _meeting(_alone(first.path, a), _alone(second.path, b))
            )
            if contact is not None:
                yield (a.name, b.name), contact


def _alone(path: Path, thing: SweptBody) -> Pair:
    """A body along its path, with bounds of its own motion, whatever the other body."""
    still = SweptBody("", thing.surface, np.eye(4))
    return Pair(path, thing, still, weights(path, thing, still))


def _balls(path: Path, thing: SweptBody) -> tuple[Array, float]:
    """The centres (k, 3) and common radius of balls that cover a body along the whole path."""
    alone = _alone(path, thing)
    steps = stations(path, np.diff(alone.ends))
    s = np.array([alone.ends[k] + share * (alone.ends[k + 1] - alone.ends[k]) for k, share in steps])
    poses = np.array([thing.pose(path.poses(*place)) for place in steps])
    centres = poses[:, :3, :3] @ thing.surface.centre + poses[:, :3, 3]
    away = float(np.diff(s, append=s[-1]).max()) / 2 + float(alone.strays.max())
    return centres, thing.surface.radius + away + 1e-9


def _meeting(first: Pair, second: Pair) -> Contact | None:
    """The contact that two bodies may have, each anywhere on its path; None if they are proven apart."""
    known: list[dict[float, Array]] = [{}, {}]

    def pose(which: int, s: float) -> Array:
        if s not in known[which]:
            known[which][s] = (first, second)[which].poses(s)[0]
        return known[which][s]

    shortest, exact = MIN_STEP_SHARE * (first.length + second.length), first.path.exact and second.path.exact
    stack = [(0.0, first.length, 0.0, second.length)]
    while stack:
        s0, s1, t0, t1 = stack.pop()
        s, t, half = (s0 + s1) / 2, (t0 + t1) / 2, (s1 - s0 + t1 - t0) / 2
        a, b = (first.first.surface, pose(0, s)), (second.first.surface, pose(1, t))
        stray = 0.0 if exact else first.stray(s0, s1) + second.stray(t0, t1)
        distance = hull_gap(*a, *b)
        if distance <= half + stray:
            distance = max(distance, mesh_distance(*a, *b))
        if distance > half + stray:
            continue
        if distance <= CONTACT_DISTANCE or half < shortest:
            time = second.path.time(*second.place(t))
            near = None if distance <= CONTACT_DISTANCE else distance
            return Contact(time, near, hull_depth(*a, *b), stray=stray)
        if s1 - s0 > t1 - t0:
            stack += [(s, s1, t0, t1), (s0, s, t0, t1)]
        else:
            stack += [(s0, s1, t, t1), (s0, s1, t0, t)]
    return None
