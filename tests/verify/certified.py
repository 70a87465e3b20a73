"""Plans with certificates, for tests: the counter's plan, and a robot among boxes along any path."""

from dataclasses import dataclass, replace
from functools import cache
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np

from kabo.geometry import Budget, Enclosure
from kabo.geometry.collision.separation_proofs import Course as Sought
from kabo.geometry.collision.separation_proofs import PlacedBody as SoughtBody
from kabo.geometry.collision.separation_proofs import Prover, Unproven, Witness, ordered
from kabo.geometry_server import GeometryServer
from kabo.language.scene_description import PoseDescription, RobotDescription
from kabo.meshes import Mesh
from kabo.plan import BodyParts, Certificate, PairProof, Plan
from kabo.planner.certify.certifying import certify
from kabo.planner.certify.motion_situation import joint_pose
from kabo.scene import Robot, load_scene
from kabo.scene.transforms import flat
from kabo.scene.urdf import load_robot
from kabo.verify.certificate.pair_proof import Frames, ProvenPair
from kabo.verify.certificate.parts import Parts
from kabo.verify.motion.arms import Arm
from kabo.verify.motion.surfaces import Surface, surface
from kabo.verify.motion.sweep import Path as Course
from kabo.verify.motion.sweep import SweptBody
from tests.support.small_robots import write_arm
from tests.verify.counter import Counter

CUBE = np.array([[x, y, z] for x in (-0.5, 0.5) for y in (-0.5, 0.5) for z in (-0.5, 0.5)])
FACES = np.array(
    [[0, 1, 3], [0, 3, 2], [4, 6, 7], [4, 7, 5], [0, 4, 5], [0, 5, 1], [2, 3, 7], [2, 7, 6], [0, 2, 6], [0, 6, 4]]
    + [[1, 5, 7], [1, 7, 3]]
)
BUDGET = Budget.share(0.01)
OUT = 1e-8  # [m] by which parts stick out of their boxes, as parts of meshes do


def with_certificate(counter: Counter, plan: Plan | None = None) -> Plan:
    """A plan of the counter with its certificate."""
    plan = counter.plan if plan is None else plan
    assert counter.problem.scene is not None
    scene = load_scene(counter.problem.scene)
    made = certify(plan, GeometryServer(scene, scene.epsilon, 0).surroundings)
    assert isinstance(made, Certificate), [str(gap) for gap in made]
    return replace(plan, certificate=made)


def changed(plan: Plan, **changes: Any) -> Plan:
    """The plan with another certificate."""
    assert plan.certificate is not None
    return replace(plan, certificate=replace(plan.certificate, **changes))


@dataclass(frozen=True, eq=False)
class Box:
    """A box on a joint of the robot's tree (0: the world) in the two forms that the rooms want."""

    mesh: Mesh
    joint: int
    joint_T: np.ndarray  # (4, 4)
    exactly: Enclosure | None = None  # of a round thing, whose mesh lies around it

    @property
    def enclosure(self) -> Enclosure:
        if self.exactly is not None:
            return self.exactly
        halves = np.ptp(self.mesh.vertices, axis=0) / 2
        return Enclosure((self.mesh.vertices * (1.0 + OUT / halves.min()),), OUT * 2.0)


def box(size: Any, joint: int, joint_T: np.ndarray) -> Box:
    """A box with edges of these lengths [m]."""
    return Box(Mesh(CUBE * np.asarray(size), FACES), joint, joint_T)


@cache
def small_robot() -> tuple[Robot, Arm]:
    """The small arm without its gripper's rules: three turning joints and a finger."""
    folder = TemporaryDirectory()
    described = RobotDescription("r", write_arm(Path(folder.name)), PoseDescription(), tool_frame="hand")  # type: ignore[arg-type]
    robot = load_robot(described, np.eye(4), {})[0]
    return robot, Arm(robot)


@dataclass(frozen=True, eq=False)
class Scenery:
    """Two boxes along a path, and what was found about them."""

    first: Box
    second: Box
    waypoints: np.ndarray
    found: Witness | Unproven | None

    @property
    def proof(self) -> PairProof:
        assert isinstance(self.found, Witness)
        return PairProof("first", "second", 0, self.found.walk, self.found.axes)

    def given(self, which: Box) -> BodyParts:
        parts = ordered(which.enclosure)
        rounds = parts.packed.rounds.tobytes() if which.exactly is not None else b""
        return BodyParts(tuple(map(len, parts.vertices)), np.concatenate(parts.vertices).tobytes(), rounds)

    def things(self) -> list[SweptBody]:
        robot, arm = small_robot()
        zero = np.zeros(robot.tree.size)
        result = []
        for name, each in (("first", self.first), ("second", self.second)):
            own: Surface = surface(each.mesh)
            if each.joint == 0:
                result.append(SweptBody(name, own, world_T=each.joint_T))
            else:
                link = next(link for link in robot.links.values() if link.joint == each.joint)
                joint_T_joint = np.linalg.inv(link.joint_T_link) @ each.joint_T
                mount = arm.mounts[link.name]
                result.append(SweptBody(name, own, mount=mount.carrying(joint_T_joint)))
                here = arm.pose(zero.tolist(), mount.carrying(joint_T_joint))
                assert np.allclose(here, joint_pose(robot, zero, each.joint) @ each.joint_T, atol=1e-12)
        return result

    def path(self) -> Course:
        return Course(small_robot()[1], self.waypoints, np.arange(len(self.waypoints), dtype=float))

    def couple(self, parts: dict[str, BodyParts] | None = None) -> ProvenPair:
        """The two as the verifier sees them."""
        given = parts or {"first": self.given(self.first), "second": self.given(self.second)}
        made = {name: Parts(each) for name, each in given.items()}
        return ProvenPair(Frames(self.path()), *self.things(), lambda thing: made[thing.name])


def sought(
    first: Box,
    second: Box,
    waypoints: np.ndarray,
    near: float = 0.01,
    deviations: np.ndarray | None = None,
    wanted: float | None = None,
) -> Scenery:
    """What the planner's side finds of two boxes along a path of the small robot."""
    robot, _ = small_robot()
    tree = robot.tree
    chain, joint = {0}, first.joint
    while joint > 0:
        chain.add(joint)
        joint = int(tree.parent[joint])
    frame = second.joint
    while frame not in chain:
        frame = int(tree.parent[frame])
    prover = Prover({"a": ordered(first.enclosure), "b": ordered(second.enclosure)}, near, BUDGET.clearance)
    bodies = [
        SoughtBody("a", first.joint, flat(first.joint_T)),
        SoughtBody("b", second.joint, flat(second.joint_T)),
    ]
    pairs = np.array([[0, 1, frame]], np.int64)
    course = Sought(tree, np.ascontiguousarray(waypoints), bodies, pairs, deviations=deviations)
    found = prover.prove(course, None if wanted is None else np.array([wanted]))
    return Scenery(first, second, waypoints, found if isinstance(found, Unproven) else found[0])
