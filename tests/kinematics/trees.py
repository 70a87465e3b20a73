"""Trees for tests, and what pinocchio and plain geometry say about them: nothing here is kabo's own arithmetic."""

from dataclasses import dataclass

import numpy as np
import pinocchio as pin

from kabo.kinematics import FrameFeature
from kabo.scene.tree import KinematicTree


@dataclass(frozen=True)
class Twin:
    """A tree of kabo and the pinocchio model of the same joints."""

    tree: KinematicTree
    model: pin.Model

    def poses(self, q):
        """The pose of each joint in the world, by pinocchio."""
        tree, data = self.tree, self.model.createData()
        full = np.array([tree.ratio[j] * q[tree.source[j]] + tree.shift[j] for j in range(1, len(tree.parent))])
        pin.forwardKinematics(self.model, data, full)
        return [pin.SE3(M) for M in data.oMi]

    def jacobian(self, q, joint):
        """The (6, n) derivative of a joint's frame, linear over angular, along the world's axes."""
        tree, data = self.tree, self.model.createData()
        full = np.array([tree.ratio[j] * q[tree.source[j]] + tree.shift[j] for j in range(1, len(tree.parent))])
        pin.computeJointJacobians(self.model, data, full)
        J = pin.getJointJacobian(self.model, data, joint, pin.LOCAL_WORLD_ALIGNED)
        result = np.zeros((6, tree.size))
        for j in range(1, len(tree.parent)):
            result[:, tree.source[j]] += tree.ratio[j] * J[:, j - 1]
        return result


def twin(joints, limits=3.0):
    """A tree from (parent, kind, placement, source, ratio, shift) of each joint, for kabo and for pinocchio."""
    model, count = pin.Model(), len(joints) + 1
    arrays = [np.zeros(count, np.int64) for _ in range(3)] + [
        np.zeros(count),
        np.zeros(count),
        np.zeros((count, 12)),
    ]
    arrays[5][0, [0, 4, 8]] = 1.0
    for j, (parent, kind, placement, source, ratio, shift) in enumerate(joints, 1):
        joint = pin.JointModelRZ() if kind == 0 else pin.JointModelPZ()
        model.addJoint(parent, joint, placement, f"j{j}")
        row = np.concatenate([placement.rotation.ravel(), placement.translation])
        for array, value in zip(arrays, (parent, kind, source, ratio, shift, row), strict=True):
            array[j] = value
    n = int(arrays[2].max()) + 1
    bounds = np.broadcast_to(np.asarray(limits, np.float64), (n,)).copy()
    return Twin(KinematicTree(*arrays, -bounds, bounds, np.ones(n)), model)


def placement(rng, size=0.3):
    """A random pose with a translation of about the given size."""
    return pin.SE3(pin.exp3(rng.normal(size=3)), rng.uniform(-size, size, 3))


def two_arms(seed=0, joints=7):
    """Two arms on one column that turns, with a mimic joint in the first and a sliding joint in the second."""
    rng = np.random.default_rng(seed)
    parts = [(0, 0, placement(rng), 0, 1.0, 0.0)]
    for arm in range(2):
        parent = 1
        for k in range(joints):
            source, ratio, shift = len({p[3] for p in parts}), 1.0, 0.0
            kind = 1 if arm == 1 and k == 1 else 0
            if arm == 0 and k == 3:
                source, ratio, shift = parts[-1][3], -0.5, 0.2
            parts.append((parent, kind, placement(rng), source, ratio, shift))
            parent = len(parts)
    return twin(parts)


def seven_axes():
    """A 7-axis arm of the usual build, 1.2 m long, whose tool frame is joint 7 and points along its z."""
    turn = [0.0, -np.pi / 2, np.pi / 2, np.pi / 2, -np.pi / 2, np.pi / 2, np.pi / 2]
    offset = [(0, 0, 0.33), (0, 0, 0), (0, -0.32, 0), (0.08, 0, 0), (-0.08, 0.38, 0), (0, 0, 0), (0.09, 0, 0)]
    chain = [
        (j, 0, pin.SE3(pin.exp3(np.array([angle, 0.0, 0.0])), np.array(t)), j, 1.0, 0.0)
        for j, (angle, t) in enumerate(zip(turn, offset, strict=True))
    ]
    return twin(chain, limits=[2.9, 1.8, 2.9, 3.0, 2.9, 3.5, 2.9])


def planar(joints=2, length=1.0, limits=3.2):
    """Joints that turn about z in a plane, each link along x."""
    step = pin.SE3(np.eye(3), np.array([length, 0.0, 0.0]))
    return twin([(j, 0, step if j else pin.SE3.Identity(), j, 1.0, 0.0) for j in range(joints)], limits)


def world_feature(feature: FrameFeature, poses):
    """The origin and direction of a feature in the world."""
    M = poses[feature.joint]
    direction = None if feature.direction is None else M.rotation @ np.array(feature.direction)
    return M.act(np.array(feature.origin)), direction


def violation(kind, first, second, lower, upper, poses):
    """How far a constraint is from being fulfilled [m or rad, the larger], by plain geometry.

    Source: docs/explanation/sampling.md.
    """
    (p, d), (r, e) = world_feature(first, poses), world_feature(second, poses)
    shapes = first.kind, second.kind
    apart = None
    if d is not None and e is not None:
        apart = float(np.arctan2(np.linalg.norm(np.cross(d, e)), d @ e))
    either = None if apart is None else min(apart, np.pi - apart)
    if kind == "height":
        return outside(float(e @ (p - r)), lower, upper)
    if kind == "distance":
        return outside(separation(p, shapes[1], r, e), lower, upper)
    if kind == "angle":
        return outside(apart, lower, upper)
    if kind == "coincident":
        gap = separation(p, shapes[1], r, e)
        return gap if first.kind == "point" else max(gap, either)
    mixed = set(shapes) == {"line", "plane"}
    if kind == "parallel":
        return abs(np.pi / 2 - apart) if mixed else either
    if kind == "perpendicular":
        return either if mixed else abs(np.pi / 2 - apart)
    return apart if kind == "aligned" else np.pi - apart


def separation(p, shape, r, e):
    """The distance of a point from a point, a line or a plane."""
    if shape == "point":
        return float(np.linalg.norm(p - r))
    return float(np.linalg.norm(np.cross(e, p - r))) if shape == "line" else abs(float(e @ (p - r)))


def outside(value, lower, upper):
    """How far a value is outside its bounds."""
    return max(
        0.0, (lower if lower is not None else -np.inf) - value, value - (upper if upper is not None else np.inf)
    )
