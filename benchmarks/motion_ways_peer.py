"""The peer and the judge of `motion_ways.py`: OMPL, and pinocchio with coal on the original meshes; nothing of kabo.

Both see the URDF's own collision elements, the pairs that the SRDF leaves on, and the bodies of a problem as exact
primitives.
"""

from collections.abc import Sequence
from time import process_time
from typing import Any

import coal
import numpy as np
import pinocchio as pin
from motion_problems import MotionProblem, Robot
from numpy.typing import NDArray

Array = NDArray[np.float64]
STEP = 0.005  # [rad or m] of the joint that moves most, between two poses that the judge looks at
RESOLUTION = 0.005  # of OMPL's checks of edges, as a share of the space's extent


class World:
    """A problem as pinocchio has it."""

    def __init__(self, problem: MotionProblem) -> None:
        self.model, geometry = models(problem.robot)
        self.geometry = geometry.copy()
        fixed = {i for i, each in enumerate(self.geometry.geometryObjects) if each.parentJoint == 0}
        links = [i for i in range(self.geometry.ngeoms) if i not in fixed]
        for body in problem.bodies:
            number = self.geometry.addGeometryObject(_object(body))
            for link in links:
                self.geometry.addCollisionPair(pin.CollisionPair(link, number))
        self.data, self.found = self.model.createData(), self.geometry.createData()
        self.places = [self.model.joints[self.model.getJointId(name)].idx_q for name in problem.robot.joints]
        self.rest = np.clip(np.zeros(self.model.nq), self.model.lowerPositionLimit, self.model.upperPositionLimit)

    def collides(self, q: Sequence[float]) -> bool:
        """Whether anything meets at these values of the planned joints."""
        self.rest[self.places] = q
        return bool(pin.computeCollisions(self.model, self.data, self.geometry, self.found, self.rest, True))

    def colliding_poses(self, path: Array) -> int:
        """At how many poses along a path anything meets, of all that lie `STEP` apart."""
        count = 0
        for a, b in zip(path, path[1:], strict=False):
            pieces = max(1, int(np.ceil(np.abs(b - a).max() / STEP)))
            count += sum(self.collides(a + (b - a) * (k / pieces)) for k in range(pieces + 1))
        return count


_MODELS: dict[str, Any] = {}


def models(robot: Robot) -> Any:
    """The kinematics and the collision elements of a robot, with the pairs that its SRDF leaves on."""
    if robot.name not in _MODELS:
        model = pin.buildModelFromUrdf(str(robot.urdf))
        text = robot.urdf.read_text().replace("package://meshes/", "meshes/")
        plain = robot.urdf.with_name("plain.urdf")
        plain.write_text(text.replace('filename="meshes/', f'filename="{robot.resources}/meshes/'))
        geometry = pin.buildGeomFromUrdf(model, str(plain), pin.GeometryType.COLLISION)
        geometry.addAllCollisionPairs()
        pin.removeCollisionPairs(model, geometry, str(robot.urdf.with_suffix(".srdf")))
        _MODELS[robot.name] = model, geometry
    return _MODELS[robot.name]


def _object(body: Any) -> Any:
    if "box" in body:
        shape = coal.Box(*body["box"])
    elif "cylinder" in body:
        shape = coal.Cylinder(body["cylinder"]["radius"], body["cylinder"]["height"])
    else:
        shape = coal.Sphere(body["sphere"]["radius"])
    x, y, z, w = body["pose"]["quaternion"]
    pose = pin.SE3(pin.Quaternion(w, x, y, z).matrix(), np.array(body["pose"]["position"]))
    return pin.GeometryObject(body["name"], 0, pose, shape)


def ompl_way(problem: MotionProblem, world: World, seconds: float) -> tuple[float, Array | None]:
    """The processor time [s] of OMPL's RRT-Connect with simplification, and its path or None."""
    from ompl import base, geometric, util

    util.setLogLevel(util.LogLevel.LOG_ERROR)
    size = len(problem.robot.joints)
    space, bounds = base.RealVectorStateSpace(size), base.RealVectorBounds(size)
    for i, place in enumerate(world.places):
        bounds.setLow(i, float(world.model.lowerPositionLimit[place]))
        bounds.setHigh(i, float(world.model.upperPositionLimit[place]))
    space.setBounds(bounds)
    setup = geometric.SimpleSetup(space)
    setup.setStateValidityChecker(lambda state: not world.collides([state[i] for i in range(size)]))
    information = setup.getSpaceInformation()
    information.setStateValidityCheckingResolution(RESOLUTION)
    setup.setPlanner(geometric.RRTConnect(information))
    start, goal = space.allocState(), space.allocState()
    for i in range(size):
        start[i], goal[i] = problem.start[i], problem.goal[i]
    setup.setStartAndGoalStates(start, goal)
    began = process_time()  # the machine may be busy with other things: the limit is of the processor
    setup.solve(base.PlannerTerminationCondition(lambda: process_time() - began > seconds))
    if not setup.haveExactSolutionPath():
        return process_time() - began, None
    setup.simplifySolution()
    spent = process_time() - began
    states = setup.getSolutionPath().getStates()
    return spent, np.array([[state[i] for i in range(size)] for state in states])
