"""Masses and inertias: of the URDF where it has them, of meshes with a density where nobody has written any."""

from dataclasses import dataclass

import numpy as np

from kabo.arrays import Array
from kabo.content_cache import ContentCache
from kabo.errors import KaboError
from kabo.meshes import Mesh, hull_of, volume_of
from kabo.scene import Body, Robot
from kabo.scene.transforms import inverse
from kabo.simulation.bearable import PointMasses, bearable_share
from kabo.simulation.settings import PhysicsSettings

LEAST_MASS = 0.02  # [kg] of what moves: less than that is no link of a robot
LEAST_INERTIA = 1e-6  # [kg m²]

CACHE_BYTES = 1 << 18


@dataclass(frozen=True)
class Mass:
    """A mass [kg] with its centre (3,) [m] and its inertia (3, 3) about it [kg m²], in the axes of some frame."""

    mass: float
    centre: Array
    inertia: Array

    def with_mass(self, mass: float) -> "Mass":
        """The same shape of another density."""
        return Mass(mass, self.centre, self.inertia * (mass / self.mass))

    def moved(self, pose: Array) -> "Mass":
        """As seen from a frame in which its own frame has a pose (4, 4)."""
        turn = pose[:3, :3]
        return Mass(self.mass, turn @ self.centre + pose[:3, 3], turn @ self.inertia @ turn.T)

    def joined(self, other: "Mass") -> "Mass":
        """Both as one body [Huygens, Steiner]."""
        total = self.mass + other.mass
        centre = (self.mass * self.centre + other.mass * other.centre) / total
        parts = (each.inertia + each.mass * _about(each.centre - centre) for each in (self, other))
        return Mass(total, centre, sum(parts, np.zeros((3, 3))))

    def usable(self) -> "Mass":
        """The nearest mass that moves at all: no principal inertia is below the least, nor above the sum of the others."""
        values, axes = np.linalg.eigh(0.5 * (self.inertia + self.inertia.T))
        values = np.maximum(values, LEAST_INERTIA)
        values[2] = min(values[2], values[0] + values[1])
        return Mass(max(self.mass, LEAST_MASS), self.centre, axes @ np.diag(values) @ axes.T)


def _about(offset: Array) -> Array:
    return np.asarray(float(offset @ offset) * np.eye(3) - np.outer(offset, offset))


_MADE: ContentCache[Mass | None] = ContentCache(CACHE_BYTES, lambda made: 256)


def of_mesh(mesh: Mesh, density: float) -> Mass | None:
    """The mass of what a mesh encloses, or of its hull if it encloses little; None: it is flat.

    Integrals over tetrahedra from the origin to each triangle [Tonon 2004].
    """
    return _MADE.get_or_make((mesh.digest, density), lambda: _of_mesh(mesh, density))


def _of_mesh(mesh: Mesh, density: float) -> Mass | None:
    try:
        hull = hull_of(mesh)
    except KaboError:
        return None
    solid = mesh if abs(volume_of(mesh)) > 0.05 * volume_of(hull) else hull
    corners = solid.vertices[solid.faces]  # (F, 3, 3)
    volumes = np.einsum("ij,ij->i", corners[:, 0], np.cross(corners[:, 1], corners[:, 2])) / 6.0
    total = float(volumes.sum())
    centre = np.einsum("i,ij->j", volumes, corners.sum(axis=1)) / (4.0 * total)
    sums = corners.sum(axis=1)
    seconds = np.einsum("i,iaj,iak->jk", volumes, corners, corners) + np.einsum("i,ij,ik->jk", volumes, sums, sums)
    spread = seconds / 20.0 - total * np.outer(centre, centre)  # of x xᵀ about the centre
    inertia = np.trace(spread) * np.eye(3) - spread
    return Mass(density * abs(total), centre, inertia * density * np.sign(total))


def mass_of_body(body: Body, settings: PhysicsSettings) -> Mass:
    """The mass of a movable body: as the scene says, or by density; spread over its shape evenly."""
    found = of_mesh(body.mesh, settings.body_density) or Mass(LEAST_MASS, np.zeros(3), LEAST_INERTIA * np.eye(3))
    return (found if body.mass is None else found.with_mass(body.mass)).usable()


def masses_of_joints(robot: Robot, settings: PhysicsSettings) -> list[Mass]:
    """What each joint of the tree carries without another joint between, in the joint's frame, whose z is its axis.

    Of joints whose URDF has no inertia, the mass of the links' shapes; lighter, where motors could not carry that.
    """
    found: list[Mass] = []
    turns, guessed = _turns(robot), []
    for joint in range(robot.model.njoints):
        given = robot.model.inertias[joint]
        if given.mass > 0.0 and joint in turns:
            own = Mass(float(given.mass), np.asarray(given.lever), np.asarray(given.inertia))
            found.append(own.moved(turns[joint]).usable())
            continue
        guessed.append(joint)
        shaped = [
            mass.moved(link.joint_T_link)
            for link in robot.links.values()
            if link.joint == joint and link.mesh is not None
            for mass in [of_mesh(link.mesh, settings.link_density)]
            if mass is not None
        ]
        total = Mass(LEAST_MASS, np.zeros(3), LEAST_INERTIA * np.eye(3)) if not shaped else shaped[0]
        for each in shaped[1:]:
            total = total.joined(each)
        found.append(total.usable())
    if not guessed:
        return found
    points = PointMasses(
        np.array([each.mass for each in found]),
        np.array([each.centre for each in found]),
        np.isin(np.arange(len(found)), guessed),
    )
    share = bearable_share(robot, points)
    for joint in guessed if share < 1.0 else ():
        found[joint] = found[joint].with_mass(share * found[joint].mass).usable()
    return found


def _turns(robot: Robot) -> dict[int, Array]:
    """Of each joint that has a link, the pose (4, 4) of pinocchio's frame in the frame whose z is the axis."""
    found: dict[int, Array] = {}
    for frame in robot.model.frames:
        if frame.name in robot.links and frame.parentJoint not in found:
            found[frame.parentJoint] = robot.links[frame.name].joint_T_link @ inverse(frame.placement.homogeneous)
    return found
