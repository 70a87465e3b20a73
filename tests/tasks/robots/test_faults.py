"""What stages are asked for and cannot mean: told before planning where it is known, refused with the reason where not."""

import math
from collections.abc import Callable
from dataclasses import replace
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import HealthCheck, event, example, given, settings
from hypothesis import strategies as st

from kabo.geometry_server import Refusal, ScenePredicates, Situation
from kabo.language import load_problem, load_scene_description
from kabo.scene import Scene, attachment, load_scene
from kabo.scene.transforms import transform
from kabo.tasks.core import Fallbacks, InitialisationError, Interface, Parent, Result, Task
from kabo.tasks.core.model.properties import PropertyResolver
from kabo.tasks.files.first_scenes import first_scene
from kabo.tasks.robots import STAGES, TaskScene, check_meaning
from kabo.tasks.robots.motion.groups import hung
from kabo.tasks.robots.stages.strokes import RESOLUTION, farthest
from tests.conftest import PROPERTY_SCALE
from tests.tasks.robots.conftest import DOMAINS, first

EXAMPLE = Path(__file__).resolve().parents[3] / "examples" / "pick_and_place"
FORCE, BARTENDER = "force_sensing/n2.yaml", "bartender/four_bottles.yaml"


def make(kind: str, *children: Any, **properties: Any) -> Any:
    return STAGES[kind](kind, *children, **properties)


def forward(scene: TaskScene, kind: str, **properties: Any) -> Any:
    stage = make(kind, **properties)
    return list(stage.forward(scene, PropertyResolver(stage.properties).values(), 0))[-1]


@cache
def small() -> Scene:
    return load_scene(load_scene_description(EXAMPLE / "scene.yaml"))


def start() -> TaskScene:
    scene: TaskScene = first_scene(small(), 0, lambda: False)
    return scene


# ----------------------------------------------------------------------------------- told before anything is planned
@pytest.mark.parametrize(
    ("stage", "told"),
    [
        (lambda: make("MoveTo", robot="arm", goal="home", of="tool.tcp"), "`of` says what is to be at a pose"),
        (lambda: make("MoveTo", robot="arm", goal="open", keep="upright"), "only the gripper moves"),
        (
            lambda: make("MoveTo", robot="arm", goal="home", keep="upright"),
            "nothing can keep upright: arm holds nothing",
        ),
        (
            lambda: make(
                "MoveRelative", robot="arm", direction={"vector": [0, 0, 1]}, min_distance=0.2, max_distance=0.1
            ),
            "is above",
        ),
        (
            lambda: make("MoveRelative", robot="arm", direction={"along": "tool.approach"}),
            "the direction has no distance",
        ),
        (
            lambda: make("MoveRelative", robot="arm", direction={"joints": {"j1": 1.0}}, max_distance=0.1),
            "offsets of joints",
        ),
        (
            lambda: make("MoveRelative", robot="arm", direction={"vector": [0, 0, 1]}, keep="upright"),
            "arm holds nothing",
        ),
        (lambda: make("Connect", robot="arm", keep="upright"), "arm holds nothing"),
        (lambda: make("PoseGenerator", robot="arm"), "there are no poses"),
        (lambda: make("PoseGenerator", robot="arm", poses=[]), "there are no poses"),
        (
            lambda: make("SampleConfiguration", robot="arm", configurations=["nowhere"]),
            "there are no configurations",
        ),
        (lambda: make("SampleConfiguration", robot="arm", configurations=[]), "there are no configurations"),
        (lambda: make("AllowContact", pairs=[["botle", "table"]]), "nothing is called 'botle'"),
        (lambda: make("ForbidContact", pairs=[["arm.linc", "table"]]), "arm has no link 'linc'"),
        (lambda: make("PredicateFilter", make("NoOp")), "nothing is asked"),
        (lambda: make("Pad", things=["botle"], distance=0.1), "nothing is called 'botle'"),
        (lambda: make("Pad", things=["arm"], distance=0.1), "'arm' is a robot: name one of its links"),
        (lambda: make("Pad", things=["arm.tool0"], distance=0.1), "arm.tool0 has no geometry"),
        (lambda: make("Unpad", things=["object"]), "nothing before it pads 'object'"),
        (
            lambda: make("AddGeometry", body="b", shape={"sphere": {"radius": 1}}, parent="tabel"),
            "nothing is called 'tabel'",
        ),
        (
            lambda: make("MoveRelative", robot="arm", direction={"joints": {"jont_1": 0.1}}),
            "arm has no joint 'jont_1', did you mean \"joint_1\"?",
        ),
        (
            lambda: make(
                "MoveRelative",
                robot="arm",
                direction={"along": "tool.approach", "distance": 0.1},
                min_distance=0.2,
            ),
            "the least distance, 0.2 m, is above the greatest, 0.1 m",
        ),
        (
            lambda: make("MoveRelative", robot="arm", direction={"vector": [0, 0, 0.1]}, min_distance=0.2),
            "the least distance, 0.2 m, is above the greatest, 0.1 m",
        ),
        (lambda: make("Attach", object="table", to="arm"), "table is not movable"),
        (lambda: make("Join", object="object", onto="table"), "no mate of the scene joins object and table"),
        (
            lambda: make("AllowContact", pairs=[["arm", "supports"]]),
            "arm is no movable object, and 'supports' is what carries one: object",
        ),
        (lambda: make("ForbidContact", pairs=[["supports", "arm.tool0"]]), "arm.tool0 is no movable object"),
        (lambda: make("AllowContact", pairs=[["table", "supports"]]), "table is no movable object"),
        (
            lambda: make("Attach", object="object", to="arm.tol0"),
            "arm has no link 'tol0', did you mean \"tool0\"?",
        ),
        (lambda: make("Attach", object="object", to="arm", of="amr"), "no robot 'amr', did you mean \"arm\"?"),
        (lambda: make("Detach", object="object", of="amr"), "the scene has no robot 'amr', did you mean \"arm\"?"),
        (lambda: make("Detach", object="object", of="arm.tol0"), "arm has no link 'tol0'"),
        (lambda: make("AllowContact", pairs=[["arm.tol0", "object"]]), 'did you mean "tool0"?'),
        (
            lambda: make("AddGeometry", body="object", shape={"sphere": {"radius": 1}}),
            "the scene has 'object' already",
        ),
        (
            lambda: make("AddGeometry", body="world", shape={"sphere": {"radius": 1}}),
            "the scene has 'world' already",
        ),
        (
            lambda: make("AddGeometry", body="arm.tool0", shape={"sphere": {"radius": 1}}),
            "the scene has 'arm.tool0' already",
        ),
        (lambda: make("MoveTo", robot="arm", goal="hme"), "no configuration 'hme', did you mean \"home\"?"),
        (
            lambda: make("MoveTo", robot="arm", goal={"jont_1": 0.1}),
            "no joint 'jont_1', did you mean \"joint_1\"?",
        ),
        (lambda: make("MoveTo", robot="arm", goal={"joint_1": 9.0}), "would be at 9, outside its limits"),
        (lambda: make("MoveTo", robot="arm", goal=[0.0]), "planned joints: [0.0] is no configuration of it"),
        (
            lambda: make("Reparameterise", make("NoOp"), acceleration={"elbow": 1.0}),
            "no robot has a joint 'elbow'",
        ),
    ],
)
def test_what_means_nothing_is_told_with_its_stage_before_planning(stage: Callable[[], Any], told: str) -> None:
    task, scene = Task("t", make("CurrentState"), stage()), small()
    with pytest.raises(InitialisationError) as refused:
        check_meaning(task, scene, Situation.of(scene.start))
    assert told in str(refused.value)
    assert f"'{task.children[-1].path}': " in str(refused.value)


def test_padding_that_is_taken_off_may_have_been_put_on_by_any_stage_before() -> None:
    pads = make("Pad", things=["object"], distance=0.01)
    known = Task(
        "t", make("CurrentState"), Fallbacks("either", pads, make("NoOp")), make("Unpad", things=["object"])
    )
    check_meaning(known, small())
    read = STAGES["Pad"]("read", things=Interface("thick"), distance=0.01)
    check_meaning(Task("t", make("CurrentState"), read, make("Unpad", things=["object"])), small())
    late = Task(
        "t",
        make("CurrentState"),
        make("Unpad", things=["object"]),
        STAGES["Pad"]("p", things=["object"], distance=0.01),
    )
    with pytest.raises(InitialisationError, match="nothing before it pads 'object'"):
        check_meaning(late, small())


def test_a_goal_that_another_stage_may_replace_is_no_fault() -> None:
    """A task of any robot may try one that only some robots have."""
    scene = small()
    either = Fallbacks("either", make("MoveTo", robot="arm", goal="carry"), make("NoOp"))
    stays = STAGES["MoveTo"]("stays", robot="arm", goal="carry", if_missing="stay")
    check_meaning(Task("t", make("CurrentState"), either, stays), scene, Situation.of(scene.start))


@pytest.mark.parametrize(
    ("stage", "told"),
    [
        ({"pairs": [[Parent("robot")]]}, "'pairs' is a list of pairs of names, not of ['arm']"),
        ({"pairs": [Parent("robot"), "object"]}, "'pairs' is a list of pairs of names, not of 'arm'"),
        ({"pairs": [[Parent("robot"), "arm"]]}, "'pairs' has a pair of arm with itself"),
    ],
)
def test_a_value_with_references_that_is_none_is_told_by_its_property(stage: dict[str, Any], told: str) -> None:
    """The stage itself looked into it first: `not enough values to unpack`."""
    task, scene = Task("t", make("CurrentState"), make("AllowContact", **stage), robot="arm"), small()
    with pytest.raises(InitialisationError) as refused:
        check_meaning(task, scene, Situation.of(scene.start))
    assert f"'AllowContact': {told}" in str(refused.value)


@pytest.mark.parametrize(
    ("stage", "told"),
    [
        ({"kind": "SamplePlacement"}, "there is no place"),
        (
            {"kind": "SamplePlacement", "region": "anywhere", "family": "flying"},
            "no family 'flying' among its placements",
        ),
        ({"kind": "SampleGrasp", "family": "teeth"}, "no family 'teeth' among its grasps"),
        ({"kind": "GraspPoses", "grasp": {}, "family": "teeth"}, "no family 'teeth' among its grasps"),
        ({"kind": "GraspPoses", "grasp": {}, "about": "spine"}, "no line 'spine'"),
        ({"kind": "SampleMeeting", "partner": "right", "mate": "lid"}, "go together"),
    ],
)
def test_a_monitor_that_means_nothing_is_told(stage: dict[str, Any], told: str) -> None:
    scene, kind = first(BARTENDER), stage["kind"]
    given = {key: value for key, value in stage.items() if key != "kind"}
    monitor = STAGES[kind]("m", "now", robot="left", object="bottle_1", **given)
    with pytest.raises(InitialisationError, match=f"'m': .*{told}"):
        check_meaning(Task("t", STAGES["CurrentState"]("now"), monitor), scene.context.scene)


def test_a_place_that_no_placement_family_fits_says_what_is_missing() -> None:
    """It was "has no placement family that fits", hundreds of times, where the region has no support."""
    description = load_problem(DOMAINS / BARTENDER).scene
    assert description is not None
    bare = replace(description.regions["anywhere"], support=None)
    scene = load_scene(replace(description, regions=dict(description.regions) | {"anywhere": bare}))
    stage = STAGES["SamplePlacement"]("p", "now", robot="left", object="bottle_1", region="anywhere")
    here = first_scene(scene, 0, lambda: False)
    refused = stage.refute(here.context, here.situation)
    assert refused is not None and refused.proof
    assert refused.comment == (
        "bottle_1 has no placement family that fits: standing names support.top, and anywhere has no support"
    )
    given = STAGES["SamplePlacement"](
        "p", "now", robot="left", object="bottle_1", region="anywhere", support="table"
    )
    assert given.refute(here.context, here.situation) is None
    held = hung(here, "bottle_1", "left.tool0", here.pose("bottle_1"))
    (again,) = stage.generate(held, PropertyResolver(stage.properties).values(), 0)
    assert again.comment == refused.comment and again.proof


def test_what_a_caller_gives_is_not_asked_for_before_it_is_given() -> None:
    task = Task(
        "t",
        make("CurrentState"),
        make("PoseGenerator", robot="arm", poses=Parent("there")),
        make("PredicateFilter", make("NoOp"), attached=[Parent("what"), "arm"]),
    )
    check_meaning(task, small(), Situation.of(small().start))


# -------------------------------------------------------------------------------------------- constraints that are kept
def holding(turn: float = 0.0) -> TaskScene:
    """The first scene of force sensing with an object upright in the arm's hand, turned about the tool's y axis."""
    scene = first(FORCE)
    name = next(iter(scene.situation.objects))
    robot = scene.robot("arm")
    tool = scene.context.surroundings.links("arm", scene.situation.robots["arm"][0])[robot.tool.frame]
    world_T = np.eye(4)
    world_T[:3, 3] = tool[:3, 3] + tool[:3, 2] * 0.16
    c, s = math.cos(turn), math.sin(turn)
    world_T[:3, :3] = [[c, 0, s], [0, 1, 0], [-s, 0, c]]
    return scene.placing(name, attachment(f"arm.{robot.tool.frame}", np.linalg.inv(tool) @ world_T))


def test_a_constraint_for_an_empty_hand_is_refused_by_its_name() -> None:
    for kind, more in (
        ("MoveTo", {"goal": "weigh"}),
        ("MoveRelative", {"direction": {"vector": [0.0, 0.0, 0.05]}}),
    ):
        found = forward(first(FORCE), kind, robot="arm", keep="upright", **more)
        assert isinstance(found, Refusal)
        assert (found.reason, found.comment) == ("constraint", "nothing can keep upright: arm holds nothing")
    other = forward(
        first(FORCE), "MoveTo", robot="arm", goal="weigh", keep={"object": "can_1", "constraint": "upright"}
    )
    assert other.comment == "nothing can keep upright: arm does not hold can_1"
    assert isinstance(forward(first(FORCE), "MoveTo", robot="arm", goal="weigh", keep=""), Result)


def test_an_end_that_breaks_what_is_kept_is_told_at_once_with_what_is_found_and_permitted() -> None:
    upright, tilted = holding(), holding(0.5)
    searched = tilted.context.surroundings.statistics.samples
    found = forward(tilted, "MoveTo", robot="arm", goal="weigh", keep="upright")
    assert found.reason == "constraint"
    assert found.comment.startswith("upright does not hold where it begins: found ")
    assert "permitted" in found.comment
    joints = list(upright.configuration("arm"))
    joints[5] += 0.4
    ended = forward(upright, "MoveTo", robot="arm", goal=joints, keep="upright", group="arm")
    assert ended.reason == "constraint"
    assert ended.comment.startswith("upright does not hold where it ends: found ")
    assert tilted.context.surroundings.statistics.samples == searched
    stroke = forward(tilted, "MoveRelative", robot="arm", direction={"vector": [0.0, 0.0, 0.03]}, keep="upright")
    assert stroke.comment.startswith("upright does not hold where it begins: found ")


# ------------------------------------------------------------------------------------------------------- supports
def test_supports_of_what_touches_something_that_no_family_knows_name_the_family_and_the_feature() -> None:
    found = forward(start(), "AllowContact", pairs=[["object", "supports"]])
    assert found.reason == "constraint"
    assert (
        found.comment
        == "object touches table, but no placement family of it says that it stands there: it has none"
    )
    scene = first(FORCE)
    name = next(iter(scene.situation.objects))
    assert isinstance(forward(scene, "AllowContact", pairs=[[name, "supports"]]), Result)
    sunk = scene.pose(name)
    sunk[2, 3] -= 0.004
    there = scene.placing(name, attachment("world", sunk))
    refused = forward(there, "AllowContact", pairs=[[name, "supports"]])
    assert "does not hold where it is" in refused.comment
    raised = scene.pose(name)
    raised[2, 3] += 0.3
    free = forward(scene.placing(name, attachment("world", raised)), "AllowContact", pairs=[[name, "supports"]])
    assert isinstance(free, Result), "what touches nothing needs no permission"


# ----------------------------------------------------------------------------------------------- places on a support
@settings(max_examples=max(30, round(2000 * PROPERTY_SCALE)), suppress_health_check=list(HealthCheck))
@given(
    x=st.floats(0.25, 0.75),
    y=st.floats(-0.55, 0.05),
    above=st.sampled_from([0.0, 0.0, 1e-4, 5e-4, 0.01]),
    turn=st.floats(0, 6.3),
)
def test_what_stands_on_a_support_does_so_with_all_its_base(x: float, y: float, above: float, turn: float) -> None:
    """Against the rectangle of the table's top and the circle of the object's base."""
    pose = transform((x, y, 0.125 + above), (0.0, 0.0, math.sin(turn / 2), math.cos(turn / 2)))
    scene = start()
    answer = ScenePredicates(scene.context.surroundings, scene.situation.first).stands_on("table", "object", pose)
    mesh = small().bodies["object"].mesh
    base = (mesh.vertices[mesh.vertices[:, 2] < -0.1249] @ pose[:3, :3].T + pose[:3, 3])[:, :2]
    room = min((base - (0.3, -0.5)).min(), ((0.7, 0.0) - base).min())  # inside the edges if above 0
    event("beyond" if room < 0 else "on")
    if abs(room) > 1e-6:
        assert answer == (room > 0.0 and above < 2e-3)


def test_place_poses_offer_nothing_beyond_the_edge_of_their_support() -> None:
    scene = start()
    held = scene.placing("object", attachment("arm.tool0", transform((0.0, 0.0, 0.13))))
    for x, offered in ((0.60, True), (0.695, False), (0.9, False)):
        stage = STAGES["PlacePoses"](
            "place",
            "now",
            robot="arm",
            object="object",
            pose={"position": [x, -0.25, 0.125]},
            support="table",
            symmetry=3,
        )
        found = list(stage.generate(held, PropertyResolver(stage.properties).values(), 0))
        assert [isinstance(each, Result) for each in found] == [offered] * 3
        if not offered:
            assert "is not proven to stand on table with all its base" in found[0].comment


# -------------------------------------------------------------------------------------------------------- strokes
@settings(max_examples=max(50, round(2000 * PROPERTY_SCALE)))
@given(
    edge=st.floats(0.0, 0.4),
    low=st.floats(0.0, 0.1),
    more=st.floats(0.0, 0.2),
    further=st.floats(0.0, 0.2),
    mm=st.booleans(),
)
@example(edge=0.036, low=0.0, more=0.036, further=0.125, mm=True)  # 36 times 1 mm is more than 36 mm
def test_the_farthest_is_the_longest_that_is_free_and_grows_with_the_greatest(
    edge: float, low: float, more: float, further: float, mm: bool
) -> None:
    """Against a scan of all lengths: never past the edge, within one step of it, and never shorter for a greater one."""
    high = low + (round(more, 3) if mm else more)
    higher = high + further
    asked: list[float] = []

    def attempt(distance: float) -> Any:
        asked.append(distance)
        return [np.array([distance])] if distance <= edge else Refusal("collision", f"{distance}")

    first_try, second = (farthest(attempt, low, most) for most in (high, higher))
    reached = [None if isinstance(found, Refusal) else float(found[0][0]) for found in (first_try, second)]
    event("nothing" if reached[0] is None else "whole" if reached[0] == high else "part")
    for found, most in zip(reached, (high, higher), strict=True):
        if found is None:
            assert edge < low or edge < most <= low
        else:
            assert low <= found <= max(most, low)
            assert found <= edge
            assert found > min(edge, most) - RESOLUTION - 1e-12
    if reached[0] is not None:
        assert reached[1] is not None
        assert reached[1] >= reached[0] - (1e-12 if mm else RESOLUTION)
    assert len(asked) <= 2 * (2 + 10)


@settings(max_examples=max(6, round(60 * PROPERTY_SCALE)), suppress_health_check=list(HealthCheck))
@given(
    least=st.sampled_from([0.0, 0.01, 0.02]),
    lengths=st.lists(st.integers(30, 400), min_size=2, max_size=4, unique=True),
    aside=st.tuples(st.floats(-0.05, 0.05), st.floats(-0.05, 0.05)),
)
def test_a_greater_greatest_length_never_gives_a_shorter_stroke(
    least: float, lengths: list[int], aside: Any
) -> None:
    """The arm moves down to the table, in a real scene: an oracle tries every millimetre."""
    scene = start()
    begun = forward(scene, "MoveRelative", robot="arm", direction={"vector": [aside[0], aside[1], 0.02]})
    if isinstance(begun, Result):
        scene = begun.scene
    down = {"vector": [0.0, 0.0, -1.0]}
    stage_of = {"robot": "arm", "direction": down}

    def height(at: TaskScene) -> float:
        robot = at.robot("arm")
        return float(at.context.surroundings.links("arm", at.situation.robots["arm"][0])[robot.tool.frame][2, 3])

    found = {}
    for most in sorted(lengths):
        answer = forward(scene, "MoveRelative", **stage_of, min_distance=least, max_distance=most / 1000)
        assert isinstance(answer, Result), answer
        found[most] = height(scene) - height(answer.scene)
    strokes = list(found.values())
    assert all(b >= a - 2e-5 for a, b in zip(strokes, strokes[1:], strict=False)), found
    most = max(found)
    event("whole" if abs(found[most] - most / 1000) < 1e-4 else "part")
    beyond = found[most] + RESOLUTION + 1e-4
    if beyond < most / 1000:
        longer = forward(scene, "MoveRelative", **stage_of, min_distance=beyond, max_distance=beyond)
        assert isinstance(longer, Refusal), "a longer one could be proven"
