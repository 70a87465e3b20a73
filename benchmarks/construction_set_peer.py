"""The construction set solved by HPP, for construction_set.py: runs with the Python of an environment that has it.

    python construction_set_peer.py [--states few|all] [--seeds 5]

The peer plans by a graph of grasps: `few` gives it the states along one way to the goal, `all` every combination
that its rules allow. Prints one JSON list with the seconds of the processor of each run, or null where it found none.
"""

import argparse
import json
import time
from itertools import chain
from math import pi, sqrt

import numpy as np
from pinocchio import SE3, Quaternion
from pyhpp.constraints import ComparisonType, ComparisonTypes, Implicit, LockedJoint, Transformation
from pyhpp.core import Progressive, ProgressiveProjector, Straight
from pyhpp.manipulation import Device, Graph, ManipulationPlanner, Problem, urdf
from pyhpp.manipulation.constraint_graph_factory import ConstraintGraphFactory, Rule
from pyhpp.manipulation.security_margins import SecurityMargins

ARM = "package://example-robot-data/robots/ur_description/{0}/ur3_gripper.{0}"
PART = "package://hpp_environments/{1}/construction_set/{0}.{1}"
PARTS = {"sphere0": "sphere", "sphere1": "sphere", "cylinder0": "cylinder_08", "cylinder1": "cylinder_08"}
HOME = [pi / 6, -pi / 2, pi / 2, 0, 0, 0]
HEIGHT, MARGIN = 0.025, 0.02
START = {"sphere0": (0.0, -0.08), "sphere1": (-0.05, -0.16), "cylinder0": (0.45, -0.16), "cylinder1": (0.5, -0.08)}
END_X = 0.06202136144745322
HALF = sqrt(0.5)
GOAL = {
    "sphere0": [-END_X, -0.15, HEIGHT, HALF, 0, -HALF, 0],
    "sphere1": [END_X, -0.15, HEIGHT, HALF, 0, HALF, 0],
    "cylinder0": [0, -0.15, HEIGHT, 0, 0, 0, 1],
    "cylinder1": [0.5, -0.08, HEIGHT, 0, 0, 0, 1],
}
MAGNETS = ["cylinder0/magnet0", "cylinder1/magnet0", "cylinder0/magnet1", "cylinder1/magnet1"]
GRIPPERS = [*MAGNETS, "r0/gripper", "r1/gripper"]
HANDLES = [[f"{s}/handle", f"{s}/magnet"] for s in ("sphere0", "sphere1")] + [
    [f"{c}/handle"] for c in ("cylinder0", "cylinder1")
]
FIRST, SECOND = ("r0/gripper", "sphere0/handle"), ("r0/gripper", "sphere1/handle")
CARRIED = ("r1/gripper", "cylinder0/handle")
JOINED = [("cylinder0/magnet0", "sphere0/magnet"), ("cylinder0/magnet1", "sphere1/magnet")]
WAY = [  # the grasps that hold in each state along the way
    [],
    [FIRST],
    [FIRST, CARRIED],
    [FIRST, CARRIED, JOINED[0]],
    [CARRIED, JOINED[0]],
    [CARRIED, JOINED[0], SECOND],
    [CARRIED, *JOINED, SECOND],
    [CARRIED, *JOINED],
    JOINED,
]
ALLOWED = {  # which handles a gripper may take at all
    "r0/gripper": ["sphere0/handle", "sphere1/handle"],
    "r1/gripper": ["cylinder0/handle"],
    "cylinder0/magnet0": ["sphere0/magnet", "sphere1/magnet"],
    "cylinder0/magnet1": ["sphere0/magnet", "sphere1/magnet"],
}


def scene() -> Device:
    """Two arms that face each other, and the parts."""
    robot = Device("construction set")
    turned = SE3(Quaternion(0.0, 0.0, 0.0, 1.0), np.array([0.25, 0.0, 0.0]))
    for name, pose in (("r0", SE3(np.eye(3), np.array([-0.25, 0.0, 0.0]))), ("r1", turned)):
        urdf.loadModel(robot, 0, name, "anchor", ARM.format("urdf"), ARM.format("srdf"), pose)
        for joint, bounds in (("shoulder_pan", [-pi, 4]), ("shoulder_lift", [-pi, 0]), ("elbow", [-2.6, 2.6])):
            robot.setJointBounds(f"{name}/{joint}_joint", bounds)
    fixed = PART.format("ground", "urdf"), PART.format("ground", "srdf")
    urdf.loadModel(robot, 0, "ground", "anchor", *fixed, SE3.Identity())
    for name, kind in PARTS.items():
        files = PART.format(kind, "urdf"), PART.format(kind, "srdf")
        urdf.loadModel(robot, 0, name, "freeflyer", *files, SE3.Identity())
        robot.setJointBounds(f"{name}/root_joint", [-1.0, 1.0, -1.0, 1.0, -0.1, 1.0, *([-1.0001, 1.0001] * 4)])
    return robot


def compared(*kinds: ComparisonType) -> ComparisonTypes:
    """How the rows of a constraint are compared."""
    found = ComparisonTypes()
    found[:] = kinds
    return found


def placements(robot: Device) -> dict[str, Implicit]:
    """For each part: lying at its height, where it lies, both at once, and a little above."""
    zero, free = ComparisonType.EqualToZero, ComparisonType.Equality
    found = {}
    for name in PARTS:
        joint = robot.model().getJointId(f"{name}/root_joint")
        flat, across = [False, False, True, True, True, False], [True, True, False, False, False, True]
        rows = {
            f"place_{name}": (HEIGHT, flat, zero),
            f"place_{name}/complement": (HEIGHT, across, free),
            f"preplace_{name}": (HEIGHT + 0.05, flat, zero),
        }
        for title, (height, mask, kind) in rows.items():
            at = SE3(Quaternion(1.0, 0.0, 0.0, 0.0), np.array([0.0, 0.0, height]))
            made = Transformation(title, robot, joint, SE3.Identity(), at, mask)
            found[title] = Implicit(made, compared(kind, kind, kind), [True, True, True])
        kinds = compared(free, free, zero, zero, zero, free)
        still = np.array([0, 0, HEIGHT, 0, 0, 0, 1.0])
        found[f"place_{name}/hold"] = LockedJoint(robot, f"{name}/root_joint", still, kinds)
    return found


def rules(states: str) -> list[Rule]:
    """What the graph may hold."""
    if states == "few":
        return [
            Rule(grippers=GRIPPERS, handles=[dict(grasps).get(g, "^$") for g in GRIPPERS], link=True)
            for grasps in WAY
        ]
    found = []
    for i, gripper in enumerate(GRIPPERS):
        for handle in chain(*HANDLES):
            if handle not in ALLOWED.get(gripper, ()):
                handles = [handle if k == i else ".*" for k in range(len(GRIPPERS))]
                found.append(Rule(grippers=GRIPPERS, handles=handles, link=False))
    return [*found, Rule(grippers=GRIPPERS, handles=[".*"] * len(GRIPPERS), link=True)]


def problem(states: str) -> tuple[Problem, np.ndarray, np.ndarray]:
    """The problem with its graph, where it starts and where it ends."""
    robot = scene()
    made = Problem(robot)
    made.clearConfigValidations()
    made.addConfigValidation("CollisionValidation")
    graph = Graph("assembly", robot, made)
    graph.errorThreshold(1e-4)
    graph.maxIterations(40)
    constraints = placements(robot)
    for name in PARTS:
        title = f"place_{name}"
        graph.registerConstraints(*(constraints[title + end] for end in ("", "/complement", "/hold")))
    made.steeringMethod = Straight(made)
    made.pathValidation = Progressive(robot, 0.02)
    factory = ConstraintGraphFactory(graph, constraints)
    factory.setGrippers(GRIPPERS)
    factory.setObjects(list(PARTS), HANDLES, [[] for _ in PARTS])
    factory.setRules(rules(states))
    factory.generate()
    margins = SecurityMargins(made, factory, ["r0", "r1", *PARTS], robot)
    margins.defaultMargin = MARGIN
    margins.apply()
    graph.initialize()
    made.pathProjector = ProgressiveProjector(made.distance(), made.steeringMethod, 0.05)
    made.constraintGraph(graph)
    start = np.array([*HOME, *HOME, *chain(*([*START[name], HEIGHT, 0, 0, 0, 1] for name in PARTS))])
    goal = np.array([*HOME, *HOME, *chain(*(GOAL[name] for name in PARTS))])
    return made, start, goal


def main() -> None:
    """Solves it again and again."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--states", choices=("few", "all"), default="all")
    parser.add_argument("--seeds", type=int, default=5)
    options = parser.parse_args()
    for _ in range(options.seeds):
        made, start, goal = problem(options.states)
        made.initConfig(start)
        made.addGoalConfig(goal)
        planner = ManipulationPlanner(made)
        planner.maxIterations(5000)
        began = time.process_time()
        try:
            path = planner.solve()
        except RuntimeError:
            path = None
        print(json.dumps(None if path is None else time.process_time() - began), flush=True)


if __name__ == "__main__":
    main()
