"""Tests of what callers are told that give a path, or nothing, in place of what was loaded from it."""

import pickle
import re
from collections.abc import Callable
from dataclasses import fields
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import kabo
from kabo import execution, simulation
from kabo.errors import ArgumentError
from kabo.execution import KnownTruth, execute

DOMAIN = Path(__file__).parents[1] / "domains" / "doors"
SCENE = Path(__file__).parents[1] / "examples" / "two_cans" / "scene.yaml"
BY_PATH = "problem must be a Problem, as kabo.load_problem(path) makes it, and is 'n3.yaml'"
NO_PLAN = "and is None; a result without a plan says why: result.reason"


@pytest.fixture(scope="module")
def problem() -> kabo.Problem:
    return kabo.load_problem(DOMAIN / "n3.yaml")


@pytest.fixture(scope="module")
def plan(problem: kabo.Problem) -> kabo.Plan:
    found = kabo.solve(problem).plan
    assert found is not None
    return found


@pytest.mark.parametrize(
    ("call", "words"),
    [
        (lambda _, plan: kabo.solve("n3.yaml"), BY_PATH),
        (lambda _, plan: kabo.explain("n3.yaml"), BY_PATH),
        (lambda _, plan: kabo.verify("n3.yaml", plan), BY_PATH),
        (lambda _, plan: kabo.after("n3.yaml", plan), BY_PATH),
        (lambda problem, _: kabo.verify(problem, None), NO_PLAN),
        (lambda problem, _: kabo.verify(problem, kabo.solve(problem)), "and is of type Result"),
        (lambda problem, _: kabo.after(problem, "plan.json"), "kabo.load_plan(path) makes it, and is 'plan.json'"),
        (lambda problem, _: kabo.solve(problem, start={}), "start must be a State"),
        (lambda *_: kabo.export("plan.json", "dot"), "and is 'plan.json'"),
        (lambda *_: execute(None, None, None, KnownTruth()), NO_PLAN),
        (lambda _, plan: execute(plan, "scene.yaml", None, KnownTruth()), "kabo.load_scene(path) makes it"),
        (lambda problem, _: kabo.plan_motion(problem, "arm", "home", "home"), "scene must be a Scene"),
    ],
)
def test_what_makes_it_is_named(call: Callable[..., Any], words: str, problem: kabo.Problem, plan: kabo.Plan):
    with pytest.raises(TypeError, match=re.escape(words)):
        call(problem, plan)
    with pytest.raises(kabo.InputError, match=re.escape(words)):
        call(problem, plan)


NAN, HUGE = float("nan"), 10**400
NO_NUMBERS = [NAN, "1", True, [1], object(), 1 + 2j, np.array([1.0, 2.0])]
NO_SEEDS = [*NO_NUMBERS, -1, 1.5, None, HUGE, 10**5000]
NO_LENGTHS = [*NO_NUMBERS, float("inf"), -1.0, HUGE, -HUGE]
TASK = SCENE.parents[1] / "pick_and_place" / "task.yaml"


def _refused(argument: str, call: Callable[..., Any], values: list[Any]) -> None:
    """Each value is refused by one sentence about the argument."""
    for value in values:
        with pytest.raises(kabo.InputError) as told:
            call(value)
        assert [each.file for each in told.value.diagnostics] == [argument], value
        assert argument in str(told.value) and "\n" not in str(told.value) and len(str(told.value)) < 250


def test_numbers_that_a_motion_cannot_be_planned_with_are_refused():
    scene = kabo.load_scene(SCENE)

    def planning(argument: str) -> Callable[[Any], Any]:
        return lambda value: kabo.plan_motion(scene, "arm", "home", {"panda_joint1": 0.1}, **{argument: value})

    _refused("seed", planning("seed"), NO_SEEDS)
    _refused("samples", planning("samples"), NO_SEEDS)
    _refused("epsilon", planning("epsilon"), [*NO_LENGTHS, 0.0, 1e-7, 1.0])
    _refused("clearance", planning("clearance"), [*NO_LENGTHS, 0.5])
    _refused("stop", planning("stop"), [3, "x", None])
    _refused("keep", planning("keep"), [3, [], True])
    _refused("holding", planning("holding"), [3, [], True])


def test_options_of_a_solve_and_of_an_explanation_are_checked(problem: kabo.Problem):
    _refused(
        "seed", lambda value: kabo.solve(problem, seed=value), [each for each in NO_SEEDS if each is not None]
    )
    _refused("epsilon", lambda value: kabo.solve(problem, epsilon=value), NO_LENGTHS)
    _refused("timeout", lambda value: kabo.solve(problem, timeout=value), [*NO_NUMBERS, -1.0])
    _refused("max_expansions", lambda value: kabo.explain(problem, max_expansions=value), [*NO_NUMBERS, -1, 1.5])
    assert kabo.explain(problem, timeout=HUGE).verdict == kabo.explain(problem).verdict == "solvable"
    _refused("workers", lambda value: kabo.solve(problem, workers=value), [*NO_NUMBERS, 0, 10**9])
    _refused("certificate", lambda value: kabo.solve(problem, certificate=value), ["no", 0])
    _refused("procedures", lambda value: kabo.solve(problem, procedures=value), [3, "x", [len]])
    with pytest.raises(kabo.InputError, match="search must be one of .*not 'gredy'; did you mean \"greedy\""):
        kabo.solve(problem, search="gredy")  # type: ignore[arg-type]
    with pytest.raises(kabo.InputError, match="unexpected keyword argument 'sead'; did you mean \"seed\""):
        kabo.explain(problem, sead=1)  # type: ignore[call-arg]


def test_numbers_that_a_task_cannot_be_planned_with_are_refused():
    def planning(argument: str) -> Callable[[Any], Any]:
        return lambda value: kabo.plan_task(TASK, TASK.with_name("scene.yaml"), **{argument: value})

    _refused("seed", planning("seed"), NO_SEEDS)
    _refused("max_solutions", planning("max_solutions"), [*NO_NUMBERS, 0, -1, 1.5])
    _refused("timeout", planning("timeout"), [*NO_NUMBERS, -1.0])
    _refused("repeat", planning("repeat"), [*NO_NUMBERS, 0, None])
    _refused("workers", planning("workers"), [*NO_NUMBERS, 0, 10**9])
    _refused("arguments", planning("arguments"), [3, "x", [1]])


def test_a_number_in_an_array_is_one(problem: kabo.Problem):
    """Numbers of numpy, as those of arrays, are told as those of Python in the plan's header."""
    found = kabo.solve(problem, seed=np.int64(3), timeout=np.float32(9)).plan  # type: ignore[arg-type]
    assert found is not None and type(found.options["seed"]) is int


READERS: list[Callable[[Any], Any]] = [
    kabo.load_plan,
    kabo.load_state,
    kabo.load_scene,
    kabo.load_problem,
    kabo.load_mesh,
    lambda path: kabo.plan_task(TASK, TASK.with_name("scene.yaml"), from_=path),
    kabo.robot_scene,
    lambda path: kabo.view(path, open=False),
]


@pytest.mark.parametrize("read", READERS)
def test_a_file_that_is_none_is_told_in_one_message(read: Callable[[Any], Any], tmp_path: Path):
    """Missing, empty, binary, a folder, of another kind, or cut off: never another error than of the input."""
    contents = {"empty.json": b"", "binary.json": bytes(range(256)), "cut.json": b'{"format": "kabo-plan/2", "no'}
    contents["picture.json"] = b"\x89PNG\r\n\x1a\n" + bytes(99)
    for name, content in contents.items():
        (tmp_path / name).write_bytes(content)
    named = [tmp_path / name for name in contents]
    for path in (*named, tmp_path / "missing.json", tmp_path, "", "a" * 5000, 3, b"x", [], object()):
        with pytest.raises(kabo.InputError):
            read(path)


def test_a_missing_file_is_told_with_the_one_that_is_called_nearly_so(tmp_path: Path):
    (tmp_path / "plan.json").write_text("{}")
    with pytest.raises(kabo.InputError, match=r'there is no such file\n.*did you mean "plan.json"'):
        kabo.load_plan(tmp_path / "plan.jso")


@pytest.mark.parametrize("path", ["none/plan.json", "", ".", "a\0b", "a" * 5000, 3, b"x", None])
def test_nothing_is_written_where_no_file_can_be(path: Any, plan: kabo.Plan, tmp_path: Path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    writers = [plan.save, kabo.State().save, kabo.Page(b"x").save]
    for write in writers:
        with pytest.raises(kabo.InputError, match="path must"):
            write(path)
    assert list(tmp_path.iterdir()) == []


def test_a_refused_argument_comes_whole_from_another_process():
    error = ArgumentError("seed", "seed must be a number", "give one")
    again = pickle.loads(pickle.dumps(error))  # noqa: S301
    assert str(again) == str(error) == "seed must be a number; give one" and again.diagnostics == error.diagnostics


def test_a_motion_is_planned_in_the_scene_of_a_file():
    there = {"panda_joint1": 0.1}
    found = kabo.plan_motion(SCENE, "arm", "home", there)
    assert found == kabo.plan_motion(kabo.load_scene(SCENE), "arm", "home", there)


def test_what_plans_are_carried_out_and_exported_with_is_checked(plan: kabo.Plan):
    scene = kabo.load_scene(SCENE)
    for kind in (execution.ExecutionSettings, simulation.PhysicsSettings):
        for name in (each.name for each in fields(kind)):
            _refused(name, lambda value, make=kind, name=name: make(**{name: value}), [NAN, "1", -1.0, object()])
    _refused("rate", lambda value: execution.KinematicRobot(scene, rate=value), [*NO_LENGTHS, 0.0])
    _refused("delay", lambda value: execution.KinematicRobot(scene, delay=value), [*NO_LENGTHS, 1e9])
    _refused("position", execution.PoseNoise, NO_LENGTHS)
    _refused("rate", lambda value: kabo.export(plan, "csv", rate=value), [NAN, "1", True, object()])
    _refused("node", lambda value: kabo.export(plan, "csv", node=value), [3, [], object()])
    _refused("sensor", lambda value: execution.execute(plan, None, None, value), [3, "x", None])


def test_what_plans_are_verified_with_is_checked(problem: kabo.Problem, plan: kabo.Plan):
    """A text such as `no` counted as True, and a scene that was none ended in an AttributeError where there is motion."""
    for name in ("knowledge_only", "paranoid", "meshes"):
        _refused(
            name, lambda value, name=name: kabo.verify(problem, plan, **{name: value}), ["no", 0, 1, None, [], NAN]
        )
    _refused(
        "scene", lambda value: kabo.verify(problem, plan, scene=value), ["", "x", 3, 0, [], Path("scene.yaml")]
    )
    _refused("changes", lambda value: kabo.verify(problem, plan, changes=value), ["x", 3, {}, None])


MESH = SCENE.parents[2] / "meshes" / "crate" / "crate.stl"
CORNERS, SIDES = [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]], [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]]
BOUNDS: list[Callable[..., Any]] = [kabo.bounding_mesh, kabo.bounding_decomposition]


def test_what_meshes_are_loaded_and_stored_with_is_checked():
    _refused("place", lambda value: kabo.load_mesh(MESH, place=value), [3, "", "x", [], NAN])
    _refused("repair", lambda value: kabo.load_mesh(MESH, repair=value), ["no", 0, None, [], NAN])
    mesh = kabo.load_mesh(MESH)
    paths = [3, "", "a\0b", b"x", [], object()]
    _refused("cache", lambda value: kabo.bounding_decomposition(mesh, 0.05, cache=value), paths)


@pytest.mark.parametrize("bound", BOUNDS)
def test_meshes_that_a_caller_makes_are_arrays_of_numbers(bound: Callable[..., Any]):
    """Lists do, too; everything else is told in a sentence, not by what numpy cannot convert."""
    no_rows: list[Any] = [
        None,
        3,
        "x",
        [[0, 1]],
        [[0, 1], [0, 1, 2]],
        [0, 1, 2],
        [["a", "b", "c"]],
        [[HUGE, 0, 0]],
    ]
    _refused("mesh", lambda value: bound(kabo.Mesh(value, SIDES), 0.01), no_rows)  # type: ignore[arg-type]
    _refused(
        "mesh", lambda value: bound(kabo.Mesh(CORNERS, value), 0.01), [*no_rows, [[NAN, 0, 1]], [[0.5, 1, 2]]]
    )  # type: ignore[arg-type]
    _refused("mesh", lambda value: bound(value, 0.01), [None, 3, "x", object()])
    for faces in (SIDES, np.array(SIDES), np.array(SIDES, np.float64), np.array(SIDES, np.int32)):
        found = bound(kabo.Mesh(CORNERS, faces), 0.01)  # type: ignore[arg-type]
        assert len(getattr(found, "faces", SIDES)) == len(SIDES)


def test_physics_is_set_to_numbers_that_it_can_count_with():
    """A step of a million seconds was taken, and so was a density of which nothing can be added up."""
    for name in (each.name for each in fields(simulation.PhysicsSettings) if each.name != "welds"):
        _refused(
            name, lambda value, name=name: simulation.PhysicsSettings(**{name: value}), [0.0, 1e-300, 1e30, HUGE]
        )
    _refused("timestep", lambda value: simulation.PhysicsSettings(timestep=value), [1e-9, 1.0])
    assert simulation.PhysicsSettings(0.01, 1e-3, 20.0, 8000.0, 1e-4, 1000.0, 1e-4).timestep == 0.01
