"""Two arms that move at once: through a domain, from the command line and in Python, judged by pinocchio and coal."""

from functools import cache
from itertools import product
from pathlib import Path

import numpy as np

import kabo
from kabo.cli import main
from kabo.language import load_problem, load_scene_description
from kabo.plan import Node, Plan
from kabo.scene import Scene, load_scene
from kabo.tasks import Task, load_task_file
from kabo.tasks.files.first_scenes import first_scene
from kabo.tasks.robots import segments
from tests.support import oracles_coal
from tests.support.oracles_motions import replay_of, states_of

ROOT = Path(__file__).resolve().parents[3]
EXAMPLE = ROOT / "examples" / "two_arms"
BASES = {"left": (-0.30, 0.65, 0.0), "right": (-0.30, -0.65, 0.0)}
WHO = {"first": "left", "this": "red", "second": "right", "that": "blue"}
OWNERS = {"red": "left", "blue": "right"}


@cache
def plan() -> Plan:
    result = kabo.solve(load_problem(EXAMPLE / "problem.yaml"))
    assert result.plan is not None
    return result.plan


@cache
def scene() -> Scene:
    return load_scene(load_scene_description(EXAMPLE / "scene.yaml"))


def acting() -> list[tuple[str, Node]]:
    return [(name, node) for name, node in plan().nodes.items() if node.motion]


def test_both_arms_are_under_way_at_once_and_the_verifier_accepts_and_certifies_it() -> None:
    for _, node in acting():
        spans = {r: [(s.times[0], s.times[-1]) for s in node.motion if s.robot == r] for r in BASES}
        alone = [spans[r][-1][1] for r in BASES]
        assert min(alone) > 0.5 * max(alone)
        assert max(s.times[-1] for s in node.motion) == max(alone) < sum(alone)
    report = kabo.verify(load_problem(EXAMPLE / "problem.yaml"), plan())
    assert report.ok, report.findings
    assert plan().certificate is not None


def test_what_the_two_arms_move_stays_apart_by_pinocchio_and_coal() -> None:
    """Moment by moment on the original meshes, poses by pinocchio from the files, distances by coal."""
    arms = oracles_coal.arms(BASES, ROOT / "meshes", "arm6", "gripper_wide")
    meshes = {
        f"{r}.{k.name}": k.mesh for r in BASES for k in scene().robots[r].links.values() if k.mesh is not None
    }
    meshes |= {name: scene().bodies[name].mesh for name in OWNERS}
    groups = [[n for n in meshes if OWNERS.get(n, n.partition(".")[0]) == robot] for robot in BASES]
    states, looked, least = states_of(plan(), scene()), 0, np.inf
    for name, node in acting():
        replay = replay_of(scene(), states[name][0], node)
        for moment in replay.moments():
            looked += 1
            poses = dict(moment.poses)
            for robot, joints in BASES.items():
                values = dict(zip(scene().robots[robot].joint_names, replay.q[robot], strict=True))
                own = {f"{robot}.{link}": pose for link, pose in arms[robot].poses(values).items()}
                assert all(np.abs(poses[n] - pose).max() < 1e-9 for n, pose in own.items() if n in poses), joints
                poses |= own
            for a, b in product(*groups):
                if np.linalg.norm(poses[a][:3, 3] - poses[b][:3, 3]) < 0.4:
                    least = min(least, oracles_coal.distance(meshes[a], poses[a], meshes[b], poses[b]))
    assert looked > 200
    assert 0.0 < least < 0.3, "the example brings both arms near to each other"


@cache
def task() -> Task:
    made = load_task_file(EXAMPLE / "tasks" / "take_both.yaml").task(WHO)
    made.plan(first_scene(scene(), 0, lambda: False), 1)
    return made


def test_in_python_a_part_of_the_solution_is_the_motion_of_one_arm_with_the_same_times() -> None:
    (solution,) = task().solutions
    both = segments(solution, scene(), "")
    for child, robot in (("this one", "left"), ("that one", "right")):
        alone = segments(solution[f"at once/{child}"], scene(), "")
        assert [(s.times, s.waypoints) for s in both if s.robot == robot] == [
            (s.times, s.waypoints) for s in alone
        ]
    assert {name for name in OWNERS if solution.end.scene.holder(name) == OWNERS[name]} == set(OWNERS)


def test_from_the_command_line_one_robot_twice_is_told_at_its_place(capsys) -> None:
    path, given = EXAMPLE / "tasks" / "take_both.yaml", WHO | {"second": "left"}
    values = [f"{name}={value}" for name, value in given.items()]
    code = main(["task", "plan", str(path), "--scene", str(EXAMPLE / "scene.yaml"), "--set", *values])
    told = capsys.readouterr().err
    assert code == 2
    assert "take_both.yaml:12:11" in told
    assert "'this one' and 'that one' both move left" in told
