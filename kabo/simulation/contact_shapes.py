"""What bodies and links are in contacts: primitive shapes exactly, meshes as hulls of their convex parts.

The parts that planning uses stick out of a mesh, so that no collision is overlooked; a finger would press on a skin that
is not there. Here each part is replaced by the hull of the mesh's own triangles inside it: it touches where the mesh
does, and only hollows inside one part are bridged; in bodies that mates join to others not even those (`hollows.py`).
"""

import logging
from contextlib import closing
from dataclasses import dataclass
from functools import partial
from itertools import product

import numpy as np

from kabo.arrays import Array
from kabo.children import made_in_children
from kabo.errors import KaboError
from kabo.geometry import bounding_decomposition
from kabo.geometry.collision.tight_parts import tight_part
from kabo.geometry_server.preparation.enclosures import SceneEnclosures
from kabo.geometry_server.preparation.preparing import cores
from kabo.meshes import Mesh, hull_of, volume_of
from kabo.meshes.hulls import hull_faces
from kabo.phases import phase
from kabo.scene import Element, Scene
from kabo.simulation.hollows import unbridged

CONVEX_SHARE = 0.995  # of the volume of its hull, from which a mesh counts as convex
FEW_TRIANGLES = 500  # of a mesh whose parts are soon made
_LOG = logging.getLogger(__name__)
# The digest of a mesh, the tolerance of its parts, the precision, and whether the body is mated:
_Key = tuple[str, float, float | None, bool]


@dataclass(frozen=True)
class ContactShape:
    """A convex shape in the frame of its link or body [m].

    `kind` is MuJoCo's: "box" (size: half lengths), "sphere" (radius), "capsule" and "cylinder" (radius, half length of
    the axis z), each with a `pose` (4, 4); or "mesh", whose `corners` (V, 3) have this shape as their hull.
    """

    kind: str
    size: tuple[float, ...] = ()
    pose: Array | None = None
    corners: Array | None = None


def make_contact_shapes(scene: Scene, precision: float | None = None) -> None:
    """Makes the shapes of all large meshes of a scene in child processes, so that `contact_shapes` finds them.

    Meshes of which none can be made are left to it.

    Args:
        scene: which keeps them.
        precision: as for `contact_shapes`.
    """
    enclosures, made = SceneEnclosures(scene, scene.epsilon), _made_of(scene)
    wanted: dict[_Key, Element] = {}
    for thing in enclosures.things:
        for element in enclosures.elements(thing):
            if _primitive(element) is None and len(element.mesh.faces) > FEW_TRIANGLES:
                wanted[_key(enclosures, element, precision, _is_mated(scene, thing))] = element
    keys = sorted(wanted.keys() - made.keys(), key=lambda key: (-len(wanted[key].mesh.faces), key[0], key[3]))
    if len(keys) < 2:  # this process is as fast
        return
    makes = [partial(_hulls, enclosures, wanted[key], precision, key[3]) for key in keys]
    with (
        phase("making contact shapes", len(keys), "meshes", log=_LOG) as step,
        closing(made_in_children(makes, cores())) as answers,
    ):
        for index, shapes in answers:
            step()
            if not isinstance(shapes, Exception):
                made[keys[index]] = shapes


def contact_shapes(scene: Scene, thing: str, precision: float | None = None) -> list[ContactShape]:
    """The shapes of a body or `robot.link`.

    Args:
        scene: of which it is.
        thing: its name.
        precision: how far parts of meshes may bridge hollows [m]; None: as the parts for planning.

    Raises:
        MeshError: a mesh has no volume, and no hull.
    """
    enclosures = SceneEnclosures(scene, scene.epsilon)
    found: list[ContactShape] = []
    for element in enclosures.elements(thing):
        made = _primitive(element)
        found += [made] if made is not None else _parts(enclosures, element, precision, _is_mated(scene, thing))
    return found


def calm(shape: ContactShape) -> ContactShape:
    """A box as the hull of its corners; any other shape as it is.

    Where two boxes touch, MuJoCo clips one face by the other, and their contacts come and go: blocks in a tower tremble,
    and creep. Hulls touch at points that stay.
    """
    if shape.kind != "box" or shape.pose is None:
        return shape
    signs = np.array(list(product((-1.0, 1.0), repeat=3)))
    return ContactShape("mesh", corners=signs * shape.size @ shape.pose[:3, :3].T + shape.pose[:3, 3])


def _is_mated(scene: Scene, thing: str) -> bool:
    """Whether a mate of the scene joins a body to another one; a body of no model may be meant by any."""
    if thing not in scene.bodies or not scene.mates:
        return False
    own = None if scene.description is None else scene.description.bodies.get(thing)
    return own is None or own.model in {
        name for mate in scene.mates.values() for name in (mate.moving, mate.fixed)
    }


def _primitive(element: Element) -> ContactShape | None:
    corners, rounding = element.corners, element.rounding
    if element.kind == "mesh" or corners is None:
        return None
    if element.kind == "box":
        return _box(corners)
    if rounding is None:
        return None
    if element.kind == "sphere":
        pose = np.eye(4)
        pose[:3, 3] = corners[0]
        return ContactShape("sphere", (rounding.radius,), pose)
    first, last = corners[0], corners[-1]
    length = float(np.linalg.norm(last - first))
    pose = _along(last - first if length > 0.0 else np.asarray(rounding.axis), 0.5 * (first + last))
    return ContactShape(element.kind, (rounding.radius or rounding.disc, 0.5 * length), pose)


def _box(corners: Array) -> ContactShape | None:
    """A box from its eight corners (8, 3): edges from the first corner to those nearest that are at right angles."""
    edges = sorted((corner - corners[0] for corner in corners[1:]), key=lambda edge: float(edge @ edge))
    axes: list[Array] = []
    for edge in edges:
        if all(abs(edge @ axis) <= 1e-9 * np.linalg.norm(edge) * np.linalg.norm(axis) + 1e-15 for axis in axes):
            axes.append(edge)
        if len(axes) == 3:
            break
    if len(axes) < 3:
        return None
    pose, lengths = np.eye(4), [float(np.linalg.norm(axis)) for axis in axes]
    pose[:3, :3] = np.stack([axis / length for axis, length in zip(axes, lengths, strict=True)], axis=1)
    if np.linalg.det(pose[:3, :3]) < 0.0:
        pose[:3, 2] *= -1.0
    pose[:3, 3] = corners.mean(axis=0)
    return ContactShape("box", tuple(0.5 * length for length in lengths), pose)


def _along(axis: Array, middle: Array) -> Array:
    """A pose (4, 4) at a place whose z is along an axis."""
    z = axis / np.linalg.norm(axis)
    x = np.cross(z, np.eye(3)[int(np.argmin(np.abs(z)))])
    x /= np.linalg.norm(x)
    pose = np.eye(4)
    pose[:3, :3] = np.stack([x, np.cross(z, x), z], axis=1)
    pose[:3, 3] = middle
    return pose


def _parts(
    enclosures: SceneEnclosures, element: Element, precision: float | None, mated: bool
) -> list[ContactShape]:
    """The hulls of the parts of a mesh; robots of the same model share them."""
    made, key = _made_of(enclosures.scene), _key(enclosures, element, precision, mated)
    if key not in made:
        made[key] = _hulls(enclosures, element, precision, mated)
    return made[key]


def _made_of(scene: Scene) -> dict[_Key, list[ContactShape]]:
    """The shapes that were made of a scene's meshes."""
    made: dict[_Key, list[ContactShape]] = scene.memory.setdefault("contact shapes", {})
    return made


def _key(enclosures: SceneEnclosures, element: Element, precision: float | None, mated: bool) -> _Key:
    return element.mesh.digest, enclosures.tolerance, precision, mated


def _hulls(
    enclosures: SceneEnclosures, element: Element, precision: float | None, mated: bool
) -> list[ContactShape]:
    mesh = element.mesh
    hull = hull_of(mesh)
    if abs(volume_of(mesh)) >= CONVEX_SHARE * volume_of(hull):
        return [ContactShape("mesh", corners=np.unique(hull.vertices, axis=0))]
    if precision is None:
        enclosure = enclosures.of_element(element)
        parts = [enclosure.parts[number] for number in enclosure.root_parts]
    else:
        return [
            ContactShape("mesh", corners=np.asarray(part))
            for part in bounding_decomposition(mesh, precision).parts
        ]
    if mated and precision is None:
        return [
            ContactShape("mesh", corners=corners)
            for corners in unbridged(mesh, [np.asarray(part) for part in parts])
        ]
    found = [_drawn_tight(mesh, np.asarray(part)) for part in parts]
    return [ContactShape("mesh", corners=corners) for corners in found if corners is not None]


def _drawn_tight(mesh: Mesh, part: Array) -> Array | None:
    """The corners of the hull of what a part holds of a mesh; None if it holds nothing that has a volume."""
    held = tight_part(mesh, part).triangles.reshape(-1, 3)
    if not len(held):
        return None
    points = np.unique(held, axis=0)
    try:
        return np.asarray(points[np.unique(hull_faces(points))])
    except KaboError:  # they lie in a plane
        return None
