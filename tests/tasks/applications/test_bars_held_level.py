"""Bars of unknown balance held where trials have shown: the committed model, a task, a domain, the commands of the page."""

import re
import runpy
import shlex
import subprocess
import sys
from functools import cache
from importlib.metadata import version
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import kabo
from kabo.exploration import Exploration, load_exploration, trial_seed
from kabo.language import load_problem, load_scene_description
from kabo.plan import Plan
from kabo.scene import Scene, load_scene
from kabo.tasks import Solution, load_task_file
from kabo.tasks.files.first_scenes import first_scene
from kabo.trials import Valid
from tests.tasks.robots.judge import Judge

ROOT = Path(__file__).resolve().parents[3]
EXAMPLE = ROOT / "examples" / "lifting_a_bar"
BARS = ("steel", "wood")
MADE_WITH = "4.0.0"  # MuJoCo: another version's contacts may differ in the last digits
each_bar = pytest.mark.parametrize("bar", BARS)


@cache
def names() -> dict[str, Any]:
    return runpy.run_path(str(EXAMPLE / "lifting_a_bar.py"))


@cache
def model() -> Exploration:
    return load_exploration(EXAMPLE / "model.jsonl")


def place(bar: str) -> dict[str, float]:
    return dict(model().infer({"torque": 0.0}, where={"bar": bar}).parameters)


@cache
def scene() -> Scene:
    return load_scene(load_scene_description(EXAMPLE / "scene.yaml"))


@cache
def solved(bar: str) -> Solution:
    task = load_task_file(EXAMPLE / "task.yaml").task({"object": bar}, seed=0)
    task.plan(first_scene(scene(), 0, lambda: False), 1, jobs=500)
    assert task.best is not None, task.explain().text
    return task.best


@cache
def plan() -> Plan:
    result = kabo.solve(load_problem(EXAMPLE / "problem.yaml"))
    assert result.plan is not None
    return result.plan


@each_bar
def test_every_trial_of_the_model_comes_out_again(bar: str) -> None:
    trials = model().trials_of({"bar": bar})
    assert len(trials) >= 50
    for number, trial in enumerate(trials):
        found = names()["lift"](trial.case, trial.parameters, trial_seed(model().seed, trial.case, number))
        assert (found.outcomes if isinstance(found, Valid) else found.reason) == (
            pytest.approx(trial.outcomes, abs=1e-3) if trial.valid else trial.reason
        )


@each_bar
def test_the_model_holds_a_bar_within_three_millimetres_of_its_balance_and_it_stays_level(bar: str) -> None:
    chosen = place(bar)
    assert chosen["along"] == pytest.approx(names()["BARS"][bar].balance, abs=0.003)
    lifts = [names()["lift"]({"bar": bar}, chosen, seed) for seed in range(5)]
    assert all(isinstance(each, Valid) for each in lifts)
    assert np.mean([each.outcomes["torque"] for each in lifts]) == pytest.approx(0.0, abs=0.03)


@each_bar
def test_the_task_grasps_a_bar_where_the_model_says_and_lifts_it(bar: str) -> None:
    solution = solved(bar)
    assert solution.end is not None
    grasp = solution["grasp/grasp pose IK"]
    bar_T_tool = np.linalg.inv(grasp.end.scene.pose(bar)) @ grasp.properties["target_pose"]
    feature = scene().robots["arm"].tool.features["tcp"]
    tcp = bar_T_tool[:3, :3] @ np.asarray(feature.origin) + bar_T_tool[:3, 3]
    assert tcp == pytest.approx((place(bar)["along"], 0.0, 0.0), abs=1e-3)
    assert solution.end.scene.holder(bar) == "arm"
    assert 0.05 <= solution.end.scene.pose(bar)[2, 3] - 0.03 <= 0.101


@each_bar
def test_nothing_touches_what_it_may_not_on_the_way(bar: str) -> None:
    """Judged by pinocchio and fcl on the original meshes."""
    assert Judge(scene()).findings(solved(bar)) == []


def test_the_nodes_of_a_plan_say_what_was_learned_and_the_verifier_accepts_it() -> None:
    learned = {each.case["bar"]: each for node in plan().nodes.values() for each in node.learned}
    assert {bar: dict(each.parameters) for bar, each in learned.items()} == {bar: place(bar) for bar in BARS}
    assert all(each.validity > 0.95 for each in learned.values())
    report = kabo.verify(load_problem(EXAMPLE / "problem.yaml"), plan())
    assert report.ok, report.findings


def test_the_domains_task_is_the_one_that_stands_alone() -> None:
    alone, own = (
        (EXAMPLE / path).read_text().partition("stages:\n")[2] for path in ("task.yaml", "tasks/lift_level.yaml")
    )
    assert alone
    assert own == alone.replace("model: model.jsonl", "model: ../model.jsonl")


def commands() -> list[str]:
    blocks = re.findall(r"```sh\n(.*?)```", (EXAMPLE / "README.md").read_text(), re.DOTALL)
    return [line for block in blocks for line in block.splitlines()]


def run(command: str, folder: Path) -> None:
    """Runs a command of the page in the repository; what it writes, and reads again, is in a folder."""
    kabo_, *arguments = shlex.split(command)
    if "-o" in arguments or arguments[0] == "verify":
        written = ("model.jsonl", "plan.json")
        arguments = [str(folder / Path(each).name) if Path(each).name in written else each for each in arguments]
    line = [sys.executable, "-m", "kabo.cli", *arguments]
    done = subprocess.run(line, cwd=ROOT, capture_output=True, text=True, check=False)
    assert (kabo_, done.returncode) == ("kabo", 0), command + done.stderr


def test_the_first_command_of_the_page_writes_the_model_again(tmp_path: Path) -> None:
    run(commands()[0], tmp_path)
    made = (tmp_path / "model.jsonl").read_bytes()
    assert made.count(b"\n") == 121
    if version("mujoco") == MADE_WITH:
        assert made == (EXAMPLE / "model.jsonl").read_bytes()


@pytest.mark.slow
def test_all_other_commands_of_the_page_run(tmp_path: Path) -> None:
    others = commands()[1:]
    assert len(others) == 6
    for command in others:
        run(command, tmp_path)
