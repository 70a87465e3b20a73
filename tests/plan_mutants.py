"""Plans that are wrong by construction, made from right ones: one kind of fault each, of a strength that is drawn.

Why a mutant is wrong is said by its kind and rests on the scene's files alone, not on anything that verification measures.
Way points off a line are found by an inverse kinematics of their own, and are accepted only if they are where they should.
"""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field, replace
from itertools import count

import numpy as np

from kabo.language.problem import Problem
from kabo.language.scene_description import BodyDescription, FeatureName, Mate, Stroke
from kabo.plan import Grant, ObjectPose, Plan, Segment
from kabo.scene import Scene, link_poses, load_scene

Array = np.ndarray


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
        return Mutant(kind, problem, plan)

    MUTATIONS[kind] = mutate
    return mutate


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
    return np.asarray(link_poses(robot, tuple(q))[robot.tool.frame])


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


# ------------------------------------------------------------------------------------------------------------- supports
@mutation
def pushed_into_its_support_and_dragged(case, rng):
    """What is lifted is pushed down first and moved aside there: it was in contact, so it goes into its support."""
    down = np.array([0.0, 0.0, -rng.uniform(0.3e-3, 1.9e-3)])
    return detour(case, rng, ("lift",), [down, sideways(rng, 0.05, 0.2)])


@mutation
def lowered_too_deep_and_raised(case, rng):
    """What is put down goes below where it ends to stand."""
    return detour(case, rng, ("lower",), [np.array([0.0, 0.0, -rng.uniform(0.2e-3, 1.9e-3)])])


@mutation
def dragged_over_its_support(case, rng):
    """What is lifted slides before it rises: contact where it does not stand."""
    return detour(case, rng, ("lift",), [sideways(rng, 0.02, 0.1)])


@mutation
def dragged_to_its_place(case, rng):
    """What is put down slides to where it ends."""
    return detour(case, rng, ("lower",), [sideways(rng, 0.02, 0.1)])


@mutation
def pushed_down_before_it_rises(case, rng):
    """Straight down and up again."""
    return detour(case, rng, ("lift",), [np.array([0.0, 0.0, -rng.uniform(0.2e-3, 1.9e-3)])])


@mutation
def another_body_as_support(case, rng):
    """The plan says that the object stands on something else, where it does not touch."""
    found = a_stroke(case, rng, "lift", "lower")
    if found is None:
        return None
    name, i, segment = found
    chosen = [g for g in segment.grants if g.kind == "support"]
    if not chosen:
        return None
    grant = pick(rng, chosen)
    standing = [b for b in case.scene.bodies if b not in grant.bodies and b not in case.scene.movable]
    other = pick(rng, standing) or "nothing"
    made = replace(grant, bodies=(grant.bodies[0], other))
    contacts = tuple(p for p in segment.allowed_contacts if set(p) != set(grant.bodies)) + (made.bodies,)
    grants = tuple(made if g == grant else g for g in segment.grants)
    return case.with_segments(name, {i: replace(segment, allowed_contacts=contacts, grants=grants)})


@mutation
def support_permitted_on_the_way(case, rng):
    """Contact with the support is permitted all along the way there, where the object does not stand."""
    found = a_stroke(case, rng, "lower")
    if found is None or found[1] == 0:
        return None
    name, i, segment = found
    grants = [g for g in segment.grants if g.kind == "support"]
    before = case.plan.nodes[name].motion[i - 1]
    more = replace(
        before,
        allowed_contacts=(*before.allowed_contacts, *(g.bodies for g in grants)),
        grants=(*before.grants, *grants),
    )
    return case.with_segments(name, {i - 1: more})


# ------------------------------------------------------------------------------------------------------------- statements
def with_grant(
    case: Case, rng: np.random.Generator, kind: str, change: Callable[[Grant], Grant | None]
) -> Plan | None:
    """The plan with one of its statements of a kind changed, or without it."""
    found = pick(rng, [(n, i, s) for n, i, s in case.segments() if any(g.kind == kind for g in s.grants)])
    if found is None:
        return None
    name, i, segment = found
    grant = pick(rng, [g for g in segment.grants if g.kind == kind])
    made = change(grant)
    grants = tuple(g if g != grant else made for g in segment.grants)
    return case.with_segments(name, {i: replace(segment, grants=tuple(g for g in grants if g is not None))})


@mutation
def a_contact_that_nothing_grants(case, rng):
    """The statement is missing."""
    return with_grant(case, rng, str(rng.choice(["grasp", "support"])), lambda grant: None)


@mutation
def a_support_of_no_such_family(case, rng):
    """The family does not exist."""
    return with_grant(case, rng, "support", lambda grant: replace(grant, by=f"family_{rng.integers(99)}"))


@mutation
def a_grasp_of_no_such_family(case, rng):
    """The family does not exist."""
    return with_grant(case, rng, "grasp", lambda grant: replace(grant, by=f"family_{rng.integers(99)}"))


@mutation
def a_grasp_of_no_family(case, rng):
    """There is a family that says how the object is held."""
    return with_grant(case, rng, "grasp", lambda grant: replace(grant, by=None))


@mutation
def a_support_by_no_family(case, rng):
    """There is a family that says how the object is lifted."""
    return with_grant(case, rng, "support", lambda grant: replace(grant, by=None))


@mutation
def a_support_called_a_mate(case, rng):
    """No mate puts an object and its support together."""
    return with_grant(case, rng, "support", lambda grant: replace(grant, kind="mate"))


@mutation
def a_support_called_a_grasp(case, rng):
    """A support is no finger."""
    return with_grant(case, rng, "support", lambda grant: replace(grant, kind="grasp", bodies=grant.bodies[::-1]))


@mutation
def a_grasp_by_another_link(case, rng):
    """A link of the arm that is no finger may touch what is held."""
    robots = case.scene.robots

    def change(grant):
        robot = grant.bodies[0].partition(".")[0]
        links = [name for name in robots[robot].links if name not in ("left_finger", "right_finger")]
        return replace(grant, bodies=(f"{robot}.{pick(rng, links)}", grant.bodies[1]))

    return with_grant(case, rng, "grasp", change)


@mutation
def a_grasp_of_what_is_not_held(case, rng):
    """A hand that closes on one object is said to grasp another one, too."""
    found = a_stroke(case, rng, "close", "open")
    if found is None or len(case.scene.movable) < 2:
        return None
    name, i, segment = found
    held = {g.bodies[1] for g in segment.grants}
    other = pick(rng, [body for body in case.scene.movable if body not in held])
    more = [(g.bodies[0], other) for g in segment.grants if g.kind == "grasp"]
    if not more:
        return None
    grants = tuple(Grant("grasp", pair, segment.grants[0].by) for pair in more)
    made = replace(segment, allowed_contacts=(*segment.allowed_contacts, *more), grants=(*segment.grants, *grants))
    return case.with_segments(name, {i: made})


@mutation
def contact_of_an_arm_permitted(case, rng):
    """A link of the arm may touch a body that stands."""
    found = pick(rng, [(n, i, s) for n, i, s in case.segments() if len(s.joints) > 2])
    name, i, segment = found
    links = [f"{segment.robot}.{link}" for link in case.scene.robots[segment.robot].links]
    pairs = [(a, b) for a in links for b in case.scene.bodies if not case.scene.never_collide(a, b)]
    pair = pick(rng, [p for p in pairs if p not in segment.allowed_contacts])
    return case.with_segments(name, {i: replace(segment, allowed_contacts=(*segment.allowed_contacts, pair))})


# -------------------------------------------------------------------------------------------------------------- strokes
def bent(case: Case, rng: np.random.Generator, *kinds: str) -> Plan | None:
    """A stroke that goes aside in its straight part, and back to its line."""
    found = a_stroke(case, rng, *kinds)
    if found is None:
        return None
    name, i, segment = found
    kind = str(segment.stage).split("/")[-1]
    rows = near_first(segment, kind)
    start, end = tool_pose(case, segment, rows[0])[:3, 3], tool_pose(case, segment, rows[1])[:3, 3]
    way = (end - start) / np.linalg.norm(end - start)
    aside = np.cross(way, rng.normal(size=3))
    aside *= rng.uniform(0.006, 0.02) / np.linalg.norm(aside)
    row = moved_row(case, segment, rows[0], rng.uniform(0.004, 0.006) * way + aside)
    if row is None:
        return None
    return rebuilt(case, name, i, kind, [rows[0], row, *rows[1:]])


@mutation
def a_bent_approach(case, rng):
    """The hand comes from aside: 45 degrees or more off its family's direction."""
    return bent(case, rng, "approach")


@mutation
def a_bent_lift(case, rng):
    """What is lifted goes aside first."""
    return bent(case, rng, "lift")


@mutation
def a_bent_lowering(case, rng):
    """What is put down comes from aside."""
    return bent(case, rng, "lower")


@mutation
def a_bent_retreat(case, rng):
    """The hand leaves aside."""
    return bent(case, rng, "retreat")


def cut_short(case: Case, rng: np.random.Generator, kind: str) -> Plan | None:
    """A stroke that begins after nine tenths of its way: shorter than half of its family's least length."""
    found = a_stroke(case, rng, kind)
    if found is None or found[1] == 0:
        return None
    name, i, segment = found
    before = case.plan.nodes[name].motion[i - 1]
    if before.joints != segment.joints:
        return None
    share, rows = rng.uniform(0.9, 0.97), segment.waypoints
    row = tuple(np.array(rows[-2]) + share * (np.array(rows[-1]) - rows[-2]))
    return through(case, name, {i - 1: [*before.waypoints, *rows[1:-1], row], i: [row, rows[-1]]})


@mutation
def an_approach_cut_short(case, rng):
    """The hand comes anyhow, and only the last millimetres are called an approach."""
    return cut_short(case, rng, "approach")


@mutation
def a_lowering_cut_short(case, rng):
    """What is put down comes anyhow, and only the last millimetres are called so."""
    return cut_short(case, rng, "lower")


@mutation
def a_stroke_that_comes_back(case, rng):
    """Nearly to the end, back to where it touches or nearly so, and away again."""
    found = a_stroke(case, rng, "lift", "lower", "approach", "retreat")
    if found is None:
        return None
    name, i, segment = found
    kind = str(segment.stage).split("/")[-1]
    rows = near_first(segment, kind)
    back = tuple(np.array(rows[0]) + rng.uniform(0.0, 0.1) * (np.array(rows[1]) - rows[0]))
    return rebuilt(case, name, i, kind, [rows[0], *rows[1:], back, *rows[1:]])


@mutation
def a_stroke_that_turns(case, rng):
    """The last joint turns by 3 degrees or more, near to what is touched, and back."""
    found = a_stroke(case, rng, "lift", "lower", "approach", "retreat")
    if found is None:
        return None
    name, i, segment = found
    kind = str(segment.stage).split("/")[-1]
    rows = near_first(segment, kind)
    row = np.array(rows[0]) + 0.02 * (np.array(rows[1]) - rows[0])
    row[-1] += rng.choice([-1, 1]) * rng.uniform(0.05, 0.5)
    return rebuilt(case, name, i, kind, [rows[0], tuple(row), *rows[1:]])


@mutation
def a_hand_that_stays(case, rng):
    """The retreat is left out."""
    found = a_stroke(case, rng, "retreat")
    if found is None:
        return None
    name, i, segment = found
    node = case.plan.nodes[name]
    if i != len(node.motion) - 1 or node.after is None:
        return None
    joints = {**node.after.robots[segment.robot], **dict(zip(segment.joints, segment.waypoints[0], strict=True))}
    after = replace(node.after, robots={**node.after.robots, segment.robot: joints})
    return case.with_node(name, motion=node.motion[:-1], after=after)


@mutation
def a_hand_that_squeezes(case, rng):
    """The hand closes farther than its family says, and opens to that again."""
    found = a_stroke(case, rng, "close")
    if found is None:
        return None
    name, i, segment = found
    (open_,), (grip,) = segment.waypoints[0], segment.waypoints[-1]
    beyond = grip + np.sign(grip - open_) * rng.uniform(0.002, 0.0069)
    if beyond < 0.0:
        return None
    return through(case, name, {i: [(open_,), (beyond,), (grip,)]})


# ------------------------------------------------------------------------------------------------- what the scene says
def with_bodies(case: Case, change: Callable[[BodyDescription], BodyDescription]) -> Problem:
    """The problem with all bodies changed."""
    assert case.problem.scene is not None
    return case.with_scene(bodies={name: change(body) for name, body in case.problem.scene.bodies.items()})


def with_grasps(case: Case, **changes) -> Problem:
    """The problem with all grasp families changed."""
    return with_bodies(
        case, lambda body: replace(body, grasps={n: replace(g, **changes) for n, g in body.grasps.items()})
    )


UP = FeatureName("world", "up")


@mutation
def the_scene_wants_a_longer_approach(case, rng):
    """At least 30 cm, the plan's are 12 cm and less."""
    least = float(rng.uniform(0.3, 0.6))
    return with_grasps(case, approach=Stroke(FeatureName("tool", "approach"), 1, least, least + 0.1))


@mutation
def the_scene_wants_another_approach(case, rng):
    """Against the direction in which the plan's hands come."""
    low = float(rng.uniform(0.02, 0.05))
    return with_grasps(case, approach=Stroke(FeatureName("tool", "approach"), -1, low, 0.2))


@mutation
def the_scene_wants_a_longer_lift(case, rng):
    """At least 40 cm, the plan's are 15 cm and less."""
    least = float(rng.uniform(0.4, 0.8))
    return with_grasps(case, lift=Stroke(UP, 1, least, least + 0.1))


@mutation
def the_scene_lifts_downwards(case, rng):
    """Against what the plan does."""
    return with_grasps(case, lift=Stroke(UP, -1, float(rng.uniform(0.02, 0.05)), 0.2))


@mutation
def the_scene_wants_shorter_strokes(case, rng):
    """At most a centimetre; the plan's are three and more."""
    most = float(rng.uniform(0.005, 0.01))
    return with_grasps(case, approach=Stroke(FeatureName("tool", "approach"), 1, most / 2, most))


@mutation
def the_scene_wants_another_grip(case, rng):
    """Fingers elsewhere by 5 mm or more."""
    shift = float(rng.uniform(0.005, 0.01))

    def change(body):
        grasps = {
            n: replace(g, fingers={j: v + shift for j, v in (g.fingers or {}).items()})
            for n, g in body.grasps.items()
        }
        return replace(body, grasps=grasps)

    return with_bodies(case, change)


@mutation
def the_scene_wants_another_retreat(case, rng):
    """Straight down, where the plan's hands leave upwards or level."""
    low = float(rng.uniform(0.02, 0.05))
    if not any(kind == "retreat" for _, _, kind in case.strokes) or case.scene.mates:
        return None
    return with_bodies(
        case,
        lambda body: replace(
            body,
            placements={n: replace(p, retreat=Stroke(UP, -1, low, 0.3)) for n, p in body.placements.items()},
        ),
    )


# ---------------------------------------------------------------------------------------------------------------- mates
def with_mates(case: Case, change: Callable[[Mate], Mate]) -> Problem | None:
    """The problem with all mates changed."""
    assert case.problem.scene is not None
    mates = case.problem.scene.mates
    return case.with_scene(mates={name: change(mate) for name, mate in mates.items()}) if mates else None


@mutation
def an_insertion_off_its_axis(case, rng):
    """A way point of the insertion 0.25 to 2 mm aside; its mate's tolerance is 0.1 mm."""
    found = a_stroke(case, rng, "insertion")
    if found is None:
        return None
    name, i, segment = found
    rows = list(segment.waypoints)
    k = int(rng.integers(2, len(rows) - 1))
    ends = [tool_pose(case, segment, rows[j])[:3, 3] for j in (0, -1)]
    aside = np.cross(ends[1] - ends[0], rng.normal(size=3))
    row = moved_row(case, segment, rows[k], aside * rng.uniform(0.25e-3, 2e-3) / np.linalg.norm(aside))
    if row is None:
        return None
    rows[k] = row
    return through(case, name, {i: rows})


@mutation
def an_insertion_that_turns(case, rng):
    """The part turns by 2 degrees or more on its way, and back."""
    found = a_stroke(case, rng, "insertion")
    if found is None:
        return None
    name, i, segment = found
    rows = list(segment.waypoints)
    k = int(rng.integers(2, len(rows) - 1))
    rows[k] = (*rows[k][:-1], rows[k][-1] + rng.choice([-1, 1]) * rng.uniform(0.04, 0.3))
    return through(case, name, {i: rows})


@mutation
def an_insertion_of_few_way_points(case, rng):
    """Straight in joints: it leaves its axis by millimetres."""
    found = a_stroke(case, rng, "insertion")
    if found is None:
        return None
    name, i, segment = found
    return through(case, name, {i: [segment.waypoints[0], segment.waypoints[-1]]})


@mutation
def another_mate(case, rng):
    """The name of another mate of the scene, or of none."""
    names = [*case.scene.mates, f"mate_{rng.integers(99)}"]
    return with_grant(
        case, rng, "mate", lambda grant: replace(grant, by=pick(rng, [n for n in names if n != grant.by]))
    )


@mutation
def the_parts_of_a_mate_turned_round(case, rng):
    """The moving part is called the fixed one."""
    return with_grant(case, rng, "mate", lambda grant: replace(grant, bodies=grant.bodies[::-1]))


@mutation
def a_mate_permitted_on_the_way(case, rng):
    """Contact is permitted before the insertion, too."""
    found = a_stroke(case, rng, "insertion")
    if found is None:
        return None
    name, i, segment = found
    grants = [g for g in segment.grants if g.kind == "mate"]
    before = case.plan.nodes[name].motion[i - 1]
    more = replace(
        before,
        allowed_contacts=(*before.allowed_contacts, *(g.bodies for g in grants)),
        grants=(*before.grants, *grants),
    )
    return case.with_segments(name, {i - 1: more})


@mutation
def the_scene_wants_a_finer_insertion(case, rng):
    """A tolerance that the plan's arms do not keep: less than a micrometre."""
    return with_mates(case, lambda mate: replace(mate, tolerance=float(rng.uniform(1e-7, 1e-6))))


@mutation
def the_scene_inserts_the_other_way(case, rng):
    """From below, or within other bounds."""
    return with_mates(
        case,
        lambda mate: (
            mate
            if mate.insertion is None
            else replace(mate, insertion=replace(mate.insertion, sign=-mate.insertion.sign))
        ),
    )


@mutation
def the_scene_wants_a_longer_insertion(case, rng):
    """At least 30 cm."""
    least = float(rng.uniform(0.3, 0.5))
    return with_mates(
        case,
        lambda mate: (
            mate
            if mate.insertion is None
            else replace(mate, insertion=replace(mate.insertion, minimum=least, maximum=least + 0.1))
        ),
    )


@mutation
def the_scene_mates_elsewhere(case, rng):
    """What the moving part is put on lies a millimetre or more higher."""
    lift = float(rng.uniform(1e-3, 5e-3))

    def higher(name, feature):
        x, y, z = feature.origin
        return replace(feature, origin=(x, y, z + lift)) if name in ("seat", "shoulder", "collar") else feature

    def change(body):
        return replace(body, features={name: higher(name, each) for name, each in body.features.items()})

    return with_bodies(case, change) if case.scene.mates else None


# --------------------------------------------------------------------------------------------------------- certificates
def with_certificate(case: Case, **changes) -> Plan | None:
    """The plan with its certificate changed."""
    certificate = case.plan.certificate
    return None if certificate is None else replace(case.plan, certificate=replace(certificate, **changes))


@mutation
def another_epsilon_in_the_certificate(case, rng):
    """Not that of the plan."""
    assert case.plan.certificate is not None
    factor = float(rng.choice([0.1, 0.5, 0.999, 1.001, 2.0, 10.0]))
    return with_certificate(case, epsilon=case.plan.certificate.epsilon * factor)


@mutation
def a_clearance_told_too_large(case, rng):
    """Larger than everything that is looked at."""
    entries = list(case.plan.certificate.segments)
    k = int(rng.integers(len(entries)))
    entries[k] = replace(entries[k], clearance=case.plan.certificate.near * float(rng.uniform(1.01, 3.0)))
    return with_certificate(case, segments=tuple(entries))


@mutation
def a_stretch_without_proof(case, rng):
    """One is left out."""
    proofs = list(case.plan.certificate.proofs)
    proofs.pop(int(rng.integers(len(proofs))))
    return with_certificate(case, proofs=tuple(proofs))


@mutation
def a_stretch_proven_twice(case, rng):
    """One comes twice."""
    proofs = case.plan.certificate.proofs
    return with_certificate(case, proofs=(*proofs, pick(rng, proofs)))


@mutation
def parts_that_do_not_enclose(case, rng):
    """The parts of one body shrunk about their middle."""
    bodies = dict(case.plan.certificate.bodies)
    moved = [f"sha256:{case.scene.bodies[name].mesh.digest}" for name in case.scene.movable]
    digest = pick(rng, sorted({d for d in moved if d in bodies}))
    vertices = np.frombuffer(bodies[digest].vertices).reshape(-1, 3)
    middle = vertices.mean(axis=0)
    smaller = middle + rng.uniform(0.5, 0.97) * (vertices - middle)
    bodies[digest] = replace(bodies[digest], vertices=smaller.tobytes())
    return with_certificate(case, bodies=bodies)


@mutation
def contacts_told_otherwise(case, rng):
    """The certificate tells of a contact that the segment does not permit."""
    entries = list(case.plan.certificate.segments)
    k = int(rng.integers(len(entries)))
    entries[k] = replace(entries[k], permitted=(*entries[k].permitted, ("x", "y")))
    return with_certificate(case, segments=tuple(entries))


# ------------------------------------------------------------------------------------------- way points, times, records
def a_moving_arm(case: Case, rng: np.random.Generator) -> tuple[str, int, Segment]:
    """A segment of an arm that goes somewhere."""
    found = [(n, i, s) for n, i, s in case.segments() if len(s.joints) > 2 and s.waypoints[0] != s.waypoints[-1]]
    return pick(rng, found)


@mutation
def a_jump(case, rng):
    """A segment begins elsewhere than the arm is."""
    name, i, segment = a_moving_arm(case, rng)
    row = np.array(segment.waypoints[0]) + rng.normal(0.0, 0.01, len(segment.joints)) + 1e-4
    return case.with_segments(name, {i: replace(segment, waypoints=(tuple(row), *segment.waypoints[1:]))})


@mutation
def a_joint_beyond_its_limit(case, rng):
    """A way point between that no joint may take."""
    name, i, segment = a_moving_arm(case, rng)
    robot = case.scene.robots[segment.robot]
    j = int(rng.integers(len(segment.joints)))
    row = np.array(segment.waypoints[0])
    row[j] = robot.tree.upper[robot.joint_names.index(segment.joints[j])] + rng.uniform(1e-4, 0.5)
    return through(case, name, {i: [segment.waypoints[0], tuple(map(float, row)), *segment.waypoints[1:]]})


@mutation
def too_fast(case, rng):
    """In a hundredth of the time or less: plans move at half of the limits and slower."""
    name, i, segment = a_moving_arm(case, rng)
    factor = float(rng.uniform(0.001, 0.01))
    times = tuple(round(segment.times[0] + factor * (t - segment.times[0]), 9) for t in segment.times)
    return case.with_segments(name, {i: replace(segment, times=times)})


@mutation
def time_that_stands_still(case, rng):
    """Two way points at one time."""
    name, i, segment = a_moving_arm(case, rng)
    k = int(rng.integers(1, len(segment.times)))
    times = (*segment.times[:k], segment.times[k - 1], *segment.times[k + 1 :])
    return case.with_segments(name, {i: replace(segment, times=times)})


@mutation
def two_segments_at_once(case, rng):
    """A segment of an arm begins before its last one has ended."""
    found = [
        (n, i)
        for n, i, s in case.segments()
        if i > 0 and case.plan.nodes[n].motion[i - 1].robot == s.robot and s.times[0] > 0.1
    ]
    chosen = pick(rng, found)
    if chosen is None:
        return None
    name, i = chosen
    segment = case.plan.nodes[name].motion[i]
    before = case.plan.nodes[name].motion[i - 1]
    early = rng.uniform(0.1, 0.9) * (before.times[-1] - before.times[0])
    return case.with_segments(name, {i: replace(segment, times=tuple(round(t - early, 6) for t in segment.times))})


@mutation
def a_robot_recorded_elsewhere(case, rng):
    """`after` says that a joint is elsewhere than the motion leaves it."""
    found = pick(rng, [n for n, node in case.plan.nodes.items() if node.after is not None and node.after.robots])
    node = case.plan.nodes[found]
    robot = pick(rng, sorted(node.after.robots))
    joint = pick(rng, sorted(node.after.robots[robot]))
    joints = {**node.after.robots[robot], joint: node.after.robots[robot][joint] + float(rng.uniform(1e-5, 0.1))}
    return case.with_node(found, after=replace(node.after, robots={**node.after.robots, robot: joints}))


@mutation
def an_object_recorded_elsewhere(case, rng):
    """`after` says that an object is elsewhere than the motion leaves it."""
    found = pick(rng, [n for n, node in case.plan.nodes.items() if node.after is not None and node.after.objects])
    node = case.plan.nodes[found]
    name = pick(rng, sorted(node.after.objects))
    pose = node.after.objects[name]
    shift = rng.normal(size=3)
    shift *= rng.uniform(1e-5, 0.05) / np.linalg.norm(shift)
    moved = replace(pose, position=tuple(float(a + b) for a, b in zip(pose.position, shift, strict=True)))
    return case.with_node(found, after=replace(node.after, objects={**node.after.objects, name: moved}))


@mutation
def another_start(case, rng):
    """An object begins elsewhere than the scene puts it."""
    start = case.plan.start
    name = pick(rng, sorted(start.objects))
    pose: ObjectPose = start.objects[name]
    x, y, z = pose.position
    moved = replace(pose, position=(x + float(rng.uniform(1e-5, 0.1)), y, z))
    return replace(case.plan, start=replace(start, objects={**start.objects, name: moved}))


# ---------------------------------------------------------------------------------------------------------- attachments
def with_attaching(
    case: Case, rng: np.random.Generator, change: Callable[[Segment], Segment], what: str
) -> Plan | None:
    """The plan with a segment changed that attaches or detaches."""
    found = pick(rng, [(n, i, s) for n, i, s in case.segments() if getattr(s, what)])
    if found is None:
        return None
    name, i, segment = found
    return case.with_segments(name, {i: change(segment)})


@mutation
def nothing_taken(case, rng):
    """The hand closes, but takes nothing."""
    return with_attaching(case, rng, lambda s: replace(s, attach=()), "attach")


@mutation
def nothing_let_go(case, rng):
    """The hand opens, but lets nothing go."""
    return with_attaching(case, rng, lambda s: replace(s, detach=()), "detach")


@mutation
def taken_by_another_link(case, rng):
    """The object hangs on the base."""

    def change(segment):
        links = [
            link
            for link in case.scene.robots[segment.robot].links
            if link in ("base_link", "link_1", "arm_link_1")
        ]
        return replace(segment, attach=((segment.attach[0][0], f"{segment.robot}.{pick(rng, links)}"),))

    return with_attaching(case, rng, change, "attach")


@mutation
def another_object_taken(case, rng):
    """What the call does not name."""

    def change(segment):
        others = [name for name in case.scene.bodies if name != segment.attach[0][0]]
        return replace(segment, attach=((pick(rng, others), segment.attach[0][1]),))

    return with_attaching(case, rng, change, "attach")


@mutation
def taken_before_the_hand_is_there(case, rng):
    """At the end of the way there."""
    found = pick(rng, [(n, i) for n, i, kind in case.strokes if kind == "close"])
    if found is None:
        return None
    name, i = found
    motion = case.plan.nodes[name].motion
    early = replace(motion[i - 1], attach=motion[i].attach)
    return case.with_segments(name, {i - 1: early, i: replace(motion[i], attach=())})


# --------------------------------------------------------------------------------------------------- knowledge, branches
def acting(case: Case) -> list[str]:
    """The nodes that act."""
    return [name for name, node in case.plan.nodes.items() if node.action is not None]


@mutation
def the_goal_too_early(case, rng):
    """After fewer actions than the shortest plan needs: the first one, or none of those that follow."""
    goal = next(name for name, node in case.plan.nodes.items() if node.kind == "goal")
    node = case.plan.nodes[case.plan.root]
    if node.kind != "action" or node.next == goal:
        return None
    return _only_reached(replace(case.plan, nodes={**case.plan.nodes, case.plan.root: replace(node, next=goal)}))


def _only_reached(plan: Plan) -> Plan:
    """The plan without nodes that nothing leads to, and its certificate without their proofs."""
    reached, waiting = set(), [plan.root]
    while waiting:
        name = waiting.pop()
        if name not in reached:
            reached.add(name)
            waiting.extend(plan.nodes[name].successors)
    certificate = plan.certificate
    if certificate is not None:
        certificate = replace(
            certificate,
            proofs=tuple(p for p in certificate.proofs if p.node in reached),
            segments=tuple(s for s in certificate.segments if s.node in reached),
        )
    nodes = {name: node for name, node in plan.nodes.items() if name in reached}
    return replace(plan, nodes=nodes, certificate=certificate)


@mutation
def an_action_left_out(case, rng):
    """The first one: what it does is needed, for shipped plans are found without a needless first action."""
    node = case.plan.nodes[case.plan.root]
    if node.kind != "action":
        return None
    return _only_reached(replace(case.plan, root=node.next))


@mutation
def outcomes_taken_for_each_other(case, rng):
    """The ways after two outcomes are exchanged."""
    found = [n for n, node in case.plan.nodes.items() if len(set(node.branches.values())) > 1]
    name = pick(rng, found)
    if name is None:
        return None
    outcomes = list(case.plan.nodes[name].branches.items())
    keys, ways = [k for k, _ in outcomes], [v for _, v in outcomes]
    return case.with_node(name, branches=dict(zip(keys, ways[1:] + ways[:1], strict=True)))


@mutation
def an_outcome_without_a_way(case, rng):
    """One of two outcomes is not planned for."""
    name = pick(rng, [n for n, node in case.plan.nodes.items() if len(node.branches) > 1])
    if name is None:
        return None
    branches = dict(case.plan.nodes[name].branches)
    branches.pop(pick(rng, sorted(branches)))
    return _only_reached(case.with_node(name, branches=branches))


@mutation
def another_argument(case, rng):
    """An action about something else than its motion moves."""
    name = pick(rng, [n for n in acting(case) if case.plan.nodes[n].motion])
    node = case.plan.nodes[name]
    key = pick(rng, sorted(node.arguments))
    others = sorted({*case.scene.robots, *case.scene.bodies} - {node.arguments[key]})
    return case.with_node(name, arguments={**node.arguments, key: pick(rng, others)})


@mutation
def an_action_that_does_not_exist(case, rng):
    """A name that the domain does not have."""
    name = pick(rng, acting(case))
    return case.with_node(name, action=f"{case.plan.nodes[name].action}_{rng.integers(99)}")


@mutation
def a_cycle(case, rng):
    """An action that leads back to the root."""
    name = pick(rng, [n for n in acting(case) if case.plan.nodes[n].next is not None])
    return case.with_node(name, next=case.plan.root)


@mutation
def no_motion(case, rng):
    """An action without what it moves."""
    found = [n for n, node in case.plan.nodes.items() if any(s.attach or s.detach for s in node.motion)]
    name = pick(rng, found)
    plan = case.with_node(name, motion=(), after=None, overlap=0.0)
    certificate = plan.certificate
    proofs = tuple(p for p in certificate.proofs if p.node != name)
    segments = tuple(s for s in certificate.segments if s.node != name)
    return replace(plan, certificate=replace(certificate, proofs=proofs, segments=segments))


@mutation
def other_files(case, rng):
    """The hash of a file is another one."""
    name = pick(rng, sorted(case.plan.files))
    digest = "sha256:" + "".join(rng.choice(list("0123456789abcdef"), 64))
    return replace(case.plan, files={**case.plan.files, name: digest})


@mutation
def an_overlap_of_one_robot(case, rng):
    """A motion begins before that of the same robot has ended."""
    followers = [
        (name, node.next)
        for name, node in case.plan.nodes.items()
        if node.motion
        and node.next is not None
        and {s.robot for s in node.motion} & {s.robot for s in case.plan.nodes[node.next].motion}
        and sum(node.next in other.successors for other in case.plan.nodes.values()) == 1
    ]
    found = pick(rng, followers)
    return None if found is None else case.with_node(found[1], overlap=round(float(rng.uniform(0.1, 1.0)), 6))


def mutants(cases: Sequence[Case], total: int, seed: int) -> Iterator[Mutant]:
    """So many mutants of all kinds in turn, each of a case that is drawn; equal seeds give equal ones."""
    made, barren = 0, 0
    for number in count():
        for which, mutate in enumerate(MUTATIONS.values()):
            if made == total:
                return
            rng = np.random.default_rng((seed, number, which))
            order = rng.permutation(len(cases))
            found = next((m for m in (mutate(cases[k], rng) for k in order) if m is not None), None)
            if found is not None:
                made += 1
                yield found
            barren = 0 if found is not None else barren + 1
            assert barren < 10 * len(MUTATIONS), "no mutation fits any case"
