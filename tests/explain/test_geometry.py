"""Explanations of problems that knowledge solves and geometry does not: a gantry whose reach is told by hand."""

import re
from pathlib import Path

import jsonschema
import numpy as np
import pytest

from kabo.explain.explain import Explanation, explain, explanation_to_json
from kabo.explain.findings import BaseMoved, BodyRemoved, SmallerEpsilon
from kabo.explain.samples import MAX_PER_ROW
from kabo.explain.scene_changes import changed, removable
from kabo.geometry_server import GeometryServer
from kabo.plan import schema
from kabo.planner.solve import solve
from kabo.scene import load_scene
from kabo.tasks.robots import TaskScene
from kabo.verify import verify_plan
from tests.planner.gantry import gantry_problem

SCHEMA = schema("kabo-explain-1")
LID = {"lid": ((0.2, 0.2, 0.01), (0.2, 0.0, 0.1))}  # over the cube
TABLE_TOP = 0.02  # the height of a cube that stands on the table
GAP = 0.003  # between an open finger and the wall of a slot
SLOT = {
    "wall_1": ((0.02, 0.2, 0.06), (0.2 + 0.045 + GAP + 0.01, 0.0, 0.03)),
    "wall_2": ((0.02, 0.2, 0.06), (0.2 - 0.045 - GAP - 0.01, 0.0, 0.03)),
}


def explained(folder: Path, *, options: dict[str, object] | None = None, **given: object) -> Explanation:
    chosen = {"max_samples": 4000, "timeout": 600.0} | (options or {})
    found = explain(gantry_problem(folder, **given), **chosen)  # type: ignore[arg-type]
    jsonschema.validate(explanation_to_json(found), SCHEMA)
    return found


def first(found: Explanation) -> dict[str, object]:
    return explanation_to_json(found)["procedures"][0]


def best(found: Explanation) -> dict[str, object]:
    return explanation_to_json(found)["counterfactuals"][0]


def test_what_works_needs_no_explanation(tmp_path: Path) -> None:
    found = explained(tmp_path)
    assert found.summary == ("There is a plan, with a motion for every action.",)
    assert (found.verdict, found.findings, found.counterfactuals) == ("solvable", (), ())


def test_what_nobody_can_know_is_proven_and_no_geometry_is_asked(tmp_path: Path) -> None:
    found = explained(tmp_path, goal="K(dusty(cube))", walls=LID)
    assert found.verdict == "proved" and not found.reachable
    assert found.summary[0].startswith("There is no plan, whatever geometry says: K(dusty(cube))")
    assert (found.findings, found.counterfactuals) == ((), ())


@pytest.mark.parametrize(
    ("at", "missing"), [((0.62, 0.0), 0.12), ((-0.56, 0.58), 0.1), ((0.3, -0.54), 0.04)], ids=str
)
def test_how_far_out_of_reach_is_what_the_rails_lack(
    tmp_path: Path, at: tuple[float, float], missing: float
) -> None:
    found = explained(tmp_path, things={"cube": (*at, TABLE_TOP)})
    assert found.verdict == "exhausted"
    assert found.summary[0] == "No plan was found: pick(gantry, cube) never succeeded."
    assert found.summary[1].startswith(f"It is out of reach by {missing:.3f} m: ")
    assert "With the base of gantry moved by (" in found.summary[2]
    (failure,) = first(found)["failures"]
    assert failure["reason"] == "out_of_reach" and abs(failure["missing"] - missing) < 1e-3
    by = np.array(best(found)["change"]["move_base"]["by"])
    lacking = np.array(at) - np.clip(at, -0.5, 0.5)
    assert np.linalg.norm(by) < missing + 0.12 and by[2] == 0.0
    assert np.allclose(by[:2] / np.linalg.norm(by), lacking / missing, atol=0.05)
    assert (best(found)["result"], best(found)["plan_actions"]) == ("solved", 2)


def test_the_body_that_blocks_is_named_with_its_share(tmp_path: Path) -> None:
    found = explained(tmp_path, walls=LID | {"far_away": ((0.1, 0.1, 0.1), (-0.2, 0.4, 0.05))})
    assert found.verdict == "exhausted"
    (failure,) = first(found)["failures"]
    assert failure["between"] == ["gantry.hand", "lid"] and failure["count"] == first(found)["calls"] >= 40
    assert failure["because_of_epsilon"] == 0 and first(found)["successes"] == 0
    assert found.summary == (
        "No plan was found: pick(gantry, cube) never succeeded.",
        f"It was blocked by lid in {failure['count']} of {failure['count']} samples (100 %).",
        "Without lid a plan of 2 actions exists.",
    )
    wanted = {"change": {"remove": "lid"}, "plan_actions": 2, "result": "solved", "said": "without lid"}
    assert best(found) == wanted and first(found)["without"] == {"lid": failure["count"]}


def test_a_change_is_tried_with_few_samples_only_if_the_problem_has_few(tmp_path: Path) -> None:
    found = explained(tmp_path, walls=LID, options={"max_samples": 300})
    assert found.summary[-1] == "Without lid a plan of 2 actions exists."


def test_a_change_that_does_not_help_is_told_with_how_much_was_tried(tmp_path: Path) -> None:
    two = LID | {"board": ((0.2, 0.2, 0.01), (0.2, 0.0, 0.13))}
    found = explained(tmp_path, walls=two, options={"max_samples": 300, "changes": 2})
    assert {each.result for each in found.counterfactuals} == {"exhausted"}
    said = [re.search(r"no proof: (\d+) samples were tried", line) for line in str(found).splitlines()]
    assert [int(each[1]) >= 300 for each in said if each] == [True] * len(found.counterfactuals)


def test_samples_show_the_robot_where_it_was_refused(tmp_path: Path) -> None:
    (row,) = explained(tmp_path, walls=LID).findings[0].rows
    samples = explained(tmp_path, walls=LID).findings[0].samples
    assert 0 < len(samples) <= MAX_PER_ROW < row.count
    problem = gantry_problem(tmp_path, walls=LID)
    assert problem.scene is not None
    first_scene = TaskScene.of(
        GeometryServer(load_scene(problem.scene)).context(), load_scene(problem.scene).start
    )
    for sample in samples:
        assert sample.row == 0 and sample.between == ("gantry.hand", "lid")
        assert first_scene.at("gantry", sample.state.robots["gantry"].values()).hit("gantry") == sample.between


def test_a_place_that_is_taken_is_blamed_on_what_stands_there(tmp_path: Path) -> None:
    box = {"box": ((0.18, 0.18, 0.1), (-0.3, 0.0, 0.05))}
    found = explained(tmp_path, walls=box)
    assert found.summary[0].endswith("place(gantry, cube, shelf) never succeeded.")
    assert "blocked by box" in found.summary[1] and "(9" in found.summary[1]
    assert found.summary[2] == "Without box a plan of 2 actions exists."


def test_a_wall_without_a_way_around_is_named(tmp_path: Path) -> None:
    wall = {"wall": ((0.02, 2.4, 1.6), (0.12, 0.0, 0.8))}
    found = explained(tmp_path, walls=wall)
    assert "blocked by wall" in found.summary[1]
    assert any(row.reason == "no_path" for row in found.findings[0].rows)
    assert found.summary[2] == "Without wall a plan of 2 actions exists."


def test_what_only_epsilon_refuses_is_told_apart(tmp_path: Path) -> None:
    found = explained(tmp_path, epsilon=0.05, walls=SLOT)
    (failure,) = first(found)["failures"]
    assert failure["because_of_epsilon"] == failure["count"] == first(found)["calls"]
    assert found.summary[1].startswith("It was refused only because of epsilon = 0.05 in ")
    assert found.summary[2] == "With epsilon = 0.0125 a plan of 2 actions exists."
    assert best(found)["change"] == {"epsilon": 0.0125}


def test_a_wall_that_truly_blocks_is_not_blamed_on_epsilon(tmp_path: Path) -> None:
    narrow = {name: (size, (0.2 + 0.9 * (at[0] - 0.2), *at[1:])) for name, (size, at) in SLOT.items()}
    found = explained(tmp_path, epsilon=0.05, walls=narrow)
    assert sum(row.because_of_epsilon for row in found.findings[0].rows) == 0
    assert not any(isinstance(each.change, SmallerEpsilon) for each in found.counterfactuals)


def test_no_grasp_for_this_robot_is_a_proof(tmp_path: Path) -> None:
    found = explained(tmp_path, robots="robots: []")
    assert (found.verdict, found.counterfactuals) == ("proved", ())
    assert found.summary[0] == "There is no plan, which is proven: pick(gantry, cube) can never succeed."
    assert found.summary[1] == "cube has no grasp family that gantry can use."
    assert first(found)["failures"][0]["reason"] == "empty_family"


@pytest.mark.parametrize(
    ("options", "said"),
    [
        ({"max_expansions": 0, "search": "breadth-first"}, "as many nodes as allowed"),
        ({"max_samples": 0}, "more samples might help"),
    ],
    ids=["expansions", "samples"],
)
def test_a_budget_that_runs_out_is_named(tmp_path: Path, options: dict[str, object], said: str) -> None:
    found = explained(tmp_path, options=options)
    assert found.verdict == "exhausted"
    assert said in " ".join(found.summary)


def test_the_same_explanation_every_time(tmp_path: Path) -> None:
    two = [explained(tmp_path, walls=LID, options={"changes": 1}) for _ in range(2)]
    assert two[0] == two[1] and str(two[0]) == str(two[1])


def test_what_the_goal_or_a_call_names_is_never_thought_away(tmp_path: Path) -> None:
    things = {"cube": (0.2, 0.0, TABLE_TOP), "other": (0.2, 0.0, TABLE_TOP + 0.04)}  # on top of the cube
    problem = gantry_problem(tmp_path, things=things, walls=LID, goal="forall(thing o) K(at(o, shelf))")
    assert [removable(problem, name) for name in ("cube", "other", "table", "lid")] == [False] * 3 + [True]
    problem = gantry_problem(tmp_path, things=things, walls=LID)
    assert [removable(problem, name) for name in ("cube", "other", "nothing")] == [False, True, False]


def test_a_thing_that_is_thought_away_leaves_knowledge_as_well(tmp_path: Path) -> None:
    things = {"cube": (0.2, 0.0, TABLE_TOP), "other": (0.2, 0.0, TABLE_TOP + 0.04)}
    found = explained(tmp_path, things=things)
    assert found.verdict == "solvable"  # the other cube is taken away first
    problem = gantry_problem(tmp_path, things=things)
    assert problem.scene is not None
    without = changed(problem, load_scene(problem.scene), BodyRemoved("other"))
    assert "other" not in without.objects and without.scene is not None and "other" not in without.scene.bodies
    assert solve(without).status == "solved"


def test_every_change_that_helps_does_so_from_scratch(tmp_path: Path) -> None:
    problem = gantry_problem(tmp_path, things={"cube": (0.54, 0.0, TABLE_TOP)})
    assert problem.scene is not None
    scene = load_scene(problem.scene)
    assert solve(problem, max_samples=2000).status == "exhausted"
    change = BaseMoved("gantry", (0.1, 0.0, 0.0))
    moved = changed(problem, scene, change)
    found = solve(moved)
    assert found.plan is not None and verify_plan(moved, found.plan).ok
    assert moved.scene is not None and moved.scene != problem.scene
