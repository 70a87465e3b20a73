"""Inverse kinematics: closed form beside projection and pinocchio's closed-loop iteration, on the same poses.

    python benchmarks/inverse_kinematics.py --poses 300

Poses are those of random configurations within limits, so that each can be reached. Projection and CLIK get up to
ten seeds each and stop at the first solution within limits; CLIK is the loop of pinocchio's documentation with full
steps, damped, in Python around its compiled Jacobians. All seconds are the processor's.
"""

import argparse
from collections.abc import Callable, Sequence
from pathlib import Path
from time import process_time
from typing import Any

import numpy as np
import pinocchio as pin
from table import Table, finish

from kabo.arrays import Array
from kabo.kinematics import project
from kabo.kinematics.closed_form import branches, end_poses
from kabo.kinematics.inverse import pose_rows
from kabo.kinematics.sampling import seeds
from kabo.language.recorded_paths import installed_folder
from kabo.language.scene_description import PoseDescription, RobotDescription
from kabo.scene import Robot, Structure
from kabo.scene.transforms import unflat
from kabo.scene.urdf import load_robot
from kabo.streams import stream_key

MESHES = Path(__file__).resolve().parent.parent / "meshes"
SEEDS, STEPS, EXACT = 10, 100, 1e-6
AT_LEAST = 0.4  # s of the processor for each figure: some systems count it in steps of 10 ms


def robots() -> dict[str, Robot]:
    """Arms of five, six and seven axes, kabo's and public ones."""
    own = {
        "mobile5, 5 axes": (MESHES / "mobile5/mobile5.urdf", tuple(f"arm_joint_{k}" for k in range(1, 6))),
        "arm6, 6 axes": (MESHES / "arm6/arm6.urdf", None),
        "arm7, 7 axes": (MESHES / "arm7/arm7.urdf", None),
    }
    public = installed_folder("example-robot-data")
    if public is not None:
        own["UR5, 6 axes"] = (public / "robots/ur_description/urdf/ur5_robot.urdf", None)
        panda = public / "robots/panda_description/urdf/panda.urdf"
        own["Panda, 7 axes"] = (panda, tuple(f"panda_joint{k}" for k in range(1, 8)))
    packages = {} if public is None else {"example-robot-data": public}
    described = {n: RobotDescription("r", path, PoseDescription(), joints) for n, (path, joints) in own.items()}
    return {name: load_robot(each, np.eye(4), packages)[0] for name, each in described.items()}


def closed_form(robot: Robot, structure: Structure, goals: Array, held: Array) -> tuple[float, float, int]:
    """The share solved, solutions of a pose, and how many poses."""
    base = np.clip(0.0, robot.tree.lower, robot.tree.upper)
    made = branches(robot.tree, structure, goals, base, held if structure.lock >= 0 else None)
    return float(np.mean(made.counts > 0)), float(np.mean(made.counts)), len(goals)


def one_by_one(robot: Robot, structure: Structure, goals: Array, held: Array) -> tuple[float, float, int]:
    """As `closed_form`, one call from Python for each pose."""
    found = [closed_form(robot, structure, goals[i : i + 1], held[i : i + 1]) for i in range(len(goals))]
    return float(np.mean([f[0] for f in found])), float(np.mean([f[1] for f in found])), len(goals)


def projection(robot: Robot, structure: Structure, goals: Array, starts: Array) -> tuple[float, float, int]:
    """From one seed after the other, to the first that arrives within limits."""
    tree = robot.tree
    active = np.arange(tree.size) < robot.planned
    solved = 0
    for i, goal in enumerate(goals):
        rows = pose_rows(structure.end, np.eye(4), unflat(goal))
        for start in starts[i]:
            if project(tree, rows, [start], tree.lower, tree.upper, active)[1][0]:
                solved += 1
                break
    return solved / len(goals), solved / len(goals), len(goals)


def clik(robot: Robot, structure: Structure, goals: Array, starts: Array) -> tuple[float, float, int]:
    """Pinocchio's closed-loop inverse kinematics, from one seed after the other."""
    solved = sum(
        any(_clik(robot, structure, goal, start) for start in starts[i])
        for i, goal in enumerate(_frames(robot, structure, goals))
    )
    return solved / len(goals), solved / len(goals), len(goals)


def _frames(robot: Robot, structure: Structure, goals: Array) -> list[Any]:
    """The poses for pinocchio's own joint frames, whose z need not be the axis."""
    data, zero = robot.data, np.zeros(robot.tree.size)
    pin.forwardKinematics(robot.model, data, robot.expand(zero.tolist()))
    ours = unflat(end_poses(robot.tree, structure, zero)[0])
    offset = np.linalg.inv(ours) @ data.oMi[structure.end].homogeneous
    return [pin.SE3(unflat(goal) @ offset) for goal in goals]


def _clik(robot: Robot, structure: Structure, goal: Any, start: Array) -> bool:
    model, data, joint = robot.model, robot.data, structure.end
    q, columns = robot.expand(start.tolist()), [model.joints[int(j)].idx_v for j in structure.joints]
    step = np.zeros(model.nv)
    for _ in range(STEPS):
        pin.computeJointJacobians(model, data, q)
        error = pin.log(data.oMi[joint].actInv(goal)).vector
        if np.linalg.norm(error) < EXACT:
            return _within(robot, structure, q)
        J = pin.getJointJacobian(model, data, joint, pin.LOCAL)[:, columns]
        step[columns] = J.T @ np.linalg.solve(J @ J.T + 1e-8 * np.eye(6), error)
        length = np.max(np.abs(step))
        q = pin.integrate(model, q, step if length < 0.5 else step * (0.5 / length))
    return False


def _within(robot: Robot, structure: Structure, q: Array) -> bool:
    tree = robot.tree
    for j in structure.joints:
        joint, k = robot.model.joints[int(j)], int(tree.source[j])
        value = q[joint.idx_q] if joint.nq == 1 else np.arctan2(q[joint.idx_q + 1], q[joint.idx_q])
        middle = 0.5 * (tree.lower[k] + tree.upper[k])
        value += 2 * np.pi * np.round((middle - value) / (2 * np.pi))
        if not tree.lower[k] <= value <= tree.upper[k]:
            return False
    return True


def measured(ask: Callable[[], tuple[float, float, int]], rounds: int, at_least: float) -> dict[str, float]:
    """The figures of a contestant, over so many rounds and seconds at least; the first call does not count."""
    ask()
    began, done = process_time(), 0
    while done < rounds or process_time() - began < at_least:
        solved, solutions, poses = ask()
        done += 1
    each = (process_time() - began) / (done * poses)
    return {"us a pose": 1e6 * each, "poses/s": 1 / each, "solved": solved, "solutions": solutions}


def table_of(name: str, robot: Robot, poses: int, at_least: float) -> Table:
    """All contestants on one robot."""
    structure = robot.structure
    assert isinstance(structure, Structure)
    tree = robot.tree
    Q = seeds(tree.lower, tree.upper, stream_key("poses", name), 0, poses)
    starts = seeds(tree.lower, tree.upper, stream_key("seeds", name), 0, poses * SEEDS).reshape(poses, SEEDS, -1)
    goals = end_poses(tree, structure, Q)
    held = Q[:, tree.source[structure.joints[max(structure.lock, 0)]]]
    table = Table(f"{name}: {poses} poses that can be reached")
    asked = {
        "closed form, all poses in a call": (lambda: closed_form(robot, structure, goals, held), 5),
        "closed form, a call a pose": (lambda: one_by_one(robot, structure, goals, held), 1),
        "projection, up to 10 seeds": (lambda: projection(robot, structure, goals, starts), 1),
        "pinocchio CLIK, up to 10 seeds": (lambda: clik(robot, structure, goals, starts), 1),
    }
    for label, (ask, rounds) in asked.items():
        table.add(label, **measured(ask, rounds, at_least))
    return table


def main(arguments: Sequence[str] | None = None) -> None:
    """Measures, prints, writes."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--poses", type=int, default=300, help="random poses of each robot")
    parser.add_argument(
        "--at-least", type=float, default=AT_LEAST, metavar="S", help="of the processor, for each figure"
    )
    parser.add_argument("--output", type=Path, default=Path("inverse_kinematics.json"))
    options = parser.parse_args(arguments)
    tables = []
    for name, robot in robots().items():
        tables.append(table_of(name, robot, options.poses, options.at_least))
    finish(tables, options.output, poses=options.poses, seeds=SEEDS)


if __name__ == "__main__":
    main()
