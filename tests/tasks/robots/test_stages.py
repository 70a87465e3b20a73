"""Stages one by one, as what they are: pure functions of scenes and properties."""

from collections.abc import Callable, Iterable
from dataclasses import replace
from itertools import islice
from typing import Any

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from kabo.geometry_server import Refusal, candidate, tool_frame
from kabo.language.scene_description import Constraint, FeatureName, Mate, Stroke
from kabo.scene import attachment
from kabo.tasks.core import InitialisationError, Propagator, Result, Solution, Stage, State, Task
from kabo.tasks.core.model.properties import PropertyResolver
from kabo.tasks.robots import STAGES, TaskScene, check_names
from kabo.tasks.robots.motion.directions import direction_of
from tests.tasks.robots.conftest import first
from tests.tasks.robots.judge import Judge
from tests.tasks.robots.test_library import end, solve

BARTENDER, FORCE = "bartender/four_bottles.yaml", "force_sensing/n2.yaml"
First = Callable[..., TaskScene]


def values(stage: Stage, **interface: Any) -> Any:
    """The properties of a stage, resolved."""
    return PropertyResolver(stage.properties).values(interface)


def make(kind: str, **properties: Any) -> Any:
    return STAGES[kind](kind, **properties)


def answers(given: Any) -> list[Any]:
    return [given] if isinstance(given, Result | Refusal) else list(given)


def forward(scene: TaskScene, kind: str, **properties: Any) -> list[Any]:
    stage = make(kind, **properties)
    assert isinstance(stage, Propagator)
    return answers(stage.forward(scene, values(stage), 0))


def backward(scene: TaskScene, kind: str, **properties: Any) -> list[Any]:
    stage = make(kind, **properties)
    assert isinstance(stage, Propagator)
    return answers(stage.backward(scene, values(stage), 0))


def only(found: Iterable[Any]) -> Any:
    (one,) = found
    return one


def tool(scene: TaskScene, robot: str) -> np.ndarray:
    """The pose (4, 4) of a robot's tool."""
    chosen = scene.robot(robot)
    return candidate(chosen, scene.configuration(robot)).pose(tool_frame(chosen))


# ------------------------------------------------------------------------------------------------- where to begin
def test_the_current_state_is_the_scene_in_which_the_task_was_asked(first_scene: First) -> None:
    scene = first_scene(BARTENDER)
    stage = make("CurrentState")
    assert only(stage.generate(scene, values(stage), 0)).scene is scene


def test_a_fixed_state_has_the_configurations_that_it_names(first_scene: First) -> None:
    scene = first_scene(BARTENDER)
    stage = make("FixedState", configurations={"left": [0.1, 0.0, 1.0, 0.0, 1.0, 0.0]})
    found = only(stage.generate(scene, values(stage), 0)).scene
    assert found.configuration("left")[:3].tolist() == [0.1, 0.0, 1.0]
    assert found.situation.robots["right"] == scene.situation.robots["right"]


def test_configurations_are_free_and_home_comes_first(first_scene: First) -> None:
    scene = first_scene(BARTENDER)
    away = scene.at("left", [0.5, *scene.configuration("left")[1:]])
    stage = make("SampleConfiguration", robot="left", random=30)
    found = [a for a in stage.generate(away, values(stage), 0) if isinstance(a, Result)]
    assert found[0].scene.situation.robots["left"] == scene.situation.robots["left"]
    assert all(a.scene.hit("left") is None for a in found)
    assert len({a.scene.situation.robots["left"] for a in found}) == len(found) > 5


# --------------------------------------------------------------------------------------------------------- moving
@pytest.mark.parametrize("vector", [(0.0, 0.0, 0.1), (0.05, 0.05, 0.0)])
def test_a_relative_motion_is_straight_and_backward_it_leads_here(first_scene: First, vector: Any) -> None:
    scene = first_scene(BARTENDER)
    there = only(forward(scene, "MoveRelative", robot="left", direction={"vector": list(vector)}))
    assert tool(there.scene, "left")[:3, 3] - tool(scene, "left")[:3, 3] == pytest.approx(vector, abs=2e-3)
    assert tool(there.scene, "left")[:3, :3] == pytest.approx(tool(scene, "left")[:3, :3], abs=0.02)
    came = only(backward(scene, "MoveRelative", robot="left", direction={"vector": list(vector)}))
    (stretch,) = came.motion
    assert stretch.end == scene.situation.configuration("left")
    assert stretch.start == came.scene.situation.configuration("left")
    assert tool(scene, "left")[:3, 3] - tool(came.scene, "left")[:3, 3] == pytest.approx(vector, abs=2e-3)


def test_a_stroke_that_is_blocked_is_shortened_down_to_its_least_distance(first_scene: First) -> None:
    scene = first_scene(BARTENDER)
    height = tool(scene, "left")[2, 3]
    down = {"vector": [0.0, 0.0, -height]}
    whole = only(forward(scene, "MoveRelative", robot="left", direction=down))
    assert isinstance(whole, Refusal)
    part = only(
        forward(scene, "MoveRelative", robot="left", direction=down, min_distance=0.1, max_distance=height)
    )
    assert isinstance(part, Result)
    assert 0.09 < height - tool(part.scene, "left")[2, 3] < height - 0.05


def test_a_twist_turns_the_tool_and_offsets_move_joints(first_scene: First) -> None:
    scene = first_scene(BARTENDER)
    turned = only(
        forward(scene, "MoveRelative", robot="left", direction={"twist": [0.0, 0.0, 0.02, 0.0, 0.0, 0.3]})
    )
    relative = tool(turned.scene, "left")[:3, :3] @ tool(scene, "left")[:3, :3].T
    assert np.arccos((np.trace(relative) - 1) / 2) == pytest.approx(0.3, abs=0.01)
    joint = scene.robot("left").joint_names[0]
    moved = only(forward(scene, "MoveRelative", robot="left", direction={"joints": {joint: 0.2}}))
    assert (moved.scene.configuration("left") - scene.configuration("left"))[0] == pytest.approx(0.2)


@pytest.mark.parametrize(
    "goal",
    [
        [0.3, -0.3, 1.9, 0.0, 1.5, 0.0],
        {"pose": {"position": [0.3, 0.6, 0.35], "rpy": [0.0, 2.4, 0.0]}},
        {"point": [0.25, 0.65, 0.4]},
    ],
)
def test_the_arm_moves_to_joints_poses_and_points_on_a_free_way(first_scene: First, goal: Any) -> None:
    scene = first_scene(BARTENDER)
    found = [a for a in forward(scene, "MoveTo", robot="left", goal=goal) if isinstance(a, Result)]
    (there,) = found
    if isinstance(goal, dict) and "pose" in goal:
        assert tool(there.scene, "left")[:3, 3] == pytest.approx(goal["pose"]["position"], abs=1e-5)
    elif isinstance(goal, dict):
        assert tool(there.scene, "left")[:3, 3] == pytest.approx(goal["point"], abs=1e-5)
        assert tool(there.scene, "left")[:3, :3] == pytest.approx(tool(scene, "left")[:3, :3], abs=1e-5)
    else:
        assert there.scene.configuration("left")[:6].tolist() == goal
    (back,) = (a for a in backward(scene, "MoveTo", robot="left", goal=goal) if isinstance(a, Result))
    assert back.motion[-1].end == scene.situation.configuration("left")


def test_the_gripper_moves_alone(first_scene: First) -> None:
    scene = first_scene(BARTENDER)
    opened = only(forward(scene, "MoveTo", robot="left", goal="open"))
    assert opened.motion == ()
    half = only(forward(scene, "MoveTo", robot="left", group="gripper", goal={"finger_joint": 0.02}))
    assert half.motion[0].group == "gripper"
    assert half.scene.configuration("left").tolist() == [*scene.configuration("left")[:-1], 0.02]


def test_a_name_that_no_configuration_has_is_refused_or_stays(first_scene: First) -> None:
    scene = first_scene(BARTENDER)
    refused = only(forward(scene, "MoveTo", robot="left", goal="hoem"))
    assert refused.reason == "constraint"
    assert "home" in refused.comment
    stays = only(forward(scene, "MoveTo", robot="left", goal="weigh", if_missing="stay"))
    assert stays.motion == ()


def test_no_robot_moves_to_where_a_joint_is_beyond_its_limits(first_scene: First) -> None:
    scene = first_scene(BARTENDER)
    robot, q = scene.robot("left"), scene.configuration("left")
    beyond, (slide,) = robot.tree.upper[0] + 0.01, robot.gripper_joints
    for goal in ({robot.joint_names[0]: beyond}, [beyond, *q[1 : robot.planned]], {slide: 0.2}):
        refused = only(forward(scene, "MoveTo", robot="left", goal=goal, if_missing="stay"))
        assert "outside its limits" in refused.comment


def test_an_unreachable_pose_is_told_from_one_where_the_hand_would_collide(first_scene: First) -> None:
    scene = first_scene(BARTENDER)
    far = only(forward(scene, "MoveTo", robot="left", goal={"pose": {"position": [5.0, 0.0, 0.5]}}))
    assert far.reason == "out_of_reach"
    inside = {"pose": {"position": [0.2, 0.3, 0.05], "rpy": [3.14159, 0.0, 0.0]}}
    blocked = only(forward(scene, "MoveTo", robot="left", goal=inside))
    assert blocked.reason == "collision"
    assert "hand" in blocked.comment
    assert any("table" in pair for pair, _ in blocked.pairs)


# ----------------------------------------------------------------------------------------------------- connecting
def connect(start: TaskScene, end: TaskScene, **properties: Any) -> Any:
    stage = make("Connect", robot="left", **properties)
    reason = stage.mismatch(start, end, values(stage))
    return reason if reason is not None else only(answers(stage.connect(start, end, values(stage), 0)))


def test_scenes_that_differ_beside_the_arm_are_never_joined_and_say_why(first_scene: First) -> None:
    scene = first_scene(BARTENDER)
    moved = scene.placing("bottle_1", attachment("world", scene.pose("bottle_2")))
    assert connect(scene, moved) == "bottle_1 stands elsewhere"
    held = scene.placing("bottle_1", attachment("left.tool0", np.eye(4)))
    assert connect(scene, held) == "bottle_1 hangs on world, then on left.tool0"
    assert connect(held, held.placing("bottle_1", attachment("left.tool0", tool(scene, "left")))) == (
        "bottle_1 is held another way"
    )
    opened = scene.at("left", [*scene.configuration("left")[:-1], 0.01])
    assert connect(scene, opened) == "left: finger_joint differs"
    other = scene.at("right", [0.1, *scene.configuration("right")[1:]])
    assert str(connect(scene, other)).startswith("right: ")
    assert "permitted" in str(connect(scene, scene.permitting([("bottle_1", "table")])))
    padded = only(forward(scene, "Pad", things=["bottle_1"], distance=0.02)).scene
    assert connect(scene, padded) == "padding of bottle_1 is there only where it ends"
    assert connect(padded, scene) == "padding of bottle_1 is there only where it begins"


def test_a_contact_on_one_side_only_says_which_stage_is_missing(first_scene: First) -> None:
    scene = first_scene(BARTENDER)
    touching = scene.permitting([("bottle_1", "table")])
    told = "contact of bottle_1 and table is permitted only where it "
    assert connect(scene, touching) == f"{told}ends: AllowContact is missing after it"
    assert connect(touching, scene) == f"{told}begins: ForbidContact is missing before it"


def test_a_contact_that_the_scene_always_permits_keeps_no_scenes_apart(first_scene: First) -> None:
    """Such a body was carried nowhere: where it is put down its table was permitted once more, and before it was not."""
    scene = first_scene(BARTENDER)
    always = min(tuple(sorted(pair)) for pair in scene.context.scene.allowed if len(pair) == 2)  # noqa: PLR2004
    assert connect(scene, scene.permitting([always])).motion == ()


def test_a_way_joins_both_ends_exactly_and_is_the_same_whenever_it_is_asked(first_scene: First) -> None:
    scene = first_scene(BARTENDER)
    end = scene.at("left", [1.2, -0.3, 1.9, 0.3, 1.5, 0.2, *scene.configuration("left")[6:]])
    found = [connect(scene, end) for _ in range(2)]
    assert found[0] == found[1]
    (way,) = found[0].motion
    assert (way.start, way.end) == (scene.situation.configuration("left"), end.situation.configuration("left"))
    assert connect(scene, scene).motion == ()


def test_a_way_keeps_its_constraint(first_scene: First) -> None:
    scene = first_scene(FORCE)
    held = end(solve(scene, "pick", robot="arm", object="cup_1")[0])
    there = only(
        forward(held, "MoveTo", robot="arm", goal="weigh", keep={"object": "cup_1", "constraint": "upright"})
    )
    (way,) = there.motion
    assert way.constraint == "upright"
    for q in way.waypoints:
        up = held.at("arm", q).pose("cup_1")[:3, 2]
        assert np.degrees(np.arccos(min(1.0, up[2]))) <= 10.1


# -------------------------------------------------------------------------------------------------------- changes
def test_attaching_and_letting_go_are_inverses_of_each_other(first_scene: First) -> None:
    scene = first_scene(FORCE)
    held = only(forward(scene, "Attach", object="cup_1", to="arm"))
    assert held.scene.holder("cup_1") == "arm"
    assert held.scene.pose("cup_1") == pytest.approx(scene.pose("cup_1"), abs=1e-8)
    again = only(backward(held.scene, "Attach", object="cup_1", to="arm"))
    assert again.scene.situation.attachment("cup_1").parent == "world"
    free = only(forward(held.scene.permitting([("cup_1", "source_table")]), "Detach", object="cup_1"))
    assert free.scene.pose("cup_1") == pytest.approx(scene.pose("cup_1"), abs=1e-8)
    back = only(backward(free.scene, "Detach", object="cup_1", of="arm"))
    assert back.scene.situation.attachment("cup_1").parent == "arm.tool0"
    assert only(forward(scene, "Detach", object="cup_1")).reason == "constraint"
    assert only(forward(held.scene, "Attach", object="cup_1", to="arm")).reason == "constraint"


def test_forbidding_a_contact_needs_it_to_be_gone(first_scene: First) -> None:
    scene = first_scene(FORCE)
    pairs = [["cup_1", "supports"]]
    allowed = only(forward(scene, "AllowContact", pairs=pairs)).scene
    assert allowed.permitted == frozenset({frozenset({"cup_1", "source_table"})})
    held = only(forward(allowed, "Attach", object="cup_1", to="arm")).scene
    refused = only(forward(held, "ForbidContact", pairs=pairs))
    assert refused.reason == "collision"
    lifted = held.placing("cup_1", replace(held.situation.attachment("cup_1")))
    up = only(forward(lifted, "MoveRelative", robot="arm", direction={"vector": [0.0, 0.0, 0.1]})).scene
    assert only(forward(up, "ForbidContact", pairs=pairs)).scene.permitted == frozenset()
    assert only(backward(up, "AllowContact", pairs=pairs)).scene.permitted == frozenset()
    assert only(backward(scene, "ForbidContact", pairs=[["cup_1", "source_table"]])).scene.permitted


def test_touch_stands_for_the_links_of_the_gripper(first_scene: First) -> None:
    scene = first_scene(FORCE)
    found = only(forward(scene, "AllowContact", pairs=[["arm", "cup_1"]], links="touch")).scene
    assert found.permitted == {frozenset({"arm.left_finger", "cup_1"}), frozenset({"arm.right_finger", "cup_1"})}


def test_added_geometry_is_in_the_way_until_it_is_removed(first_scene: First) -> None:
    scene = first_scene(BARTENDER)
    box = {"body": "wall", "shape": {"box": [0.02, 0.3, 0.3]}, "pose": {"position": [0.2, 1.1, 0.3]}}
    walled = only(forward(scene, "AddGeometry", **box)).scene
    end = [1.2, *scene.configuration("left")[1:]]
    free, blocked = scene.workspace("left"), walled.workspace("left")
    assert free.segment_hit(scene.configuration("left"), np.array(end)) < 0
    index = blocked.segment_hit(scene.configuration("left"), np.array(end))
    assert "wall" in blocked.pairs[index]
    removed = only(forward(walled, "RemoveGeometry", bodies=["wall"])).scene
    assert removed.workspace("left").segment_hit(scene.configuration("left"), np.array(end)) < 0
    refused = only(forward(walled, "RemoveGeometry", bodies=["wal"]))
    assert refused.comment == "no added body is called 'wal', did you mean \"wall\"?"
    assert only(backward(walled, "AddGeometry", **box)).scene.extras == ()
    again = only(forward(walled, "AddGeometry", **box))
    assert again.comment.startswith("a body called 'wall' is there already")
    gone = only(backward(scene, "AddGeometry", **box))
    assert gone.comment.startswith("the scene after it has no added body 'wall'")
    inside = {**box, "pose": {"position": tool(scene, "left")[:3, 3].tolist()}}
    assert only(forward(scene, "AddGeometry", **inside)).reason == "collision"


@pytest.mark.parametrize("distance", [0.03, 0.05])
def test_padding_keeps_its_distance_along_the_whole_way(first_scene: First, distance: float) -> None:
    scene = first_scene(BARTENDER)
    things = ["bottle_1", "bottle_2"]
    padded = only(forward(scene, "Pad", things=things, distance=distance)).scene
    sides = [padded.at("left", [a, 0.3, 1.9, 0.0, 0.6, 0.0, 0.055]) for a in (-0.9, 0.9)]
    if any(side.hit("left") is not None for side in sides):
        sides = [padded.at("left", [a, -0.2, 1.6, 0.0, 1.2, 0.0, 0.055]) for a in (-0.9, 0.9)]
    found = connect(*sides)
    assert isinstance(found, Result), found
    judge = Judge(scene.context.scene)
    for each in found.motion:
        for q in each.waypoints:
            still = replace(each, waypoints=(q,))
            for link in scene.robot("left").links.values():
                if link.mesh is not None and not scene.robot("left").stands(link.name):
                    clear = judge.clearance(still, sides[0], f"left.{link.name}", things)
                    assert clear >= distance - 1e-6
    assert only(forward(padded, "Unpad", things=things)).scene.extras == ()
    assert only(backward(scene, "Unpad", things=things, distance=distance)).scene.extras
    assert only(backward(padded, "Pad", things=things, distance=distance)).scene.extras == ()
    unpadded = only(forward(padded, "Unpad", things=["bottle_2"])).scene
    gone = only(backward(unpadded, "Pad", things=things, distance=distance))
    assert gone.comment.startswith("the scene after it has no padding of bottle_2")


# ------------------------------------------------------------------------------------------------------- directions
def test_directions_are_read_as_grasp_families_write_them() -> None:
    read = direction_of({"against": "tool.approach", "distance": [0.05, 0.1]}, None)
    assert read is not None
    assert read.stroke.sign == -1
    assert (read.stroke.minimum, read.stroke.maximum) == pytest.approx((0.05, 0.1))
    with pytest.raises(ValueError, match="along or against"):
        direction_of({"towards": "tool.approach"}, None)


# ------------------------------------------------------------------------------------------------------------ names
def test_what_a_scene_does_not_have_is_refused_before_planning_all_at_once(first_scene: First) -> None:
    scene = first_scene(BARTENDER).context.scene
    go = make("MoveTo", robot="rigth", goal="home")
    put = make("SampleGrasp", robot="right", object="botle_1", monitors="../go")
    with pytest.raises(InitialisationError) as caught:
        check_names(Task("wrong", make("CurrentState"), go, put), scene)
    assert len(caught.value.errors) == 2
    assert 'did you mean "right"?' in caught.value.errors[0]
    check_names(Task("right", make("CurrentState"), make("MoveTo", robot="right", goal="home")), scene)


def test_motions_cost_their_length(first_scene: First) -> None:
    scene = first_scene(BARTENDER)
    joint = scene.robot("left").joint_names[0]
    moved = only(forward(scene, "MoveRelative", robot="left", direction={"joints": {joint: 0.2}}))
    assert moved.cost == pytest.approx(0.2)


# --------------------------------------------------------------------------------------------- inverse kinematics
def test_a_mate_brings_the_part_in_the_hand_to_the_other_one(first_scene: First) -> None:
    scene = first_scene(FORCE)
    names = {role: {f: FeatureName(role, f) for f in ("base", "axis")} for role in ("moving", "fixed")}
    constraints = (
        Constraint("coincident", names["moving"]["axis"], names["fixed"]["axis"]),
        Constraint("aligned", names["moving"]["axis"], names["fixed"]["axis"]),
    )
    mate = Mate("over", "cup", "cup", constraints, Stroke(FeatureName("fixed", "axis"), -1, 0.02, 0.05))
    mated = replace(scene.context.scene, mates={"over": mate})
    held = end(solve(scene, "pick", robot="arm", object="cup_1")[0])
    surroundings = held.context.surroundings
    surroundings.scene = mated
    stage = make("SampleMate", robot="arm", object="cup_1", onto="cup_2", mate="over", monitors="x")
    offered = only(stage.generate(held, values(stage), 0))
    assert frozenset({"cup_1", "cup_2"}) in offered.scene.permitted
    assert offered.properties["insertion"].stroke.along == FeatureName("this", "axis")
    found = [at for batch in islice(offered.properties["target"].batches(), 4) for at in batch]
    assert found
    for at in found[:8]:
        there = held.at("arm", at.q)
        apart = there.pose("cup_1")[:2, 3] - there.pose("cup_2")[:2, 3]
        assert apart == pytest.approx([0.0, 0.0], abs=1e-5)
        assert there.pose("cup_1")[2, 2] == pytest.approx(1.0, abs=1e-6)


@settings(max_examples=10, suppress_health_check=list(HealthCheck))
@given(most=st.integers(1, 6), apart=st.sampled_from([0.0, 0.5, 2.0]))
def test_solutions_of_inverse_kinematics_are_free_apart_and_no_more_than_asked_for(
    most: int, apart: float
) -> None:
    scene = first(BARTENDER)
    grasps = make("SampleGrasp", robot="right", object="bottle_4", monitors="x")
    offered = only(grasps.generate(scene, values(grasps), 0))
    wrapped = Solution(grasps, State(scene, {}, 1), State(scene, offered.properties, 2), 0.0)
    stage = make("ComputeIK", robot="right", max_ik_solutions=most, min_distance=apart)
    found = [a for a in stage.transform(wrapped, values(stage, **offered.properties), 0) if isinstance(a, Result)]
    assert 1 <= len(found) <= most
    tcp = scene.robot("right").tool.features["tcp"].origin
    for i, one in enumerate(found):
        assert one.scene.hit("right") is None
        q = one.scene.configuration("right")
        assert all(np.abs(q - other.scene.configuration("right")).sum() >= apart for other in found[:i])
        at = one.properties["target_pose"] @ np.array([*tcp, 1.0])
        assert at[:2] == pytest.approx(scene.pose("bottle_4")[:2, 3], abs=1e-5), "on the axis of the bottle"


def test_stages_declare_every_interface_property_that_they_write(first_scene: First) -> None:
    start = first_scene(BARTENDER)
    picked = solve(start, "pick", robot="right", object="bottle_4")[0]
    placed = solve(end(picked), "place", robot="right", object="bottle_4", region="dishwasher")[0]
    for solution in (picked, placed):
        written = {name for part in solution.walk() for name in part.properties}
        stages = {part.stage for part in solution.walk()}
        declared = {name for stage in stages if isinstance(stage, Stage) for name in stage.writes({})}
        assert written and written <= declared
