"""BIMANUAL ASSEMBLY: all seven actions, subassemblies that move as one, contact of mating parts only [K Table 6.6]."""

from collections.abc import Mapping
from functools import cache
from itertools import combinations

import numpy as np
import pytest

import kabo
from kabo.geometry_server import GeometryServer, Refusal, Situation, Success
from kabo.language.formulas import GroundCall
from kabo.plan import Segment
from kabo.scene import world_T
from kabo.tasks.procedures import GeometricProcedures
from tests.domains.scenes import DOMAINS, problem_of, scene_of

GEARBOX = DOMAINS / "assembly" / "gearbox.yaml"
BEARING_ON_TREE, BEARING_IN_PIPE, PIPE_ON_TREE = (
    (("mate", name),) for name in ("bearing_on_tree", "bearing_in_pipe", "pipe_on_tree")
)
PLAN = (
    GroundCall("pick", ("robot_1", "o1")),
    GroundCall("insert", ("robot_1", "o1", "o4"), BEARING_ON_TREE),
    GroundCall("pick", ("robot_1", "o3")),
    GroundCall("pick", ("robot_2", "o2")),
    GroundCall("insert_bimanual", ("robot_1", "o3", "robot_2", "o2"), BEARING_IN_PIPE),
    GroundCall("insert", ("robot_1", "o3", "o4"), PIPE_ON_TREE),
)


@cache
def asked(seed: int) -> GeometricProcedures:
    return GeometricProcedures(GeometryServer(scene_of(GEARBOX), seed=seed), GEARBOX.parent)


@cache
def ran(*calls: GroundCall, seed: int = 0) -> tuple[Situation, tuple[Segment, ...]]:
    """What is where after some calls, and the motion of the last."""
    if not calls:
        return Situation.of(scene_of(GEARBOX).start), ()
    before, _ = ran(*calls[:-1], seed=seed)
    answer = asked(seed).call(calls[-1], before)
    assert isinstance(answer, Success), answer
    return before.replace(answer.changes), answer.motion


def parents(situation: Situation) -> Mapping[str, str]:
    return {name: value.parent for name, (value,) in situation.objects.items()}


def poses(situation: Situation) -> Mapping[str, np.ndarray]:
    return {name: world_T(scene_of(GEARBOX), situation.first, name) for name in situation.objects}


@pytest.mark.parametrize("search", [None, "breadth-first"])
def test_the_gearbox_takes_six_actions(search):
    result = kabo.solve(problem_of(GEARBOX), search=search)
    actions = [node.action for node in result.plan.nodes.values() if node.action]
    assert len(actions) == 6
    assert sorted(actions[:-1]) == sorted([*["pick_up"] * 3, "assemble_bearing_tree", "assemble_pipe_bearing"])
    assert actions[-1] == "assemble_pipe_tree"
    assert result.statistics["collision_checks"] <= 3000


def test_the_plan_is_verified_by_who_did_not_make_it():
    problem = problem_of(GEARBOX)
    report = kabo.verify_plan(problem, kabo.solve(problem, seed=7).plan)
    assert report.ok, report.findings


def test_after_each_assembly_the_moving_part_hangs_on_the_fixed_one():
    assert parents(ran(*PLAN[:2])[0])["o1"] == "o4"
    assert parents(ran(*PLAN[:5])[0]) == {"o1": "o4", "o2": "o3", "o3": "robot_1.tool0", "o4": "world"}
    assert parents(ran(*PLAN)[0]) == {"o1": "o4", "o2": "o3", "o3": "o4", "o4": "world"}


def test_parts_are_put_together_as_their_mates_say():
    at = poses(ran(*PLAN)[0])
    for moving, fixed, height in (("o1", "o4", 0.07), ("o2", "o3", 0.09), ("o3", "o4", 0.03)):
        between = np.linalg.inv(at[fixed]) @ at[moving]
        assert between[:3, 3] == pytest.approx([0, 0, height], abs=1e-5)
        assert between[:3, 2] == pytest.approx([0, 0, 1], abs=1e-5)


def test_a_gearbox_that_is_taken_by_its_pipe_moves_as_one():
    assembled = ran(*PLAN)[0]
    taken, motion = ran(*PLAN, GroundCall("pick", ("robot_1", "o3")))
    assert parents(taken) == {"o1": "o4", "o2": "o3", "o3": "robot_1.tool0", "o4": "o3"}
    assert [attached for segment in motion for attached in segment.attach] == [("o3", "robot_1.tool0")]
    before, lifted = poses(assembled), poses(taken)
    carried = poses(ran(*PLAN, GroundCall("pick", ("robot_1", "o3")), GroundCall("move", ("robot_1",)))[0])
    assert np.linalg.norm(carried["o3"][:3, 3] - lifted["o3"][:3, 3]) > 0.05
    for first, second in combinations(before, 2):
        for after in (lifted, carried):
            between = np.linalg.inv(before[first]) @ before[second], np.linalg.inv(after[first]) @ after[second]
            assert between[0] == pytest.approx(between[1], abs=1e-7)


def test_only_the_mating_parts_and_the_hands_that_hold_them_may_touch():
    for count, mating, held in (
        (2, {"o1", "o4"}, {"o1"}),
        (5, {"o2", "o3"}, {"o2", "o3"}),
        (6, {"o3", "o4"}, {"o3"}),
    ):
        motion = ran(*PLAN[:count])[1]
        met = {frozenset(pair) for segment in motion for pair in segment.allowed_contacts}
        hands = {pair for pair in met if any("finger" in name for name in pair)}
        assert {name for pair in hands for name in pair if "finger" not in name} == held
        assert met - hands == {frozenset(mating)}
        strokes = [s for s in motion if any(set(pair) == mating for pair in s.allowed_contacts)]
        assert {segment.stage for segment in strokes} <= {"insert/insertion"}
        assert strokes


def test_two_robots_move_one_after_the_other_while_they_meet():
    motion = ran(*PLAN[:5])[1]
    assert [segment.robot for segment in motion][:2] == ["robot_1", "robot_2"]
    assert all(a.times[-1] <= b.times[0] for a, b in zip(motion, motion[1:], strict=False))
    joined = [segment for segment in motion if segment.attach]
    assert [(s.robot, s.attach, s.detach) for s in joined] == [("robot_2", (("o2", "o3"),), ("o2",))]


@pytest.mark.parametrize(
    ("giver", "receiver", "name"), [("robot_1", "robot_2", "o1"), ("robot_2", "robot_1", "o2")]
)
def test_a_bearing_is_handed_over_from_either_robot(giver, receiver, name):
    calls = GroundCall("pick", (giver, name)), GroundCall("hand_over", (giver, name, receiver))
    after, motion = ran(
        *calls, seed=1
    )  # with seed 0 the second one takes ten seconds, with others a quarter of one
    assert parents(after)[name] == f"{receiver}.tool0"
    taken = next(segment for segment in motion if segment.attach)
    let_go = next(segment for segment in motion if segment.detach)
    assert taken.robot == receiver
    assert let_go.robot == giver
    assert taken.times[-1] <= let_go.times[0]
    assert motion[-1].robot == giver  # it retreats


@pytest.mark.parametrize(("robot", "name"), [("robot_1", "o1"), ("robot_1", "o3"), ("robot_2", "o2")])
def test_what_was_picked_up_is_put_down(robot, name):
    calls = GroundCall("pick", (robot, name)), GroundCall("place", (robot, name, "work_area"))
    assert parents(ran(*calls)[0])[name] == "world"


def test_nothing_is_held_by_a_robot_that_has_no_grasp_for_it():
    answer = asked(0).call(GroundCall("pick", ("robot_2", "o3")), ran()[0])
    assert isinstance(answer, Refusal)
    assert answer.reason == "empty_family"
    assert answer.proof


def test_a_bearing_that_is_held_from_inside_does_not_go_on_the_tree():
    handed = GroundCall("pick", ("robot_1", "o1")), GroundCall("hand_over", ("robot_1", "o1", "robot_2"))
    held = ran(*handed)[0]
    answer = asked(0).call(GroundCall("insert", ("robot_2", "o1", "o4"), BEARING_ON_TREE), held)
    assert isinstance(answer, Refusal)


def test_parts_fit_with_little_air_where_they_are_mated_and_six_millimetres_elsewhere():
    scene = scene_of(GEARBOX)
    bearing, pipe, tree = (scene.bodies[name].mesh.vertices for name in ("o1", "o3", "o4"))

    def radii(points: np.ndarray, low: float, high: float) -> np.ndarray:
        chosen = points[(points[:, 2] > low) & (points[:, 2] < high)]
        return np.linalg.norm(chosen[:, :2], axis=1)

    outer, bore = radii(bearing, 0.0, 0.024).max(), radii(bearing, 0.0, 0.024).min()
    assert 0.0001 < radii(pipe, 0.0901, 0.117).min() - outer < 0.0003
    assert 0.0001 < bore - radii(tree, 0.071, 0.0939).max() < 0.0003
    assert radii(pipe, 0.001, 0.0829).min() - outer >= 0.0059  # the bearing of the tree inside the pipe
    assert bore - radii(tree, 0.0965, 0.14).max() >= 0.0085  # the end of the tree inside the bearing of the pipe


@pytest.mark.slow
def test_parts_that_are_alike_do_not_make_the_search_prove_that_each_refused_plan_was_cheapest():
    """A count of expansions, not a time: it was 224,000 while each proof might take 20,000."""
    result = kabo.solve(kabo.load_problem(DOMAINS / "assembly" / "two_gearboxes.yaml"))
    assert result.plan is not None and result.statistics["plan_actions"] == 12  # noqa: PLR2004
    assert result.statistics["expanded"] < 100_000  # noqa: PLR2004
