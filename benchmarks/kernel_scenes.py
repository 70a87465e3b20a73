"""The two scenes of `kernel.py` as arrays: kabo's two-arm bar, and two Pandas from example-robot-data."""

import sysconfig
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
import numpy.typing as npt
import trimesh

import kabo
from kabo.arrays import Array
from kabo.geometry import Budget, Enclosure, FixedGroup, MovingGroup
from kabo.geometry_server.preparation.enclosures import SceneEnclosures
from kabo.language.scene_description import SceneDescription
from kabo.language.yaml.loading import load_scene_description
from kabo.scene import KinematicTree, load_scene, world_T

Triangles = tuple[Array, npt.NDArray[np.int64]]

ROOT = Path(__file__).resolve().parent.parent
PANDA = Path(sysconfig.get_paths()["purelib"]) / "cmeel.prefix/share/example-robot-data/robots/panda_description"


@dataclass(frozen=True)
class Thing:
    """A link or body: the joint that carries it (0: the world), its pose there, its parts and original mesh."""

    name: str
    joint: int
    pose: Array  # (4, 4)
    enclosure: Enclosure
    mesh: Triangles


@dataclass(frozen=True)
class Arrangement:
    """Both arms in one tree, things that move first, and the pairs to check."""

    name: str
    tree: KinematicTree
    things: tuple[Thing, ...]
    moving: int
    pairs: npt.NDArray[np.int64]  # (P, 2)
    hands: tuple[tuple[int, Array], ...]  # joint, and the tool centre in its frame
    front: float  # x of the bases: hands of the `near` set are beyond [m]
    swept: npt.NDArray[np.int64]  # the values of q that a segment changes: the first arm
    geometry: float  # the budget's share for each body [m]

    @property
    def groups(self) -> tuple[list[MovingGroup], list[FixedGroup]]:
        """What a view takes."""
        flat = [np.concatenate([thing.pose[:3, :3].ravel(), thing.pose[:3, 3]]) for thing in self.things]
        rows = list(zip(self.things, flat, strict=True))
        moving = [MovingGroup(t.joint, pose, t.enclosure, t.mesh) for t, pose in rows[: self.moving]]
        return moving, [FixedGroup(pose, t.enclosure, t.mesh) for t, pose in rows[self.moving :]]

    @property
    def size(self) -> str:
        """How large it is, in words."""
        parts = [len(thing.enclosure.parts) for thing in self.things]
        products = sum(parts[i] * parts[k] for i, k in self.pairs)
        triangles = sum(len(thing.mesh[1]) for thing in self.things)
        return f"{sum(parts)} parts, {len(self.pairs)} pairs ({products} of parts), {triangles} triangles"

    def full(self) -> "Arrangement":
        """This arrangement as if every body used up its share: sweeps have no slack but their own."""
        used = [replace(t, enclosure=replace(t.enclosure, deviation=self.geometry)) for t in self.things]
        return replace(self, things=tuple(used))

    def expand(self, q: Array) -> Array:
        """The value of every joint but the world's (J-1,)."""
        tree = self.tree
        return np.ascontiguousarray(tree.ratio[1:] * q[tree.source[1:]] + tree.shift[1:])


def _arrange(
    name: str,
    tree: KinematicTree,
    things: Sequence[Thing],
    checked: Callable[[str, str], bool],
    **others: object,
) -> Arrangement:
    ordered = sorted(things, key=lambda thing: thing.joint == 0)
    moving = sum(thing.joint > 0 for thing in ordered)
    pairs = [
        (i, k)
        for i in range(moving)
        for k in range(i + 1, len(ordered))
        if checked(ordered[i].name, ordered[k].name)
    ]
    return Arrangement(name, tree, tuple(ordered), moving, np.array(pairs, np.int64), **others)  # type: ignore[arg-type]


def joined(first: KinematicTree, second: KinematicTree) -> KinematicTree:
    """Two robots in one tree: the second's joints and values behind the first's, the world shared."""
    joints, size = len(first.parent), first.size
    parent = np.where(second.parent[1:] > 0, second.parent[1:] + joints - 1, 0)
    return KinematicTree(
        np.concatenate([first.parent, parent]),
        np.concatenate([first.kind, second.kind[1:]]),
        np.concatenate([first.source, second.source[1:] + size]),
        *(np.concatenate([getattr(first, f), getattr(second, f)[1:]]) for f in ("ratio", "shift", "placement")),
        *(np.concatenate([getattr(first, f), getattr(second, f)]) for f in ("lower", "upper", "velocity")),
    )


# Scenes ---------------------------------------------------------------------------------------------------------------


def bar() -> Arrangement:
    """BARTENDER with four bottles."""
    problem = kabo.load_problem(ROOT / "domains" / "bartender" / "four_bottles.yaml")
    return _of_scene("bar with two arms", problem.scene, [0.0, 0.0, 0.13], front=-0.3)


PANDAS = """scene: pandas
epsilon: 0.01
packages: {{example-robot-data: installed}}
robots:
  left: {{model: panda, base: {{position: [0, -0.45, 0]}}}}
  right: {{model: panda, base: {{position: [0, 0.45, 0]}}}}
robot_models:
  panda:
    urdf: package://example-robot-data/robots/panda_description/urdf/panda.urdf
    srdf: package://example-robot-data/robots/panda_description/srdf/panda.srdf
    joints: [panda_joint1, panda_joint2, panda_joint3, panda_joint4, panda_joint5, panda_joint6, panda_joint7]
    tool: {{frame: panda_hand}}
objects:
{objects}"""


def pandas() -> Arrangement:
    """Two Pandas of example-robot-data on a table with six objects, as a scene loads them.

    Raises:
        FileNotFoundError: the extra `robots` is not installed.
    """
    if not PANDA.is_dir():
        raise FileNotFoundError("the Pandas come with example-robot-data: pip install '.[robots]'")
    with TemporaryDirectory() as folder:
        lines = []
        for name, mesh in _objects().items():
            mesh.export(Path(folder) / f"{name}.stl")
            lines.append(f"  {name}: {{mesh: {name}.stl}}\n")
        path = Path(folder) / "pandas.yaml"
        path.write_text(PANDAS.format(objects="".join(lines)))
        return _of_scene("two Pandas", load_scene_description(path), [0.0, 0.0, 0.1], front=0.0)


def _of_scene(name: str, description: SceneDescription | None, tool: Sequence[float], front: float) -> Arrangement:
    """All links and bodies of a scene with two robots, with the parts that planning would use."""
    assert description is not None
    scene = load_scene(description)
    enclosures = SceneEnclosures(scene, Budget.share(scene.epsilon).geometry)
    left, right = scene.robots.values()
    things, hands = [], []
    for robot, shift in ((left, 0), (right, len(left.tree.parent) - 1)):
        for link in robot.links.values():
            joint = link.joint + shift if link.joint else 0
            if link.mesh is not None:
                own = f"{robot.name}.{link.name}"
                mesh = link.mesh.vertices, link.mesh.faces
                things.append(Thing(own, joint, link.joint_T_link, enclosures.of(own), mesh))
        held = robot.links[robot.tool.frame]
        hands.append((held.joint + shift, (held.joint_T_link @ [*tool, 1.0])[:3]))
    for own, body in scene.bodies.items():
        mesh = body.mesh.vertices, body.mesh.faces
        things.append(Thing(own, 0, world_T(scene, scene.start, own), enclosures.of(own), mesh))
    return _arrange(
        name,
        joined(left.tree, right.tree),
        things,
        lambda a, b: not scene.never_collide(a, b),
        hands=tuple(hands),
        front=front,
        swept=np.arange(left.planned),
        geometry=enclosures.tolerance,
    )


def _objects() -> dict[str, trimesh.Trimesh]:
    """The meshes of six objects and the table, as they stand in the world."""
    box, cylinder, annulus = (getattr(trimesh.creation, name) for name in ("box", "cylinder", "annulus"))
    pieces = {
        "bearing": ([annulus(0.02, 0.045, 0.03, sections=96)], (0.55, -0.25, 0.016)),
        "pipe": ([annulus(0.03, 0.04, 0.2, sections=96)], (0.45, 0.25, 0.101)),
        "bottle": (
            [
                cylinder(0.035, 0.09, sections=64),
                cylinder(0.035, 0.09, sections=64),
                cylinder(0.015, 0.1, sections=48),
            ],
            (0.6, 0.05, 0.091),
        ),
        "tee": ([box([0.2, 0.04, 0.04]), box([0.04, 0.04, 0.16])], (0.35, 0.0, 0.021)),
        "ball": ([trimesh.creation.icosphere(subdivisions=4, radius=0.05)], (0.7, 0.3, 0.058)),
        "bracket": (
            [box([0.16, 0.06, 0.02]), box([0.02, 0.06, 0.14]), cylinder(0.02, 0.1, sections=64)],
            (0.65, -0.1, 0.011),
        ),
        "table": ([box([1.4, 1.6, 0.05])], (0.35, 0.0, -0.025)),
    }
    shifts = {
        "bottle": ((0, 0, -0.045), (0, 0, 0.045), (0, 0, 0.13)),
        "tee": ((0, 0, 0), (0, 0, 0.1)),
        "bracket": ((0, 0, 0), (0.07, 0, 0.06), (-0.06, 0, 0.05)),
    }
    made = {}
    for name, (meshes, position) in pieces.items():
        for mesh, shift in zip(meshes, shifts.get(name, ((0, 0, 0),)), strict=True):
            mesh.apply_translation(np.add(position, shift))
        made[name] = trimesh.util.concatenate(meshes)
    return made


def scenes(which: str) -> list[Arrangement]:
    """The scenes to measure: `generated`, `pandas` or `both`."""
    makers = {"generated": [bar], "pandas": [pandas], "both": [bar, pandas]}
    return [make() for make in makers[which]]
