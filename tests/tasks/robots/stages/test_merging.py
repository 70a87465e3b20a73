"""A merger moves different robots at once: what they move is apart at the times that they have, or it is refused."""

from collections.abc import Sequence
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import HealthCheck, assume, event, given, settings
from hypothesis import strategies as st

from kabo.geometry_server import GeometryServer, Refusal, Team
from kabo.language import load_scene_description
from kabo.scene import Scene, attachment, load_scene
from kabo.scene.transforms import transform
from kabo.tasks.core import InitialisationError, Result, Serial, Solution, State, Task
from kabo.tasks.core.model.properties import PropertyResolver
from kabo.tasks.robots import STAGES, TaskScene, check_meaning, segments
from kabo.tasks.robots.motion.together import Track, _MovingBodies
from tests.conftest import PROPERTY_SCALE
from tests.support import oracles_coal

ROOT = Path(__file__).resolve().parents[4]
BASES = {"left": (-0.30, 0.65, 0.0), "right": (-0.30, -0.65, 0.0), "far": (0.75, 0.0, 0.0)}
TOWARDS = {"left": (-1.5, -0.3), "right": (0.3, 1.5), "far": (2.4, 3.1)}  # rad: about where the others are
EPSILON = 0.01
STEP = 0.01  # rad, summed over the joints: how far arms move from one moment of the oracle to the next
FAR = 0.05  # m: the oracle looks no closer at what stays farther apart

THIRD = """
  far:
    model: arm
    base: {position: [0.75, 0.0, 0.0]}
"""


@cache
def scene() -> Scene:
    """Three arms around a table; a bottle each."""
    text = (ROOT / "examples" / "two_arms" / "scene.yaml").read_text()
    text = text.replace("\nrobot_models:", f"{THIRD}\nrobot_models:")
    text = text.replace(
        "regions:", "  green: {model: bottle, movable: true, pose: {position: [0.45, 0.3, 0]}}\n\nregions:"
    )
    text = text.replace("allowed_contacts:", "allowed_contacts:\n  - [far.base_link, table]").replace(
        "0.95, 2.00", "2.2, 2.0"
    )
    folder = ROOT / "examples" / "two_arms"
    path = folder / ".three_arms.yaml"
    path.write_text(text)
    try:
        return load_scene(load_scene_description(path))
    finally:
        path.unlink()


@cache
def arms() -> dict[str, oracles_coal.Kinematics]:
    return oracles_coal.arms(BASES, ROOT / "meshes", "arm6", "gripper_wide")


def first(holding: Sequence[str] = ()) -> TaskScene:
    """All arms at home, some with a bottle in their hands."""
    now = TaskScene.of(GeometryServer(scene()).context(), scene().start)
    for robot, name in zip(("left", "right", "far"), ("red", "blue", "green"), strict=True):
        if robot in holding:
            held = transform((0.0, 0.0, 0.13), (0.5, 0.5, 0.5, 0.5)) @ transform((0.0, 0.0, -0.12))
            now = now.at(robot, [*now.configuration(robot)[:6], 0.03])
            now = now.placing(name, attachment(f"{robot}.tool0", held))
    return now


def make(kind: str, name: str, *children: Any, **properties: Any) -> Any:
    return STAGES[kind](name, *children, **properties)


def solved(stage: Any, before: TaskScene) -> Solution:
    """The first solution of a propagator from a scene, as the planning core would make it."""
    found = list(stage.forward(before, PropertyResolver(stage.properties).values(), 0))[-1]
    assert isinstance(found, Result), found
    return Solution(
        stage, State(before, {}, 0), State(found.scene, found.properties, 1), found.cost, "", found.motion
    )


def then(*solutions: Solution) -> Solution:
    """Solutions one after the other, as those of a serial container."""
    whole = Serial("serial", *(each.stage for each in solutions))
    return Solution(whole, solutions[0].start, solutions[-1].end, sum(s.cost for s in solutions), parts=solutions)


def merged(before: TaskScene, solutions: Sequence[Solution]) -> Result | Refusal:
    stage = make("Merger", "at once")
    (found,) = stage.merge(before, solutions, PropertyResolver(stage.properties).values(), 0)
    assert isinstance(found, Result | Refusal)
    return found


def whole(result: Result, before: TaskScene) -> Solution:
    stage = make("Merger", "at once")
    return Solution(stage, State(before, {}, 0), State(result.scene, {}, 1), result.cost, "", result.motion)


# ------------------------------------------------------------------------------------------------------ the oracle
def things(before: TaskScene, robot: str, values: dict[str, float]) -> dict[str, tuple[Any, np.ndarray]]:
    """The meshes of a robot's links, and of what it holds, where pinocchio has them."""
    poses, found = arms()[robot].poses(values), {}
    for link in scene().robots[robot].links.values():
        if link.mesh is not None:
            found[f"{robot}.{link.name}"] = link.mesh, poses[link.name]
    for name in before.situation.carried(robot):
        held = before.situation.attachment(name)
        pose = poses["tool0"] @ transform(held.position, held.quaternion)
        found[name] = scene().bodies[name].mesh, pose
    return found


def least(before: TaskScene, solutions: Sequence[Solution]) -> float:
    """The least distance [m] of what different robots move, at moments close together, each at its own times."""
    moved = {s.robot: made for each in solutions for made in [segments(each, scene(), "")] for s in made}
    ends = max(segment.times[-1] for made in moved.values() for segment in made)
    knots = {0.0, ends, *(t for made in moved.values() for segment in made for t in segment.times)}
    times = sorted(knots)
    dense = [a + (b - a) * k / 24 for a, b in zip(times, times[1:], strict=False) for k in range(24)] + [ends]
    found, last = FAR, None
    for time in dense:
        here = {robot: values_at(before, robot, made, time) for robot, made in moved.items()}
        q = np.concatenate([list(values.values()) for values in here.values()])
        if last is not None and np.abs(q - last).sum() < STEP and time != ends:
            continue
        last = q
        found = min(found, nearest([things(before, robot, values) for robot, values in here.items()], found))
    return float(found)


def values_at(before: TaskScene, robot: str, made: Sequence[Any], time: float) -> dict[str, float]:
    names = scene().robots[robot].joint_names
    values = dict(zip(names, before.situation.configuration(robot), strict=True))
    for segment in made:
        if segment.times[0] <= time:
            values |= dict(zip(segment.joints, segment.trajectory.at(time).tolist(), strict=True))
    return values


def nearest(groups: Sequence[dict[str, tuple[Any, np.ndarray]]], known: float) -> float:
    balls = [np.array([ball(mesh, pose) for mesh, pose in group.values()]) for group in groups]
    for i, one in enumerate(groups):
        for k in range(i + 1, len(groups)):
            gaps = np.linalg.norm(balls[i][:, None, :3] - balls[k][None, :, :3], axis=2)
            gaps -= balls[i][:, None, 3] + balls[k][None, :, 3]
            mine, theirs = list(one.values()), list(groups[k].values())
            for a, b in np.argwhere(gaps < known):
                known = min(known, oracles_coal.distance(*mine[a], *theirs[b]))
    return known


def ball(mesh: Any, pose: np.ndarray) -> tuple[float, ...]:
    """Centre and radius of a ball about a mesh."""
    if mesh.digest not in _BALLS:
        low, high = mesh.vertices.min(axis=0), mesh.vertices.max(axis=0)
        _BALLS[mesh.digest] = (low + high) / 2, float(np.linalg.norm(high - low)) / 2
    middle, radius = _BALLS[mesh.digest]
    return (*(pose[:3, :3] @ middle + pose[:3, 3]), radius)


_BALLS: dict[str, tuple[np.ndarray, float]] = {}  # centre and radius, of meshes in their own frames


# --------------------------------------------------------------------------------------------------------- the laws
SHARES = st.tuples(*[st.floats(0.0, 1.0)] * 6)
WAYS = st.lists(st.tuples(SHARES, st.sampled_from([0.0, 0.1, 0.3])), min_size=1, max_size=2)
TEAMS = st.sampled_from([("left", "right"), ("left", "far"), ("right", "far"), ("left", "right", "far")])


def goal(robot: str, shares: Sequence[float]) -> list[float]:
    low = np.array([TOWARDS[robot][0], 0.1, 0.7, -0.6, 0.2, -1.0])
    high = np.array([TOWARDS[robot][1], 1.1, 1.6, 0.6, 1.4, 1.0])
    return [float(v) for v in np.round(low + np.array(shares) * (high - low), 3)]


def followed(before: TaskScene, robot: str, way: Sequence[tuple[Sequence[float], float]]) -> Solution:
    """The motion of one robot through some configurations, with rests before them, while the others stand still."""
    now, made = before, list[Solution]()
    for number, (shares, rest) in enumerate(way):
        if rest:
            made.append(solved(make("Wait", f"rest {number}", robot=robot, duration=rest), now))
        go = make("MoveTo", f"go {number}", robot=robot, group="arm", goal=goal(robot, shares))
        assume(isinstance(list(go.forward(now, PropertyResolver(go.properties).values(), 0))[-1], Result))
        made.append(solved(go, now))
        assert made[-1].end is not None
        now = made[-1].end.scene
    return then(*made)


@pytest.mark.slow
@settings(max_examples=max(12, round(150 * PROPERTY_SCALE)), suppress_health_check=list(HealthCheck))
@given(team=TEAMS, ways=st.tuples(WAYS, WAYS, WAYS), hands=st.sets(st.sampled_from(["left", "right", "far"])))
def test_what_is_merged_is_apart_and_what_is_refused_comes_near(team: Any, ways: Any, hands: Any) -> None:
    """Both sides of the bound, against pinocchio and coal; and every motion keeps the times that it has alone."""
    before = first(sorted(hands))
    children = [followed(before, robot, way) for robot, way in zip(team, ways, strict=False)]
    found, distance = merged(before, children), least(before, children)
    near = "contact" if distance <= 0 else "near" if distance < 2 * EPSILON else "apart"
    event(f"{len(team)} robots, {near}, {'merged' if isinstance(found, Result) else 'refused'}")
    if isinstance(found, Refusal):
        assert distance < 2 * EPSILON + STEP, f"refused {found.comment}, which stays {distance:.4f} m apart"
        assert found.reason == "collision" and found.pairs
        return
    assert distance > 0.0, "merged motions collide"
    made = segments(whole(found, before), scene(), "")
    for robot, child in zip(team, children, strict=False):
        alone = segments(child, scene(), "")
        assert [(s.times, s.waypoints) for s in made if s.robot == robot] == [
            (s.times, s.waypoints) for s in alone
        ]
        assert found.scene.situation.robots[robot] == child.end.scene.situation.robots[robot]


MIDDLE = {"left": [-0.92, 0.75, 1.1, 0.0, 0.9, 0.0], "right": [0.92, 0.75, 1.1, 0.0, 0.9, 0.0]}


def to_and_fro(before: TaskScene, robot: str, rest: float = 0.0) -> Solution:
    """To the middle of the table, where only one arm has room, and home again."""
    now, made = before, list[Solution]()
    if rest:
        made.append(solved(make("Wait", "rest", robot=robot, duration=rest), now))
    for wanted in (MIDDLE[robot], "home"):
        made.append(solved(make("MoveTo", f"to {wanted}", robot=robot, group="arm", goal=wanted), now))
        assert made[-1].end is not None
        now = made[-1].end.scene
    return then(*made)


def test_it_is_the_times_that_count_arms_may_pass_the_same_place_one_after_the_other() -> None:
    before = first()
    left, right = to_and_fro(before, "left"), to_and_fro(before, "right")
    refused = merged(before, [left, right])
    assert isinstance(refused, Refusal)
    (pair, count), *_ = refused.pairs
    assert {name.partition(".")[0] for name in pair} == {"left", "right"}
    assert count == 1
    assert pair[0] in refused.comment
    assert "between" in refused.comment
    ended = segments(left, scene(), "")[-1].times[-1]
    late = merged(before, [left, to_and_fro(before, "right", rest=ended)])
    assert isinstance(late, Result)
    assert least(before, [left, to_and_fro(before, "right", rest=ended)]) > 0.0


def test_what_is_proven_of_a_motion_is_what_its_trajectories_say() -> None:
    """Rests, gaps and motions of a track, as one sequence of polynomials that goes on after its end."""
    track = Track.of(to_and_fro(first(), "right", rest=0.25))
    until = track.seconds + 0.5
    made = track.polynomials("right", until)
    assert (made.times[0], made.times[-1]) == (0.0, until)
    at = np.linspace(0.0, until, 400)
    piece = np.clip(np.searchsorted(made.times, at, side="right") - 1, 0, len(made.padded) - 1)
    local = (at - made.times[piece])[:, None, None] ** np.arange(6)
    assert np.abs((made.padded[piece] * local).sum(axis=-1) - track.at("right", at)).max() < 1e-9
    assert np.ptp(track.at("right", at), axis=0).max() > 0.5


def test_arms_that_may_be_far_from_their_path_are_not_proven_apart() -> None:
    before = first()
    robots = ("left", "right")
    bodies = _MovingBodies(
        before, Team.of(scene(), robots), {"left": 0, "right": 1, "red": 0, "blue": 1}, before.permitted
    )
    home = np.concatenate([before.configuration(robot) for robot in robots])
    path = np.array([home, home])
    assert bodies.hit(path, np.zeros((1, len(home)))) is None
    pair, piece = bodies.hit(path, np.full((1, len(home)), 1.0))
    assert {name.partition(".")[0] for name in pair} == {"left", "right"}
    assert piece == 0


def test_who_is_done_sooner_waits_and_all_have_ended_before_what_follows_begins() -> None:
    before = first()
    short = solved(make("Wait", "short", robot="left", duration=0.25), before)
    long = solved(make("Wait", "long", robot="right", duration=2.0), before)
    found = merged(before, [short, long])
    assert isinstance(found, Result)
    after = solved(make("Wait", "after", robot="left", duration=1.0), found.scene)
    made = segments(then(whole(found, before), after), scene(), "")
    assert [(s.robot, s.times[0], s.times[-1]) for s in made] == [
        ("left", 0.0, 0.25),
        ("right", 0.0, 2.0),
        ("left", 2.0, 3.0),
    ]


def test_backward_all_end_in_one_scene_and_begin_together() -> None:
    end, made = first(), list[Solution]()
    for robot in ("left", "right"):
        stage = make("MoveRelative", robot, robot=robot, direction={"vector": [0.0, 0.0, 0.05]})
        (found,) = stage.backward(end, PropertyResolver(stage.properties).values(), 0)
        made.append(Solution(stage, State(found.scene, {}, 0), State(end, {}, 1), 0.0, "", found.motion))
    found = merged(end, made)
    assert isinstance(found, Result)
    assert found.scene.situation.robots["left"] == made[0].start.scene.situation.robots["left"]
    assert found.scene.situation.robots["right"] == made[1].start.scene.situation.robots["right"]
    assert {each.end for each in found.motion} == {end.situation.configuration(r) for r in ("left", "right")}
    assert [each.since for each in found.motion] == [None, 0.0]


def test_what_the_hands_hold_is_looked_at_as_well() -> None:
    """The same motions at several distances: somewhere they are free with empty hands and not with bottles in them."""

    def tried(turn: float, holding: Sequence[str]) -> tuple[bool, float]:
        before = first(holding)
        ways = {"left": [-turn, 0.75, 1.1, 0.0, 0.9, 0.0], "right": [turn, 0.75, 1.1, 0.0, 0.9, 0.0]}
        made = [solved(make("MoveTo", r, robot=r, group="arm", goal=q), before) for r, q in ways.items()]
        return isinstance(merged(before, made), Result), least(before, made)

    differing = 0
    for turn in np.linspace(0.6, 0.9, 7):
        (empty, apart), (full, near) = (tried(float(turn), holding) for holding in ((), ("left", "right")))
        assert (not empty or apart > 0.0) and (not full or near > 0.0)
        differing += empty and not full
    assert differing > 0


# ------------------------------------------------------------------------------------------- what cannot be merged
def moving(name: str, robot: str, **properties: Any) -> Any:
    return make("MoveTo", name, robot=robot, **({"goal": "home"} | properties))


def taking(name: str, robot: str, thing: str) -> Any:
    return make("Attach", name, object=thing, to=robot)


@pytest.mark.parametrize(
    ("children", "told"),
    [
        ([moving("a", "left"), moving("b", "left")], "'a' and 'b' both move left"),
        ([moving("a", "left"), moving("b", "left", goal="open", group="gripper")], "arm and gripper"),
        ([taking("a", "left", "red"), taking("b", "right", "red")], "'a' and 'b' both move red"),
        ([moving("a", "left")], "at least two children"),
        (
            [moving("a", "left"), make("Pad", "b", things=["red"], distance=0.1)],
            "'together/b' changes what geometry",
        ),
    ],
)
def test_what_can_never_be_merged_is_told_before_planning(children: Any, told: str) -> None:
    task = Task("t", make("CurrentState", "now"), make("Merger", "together", *children))
    with pytest.raises(InitialisationError, match="'together': ") as refused:
        check_meaning(task, scene())
    assert told in str(refused.value)


def test_what_is_only_known_while_planning_is_refused_then() -> None:
    before = first()
    twice = [solved(moving(name, "left", goal={"finger_joint": 0.03}), before) for name in ("a", "b")]
    assert "both move left" in merged(before, twice).comment
    stage = make("FixedState", "silent")
    moved = before.at("left", MIDDLE["left"] + [0.0])
    silent = Solution(stage, State(before, {}, 0), State(moved, {}, 1), 0.0, "", ())
    other = solved(moving("b", "right", goal={"finger_joint": 0.03}), before)
    assert "'silent' changes where left is" in merged(before, [silent, other]).comment


def test_reparameterise_leaves_merged_motion_as_it_is() -> None:
    before = first()
    moved = [to_and_fro(before, "left"), solved(make("Wait", "rest", robot="right", duration=0.5), before)]
    found = merged(before, moved)
    assert isinstance(found, Result)
    stage = make("Reparameterise", "smooth", make("NoOp", "inside"))
    (answer,) = stage.transform(whole(found, before), PropertyResolver(stage.properties).values(), 0)
    assert [(s.waypoints, s.timed, s.since) for s in answer.motion] == [
        (s.waypoints, s.timed, s.since) for s in found.motion
    ]


def test_a_merger_may_hold_a_merger() -> None:
    before = first()
    pair = [solved(make("Wait", r, robot=r, duration=0.5), before) for r in ("left", "right")]
    inner = merged(before, pair)
    assert isinstance(inner, Result)
    outer = merged(before, [whole(inner, before), solved(make("Wait", "far", robot="far", duration=0.25), before)])
    assert isinstance(outer, Result)
    made = segments(whole(outer, before), scene(), "")
    assert sorted((s.robot, s.times) for s in made) == [
        ("far", (0.0, 0.25)),
        ("left", (0.0, 0.5)),
        ("right", (0.0, 0.5)),
    ]
