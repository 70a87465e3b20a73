"""Plans that begin in the state of a run: after every step of every domain a plan is found, verified, and continued."""

import json
import random
from contextlib import suppress
from dataclasses import replace
from pathlib import Path

import jsonschema
import pytest

import kabo
from kabo.errors import InputError
from kabo.geometry_server import whole_state
from kabo.knowledge import ground
from kabo.plan import Done, History, Plan, State, load_state, plan_from_json, plan_to_json, schema
from kabo.plan.state import changed
from kabo.planner.continuing import knowledge_after
from tests.planner.gantry import gantry_problem

DOMAINS = Path(__file__).parents[2] / "domains"
SEEDS = 2
KNOWLEDGE = (
    "asking_bartender/n3", "bomb_in_the_toilet/n3", "btcs/n4", "canadian_traveller/n3", "coloured_balls/n3_1", "doors/n3",
    "elogistics/n3", "grid/n3", "logistics/n3", "medicate/n5", "painted_doors/n3", "poisonous_liquid/n2", "rovers/n4",
    "safes/n3_with_note", "unix/n2", "wumpus/n4",
)  # fmt: skip


DISH_DOMAIN = """\
domain: dishes
types: [dish]
predicates: {whole: [dish], clean: [dish]}
actions:
  wash: {parameters: {d: dish}, preconditions: ["K(whole(d))"], effects: ["add(Kf, clean(d))"]}
  drop: {parameters: {d: dish}, preconditions: ["K(whole(d))"], effects: ["add(Kf, not whole(d))"]}
"""
DISH_PROBLEM = """\
problem: dishes
domain: domain.yaml
objects: {dish: [cup]}
initial: ["add(Kf, whole(cup))"]
goal: ["K(clean(cup))", "K(whole(cup))"]
"""


def way_through(problem: kabo.Problem, plan: Plan, seed: int) -> History:
    """All nodes of a branch but the goal, with outcomes drawn by the seed of those that are possible."""
    dice, history, name, task = random.Random(seed), [], plan.root, ground(problem)
    while (node := plan.nodes[name]).kind != "goal":
        outcome = None
        for outcome in dice.sample(list(node.branches), len(node.branches)):
            with suppress(InputError):  # branches share nodes: not every outcome is possible on every way there
                knowledge_after(task, kabo.after(problem, plan, [*history, (name, outcome)]).done)
                break
        history.append((name, outcome))
        name = str(node.next) if outcome is None else node.branches[outcome]
    return history


@pytest.mark.parametrize("name", KNOWLEDGE)
def test_after_every_step_of_a_run_the_rest_is_planned_and_proven(name: str) -> None:
    problem = kabo.load_problem(DOMAINS / f"{name}.yaml")
    plan = kabo.solve(problem).plan
    assert plan is not None
    whole = plan.statistics.plan_actions
    for seed in range(SEEDS):
        way = way_through(problem, plan, seed)
        for count in {0, 1, len(way) // 2, len(way) - 1}:
            state = kabo.after(problem, plan, way[:count])
            found = kabo.solve(problem, start=state)
            assert found.plan is not None and found.plan.done == state.done, (name, count)
            report = kabo.verify(problem, found.plan, start=state)
            assert report.ok, report
            acted = sum(1 for step in state.done if step.action is not None)
            assert found.plan.statistics.plan_actions <= max(whole, 1) + acted
        assert kabo.solve(problem, start=kabo.after(problem, plan, way)).plan.statistics.plan_actions == 0  # type: ignore[union-attr]


@pytest.mark.parametrize("name", ["stacked/n2", "bartender/four_bottles", "doors/n3", "unix/n2"])
def test_a_state_that_was_foreseen_continues_the_plan_and_searches_nothing(name: str) -> None:
    problem, memo = kabo.load_problem(DOMAINS / f"{name}.yaml"), kabo.Memo()
    plan = kabo.solve(problem, memo=memo).plan
    assert plan is not None
    for seed in range(SEEDS):
        way = way_through(problem, plan, seed)
        for count in range(len(way)):
            state = kabo.after(problem, plan, way[:count])
            found = kabo.solve(problem, start=state, memo=memo)
            assert found.plan is not None and found.statistics["expanded"] == 0
            assert found.plan.root == way[count][0]
            assert all(found.plan.nodes[node] == plan.nodes[node] for node in found.plan.nodes)
            if count == len(way) - 1:
                report = kabo.verify(problem, found.plan, start=state)
                assert report.ok, report
                content = plan_to_json(found.plan)
                assert plan_from_json(content) == found.plan
                jsonschema.Draft202012Validator(schema("kabo-plan-2")).validate(json.loads(content))


def test_a_body_that_was_moved_is_lifted_from_where_it_rests_and_the_same_actions_are_tried_first() -> None:
    problem, memo = kabo.load_problem(DOMAINS / "stacked" / "n2.yaml"), kabo.Memo()
    plan = kabo.solve(problem, memo=memo).plan
    assert plan is not None
    state = kabo.after(problem, plan)
    assert state.geometry is not None
    for name, shift in (("o1", (0.012, 0.004)), ("o2", (-0.006, 0.009))):
        old = state.geometry.objects[name]
        x, y, z = old.position
        moved = replace(old, position=(x + shift[0], y + shift[1], z))
        begun = kabo.after(problem, plan, objects={name: moved})
        again = [kabo.solve(problem, start=begun).plan for _ in range(2)]
        assert again[0] is not None and plan_to_json(again[0]) == plan_to_json(again[1])  # type: ignore[arg-type]
        found = kabo.solve(problem, start=begun, memo=memo).plan
        assert memo.continued and found is not None
        assert [node.action for node in found.nodes.values()] == [node.action for node in plan.nodes.values()]
        for each in (again[0], found):
            assert kabo.verify(problem, each, start=begun).ok
            assert not kabo.verify(problem, each, start=state).ok  # there it is elsewhere
        assert not kabo.verify(problem, replace(found, done=None)).ok
        memo = kabo.Memo.of_plan(problem, plan)  # as another process has it


def test_motion_of_a_plan_from_elsewhere_does_not_pass_for_this_state() -> None:
    problem = kabo.load_problem(DOMAINS / "stacked" / "n2.yaml")
    plan = kabo.solve(problem).plan
    assert plan is not None and plan.start is not None
    x, y, z = plan.start.objects["o2"].position
    pushed = replace(plan.start.objects["o2"], position=(x + 0.03, y, z))
    begun = kabo.after(problem, plan, objects={"o2": pushed})
    lying = replace(plan, start=begun.geometry, done=())
    report = kabo.verify(problem, lying, start=begun)
    assert not report.ok and any("o2" in finding.message for finding in report.findings)
    report = kabo.verify(problem, replace(plan, done=()), start=begun)
    assert [each.message for each in report.findings] == ["start: o2 is not where it is in the run"]


def test_what_was_done_must_have_been_possible() -> None:
    problem = kabo.load_problem(DOMAINS / "doors" / "n3.yaml")
    plan = kabo.solve(problem).plan
    assert plan is not None
    done = kabo.after(problem, plan, way_through(problem, plan, 1)).done
    acted = next(step for step in done if step.action is not None and step.on is None)
    observed = next(step for step in done if step.on is not None)
    wrong = {
        "no action": replace(acted, action="fly"),
        "no action that matters": replace(acted, arguments=dict.fromkeys(acted.arguments, "nowhere")),
        "nothing that can be observed": replace(observed, on="open(moon)"),
        "no value of": replace(observed, outcome="perhaps"),
    }
    for text, step in wrong.items():
        state = State((*done[: done.index(acted)], step))
        with pytest.raises(InputError, match=text.removeprefix("no action that") or text):
            kabo.solve(problem, start=state)
        assert not kabo.verify(problem, replace(plan, done=state.done), start=state).ok
    for skipped in range(len(done)):
        state = State((*done[:skipped], *done[skipped + 1 :]))
        try:
            found = kabo.solve(problem, start=state).plan
        except InputError as error:
            assert "step" in str(error)
            continue
        assert found is None or kabo.verify(problem, found, start=state).ok


def test_histories_that_are_no_way_through_the_plan_are_refused() -> None:
    problem = kabo.load_problem(DOMAINS / "doors" / "n3.yaml")
    plan = kabo.solve(problem).plan
    assert plan is not None
    way = list(way_through(problem, plan, 0))
    branching = next(number for number, (_, outcome) in enumerate(way) if outcome is not None)
    faults = {
        "does not follow there": way[1:],
        "has no node n99": [*way[:1], ("n99", None)],
        "is missing": [*way[:branching], (way[branching][0], None)],
        "is none that the plan has a branch for: ajar": [*way[:branching], (way[branching][0], "ajar")],
        "is the goal": [*way, (f"n{len(plan.nodes) - 1}", None)],
        "step 1 is 'n', and not a node with the outcome": "n0",
        "step 1 is .'n0',., and not a node with the outcome": [("n0",)],
        "step 2 is .7, None., and not a node with the outcome": [way[0], (7, None)],
    }
    for text, history in faults.items():
        with pytest.raises(InputError, match=text):
            kabo.after(problem, plan, history)  # type: ignore[arg-type]
    with pytest.raises(InputError, match="the plan is of doors_n3"):
        kabo.after(kabo.load_problem(DOMAINS / "grid" / "n3.yaml"), plan)


def test_states_are_read_as_they_were_written_and_faults_are_told(tmp_path: Path) -> None:
    problem = kabo.load_problem(DOMAINS / "bartender" / "four_bottles.yaml")
    plan = kabo.solve(problem, certificate=False).plan
    assert plan is not None
    file = tmp_path / "state.json"
    for seed in range(5):
        state = kabo.after(problem, plan, way_through(problem, plan, seed)[: 2 * seed])
        state.save(file)
        assert load_state(file) == state
        jsonschema.Draft202012Validator(schema("kabo-state-1")).validate(json.loads(file.read_text()))
    assert state.geometry is not None and changed(state.geometry, state.geometry) == state.geometry
    for wrong, text in (
        ("{}", '"format" is missing'),
        ('{"format":"kabo-state/1","done":[{}]}', "a step is an action, an observation, or both"),
        ('{"format":"kabo-state/1","done":[{"on":"a(b)"}]}', '"outcome" is missing'),
        ('{"format":"kabo-state/2","done":[]}', "of another version"),
        ('{"format":"kabo-plan/2","nodes":{}}', "the state of a run is needed here, this is a plan"),
    ):
        file.write_text(wrong)
        with pytest.raises(InputError, match=text):
            load_state(file)
    begun = kabo.after(problem, plan)
    assert begun.geometry is not None
    lacking = replace(begun.geometry, objects={"bottle_9": next(iter(begun.geometry.objects.values()))})
    with pytest.raises(InputError, match="no movable object bottle_9"):
        kabo.solve(problem, start=State((), lacking))


def test_a_goal_that_is_out_of_reach_after_what_was_done_is_told_with_a_proof(tmp_path: Path) -> None:
    (tmp_path / "domain.yaml").write_text(DISH_DOMAIN)
    (tmp_path / "problem.yaml").write_text(DISH_PROBLEM)
    problem = kabo.load_problem(tmp_path / "problem.yaml")
    assert kabo.solve(problem).plan is not None
    found = kabo.solve(problem, start=State((Done("drop", {"d": "cup"}),)))
    assert found.status == "no_plan" and found.reason is not None
    assert "whatever geometry says" in found.reason.message and "whole(cup)" in found.reason.message
    assert any(
        "whole(cup)" in why and "was in reach until step 1: drop(cup)" in why for why in found.reason.details
    )


@pytest.mark.parametrize(
    ("change", "text"),
    [
        (
            lambda o: {"o1": replace(o["o1"], parent="o2"), "o2": replace(o["o2"], parent="o1")},
            "o1 hangs on itself",
        ),
        (lambda o: {"o1": replace(o["o1"], parent="o1")}, "o1 hangs on itself"),
        (lambda o: {"o1": replace(o["o1"], position=(float("nan"), 0.0, 0.0))}, "the pose of o1 has a number"),
        (lambda o: {"o1": replace(o["o1"], quaternion=(0.0, 0.0, 0.0, 2.0))}, "the quaternion of o1 has not"),
        (lambda o: {"o1": replace(o["o1"], parent="mobile.hnd")}, "no body or link mobile.hnd"),
        (
            lambda o: {"o1": replace(o["o1"], position=(1e308, 0.0, 0.0))},
            "o1 reaches 1e[+]308 m from the world's origin",
        ),
        (lambda o: {"o1": replace(o["o1"], parent="o2", position=(0.0, 0.0, 499.9999))}, "o1 reaches 500.1 m"),
        (None, "arm_joint_2 of mobile is at 50, outside its limits"),
    ],
)
def test_states_that_cannot_be_are_refused_by_name(change, text) -> None:  # type: ignore[no-untyped-def]
    problem = kabo.load_problem(DOMAINS / "stacked" / "n2.yaml")
    plan = kabo.solve(problem, geometry="none").plan
    scene = kabo.load_scene(DOMAINS / "stacked" / "n2.yaml")
    assert plan is not None
    start = whole_state(scene, {**scene.start.robots, **scene.start.objects})
    if change is None:
        start = replace(start, robots={"mobile": {**start.robots["mobile"], "arm_joint_2": 50.0}})
    else:
        start = replace(start, objects={**start.objects, **change(start.objects)})
    with pytest.raises(InputError, match=text):
        kabo.solve(problem, start=State((), start))


def test_a_state_says_where_everything_is() -> None:
    """What is left out was not seen: it need not be where the problem has it."""
    problem = kabo.load_problem(DOMAINS / "stacked" / "n2.yaml")
    scene = kabo.load_scene(DOMAINS / "stacked" / "n2.yaml")
    start = whole_state(scene, {**scene.start.robots, **scene.start.objects})
    joints = start.robots["mobile"]
    faults = {
        "where o2 is": replace(start, objects={"o1": start.objects["o1"]}),
        "where robot mobile is": replace(start, robots={}),
        "where arm_joint_2 of mobile is": replace(
            start, robots={"mobile": {name: value for name, value in joints.items() if name != "arm_joint_2"}}
        ),
    }
    for text, geometry in faults.items():
        with pytest.raises(InputError, match=f"the state does not say {text}"):
            kabo.solve(problem, start=State((), geometry))
    plan = kabo.solve(problem, geometry="none").plan
    assert plan is not None
    state = kabo.after(problem, plan, [(plan.root, None)])
    with pytest.raises(InputError, match="not where robots and objects are: it has no geometry"):
        kabo.solve(problem, start=state)
    assert kabo.solve(problem, start=state, geometry="none").plan is not None


def test_robots_and_objects_that_a_plan_does_not_have_are_not_put_anywhere() -> None:
    problem = kabo.load_problem(DOMAINS / "stacked" / "n2.yaml")
    scene = kabo.load_scene(DOMAINS / "stacked" / "n2.yaml")
    plan = kabo.solve(problem, geometry="none").plan
    assert plan is not None
    with pytest.raises(InputError, match="the plan has no movable object o1"):
        kabo.after(problem, plan, objects={"o1": whole_state(scene, scene.start.objects).objects["o1"]})
    plan = replace(plan, start=whole_state(scene, {**scene.start.robots, **scene.start.objects}))
    with pytest.raises(InputError, match="the plan has no robot mobil\n.*mobile") as found:
        kabo.after(problem, plan, robots={"mobil": {"arm_joint_2": 0.1}})
    assert len(found.value.diagnostics) == 1
    with pytest.raises(InputError, match="the plan has no joint of mobile arm_joint_9"):
        kabo.after(problem, plan, robots={"mobile": {"arm_joint_9": 0.1}})


def test_what_a_hand_holds_is_not_said_to_hang_in_the_air_or_to_overlap_its_fingers(tmp_path: Path) -> None:
    things = {"cube": (0.2, 0.0, 0.02), "second": (-0.2, 0.3, 0.02)}
    goal = "K(at(cube, shelf)) and K(at(second, shelf))"
    problem = gantry_problem(tmp_path, things=things, goal=goal)
    plan = kabo.solve(problem).plan
    assert plan is not None
    state = kabo.after(problem, plan, [(plan.root, None)])
    assert state.geometry is not None
    (held,) = (name for name, own in state.geometry.objects.items() if own.parent == "gantry.hand")
    (other,) = things.keys() - {held}
    gone = replace(state.geometry.objects[other], position=(5.0, 0.0, 0.02))
    found = kabo.solve(problem, start=kabo.after(problem, plan, [(plan.root, None)], objects={other: gone}))
    assert found.status == "no_plan" and found.reason is not None
    assert f"{other} hangs in the air at the start: nothing is below it" in found.reason.details
    assert not any(text.startswith(f"{held} ") or f"and {held} " in text for text in found.reason.details)


def test_only_worlds_count_that_agree_with_what_was_observed() -> None:
    problem = kabo.load_problem(DOMAINS / "bartender" / "four_bottles.yaml")
    plan = kabo.solve(problem, geometry="none").plan
    assert plan is not None
    history: list[tuple[str, str | None]] = []
    name, counts = plan.root, []
    while plan.nodes[name].kind != "goal":
        node = plan.nodes[name]
        outcome = next(iter(node.branches), None)
        history.append((name, outcome))
        name = str(node.next) if outcome is None else node.branches[outcome]
        start = kabo.after(problem, plan, history)
        rest = kabo.solve(problem, start=start, geometry="none").plan
        assert rest is not None
        worlds = kabo.verify(problem, rest, start=start, knowledge_only=True).worlds
        assert worlds is not None and worlds.exhaustive
        if outcome is not None:
            counts.append(worlds.worlds)
    assert counts == [8, 4, 2, 1]


@pytest.mark.parametrize("number", [float("nan"), float("inf"), -float("inf")])
def test_a_state_in_which_something_is_nowhere_is_neither_made_nor_written(number: float, tmp_path: Path) -> None:
    problem = gantry_problem(tmp_path, things={"cube": (0.2, 0.0, 0.02)}, goal="K(at(cube, shelf))")
    plan = kabo.solve(problem).plan
    assert plan is not None
    state = kabo.after(problem, plan)
    assert state.geometry is not None
    joints = {"gantry": {"x": number}}
    with pytest.raises(InputError, match=f"x of gantry is at {number}"):
        kabo.after(problem, plan, robots=joints)
    nowhere = replace(state.geometry.objects["cube"], position=(0.0, number, 0.0))
    with pytest.raises(InputError, match="the pose of cube has a number that is not finite"):
        kabo.after(problem, plan, objects={"cube": nowhere})
    for change in (kabo.plan.StateChange(robots=joints), kabo.plan.StateChange(objects={"cube": nowhere})):
        with pytest.raises(InputError, match="finite"):
            replace(state, geometry=changed(state.geometry, change)).save(tmp_path / "state.json")
    assert not (tmp_path / "state.json").exists()
