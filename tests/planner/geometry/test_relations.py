"""What is known of bodies that are not where what was done has left them: an event says it, or no plan begins there."""

import json
import shutil
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import pytest

import kabo
from kabo.cli import exit_codes
from kabo.cli.main import main
from kabo.plan import Done, ObjectPose, Plan, State
from kabo.planner.geometry.relations import Relations, told
from tests.planner.gantry import gantry

THINGS = {"cube": (0.2, 0.0, 0.02), "second": (-0.2, 0.3, 0.02)}
EVENTS = """events:
  moved:
    parameters: {o: thing}
    effects: ["forall(location l) del(Kf, at(o, l))"]
  lost:
    parameters: {r: robot, o: thing}
    effects: ["add(Kf, not held(o), free(r))"]
"""
Case = tuple[Path, kabo.Problem, Plan]


@pytest.fixture(scope="module", params=["", EVENTS], ids=["without events", "with events"])
def case(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> Case:
    path = gantry(
        tmp_path_factory.mktemp("gantry"), things=THINGS, goal="K(at(cube, shelf)) and K(at(second, shelf))"
    )
    with path.with_name("domain.yaml").open("a") as file:
        file.write(request.param)
    problem = kabo.load_problem(path)
    plan = kabo.solve(problem).plan
    assert plan is not None
    path.with_name("plan.json").write_bytes(kabo.plan_to_json(plan))
    return path, problem, plan


def after(case: Case, nodes: int, **shifts: tuple[float, float, float]) -> State:
    """The state after so many nodes, in which bodies were shifted."""
    _, problem, plan = case
    state = kabo.after(problem, plan, [(f"n{number}", None) for number in range(nodes)])
    assert state.geometry is not None
    moved = {}
    for name, shift in shifts.items():
        own = state.geometry.objects[name]
        x, y, z = (a + b for a, b in zip(own.position, shift, strict=True))
        moved[name] = replace(own, position=(x, y, z))
    return placed(state, **moved)


def placed(state: State, **poses: ObjectPose) -> State:
    """The state with bodies elsewhere."""
    assert state.geometry is not None
    return replace(state, geometry=replace(state.geometry, objects={**state.geometry.objects, **poses}))


def replanned(case: Case, state: State, folder: Path) -> int:
    """The exit code of `kabo replan` from the state."""
    state.save(folder / "state.json")
    files = [str(case[0]), str(case[0].with_name("plan.json"))]
    rest = ["--after", str(folder / "state.json"), "-o", str(folder / "rest.json"), "--timeout", "20"]
    return main(["replan", *files, *rest])


@pytest.mark.parametrize("nodes", [2, 4])
def test_what_was_taken_from_where_it_was_put_is_not_taken_to_be_there(
    case: Case, nodes: int, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path, problem, _ = case
    state = after(case, nodes, cube=(0.0, 0.3, 0.0))
    assert replanned(case, state, tmp_path) == exit_codes.BAD_INPUT
    said = capsys.readouterr().err
    assert f"{tmp_path / 'state.json'}:1:1: cube is not in shelf any more" in said
    if not problem.domain.events:
        assert "the domain has no event moved(body)" in said
        return
    step = said.partition("add what happened to `done`: ")[2].partition("\n")[0]
    assert json.loads(step) == {"action": "moved", "arguments": {"o": "cube"}}
    told_so = replace(state, done=(*state.done, Done("moved", {"o": "cube"})))
    assert replanned(case, told_so, tmp_path) == exit_codes.DONE
    rest = kabo.load_plan(tmp_path / "rest.json")
    assert rest.start == told_so.geometry
    last = [
        node.after.objects["cube"] for node in rest.nodes.values() if node.after and "cube" in node.after.objects
    ]
    assert any(
        pose.parent == "world" and abs(pose.position[0] + 0.3) < 0.1 and abs(pose.position[1]) < 0.1
        for pose in last
    )
    command = ["verify", str(path), str(tmp_path / "rest.json"), "--after", str(tmp_path / "state.json")]
    assert main(command) == exit_codes.DONE


def test_an_event_says_only_what_has_happened_to_its_body(case: Case) -> None:
    _, problem, plan = case
    if not problem.domain.events:
        return
    state = after(case, 4, cube=(0.0, 0.3, 0.0), second=(0.5, 0.0, 0.0))
    state = replace(state, done=(*state.done, Done("moved", {"o": "cube"})))
    with pytest.raises(kabo.InputError, match="second is not in shelf any more") as found:
        kabo.solve(problem, start=state, memo=kabo.Memo.of_plan(problem, plan))
    assert len(found.value.diagnostics) == 1


def in_hand(case: Case) -> ObjectPose:
    """How the hand holds the cube after the first node."""
    geometry = after(case, 1).geometry
    assert geometry is not None
    return geometry.objects["cube"]


FALSE_STATES: dict[str, Callable[[Case], State]] = {
    "cube is not held by gantry any more": lambda case: placed(
        after(case, 1), cube=ObjectPose("world", (0.2, 0.0, 0.02), (0.0, 0.0, 0.0, 1.0))
    ),
    "cube is held by gantry": lambda case: placed(after(case, 0), cube=in_hand(case)),
    "second is held by gantry": lambda case: placed(after(case, 1), second=in_hand(case)),
    "second hangs on cube": lambda case: placed(
        after(case, 0), second=ObjectPose("cube", (0.0, 0.0, 0.04), (0.0, 0.0, 0.0, 1.0))
    ),
    "second does not rest on table any more, but on cube": lambda case: after(case, 0, second=(0.4, -0.3, 0.04)),
    "second does not rest on table any more, but on nothing": lambda case: after(case, 0, second=(0.0, 0.0, 0.1)),
}


@pytest.mark.parametrize("text", FALSE_STATES)
def test_what_is_elsewhere_than_what_was_done_has_left_it_is_told(case: Case, text: str) -> None:
    _, problem, plan = case
    state = FALSE_STATES[text](case)
    with pytest.raises(kabo.InputError, match=text) as found:
        kabo.solve(problem, start=state, memo=kabo.Memo.of_plan(problem, plan))
    (finding,) = found.value.diagnostics
    held = "is held" in text or "hangs on" in text
    assert finding.hint is not None and ("is an action" in finding.hint) is held


def test_a_body_that_was_only_pushed_is_planned_for_where_it_is(case: Case) -> None:
    _, problem, plan = case
    state = after(case, 1, second=(0.05, -0.02, 0.0))
    memo = kabo.Memo.of_plan(problem, plan)
    rest = kabo.solve(problem, start=state, memo=memo).plan
    assert rest is not None and rest.start == state.geometry and memo.continued
    assert kabo.verify(problem, rest, start=state).ok


@pytest.mark.parametrize(
    ("before", "now", "text"),
    [
        ("pipe", "world", "it does not hang on pipe any more"),
        ("arm.tool", "pipe", "it hangs on pipe"),
        ("arm.tool", "other.tool", "it is held by other"),
        ("arm.tool", "world", "it is not held by arm any more"),
    ],
)
def test_parts_that_were_joined_and_handed_over_are_told_as_such(before: str, now: str, text: str) -> None:
    nothing: frozenset[str] = frozenset()
    assert told("it", Relations(nothing, nothing, before), Relations(nothing, nothing, now)) == text


def test_what_cannot_be_is_told_beside_a_plan_that_begins_there(
    case: Case, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """Nobody knows from a plan that a hand has opened, nor of a body that the former plan has in the air as well."""
    state = after(case, 1)
    assert state.geometry is not None
    joints = {**state.geometry.robots["gantry"], "finger": 0.035}
    opened = replace(state, geometry=replace(state.geometry, robots={"gantry": joints}))
    assert replanned(case, opened, tmp_path) == exit_codes.DONE
    assert (
        "warning: cube is held by gantry at the start, but 15 mm away from its fingers" in capsys.readouterr().err
    )
    assert replanned(case, after(case, 1, second=(0.01, 0.0, 0.0)), tmp_path) == exit_codes.DONE
    assert "warning" not in capsys.readouterr().err


def test_what_was_done_beside_the_former_plan_is_not_compared_with_it_and_that_is_told(
    case: Case, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    state = after(case, 1)
    assert replanned(case, state, tmp_path) == exit_codes.DONE
    assert "no way through" not in capsys.readouterr().err
    other = {name: "second" if value == "cube" else value for name, value in state.done[0].arguments.items()}
    beside = replace(state, done=(replace(state.done[0], arguments=other),))
    replanned(case, beside, tmp_path)
    said = "warning: what was done is no way through the former plan: whether things are where it left them is not known"
    assert said in capsys.readouterr().err


def test_of_a_plan_that_was_made_for_other_files_only_the_actions_are_tried_again(
    case: Case, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path, _, plan = case
    folder = tmp_path / "later"
    shutil.copytree(path.parent, folder)
    later = folder / path.name
    wall = "wall: {box: [0.05, 0.05, 0.3], movable: false, pose: {position: [-0.05, 0, 0.15]}}"  # on the old way
    later.write_text(later.read_text().replace("bodies: {", f"bodies: {{{wall}, "))
    after(case, 1).save(tmp_path / "state.json")
    files = [str(later), str(folder / "plan.json"), "--after", str(tmp_path / "state.json")]
    assert main(["replan", *files, "-o", str(tmp_path / "rest.json"), "--timeout", "20"]) == exit_codes.DONE
    assert "the former plan is of other files (problem.yaml has changed since)" in capsys.readouterr().err
    rest = kabo.load_plan(tmp_path / "rest.json")
    done = [(node.action, dict(node.arguments)) for node in plan.nodes.values()][1:]
    assert [(node.action, dict(node.arguments)) for node in rest.nodes.values()] == done
    command = ["verify", str(later), str(tmp_path / "rest.json"), "--after", str(tmp_path / "state.json")]
    assert main(command) == exit_codes.DONE
