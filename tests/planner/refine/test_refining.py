"""Refined plans: never longer, never slower, the same state at every branch and merge, free by an independent judge."""

import json
from functools import cache
from types import SimpleNamespace

import jsonschema
import numpy as np
import pytest

import kabo
from kabo.geometry_server import Success
from kabo.plan import Plan, plan_from_json, plan_to_json, schema
from kabo.planner.refine.refining import _independent
from kabo.planner.refine.refining_stops import Stop
from kabo.planner.result import result_to_json
from tests.domains.scenes import DOMAINS, problem_of, scene_of
from tests.support.oracles_motions import collisions

BOTH_ARMS = """problem: both_arms
domain: {home}/domain.yaml
scene: {home}/scene.yaml
objects:
  robot: [left, right]
  bottle: [bottle_1, bottle_4]
bodies:
  bottle_1: {{model: bottle, pose: {{frame: table, position: [0.175, 0.690, 0.02]}}}}
  bottle_4: {{model: bottle, pose: {{frame: table, position: [0.075, -0.230, 0.02]}}}}
initial:
  - add(Kf, hand_empty(left), hand_empty(right))
  - forall(bottle o) add(Kf, not grasped(o))
goal:
  - K(robot_grasps(left, bottle_1))
  - K(robot_grasps(right, bottle_4))
"""
CASES = ["stacked/n2.yaml", "force_sensing/n1.yaml"]


@cache
def planned(case: str, quality: str):
    result = kabo.solve(problem_of(DOMAINS / case), quality=quality)
    assert result.plan is not None
    return result


def way(plan: Plan) -> float:
    segments = [segment for node in plan.nodes.values() for segment in node.motion]
    return sum(float(np.linalg.norm(np.diff(np.array(s.waypoints), axis=0), axis=1).sum()) for s in segments)


@pytest.mark.parametrize("case", CASES)
def test_a_refined_plan_is_shorter_and_no_slower(case):
    statistics = planned(case, "good").statistics
    assert statistics["path_length"] < statistics["path_length_found"]
    assert statistics["duration"] <= statistics["duration_found"]
    assert way(planned(case, "good").plan) < way(planned(case, "fast").plan)


@pytest.mark.parametrize("case", CASES)
def test_a_refined_plan_has_the_nodes_that_were_found(case):
    fast, good = (planned(case, quality).plan for quality in ("fast", "good"))
    told = [[(n.kind, n.action, dict(n.arguments), n.successors) for n in p.nodes.values()] for p in (fast, good)]
    assert told[0] == told[1]
    taken = [
        [(s.stage, s.attach, s.detach) for n in p.nodes.values() for s in n.motion if s.attach or s.detach]
        for p in (fast, good)
    ]
    assert taken[0] == taken[1]


@pytest.mark.parametrize("case", CASES)
def test_a_refined_plan_is_verified_and_free_by_sampling_the_exact_meshes(case):
    problem, plan = problem_of(DOMAINS / case), planned(case, "good").plan
    report = kabo.verify(problem, plan)
    assert report.ok, report.findings
    assert not list(collisions(scene_of(DOMAINS / case), plan, list(plan.nodes)))


def test_an_assembly_is_faster_early_and_verified_though_parts_hang_on_parts():
    case, seed = "assembly/gearbox.yaml", 3  # where motion with a part that hangs on another one becomes faster
    result, fast = (kabo.solve(problem_of(DOMAINS / case), seed=seed, quality=how) for how in ("good", "fast"))
    statistics, fast = result.statistics, fast.plan
    assert statistics["duration"] < 0.9 * statistics["duration_found"]
    assert kabo.verify(problem_of(DOMAINS / case), result.plan).ok
    hanging = [n for n in result.plan.nodes.values() if any("." not in to for s in n.motion for _, to in s.attach)]
    assert hanging
    changed = [name for name, node in result.plan.nodes.items() if node.motion != fast.nodes[name].motion]
    assert {name for name, node in result.plan.nodes.items() if node in hanging} & {*changed}


def test_refinement_is_the_same_on_every_run():
    case = CASES[0]
    again = kabo.solve(kabo.load_problem(DOMAINS / case), quality="good")
    assert plan_to_json(again.plan) == plan_to_json(planned(case, "good").plan)


def test_only_good_plans_say_their_quality_and_what_it_came_to():
    fast, good = (planned(CASES[0], quality) for quality in ("fast", "good"))
    assert "quality" not in fast.plan.options
    assert good.plan.options["quality"] == "good"
    assert "path_length" not in fast.statistics


def test_refined_plans_and_their_figures_are_as_the_schemas_say():
    result = planned(CASES[0], "good")
    jsonschema.validate(json.loads(plan_to_json(result.plan)), schema("kabo-plan-2"))
    body = result_to_json(result)
    jsonschema.validate(body, schema("kabo-result-1"))
    assert body["statistics"]["path_length"] < body["statistics"]["path_length_found"]
    assert plan_from_json(plan_to_json(result.plan)) == result.plan


def test_both_arms_move_at_once_where_they_cannot_meet(tmp_path):
    path = tmp_path / "both_arms.yaml"
    path.write_text(BOTH_ARMS.format(home=DOMAINS / "bartender"))
    problem = kabo.load_problem(path)
    plan = kabo.solve(problem, quality="good").plan
    early = [node for node in plan.nodes.values() if node.overlap > 0.0]
    assert len(early) == 1
    assert kabo.verify(problem, plan).ok
    lasting = [max(s.times[-1] for s in node.motion) for node in plan.nodes.values() if node.motion]
    assert early[0].overlap > 0.5 * min(lasting)


def _stop(reads: int, writes: int) -> Stop:
    """A node that moves, asks for some bits of knowledge and changes others."""
    action = SimpleNamespace(call=object(), reads=reads, effects=SimpleNamespace(writes=writes))
    answer = Success((None,), {})  # type: ignore[arg-type]
    variant = SimpleNamespace(node=SimpleNamespace(action=action), following={None: None}, answer=answer)
    return Stop([variant], None, ways_in=1)  # type: ignore[list-item, arg-type]


@pytest.mark.parametrize(("reads", "free"), [(0b1001, True), (0b0011, False)])
def test_a_node_waits_for_the_knowledge_that_it_needs(reads, free):
    first, after = _stop(0, 0b0110), _stop(reads, 0)
    server = SimpleNamespace(single=lambda call, _: ("left",) if call is first.call else ("right",))
    assert _independent(first, after, server) is free  # type: ignore[arg-type]


def test_a_node_waits_for_the_robot_and_the_objects_that_move():
    server = SimpleNamespace(single=lambda call, _: ("left", "cup"))
    assert not _independent(_stop(0, 0), _stop(0, 0), server)  # type: ignore[arg-type]
