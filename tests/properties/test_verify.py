"""Laws of the verifier: what it calls free is free wherever one looks, what it calls a contact is near one.

Random robots (revolute, prismatic and mimic joints), random paths, boxes around them; the oracle is dense sampling
with python-fcl and pinocchio's reference poses.
"""

import itertools
import os
import tempfile
from pathlib import Path as File

import fcl
import numpy as np
import trimesh
from hypothesis import assume, event, given, settings
from hypothesis import strategies as st

from kabo.language.scene_description import PoseDescription, RobotDescription
from kabo.scene import Mesh, Robot, link_pose, link_poses
from kabo.scene.urdf import load_robot
from kabo.verify.motion.arms import Arm
from kabo.verify.motion.surfaces import surface
from kabo.verify.motion.sweep import Path, SweptBody, open_intervals

SAMPLES = 60
EXAMPLES = settings(max_examples=max(20, round(300 * float(os.environ.get("KABO_PROPERTY_SCALE", "0.1")))))
JOINTS = st.tuples(
    st.sampled_from(["revolute", "revolute", "prismatic"]),
    st.sampled_from(["1 0 0", "0 1 0", "0 0 1", "0.6 0 0.8"]),
    st.tuples(*[st.sampled_from([-0.2, 0.0, 0.1, 0.3])] * 3),
    st.booleans(),
)


def urdf(joints) -> str:
    """A chain of links with a box on each; `True` makes a joint mimic the first one."""
    text = '<robot name="r"><link name="l0"/>'
    for i, (kind, axis, offset, mimics) in enumerate(joints, 1):
        text += f'<link name="l{i}"><collision><origin xyz="0.05 0 0.02"/><geometry><box size="0.3 0.06 0.04"/>'
        text += f'</geometry></collision></link><joint name="j{i}" type="{kind}"><parent link="l{i - 1}"/>'
        text += f'<child link="l{i}"/><origin xyz="{offset[0]} {offset[1]} {offset[2]}" rpy="0.3 0.1 0"/>'
        text += f'<axis xyz="{axis}"/><limit lower="-3" upper="3" velocity="1" effort="1"/>'
        text += '<mimic joint="j1" multiplier="-0.5" offset="0.2"/>' if mimics and i > 1 else ""
        text += "</joint>"
    return text + "</robot>"


def robot_of(joints) -> Robot:
    with tempfile.TemporaryDirectory() as folder:
        file = File(folder) / "r.urdf"
        file.write_text(urdf(joints))
        return load_robot(RobotDescription("r", file, PoseDescription()), np.eye(4), {})[0]


@st.composite
def motions(draw):
    robot = robot_of(draw(st.lists(JOINTS, min_size=2, max_size=5)))
    n = len(robot.joint_names)
    numbers = st.floats(-1.2, 1.2)
    rows = draw(st.lists(st.tuples(*[numbers] * n), min_size=2, max_size=3, unique=True))
    return robot, np.array(rows)


BOXES = st.lists(  # how far from where the last link is half-way, and how large
    st.tuples(st.tuples(*[st.floats(-0.25, 0.25)] * 3), st.tuples(*[st.sampled_from([0.004, 0.05, 0.2])] * 3)),
    min_size=1,
    max_size=3,
)


def mesh(made) -> Mesh:
    return Mesh(np.ascontiguousarray(made.vertices, dtype=float), np.asarray(made.faces, dtype=np.int64))


def oracle(first: trimesh.Trimesh, second: trimesh.Trimesh) -> float:
    """The distance of two surfaces; 0 where they cross."""
    models = []
    for one in (first, second):
        model = fcl.BVHModel()
        model.beginModel(len(one.vertices), len(one.faces))
        model.addSubModel(one.vertices, one.faces)
        model.endModel()
        models.append(fcl.CollisionObject(model))
    if fcl.collide(*models, fcl.CollisionRequest(), fcl.CollisionResult()):
        return 0.0
    return fcl.distance(*models, fcl.DistanceRequest(), fcl.DistanceResult())


def between(rows: np.ndarray) -> list[np.ndarray]:
    """Configurations along a path, the way points among them."""
    shares = np.linspace(0, 1, SAMPLES // (len(rows) - 1))
    return [a + s * (b - a) for a, b in itertools.pairwise(rows) for s in shares]


@EXAMPLES
@given(motion=motions(), boxes=BOXES)
def test_what_is_proven_free_is_free_wherever_one_looks(motion, boxes):
    robot, rows = motion
    assume(np.abs(np.diff(rows, axis=0)).max() > 1e-3)  # what does not move was proven by the motion before
    arm = Arm(robot)
    path = Path(arm, rows, np.arange(len(rows), dtype=float))
    name = f"l{len(robot.links) - 1}"
    last = SweptBody(f"r.{name}", surface(robot.links[name].mesh), mount=arm.mounts[name])
    things, shapes = [], []
    middle = link_pose(robot, (rows[0] + rows[1]) / 2, name)[:3, 3]
    for place, size in boxes:
        world_T = np.eye(4)
        world_T[:3, 3] = middle + place
        shapes.append(trimesh.creation.box(size, transform=world_T))
        things.append(SweptBody(f"box_{len(things)}", surface(mesh(trimesh.creation.box(size))), world_T))
    _, left = open_intervals(path, [(last, thing) for thing in things])
    proofs = {pair.second.name: pair.advance(stretches) for pair, stretches in left}
    own = trimesh.Trimesh(robot.links[name].mesh.vertices, robot.links[name].mesh.faces, process=False)
    poses = [link_pose(robot, q, name) for q in between(rows)]
    step = max(np.abs(b - a).sum() for a, b in itertools.pairwise(poses)) * 2
    for thing, shape in zip(things, shapes, strict=True):
        least = min(oracle(own.copy().apply_transform(pose), shape) for pose in poses)
        contact = proofs[thing.name].contact if thing.name in proofs else None
        event("contact" if contact else "near" if least < 0.05 else "far")
        assert contact or least > 0.0, "overlooked a collision"
        assert not contact or least <= step, f"reported a contact, but the least distance is {least}"


@EXAMPLES
@given(motion=motions())
def test_no_point_moves_farther_than_its_bound(motion):
    robot, rows = motion
    arm = Arm(robot)
    configurations = between(rows)
    for name, link in robot.links.items():
        if link.mesh is None:
            continue
        thing = SweptBody(name, surface(link.mesh), mount=arm.mounts[name])
        bound = arm.reach(arm.mounts[name].joint, thing.lever, arm.chains[arm.mounts[name].joint])
        turning = arm.turning(arm.mounts[name].joint)
        before = None
        for q in configurations:
            pose = link_pose(robot, q, name)
            if before is not None:
                points = link.mesh.vertices @ pose[:3, :3].T + pose[:3, 3]
                moved = np.linalg.norm(
                    points - (link.mesh.vertices @ before[1][:3, :3].T + before[1][:3, 3]), axis=1
                )
                assert moved.max() <= np.abs(q - before[0]) @ bound + 1e-9
                cosine = (np.trace(pose[:3, :3] @ before[1][:3, :3].T) - 1) / 2
                assert np.arccos(np.clip(cosine, -1, 1)) <= np.abs(q - before[0]) @ turning + 1e-6
            before = q, pose


@EXAMPLES
@given(motion=motions())
def test_poses_are_those_of_the_reference(motion):
    robot, rows = motion
    arm = Arm(robot)
    for q in rows:
        joints = arm.joint_poses(q)
        for name, pose in link_poses(robot, q).items():
            mount = arm.mounts[name]
            assert np.allclose(joints[mount.joint] @ mount.joint_T_body, pose, atol=1e-12)
