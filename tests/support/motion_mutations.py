"""Plans and scenes that are spoilt at random, from right ones: most of what comes out collides, not all.

Every mutation is drawn from a generator of its own, by a seed and a number, and says which nodes it spoils.
"""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field, replace
from itertools import pairwise

import numpy as np

from kabo.language.problem import Problem
from kabo.language.scene_description import BodyDescription, PoseDescription, Shape
from kabo.plan import Node, ObjectPose, Plan, Segment
from kabo.scene import Scene, load_scene
from tests.support.oracles_motions import Judge, Moment, replay_of, states_of


@dataclass(frozen=True)
class Mutant:
    """A problem and a plan, one of them spoilt at these nodes."""

    kind: str
    problem: Problem
    plan: Plan
    nodes: tuple[str, ...]


@dataclass
class Case:
    """A right plan, and what is worked out about it once."""

    name: str
    problem: Problem
    plan: Plan
    known: dict[str, list[Moment]] = field(default_factory=dict)

    def __post_init__(self) -> None:
        assert self.problem.scene is not None
        self.scene: Scene = load_scene(self.problem.scene)
        self.states = states_of(self.plan, self.scene)
        self.judge = Judge(self.scene)
        self.moving = [name for name, node in self.plan.nodes.items() if node.motion]

    def moments(self, node: str) -> list[Moment]:
        """The moments of a motion, in one state."""
        if node not in self.known:
            self.known[node] = list(replay_of(self.scene, self.states[node][0], self.plan.nodes[node]).moments())
        return self.known[node]

    def with_node(self, name: str, node: Node) -> Plan:
        """The plan with another node."""
        return replace(self.plan, nodes={**self.plan.nodes, name: node})


Mutation = Callable[[Case, np.random.Generator], Mutant | None]


def _pick(rng: np.random.Generator, things: Sequence):
    return things[int(rng.integers(len(things)))] if things else None


def _place(case: Case, rng: np.random.Generator, node: str) -> tuple[str, np.ndarray]:
    """Something that moves in a node, and a place at or near where it comes by."""
    moment = _pick(rng, case.moments(node))
    names = sorted(name for name in moment.moving if name in case.judge.objects)
    name = _pick(rng, names)
    pose, middle = moment.poses[name], case.judge.centres[case.judge.names.index(name)]
    return name, pose[:3, :3] @ middle + pose[:3, 3] + rng.normal(0.0, 0.03, 3)


def _turned(rng: np.random.Generator) -> tuple[float, float, float, float]:
    angle = rng.uniform(0, np.pi) / 2
    return (0.0, 0.0, float(np.sin(angle)), float(np.cos(angle)))


def _obstacle(case: Case, rng: np.random.Generator, size: Sequence[float], node: str) -> tuple[str, Problem]:
    thing, place = _place(case, rng, node)
    pose = PoseDescription(position=tuple(map(float, place)), quaternion=_turned(rng))
    body = BodyDescription("obstacle", Shape("box", size=tuple(map(float, size))), pose, movable=False)
    assert case.problem.scene is not None
    scene = replace(case.problem.scene, bodies={**case.problem.scene.bodies, "obstacle": body})
    return thing, replace(case.problem, scene=scene)


def obstacle(case: Case, rng: np.random.Generator) -> Mutant:
    """A block where something comes by."""
    node = _pick(rng, case.moving)
    _, problem = _obstacle(case, rng, rng.uniform(0.01, 0.08, 3), node)
    return Mutant("obstacle", problem, case.plan, (node,))


def thin_obstacle(case: Case, rng: np.random.Generator) -> Mutant:
    """A plate of 1 mm where something comes by."""
    node = _pick(rng, case.moving)
    _, problem = _obstacle(case, rng, rng.permutation([0.001, 0.1, 0.1]), node)
    return Mutant("thin obstacle", problem, case.plan, (node,))


def permitted_obstacle(case: Case, rng: np.random.Generator) -> Mutant:
    """A block in the way, with contacts of all that moves permitted in the plan."""
    node = _pick(rng, case.moving)
    _, problem = _obstacle(case, rng, rng.uniform(0.03, 0.08, 3), node)
    moving = sorted({name for moment in case.moments(node) for name in moment.moving})
    return Mutant("contacts permitted", problem, _permitting(case, node, moving, ("obstacle",)), (node,))


def _permitting(case: Case, name: str, first: Sequence[str], second: Sequence[str]) -> Plan:
    more = tuple((a, b) for a in first for b in second)
    node = case.plan.nodes[name]
    motion = tuple(replace(s, allowed_contacts=(*s.allowed_contacts, *more)) for s in node.motion)
    return case.with_node(name, replace(node, motion=motion))


def _arm_segment(case: Case, rng: np.random.Generator) -> tuple[str, int] | None:
    """A segment of an arm that moves."""
    found = [
        (name, i)
        for name in case.moving
        for i, s in enumerate(case.plan.nodes[name].motion)
        if s.joints == case.scene.robots[s.robot].planned_joints and s.waypoints[0] != s.waypoints[-1]
    ]
    return _pick(rng, found)


def _with_segment(case: Case, name: str, index: int, segment: Segment) -> Plan:
    motion = list(case.plan.nodes[name].motion)
    motion[index] = segment
    return case.with_node(name, replace(case.plan.nodes[name], motion=tuple(motion)))


def way_point(case: Case, rng: np.random.Generator) -> Mutant | None:
    """A way point elsewhere, or a new one half-way."""
    found = _arm_segment(case, rng)
    if found is None:
        return None
    name, i = found
    segment = case.plan.nodes[name].motion[i]
    rows, times = [list(row) for row in segment.waypoints], list(segment.times)
    if len(rows) == 2:
        rows.insert(1, [(a + b) / 2 for a, b in zip(*rows, strict=True)])
        times.insert(1, round((times[0] + times[1]) / 2, 6))
    k = int(rng.integers(1, len(rows) - 1))
    rows[k] = [float(v) for v in np.array(rows[k]) + rng.normal(0.0, rng.choice([0.05, 0.2, 0.6]), len(rows[k]))]
    moved = replace(segment, waypoints=tuple(map(tuple, rows)), times=tuple(times))
    return Mutant("way point moved", case.problem, _with_segment(case, name, i, moved), (name,))


def short_cut(case: Case, rng: np.random.Generator) -> Mutant | None:
    """Straight from the beginning of one segment to the end of a later one of the same arm."""
    found = _arm_segment(case, rng)
    if found is None:
        return None
    name, i = found
    segment = case.plan.nodes[name].motion[i]
    straight = replace(
        segment,
        waypoints=(segment.waypoints[0], segment.waypoints[-1]),
        times=(segment.times[0], segment.times[-1]),
    )
    return Mutant("way points left out", case.problem, _with_segment(case, name, i, straight), (name,))


def backward(case: Case, rng: np.random.Generator) -> Mutant | None:
    """A segment's way points in the order of time reversed."""
    found = _arm_segment(case, rng)
    if found is None:
        return None
    name, i = found
    segment = case.plan.nodes[name].motion[i]
    turned = replace(segment, waypoints=segment.waypoints[::-1])
    return Mutant("time reversed", case.problem, _with_segment(case, name, i, turned), (name,))


def displaced(case: Case, rng: np.random.Generator) -> Mutant | None:
    """An object stands where something comes by before it is touched itself."""
    options = []
    for name in case.moving:
        moved = {thing for moment in case.moments(name) for thing in moment.moving}
        state = case.states[name][0]
        for thing, where in state.objects.items():
            alone = all(other.parent != thing for other in state.objects.values())
            if thing not in moved and alone and where == case.scene.start.objects[thing]:
                options.append((name, thing))
    found = _pick(rng, options)
    if found is None:
        return None
    name, thing = found
    _, place = _place(case, rng, name)
    return Mutant("object displaced", *_moved_object(case, thing, place), (name,))


def _moved_object(case: Case, thing: str, place: np.ndarray) -> tuple[Problem, Plan]:
    start, scene = case.plan.start, case.problem.scene
    assert start is not None and scene is not None
    where = tuple(round(float(v), 9) for v in place)
    quaternion = (0.0, 0.0, 0.0, 1.0)
    body = replace(scene.bodies[thing], pose=PoseDescription(position=where, quaternion=quaternion))
    objects = {**start.objects, thing: ObjectPose("world", where, quaternion)}
    problem = replace(case.problem, scene=replace(scene, bodies={**scene.bodies, thing: body}))
    return problem, replace(case.plan, start=replace(start, objects=objects))


def base_moved(case: Case, rng: np.random.Generator) -> Mutant | None:
    """A robot's base stands elsewhere than when the plan was made."""
    scene = case.problem.scene
    assert scene is not None
    robot = _pick(rng, sorted({s.robot for name in case.moving for s in case.plan.nodes[name].motion}))
    base = scene.robots[robot].base
    shift = rng.normal(0.0, rng.choice([0.02, 0.06]), 3)
    moved = replace(base, position=tuple(float(a + b) for a, b in zip(base.position, shift, strict=True)))
    robots = {**scene.robots, robot: replace(scene.robots[robot], base=moved)}
    nodes = [n for n in case.moving if any(s.robot == robot for s in case.plan.nodes[n].motion)]
    problem = replace(case.problem, scene=replace(scene, robots=robots))
    return Mutant("base moved", problem, case.plan, (_pick(rng, nodes),))


def closed_early(case: Case, rng: np.random.Generator) -> Mutant | None:
    """The hand closes, and has the object, before the arm goes there."""
    found = [
        (name, i)
        for name in case.moving
        for i, (before, s) in enumerate(pairwise(case.plan.nodes[name].motion))
        if s.joints == case.scene.robots[s.robot].gripper_joints
        and before.robot == s.robot
        and before.joints != s.joints
        and s.waypoints[0] != s.waypoints[-1]
    ]
    chosen = _pick(rng, found)
    if chosen is None:
        return None
    name, i = chosen
    motion = list(case.plan.nodes[name].motion)
    arm, hand = motion[i], motion[i + 1]
    begin, shut = arm.times[0], hand.times[-1] - hand.times[0]
    first = replace(hand, times=_from(hand, begin), attach=(), detach=())
    second = replace(arm, times=_from(arm, begin + shut), attach=hand.attach, detach=hand.detach)
    motion[i : i + 2] = [first, second]
    return Mutant(
        "hand moves early",
        case.problem,
        case.with_node(name, replace(case.plan.nodes[name], motion=tuple(motion))),
        (name,),
    )


def _from(segment: Segment, begin: float) -> tuple[float, ...]:
    return tuple(round(t - segment.times[0] + begin, 6) for t in segment.times)


def attachment(case: Case, rng: np.random.Generator) -> Mutant | None:
    """What is taken or let go is not, or by a segment that comes earlier."""
    found = [
        (name, i)
        for name in case.moving
        for i, s in enumerate(case.plan.nodes[name].motion)
        if s.attach or s.detach
    ]
    chosen = _pick(rng, found)
    if chosen is None:
        return None
    name, i = chosen
    motion = list(case.plan.nodes[name].motion)
    attach, detach = motion[i].attach, motion[i].detach
    motion[i] = replace(motion[i], attach=(), detach=())
    if rng.random() < 0.7:
        earlier = [k for k in range(i) if motion[k].robot == motion[i].robot]
        k = _pick(rng, earlier)
        if k is not None:
            motion[k] = replace(motion[k], attach=attach, detach=detach)
    return Mutant(
        "attachment changed",
        case.problem,
        case.with_node(name, replace(case.plan.nodes[name], motion=tuple(motion))),
        (name,),
    )


def at_once(case: Case, rng: np.random.Generator) -> Mutant | None:
    """Two arms that moved one after the other move at the same time."""
    found = [
        (name, i, k)
        for name in case.moving
        for i, s in enumerate(case.plan.nodes[name].motion)
        for k, t in enumerate(case.plan.nodes[name].motion)
        if k > i and s.robot != t.robot and len(s.joints) == len(t.joints) > 2
    ]
    chosen = _pick(rng, found)
    if chosen is None:
        return None
    name, i, k = chosen
    motion = list(case.plan.nodes[name].motion)
    motion[k] = replace(motion[k], times=_from(motion[k], motion[i].times[0]))
    return Mutant(
        "arms at once",
        case.problem,
        case.with_node(name, replace(case.plan.nodes[name], motion=tuple(motion))),
        (name,),
    )


def widened(case: Case, rng: np.random.Generator) -> Mutant | None:
    """A way point elsewhere, and contacts with everything permitted."""
    made = way_point(case, rng)
    if made is None:
        return None
    name = made.nodes[0]
    spoilt = replace(case, plan=made.plan)
    moving = sorted({thing for moment in case.moments(name) for thing in moment.moving})
    still = sorted(set(case.scene.bodies) - set(moving))
    return Mutant("contacts widened", case.problem, _permitting(spoilt, name, moving, still), made.nodes)


MUTATIONS: tuple[Mutation, ...] = (
    obstacle,
    thin_obstacle,
    permitted_obstacle,
    way_point,
    short_cut,
    backward,
    displaced,
    base_moved,
    closed_early,
    attachment,
    at_once,
    widened,
)


def mutants(case: Case, seed: int) -> Iterator[Mutant]:
    """Mutants of a case without end; equal seeds give equal ones."""
    number = 0
    while True:
        for which, mutation in enumerate(MUTATIONS):
            made = mutation(case, np.random.default_rng((seed, number, which)))
            if made is not None:
                yield made
        number += 1
