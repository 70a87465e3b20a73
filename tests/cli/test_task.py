"""`kabo task`: plans task files, shows structures and reports, compares runs; robot-free stages of one's own."""

import json
import signal
from pathlib import Path

import pytest

from tests.support.folders import written_in

STAGES = """\
from kabo.tasks import Failure, Result, connector, generator, register

@generator()
def Zero(scene, properties, seed):
    '''Begins at zero.'''
    yield Result(0.0)

@generator(points=list)
def Goals(scene, properties, seed):
    for point in properties["points"]:
        yield Result(float(point), comment=f"point {point}") if point >= 0 else Failure("below_zero", str(point))

@connector(reach=10.0)
def Go(start, end, properties, seed):
    if abs(end - start) > properties["reach"]:
        return [Failure("no_path", f"{start} to {end}")]
    return [Result(cost=abs(end - start) + seed % 7)]

for kind in (Zero, Goals, Go):
    register(kind, f"walk/{kind.__name__}")
"""
TASK = """\
name: walk
properties:
  reach: {type: number, default: 5}
  label: {type: name}
max_solutions: 10
stages:
  - {name: start, stage: walk/Zero}
  - {name: go, stage: walk/Go, reach: <PARENT>}
  - {name: goals, stage: walk/Goals, points: [1, -1, 3, 9]}
"""


@pytest.fixture
def walk(tmp_path, monkeypatch):
    (tmp_path / "walk.py").write_text(STAGES)
    (tmp_path / "walk.yaml").write_text(TASK)
    monkeypatch.chdir(tmp_path)
    return tmp_path


def plan(kabo, *arguments):
    return kabo("task", "plan", "walk.yaml", "--stages", "walk.py", "--set", "label=a", *arguments)


def test_plan_shows_the_tree_with_counts_comments_and_costs(kabo, walk):
    said = plan(kabo)
    assert said.code == 0
    assert said.out.startswith("walk: 2 solutions, best cost ")
    assert "everything was tried" in said.out.splitlines()[0]
    for part in ("→ ←  go  [Go]", "2 solved · 1 failed", "no path 1", "+ point 3", "- below_zero: -1"):
        assert part in said.out


def test_plan_without_a_solution_says_why_and_exits_with_4(kabo, walk):
    said = plan(kabo, "reach=0.5")
    assert said.code == 4
    assert 'the stage "go" never succeeds' in said.out and "3 × no path found" in said.out


def test_plan_prints_one_object_and_writes_the_same_report(kabo, walk):
    said = plan(kabo, "--json", "-o", "r.json", "--max-solutions", 1, "--seed", 3)
    assert said.code == 0 and said.json == json.loads((walk / "r.json").read_text())
    assert [run["seed"] for run in said.json["runs"]] == [3]
    assert len(said.json["runs"][0]["solutions"]) == 1
    assert said.json["arguments"] == {"label": "a"}
    assert written_in(walk) == ["r.json", "walk.py", "walk.yaml"]


def test_several_runs_have_several_seeds(kabo, walk):
    runs = plan(kabo, "--json", "--repeat", 3, "--seed", 2).json["runs"]
    assert [run["seed"] for run in runs] == [2, 3, 4]


def test_workers_do_not_change_the_solutions(kabo, walk):
    def solutions(*arguments):
        return [each["cost"] for each in plan(kabo, "--json", *arguments).json["runs"][0]["solutions"]]

    assert len(solutions("--workers", 1)) == 2
    assert solutions("--workers", 1) == solutions("--workers", 2) == solutions()


def test_a_solution_that_is_complete_when_time_ends_is_told(kabo, walk):
    slow = "\n\n@forward()\ndef Slow(scene, properties, seed):\n    sleep(0.3)\n    yield Result(scene)\n"
    stages = STAGES.replace("import Failure, Result,", "import Failure, Result, forward,").replace(
        "\nfor kind in (Zero,", slow + "\nfor kind in (Slow, Zero,"
    )
    (walk / "walk.py").write_text("from time import sleep\n" + stages)
    (walk / "walk.yaml").write_text(
        "name: slow\nstages:\n  - {name: z, stage: walk/Zero}\n  - {name: slow, stage: walk/Slow}\n"
    )
    said = kabo("task", "plan", "walk.yaml", "--stages", "walk.py", "--timeout", 0.1)
    assert said.code == 0 and said.out.startswith("slow: 1 solution"), said.out


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["--set", "laebl=a"], 'has no property "laebl"'),
        (["--set", "label"], "write --set name=value"),
        (["--set", "label=a", "--set", "label=b"], '"label" is given twice'),
        (["--set", "label=a", "reach=far"], '"reach" must be a number, this is "far"'),
        ([], 'walk.yaml:4:3: the name "label" must be given'),
        (["--scene", "walk.yaml", "--set", "label=a"], "a scene is needed here, or a problem with one"),
        (["--scene", "none.yaml", "--set", "label=a"], "there is no such file"),
        (["--stages", "none.py", "--set", "label=a"], "none.py:1:1: this is no Python file"),
        (["--stages", "walk.yaml", "--set", "label=a"], "walk.yaml:"),
    ],
)
def test_wrong_arguments_are_told_with_exit_code_2(kabo, walk, arguments, message):
    said = kabo("task", "plan", "walk.yaml", "--stages", "walk.py", *arguments, "-o", "r.json")
    assert said.code == 2 and message in said.err and not said.out
    assert "Traceback" not in said.err and not (walk / "r.json").exists()
    told = kabo("task", "plan", "walk.yaml", "--stages", "walk.py", *arguments, "--json")
    assert told.json["code"] == "bad_request"


def test_a_mistake_in_stages_of_ones_own_is_told_at_its_line(kabo, walk):
    (walk / "bad.py").write_text("x = 1\ny = x / 0\n")
    said = kabo("task", "plan", "walk.yaml", "--stages", "bad.py")
    assert said.code == 2 and "bad.py:2:1: ZeroDivisionError: division by zero" in said.err


def test_an_error_inside_a_stage_of_ones_own_is_told_at_its_line(kabo, walk):
    (walk / "walk.py").write_text(STAGES.replace("yield Result(0.0)", "yield Result(1 / 0)"))
    said = plan(kabo)
    assert said.code == 2 and "walk.py:6:1: ZeroDivisionError: division by zero" in said.err
    assert "Traceback" not in said.err


def test_mistakes_in_the_task_file_are_told_all_at_once(kabo, walk):
    (walk / "walk.yaml").write_text(TASK.replace("walk/Go,", "walk/Goo,").replace("points:", "point:"))
    for command in ("plan", "show"):
        said = kabo("task", command, "walk.yaml", "--stages", "walk.py")
        assert said.code == 2
        assert 'walk.yaml:8:23: unknown stage "walk/Goo"' in said.err and 'did you mean "walk/Go"?' in said.err
        assert '"goals" has no property "point"' in said.err and 'needs the property "points"' in said.err


def test_what_does_not_fit_together_is_told_at_its_place(kabo, walk):
    (walk / "walk.yaml").write_text(TASK.replace("walk/Zero", "walk/Go"))
    for command in ("plan", "show"):
        said = kabo(
            "task", command, "walk.yaml", "--stages", "walk.py", *(["--set", "label=a"] * (command == "plan"))
        )
        assert said.code == 2 and "walk.yaml:1:7" in said.err and "two connectors" in said.err


def test_a_task_of_robots_needs_a_scene(kabo, walk):
    (walk / "t.yaml").write_text("name: t\nstages:\n  - {name: start, stage: CurrentState}\n")
    said = kabo("task", "plan", "t.yaml")
    assert said.code == 2 and "moves robots and needs a scene" in said.err and "--scene FILE" in said.err


def test_show_prints_the_structure_with_arrows(kabo, walk):
    said = kabo("task", "show", "walk.yaml", "--stages", "walk.py")
    assert said.code == 0 and said.out.splitlines()[:3] == [
        "walk(reach = 5, label); at most 10 solutions",
        "← →  walk  [Task]  reach: 5",
        "  ← →  start  [Zero]",
    ]
    told = kabo("task", "show", "walk.yaml", "--stages", "walk.py", "--json").json
    assert [stage["arrows"] for stage in told["stages"]] == ["← →", "← →", "→ ←", "← →"]
    assert told["properties"][1] == {"name": "label", "type": "name", "required": True, "default": None}


def test_show_prints_what_planning_found_and_writes_a_page(kabo, walk):
    plan(kabo, "-o", "r.json")
    said = kabo("task", "show", "r.json", "--comments", 1)
    assert said.code == 0 and "+ point 1" in said.out and "+ and 2 more" in said.out
    assert kabo("task", "show", "r.json", "--json").json["format"] == "kabo-task/2"
    said = kabo("task", "show", "r.json", "--html", "r.html")
    page = (walk / "r.html").read_text()
    assert said.code == 0 and not said.out and page.startswith("<!DOCTYPE html>") and "<title>walk – kabo" in page


def test_show_of_no_report_and_a_page_of_no_report_are_told(kabo, walk):
    (walk / "bad.json").write_text('{"format": "kabo-plan/1"}')
    said = kabo("task", "show", "bad.json")
    assert said.code == 2 and "this is no report of planning" in said.err
    said = kabo("task", "show", "walk.yaml", "--html", "x.html")
    assert said.code == 2 and "a page shows what planning found" in said.err and not (walk / "x.html").exists()
    assert kabo("task", "show", "none.json").code == 2


def test_compare_finds_what_differs(kabo, walk):
    plan(kabo, "--repeat", 12, "-o", "a.json")
    plan(kabo, "--repeat", 12, "-o", "b.json", "--set", "reach=20")
    said = kabo("task", "compare", "a.json", "b.json")
    assert said.code == 0 and said.out.startswith("walk (12 runs) and walk (12 runs)")
    found = kabo("task", "compare", "a.json", "b.json", "--json").json
    assert found["stages"]["go"]["failures"]["means"] == [1.0, 0.0]
    assert found["stages"]["go"]["failures"]["adjusted"] < 0.01
    assert found["stages"]["start"]["calls"]["p"] == 1.0
    assert kabo("task", "compare", "a.json", "walk.yaml").code == 2


def test_stages_are_listed_with_their_properties(kabo, walk):
    said = kabo("task", "stages", "--stages", "walk.py")
    assert (
        said.code == 0
        and "walk/Zero" in said.out
        and "Begins at zero." in said.out
        and "SerialContainer" in said.out
    )
    said = kabo("task", "stages", "walk/Go", "--stages", "walk.py")
    assert "  reach: a number, default 10.0" in said.out
    assert kabo("task", "stages", "walk/Goe", "--stages", "walk.py").code == 2
    pages = kabo("task", "stages", "--stages", "walk.py", "--json").json["stages"]
    assert pages["walk/Goals"]["properties"]["points"] == {"type": "a list", "default": None, "doc": ""}


def test_an_interrupt_ends_planning_with_what_there_is(kabo, walk):
    text = STAGES.replace(
        "    return [Result(cost", "    os.kill(os.getpid(), signal.SIGINT)\n    return [Result(cost"
    )
    (walk / "walk.py").write_text("import os\nimport signal\n" + text)
    before = signal.getsignal(signal.SIGINT)
    said = plan(kabo, "--repeat", 5)
    assert "ending with what there is" in said.err and "stopped" in said.out
    assert signal.getsignal(signal.SIGINT) is before


SCENE = Path(__file__).parents[2] / "examples" / "pick_and_place" / "scene.yaml"
MOVE = """\
name: move
properties:
  robot: {type: robot, default: arm}
stages:
  - {name: start, stage: CurrentState}
  - {name: go, stage: MoveTo, goal: home}
"""


def test_a_robot_is_moved_in_a_scene(kabo, walk):
    (walk / "move.yaml").write_text(MOVE.replace("goal: home", "goal: open"))
    said = kabo("task", "plan", "move.yaml", "--scene", SCENE, "--json")
    assert said.code == 0 and len(said.json["runs"][0]["solutions"]) == 1
    said = kabo("task", "plan", "move.yaml", "--scene", SCENE, "--set", "robot=arn")
    assert said.code == 2 and '"robot" is arn, which is no robot of the scene' in said.err
    assert 'did you mean "arm"?' in said.err


def test_a_property_that_a_robot_stage_cannot_use_is_told_at_its_stage(kabo, walk):
    (walk / "move.yaml").write_text(MOVE.replace("goal: home", "goal: {pose: {position: [1, 0, 0]}}, of: foo"))
    said = kabo("task", "plan", "move.yaml", "--scene", SCENE)
    assert said.code == 2 and "move.yaml:6:12: 'go': arm has no frame 'foo'" in said.err
    assert "Traceback" not in said.err


def test_a_solution_is_exported_as_a_plan_verified_and_pictured(kabo, tmp_path, monkeypatch):
    example = Path(__file__).parents[2] / "examples" / "pick_and_place"
    scene = str(example / "scene.yaml")
    monkeypatch.chdir(tmp_path)
    planned = kabo(
        "task", "plan", str(example / "task.yaml"), "--scene", scene, "--max-solutions", "1", "-o", "r.json"
    )
    assert planned.code == 0
    exported = kabo("task", "export", "r.json", "-o", "plan.json")
    assert exported.code == 0 and "solution 1, " in exported.err and "certified" in exported.err
    assert kabo("verify", scene, "plan.json").code == 0
    assert kabo("verify", scene, "r.json", "--solution", "1").code == 0
    assert kabo("view", "r.json", "--solution", "1", "--no-open", "-o", "page.html").code == 0
    assert kabo("view", "plan.json", "--problem", scene, "--no-open", "-o", "plan.html").code == 0
    content = json.loads(Path("r.json").read_text())
    for segment in content["runs"][0]["solutions"][0]["motion"]["segments"]:
        segment["attach"] = []
    Path("spoilt.json").write_text(json.dumps(content))
    refused = kabo("verify", scene, "spoilt.json", "--json")
    assert refused.code == 5 and not refused.json["verified"] and refused.json["solutions"][0]["solution"] == 1
    assert "no solution 2" in kabo("task", "export", "r.json", "--solution", "2").err
    assert kabo("verify", scene, "plan.json", "--solution", "1").code == 2
