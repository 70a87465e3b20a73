"""Plans that are wrong by construction, made from right ones: one kind of fault each, of a strength that is drawn.

Why a mutant is wrong is said by its kind and rests on the scene's files alone, not on anything that verification measures.
Way points off a line are found by an inverse kinematics of their own, and are accepted only if they are where they should.
"""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from kabo.arrays import Array
from kabo.language.problem import Problem
from kabo.plan import Plan, Segment
from kabo.scene import Scene, link_pose, load_scene


@dataclass(frozen=True)
class Mutant:
    """A problem and a plan, one of which was spoilt."""

    kind: str
    problem: Problem
    plan: Plan


@dataclass
class Case:
    """A right plan and its scene; `strokes`: node, number of a segment, the last part of its stage's name."""

    problem: Problem
    plan: Plan
    scene: Scene = field(init=False)

    def __post_init__(self) -> None:
        assert self.problem.scene is not None
        self.scene = load_scene(self.problem.scene)

    @property
    def strokes(self) -> list[tuple[str, int, str]]:
        """All segments with what they are for."""
        return [(n, i, str(s.stage).split("/")[-1]) for n, i, s in self.segments()]

    def segments(self) -> Iterator[tuple[str, int, Segment]]:
        """All segments with their nodes."""
        for name, node in self.plan.nodes.items():
            for i, segment in enumerate(node.motion):
                yield name, i, segment

    def with_node(self, name: str, **changes) -> Plan:
        """The plan with a node changed."""
        return replace(self.plan, nodes={**self.plan.nodes, name: replace(self.plan.nodes[name], **changes)})

    def with_segments(self, name: str, changed: dict[int, Segment]) -> Plan:
        """The plan with some segments of a node changed."""
        motion = tuple(changed.get(i, s) for i, s in enumerate(self.plan.nodes[name].motion))
        return self.with_node(name, motion=motion)

    def with_scene(self, **changes) -> Problem:
        """The problem with its scene changed, as if the file said so."""
        assert self.problem.scene is not None
        return replace(self.problem, scene=replace(self.problem.scene, **changes))


Mutation = Callable[[Case, np.random.Generator], "Mutant | None"]
MUTATIONS: dict[str, Mutation] = {}


def mutation(
    made: Callable[[Case, np.random.Generator], "tuple[Problem, Plan] | Plan | Problem | None"],
) -> Mutation:
    """Registers a kind by the name of its function."""
    kind = made.__name__.replace("_", " ")

    def mutate(case: Case, rng: np.random.Generator) -> Mutant | None:
        found = made(case, rng)
        if found is None:
            return None
        problem, plan = (
            found
            if isinstance(found, tuple)
            else (case.problem, found)
            if isinstance(found, Plan)
            else (found, case.plan)
        )
        if plan.certificate is case.plan.certificate:
            plan = replace(plan, certificate=None)  # which would be wrong for another reason, too
        if _stale(plan, case.plan):
            plan = without_trajectories(plan)  # which would be wrong for another reason, too
        return Mutant(kind, problem, plan)

    MUTATIONS[kind] = mutate
    return mutate


def _stale(plan: Plan, original: Plan) -> bool:
    """Whether a segment was changed whose trajectory was not."""
    known = {id(s.trajectory) for node in original.nodes.values() for s in node.motion}
    for segment in (s for node in plan.nodes.values() for s in node.motion if s.trajectory is not None):
        own = segment.trajectory
        elsewhere = own.waypoints != segment.waypoints or own.joints != segment.joints
        later = (own.times[0], own.times[-1]) != (segment.times[0], segment.times[-1])
        if elsewhere or later and id(own) in known:
            return True
    return False


def without_trajectories(plan: Plan) -> Plan:
    """The plan as the old format has it: its way points at their times alone."""
    nodes = {
        name: replace(node, motion=tuple(replace(s, trajectory=None) for s in node.motion))
        for name, node in plan.nodes.items()
    }
    return replace(plan, nodes=nodes)


def pick(rng: np.random.Generator, things: Sequence):
    """One of several; None of none."""
    return things[int(rng.integers(len(things)))] if len(things) else None


def a_stroke(case: Case, rng: np.random.Generator, *kinds: str) -> tuple[str, int, Segment] | None:
    """A segment whose stage is one of these."""
    found = pick(rng, [(name, i) for name, i, kind in case.strokes if kind in kinds])
    return None if found is None else (*found, case.plan.nodes[found[0]].motion[found[1]])


# ----------------------------------------------------------------------------------------------- way points off a line
def tool_pose(case: Case, segment: Segment, row: Sequence[float]) -> Array:
    """Where the tool of a segment's robot is (4, 4); its hand does not matter."""
    robot = case.scene.robots[segment.robot]
    q = np.zeros(len(robot.joint_names))
    q[[robot.joint_names.index(joint) for joint in segment.joints]] = row
    assert robot.tool is not None
    return np.asarray(link_pose(robot, tuple(q), robot.tool.frame))


def moved_row(case: Case, segment: Segment, row: Sequence[float], shift: Array) -> tuple[float, ...] | None:
    """The row near another one with the tool moved by `shift` (3,) [m] and, where the arm can, not turned."""
    start, q = tool_pose(case, segment, row), np.array(row)
    goal = start[:3, 3] + shift

    def off(values: Array) -> Array:
        pose = tool_pose(case, segment, values)
        turned = pose[:3, :3] @ start[:3, :3].T
        axis = [turned[2, 1] - turned[1, 2], turned[0, 2] - turned[2, 0], turned[1, 0] - turned[0, 1]]
        return np.concatenate([pose[:3, 3] - goal, 0.2 * np.array(axis)])

    for _ in range(60):
        error = off(q)
        if np.abs(error[:3]).max() < 1e-7:
            return tuple(round(float(v), 9) for v in q)
        jacobian = np.array([(off(q + step) - error) / 1e-6 for step in 1e-6 * np.eye(len(q))]).T
        q = q - np.linalg.lstsq(jacobian, error, rcond=1e-4)[0]
        if np.abs(q - row).max() > 1.0:
            return None
    return None


def near_first(segment: Segment, kind: str) -> list[tuple[float, ...]]:
    """The way points from the end that is near to what is taken, let go or stands."""
    rows = list(segment.waypoints)
    return rows[::-1] if kind in ("approach", "lower", "insertion") else rows


def rebuilt(case: Case, name: str, i: int, kind: str, rows: Sequence[Sequence[float]]) -> Plan:
    """The plan with a segment through other way points, given from its near end."""
    return through(case, name, {i: list(rows)[::-1] if kind in ("approach", "lower", "insertion") else list(rows)})


def through(case: Case, name: str, rows: dict[int, list[Sequence[float]]]) -> Plan:
    """The plan with other way points of some segments, at a third of the limits; what comes later is put off."""
    motion, late = [], 0.0
    for i, segment in enumerate(case.plan.nodes[name].motion):
        start, times = segment.times[0] + late, [t + late for t in segment.times]
        if i in rows:
            robot = case.scene.robots[segment.robot]
            limits = robot.tree.velocity[[robot.joint_names.index(joint) for joint in segment.joints]]
            steps = np.abs(np.diff(np.array(rows[i]), axis=0)) / limits
            times = [start, *(start + np.cumsum(np.maximum(0.02, 3.0 * steps.max(axis=1))))]
            late += float(times[-1]) - late - segment.times[-1]
            segment = replace(segment, waypoints=tuple(tuple(map(float, row)) for row in rows[i]))
        motion.append(replace(segment, times=tuple(round(float(t), 6) for t in times)))
    return case.with_node(name, motion=tuple(motion))


def detour(case: Case, rng: np.random.Generator, kinds: Sequence[str], shifts: Sequence[Array]) -> Plan | None:
    """A stroke that first takes the tool elsewhere from its near end: each shift is from there [m]."""
    found = a_stroke(case, rng, *kinds)
    if found is None:
        return None
    name, i, segment = found
    kind = str(segment.stage).split("/")[-1]
    rows = near_first(segment, kind)
    added: list[tuple[float, ...]] = []
    for shift in shifts:
        row = moved_row(case, segment, (added or rows)[-1 if added else 0], shift)
        if row is None:
            return None
        added.append(row)
    return rebuilt(case, name, i, kind, [rows[0], *added, *rows[1:]])


def sideways(rng: np.random.Generator, low: float, high: float) -> Array:
    """A horizontal vector of a length that is drawn."""
    angle = rng.uniform(0.0, 2.0 * np.pi)
    return rng.uniform(low, high) * np.array([np.cos(angle), np.sin(angle), 0.0])
