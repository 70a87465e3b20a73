"""From paths to a Problem: what it holds, which files were read, and all findings of all files at once."""

import hashlib
import math
import subprocess
import sys
from pathlib import Path

import pytest

from kabo.errors import InputError
from kabo.language import check_files, load_problem, load_scene_description
from kabo.language import formulas as f
from kabo.language.problem import Function
from kabo.language.scene_description import Feature, FeatureName, Stroke
from tests.language.conftest import DOMAIN, PROBLEM, SCENE, Kitchen
from tests.support.counted_calls import calls_made


def test_a_problem_holds_what_its_files_say(kitchen: Kitchen) -> None:
    problem = load_problem(kitchen.write())
    assert problem.name == "one_bottle"
    assert dict(problem.objects) == {"shelf": "location", "left": "robot", "bottle_1": "bottle"}
    assert problem.options == {"search": "breadth-first", "seed": 3, "timeout": 10.0}
    assert dict(problem.domain.types) == {"robot": None, "bottle": None, "location": None}
    assert problem.domain.predicates["at_location"] == ("bottle", "location")
    assert problem.domain.functions["content"] == Function("content", ("bottle",), None, ("water", "wine"))
    assert problem.domain.functions["fuel"] == Function("fuel", ())
    assert problem.values_of("home_of") == ("shelf",)
    bottle = f.Constant("bottle_1")
    wine = f.Comparison("=", f.Application("content", (bottle,)), f.Constant("wine"))
    assert problem.goal == (f.Or((f.Know(f.Literal(f.Atom("grasped", (bottle,)))), f.Know(wine))),)
    assert len(problem.initial) == 2


def test_an_action_holds_resolved_trees(kitchen: Kitchen) -> None:
    action = load_problem(kitchen.write()).domain.actions["pick_up"]
    robot, bottle = f.Variable("r", "robot"), f.Variable("o", "bottle")
    grasped = f.Atom("grasped", (bottle,))
    assert action.preconditions == (
        f.Know(f.Literal(f.Atom("hand_empty", (robot,)))),
        f.Know(f.Literal(grasped, positive=False)),
    )
    side = f.Argument(f.Constant("side"), "grasp")
    assert action.geometry == f.ProcedureCall("pick", (f.Argument(robot), f.Argument(bottle), side))
    assert action.sense == (f.Application("content", (bottle,)),)
    assert action.cost == f.Arithmetic("+", f.Application("fuel"), f.Number(1.0))
    place = action.preconditions[1].place
    assert place is not None and (Path(place.file).name, place.line, place.column) == ("domain.yaml", 22, 9)


def test_every_file_read_has_its_digest_under_its_path_from_the_problem(tmp_path: Path) -> None:
    (tmp_path / "sub").mkdir()
    kitchen = Kitchen(tmp_path)
    kitchen.write()
    text = PROBLEM.replace("domain.yaml", "../domain.yaml").replace("scene.yaml", "./../scene.yaml")
    (tmp_path / "sub" / "p.yaml").write_text(text)
    expected = {
        "p.yaml": text.encode(),
        "../domain.yaml": DOMAIN.encode(),
        "../scene.yaml": SCENE.encode(),
    }
    files = load_problem(tmp_path / "sub" / "p.yaml").files
    assert dict(files) == {name: "sha256:" + hashlib.sha256(data).hexdigest() for name, data in expected.items()}


def test_a_problem_without_a_scene_is_symbolic_and_finds_its_domain_beside_it(kitchen: Kitchen) -> None:
    kitchen.write(
        problem="problem: p\nobjects: {bottle: b}\ninitial: add(Kf, closed)\ngoal: forall(bottle x) K(grasped(x))"
    )
    problem = load_problem(kitchen.problem)
    assert problem.scene is None
    assert problem.of_type("bottle") == ("b",)
    assert problem.initial == (f.Change("add", "Kf", (f.Literal(f.Atom("closed")),)),)


def test_a_scene_holds_what_its_files_say(kitchen: Kitchen) -> None:
    scene = load_problem(kitchen.write()).scene
    assert scene is not None
    assert (scene.name, scene.epsilon) == ("bar", 0.02)
    robot = scene.robots["left"]
    assert robot.urdf == kitchen.folder / "arm.urdf"
    assert robot.base.position == (0.0, 0.5, 0.0)
    assert robot.inverse_kinematics == "automatic"
    assert robot.configurations["home"] == (0.0, -math.pi / 2, 0.5)
    assert robot.tool_features["approach"] == Feature("line", (0.0, 0.0, 0.1), (0.0, 0.0, 1.0))
    assert robot.gripper is not None
    assert robot.gripper.open == {"finger_joint": 0.04} and robot.gripper.touch_links == (
        "left_finger",
        "right_finger",
    )
    bottle = scene.bodies["bottle_1"]
    assert bottle.movable and bottle.model == "bottle" and bottle.shape.scale == 0.001
    assert bottle.shape.path == kitchen.folder / "bottle.stl"
    side = bottle.grasps["side"]
    assert side.approach == Stroke(FeatureName("tool", "approach"), 1, 0.05, 0.15)
    assert side.lift == Stroke(FeatureName("world", "up"), 1, 0.1, 0.1)
    assert side.fingers == {"finger_joint": 0.03}
    assert [str(each.second) for each in side.constraints] == ["this.axis", "this.base"]
    assert not scene.bodies["table"].movable
    assert scene.allowed_contacts == (("left.base_link", "table"),)
    assert scene.regions["shelf"].support == "table"
    (upright,) = scene.motion_constraints["upright"]
    assert (upright.lower, upright.upper) == (None, math.radians(10))


def test_a_problem_replaces_bodies_and_regions_of_the_same_name(kitchen: Kitchen) -> None:
    bodies = "bodies:\n  tray: {sphere: {radius: 1}}\n"
    regions = "regions:\n  shelf: {sphere: {radius: 2}}\n"
    kitchen.write(problem=regions + PROBLEM.replace("bodies:\n", bodies))
    scene = load_problem(kitchen.problem).scene
    assert scene is not None
    assert scene.bodies["tray"].shape.kind == "sphere" and scene.bodies["tray"].movable
    assert scene.regions["shelf"].shape.size == (2.0, 2.0, 2.0) and scene.regions["shelf"].support is None


def test_keys_beside_a_model_replace_those_of_the_model(kitchen: Kitchen) -> None:
    kitchen.write(problem=PROBLEM.replace("{model: bottle, ", "{model: bottle, scale: 2, mass: 3, "))
    scene = load_problem(kitchen.problem).scene
    assert scene is not None
    assert (scene.bodies["bottle_1"].shape.scale, scene.bodies["bottle_1"].mass) == (2.0, 3.0)


def test_findings_of_all_files_come_at_once_sorted_by_place(kitchen: Kitchen) -> None:
    kitchen.write(
        domain=DOMAIN.replace("K(hand_empty(r))", "K(hand_emty(r))").replace(
            "K(not grasped(o))", "K(not grasped o)"
        ),
        scene=SCENE.replace("epsilon: 0.02", "epsilon: x").replace("support: table", "support: chair"),
        problem=PROBLEM.replace("seed: 3", "seed: x").replace("search", "serch"),
    )
    with pytest.raises(InputError) as caught:
        load_problem(kitchen.problem)
    places = [(Path(each.file).name, each.line) for each in caught.value.diagnostics]
    assert places == [
        ("domain.yaml", 21),
        ("domain.yaml", 22),
        ("problem.yaml", 14),
        ("problem.yaml", 14),
        ("scene.yaml", 2),
        ("scene.yaml", 50),
    ]
    assert list(caught.value.diagnostics) == check_files([kitchen.problem])


def test_a_missing_domain_does_not_hide_what_else_is_wrong(kitchen: Kitchen) -> None:
    kitchen.write(problem=PROBLEM.replace("domain.yaml", "gone.yaml").replace("not grasped(b)", "not grasped b"))
    messages = [each.message for each in check_files([kitchen.problem])]
    assert messages == [
        '"gone.yaml": there is no such file',
        'unexpected "b", expected "(" or ")" or "," or "and"',
    ]


def test_a_missing_default_domain_is_reported_at_the_problem(kitchen: Kitchen) -> None:
    kitchen.write()
    (kitchen.folder / "domain.yaml").unlink()
    kitchen.problem.write_text("problem: p\ngoal: K(a)\n")
    (one,) = check_files([kitchen.problem])
    assert (one.line, one.column, one.message) == (1, 1, '"domain.yaml": there is no such file')


def test_files_of_every_kind_are_told_apart_by_their_keys(kitchen: Kitchen) -> None:
    kitchen.write()
    assert check_files([kitchen.folder / f"{name}.yaml" for name in ("domain", "scene", "problem")]) == []
    (kitchen.folder / "other.yaml").write_text("name: pick\n")
    (one,) = check_files([kitchen.folder / "other.yaml"])
    assert one.message == (
        "this is no domain (key `domain`), problem (key `problem`), scene (key `scene`), task (key `stages`), "
        "exploration (key `exploration`), sensor file (key `sensors`) or truth file (key `truth`)"
    )


def test_only_a_problem_can_be_loaded_as_one(kitchen: Kitchen) -> None:
    kitchen.write()
    with pytest.raises(InputError, match="a problem is needed here, this is a scene"):
        load_problem(kitchen.folder / "scene.yaml")


def test_the_same_finding_reached_on_two_ways_is_given_once(kitchen: Kitchen) -> None:
    kitchen.write(
        scene=SCENE.replace("scale: 0.001", "scale: 0"),
        problem=PROBLEM,
    )
    found = check_files([kitchen.problem, kitchen.folder / "scene.yaml"])
    assert [each.message for each in found] == ["the scale must be greater than 0"]


@pytest.mark.parametrize(
    ("old", "new"),
    [
        ("domain.yaml", "../domain.yaml"),
        ("scene.yaml", "../scene.yaml"),
        ("{model: bottle,", "{model: bottle, mesh: ../bottle.stl,"),
    ],
)
def test_nothing_outside_of_the_folder_is_looked_at(tmp_path: Path, old: str, new: str) -> None:
    Kitchen(tmp_path).write()
    (tmp_path / "in").mkdir()
    kitchen = Kitchen(tmp_path / "in")
    kitchen.write(problem=PROBLEM.replace(old, new))
    load_problem(kitchen.problem, within=tmp_path)
    with pytest.raises(InputError, match="the file lies outside of the folder that may be read"):
        load_problem(kitchen.problem, within=tmp_path / "in")


def test_importing_the_language_imports_nothing_heavy() -> None:
    heavy = ("numpy", "scipy", "lark", "yaml", "numba")
    code = f"import sys, kabo.language; print([name for name in {heavy} if name in sys.modules])"
    result = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert result.stdout.strip() == "[]"


def test_a_problem_with_its_scene_is_loaded_in_few_calls(kitchen: Kitchen) -> None:
    kitchen.write()
    load_problem(kitchen.problem)  # builds the grammar's tables
    assert calls_made(lambda: load_problem(kitchen.problem)) < 30_000


def test_a_scene_is_loaded_by_itself_or_with_what_a_problem_adds(kitchen: Kitchen) -> None:
    problem = kitchen.write()
    alone, with_bottle = load_scene_description(kitchen.folder / "scene.yaml"), load_scene_description(problem)
    assert set(with_bottle.bodies) - set(alone.bodies) == {"bottle_1"}
    with pytest.raises(InputError, match="a scene is needed here, or a problem with one"):
        load_scene_description(kitchen.folder / "domain.yaml")
    kitchen.write(problem="problem: p\ngoal: K(closed)\n")
    with pytest.raises(InputError, match="this problem has no scene"):
        load_scene_description(problem)
    with pytest.raises(InputError, match="there is no such file"):
        load_scene_description(kitchen.folder / "none.yaml")
