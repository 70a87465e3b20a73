"""The two scenes of `kernel.py` as arrays: kabo's two-arm bar, and two Pandas from example-robot-data."""

import re
import sysconfig
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
import numpy.typing as npt
import trimesh

import kabo
from kabo.arrays import Array
from kabo.errors import MeshError
from kabo.geometry import Enclosure, FixedGroup, MovingGroup, enclosing_parts
from kabo.meshes import hull_of, load_mesh
from kabo.scene import REVOLUTE, KinematicTree, Mesh, load_scene, world_T

Triangles = tuple[Array, npt.NDArray[np.int64]]

ROOT = Path(__file__).resolve().parent.parent
PANDA = Path(sysconfig.get_paths()["purelib"]) / "cmeel.prefix/share/example-robot-data/robots/panda_description"
PANDA_LINKS = (*(f"panda_link{i}" for i in range(8)), "panda_hand", "panda_leftfinger", "panda_rightfinger")
PANDA_TOLERANCE = 0.004  # metres: what epsilon = 1 cm leaves to each body


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


# The bar ------------------------------------------------------------------------------------------------------------


def bar() -> Arrangement:
    """BARTENDER with four bottles: all links and bodies, parts for its own epsilon."""
    scene = load_scene(kabo.load_problem(ROOT / "domains" / "bartender" / "four_bottles.yaml").scene)
    geometry = 0.4 * scene.epsilon
    made: dict[str, Enclosure] = {}
    left, right = scene.robots.values()
    things, hands = [], []
    for robot, shift in ((left, 0), (right, len(left.tree.parent) - 1)):
        for link in robot.links.values():
            joint = link.joint + shift if link.joint else 0
            if link.mesh is not None:
                name = f"{robot.name}.{link.name}"
                things.append(_thing(name, joint, link.joint_T_link, link.mesh, geometry, made))
        tool = robot.links[robot.tool.frame]
        hands.append((tool.joint + shift, (tool.joint_T_link @ [0.0, 0.0, 0.13, 1.0])[:3]))
    for name, body in scene.bodies.items():
        things.append(_thing(name, 0, world_T(scene, scene.start, name), body.mesh, geometry, made))
    return _arrange(
        "bar with two arms",
        joined(left.tree, right.tree),
        things,
        lambda a, b: not scene.never_collide(a, b),
        hands=tuple(hands),
        front=-0.3,
        swept=np.arange(left.planned),
        geometry=geometry,
    )


def _thing(name: str, joint: int, pose: Array, mesh: Mesh, tolerance: float, made: dict[str, Enclosure]) -> Thing:
    if mesh.digest not in made:
        made[mesh.digest] = enclosing_parts(mesh, tolerance)
    return Thing(name, joint, pose, made[mesh.digest], (mesh.vertices, mesh.faces))


# Two Pandas ---------------------------------------------------------------------------------------------------------


def pandas() -> Arrangement:
    """Two Pandas on a table with six objects, as a scene has them: the links' collision meshes, hulls of open ones.

    Raises:
        FileNotFoundError: the extra `robots` is not installed.
    """
    if not PANDA.is_dir():
        raise FileNotFoundError("the Pandas come with example-robot-data: pip install '.[robots]'")
    model = _panda_model()
    trees = [_tree(model, np.array([0.0, y, 0.0])) for y in (-0.45, 0.45)]
    links = {name: _panda_link(name) for name in PANDA_LINKS}
    things, hands = [], []
    for side, shift in (("L", 0), ("R", model.njoints - 1)):
        base = np.eye(4)
        base[1, 3] = -0.45 if side == "L" else 0.45
        for name, (enclosure, mesh) in links.items():
            frame = model.frames[model.getFrameId(name)]
            pose = frame.placement.homogeneous if frame.parentJoint else base @ frame.placement.homogeneous
            joint = frame.parentJoint + shift if frame.parentJoint else 0
            things.append(Thing(f"{side}.{name}", joint, pose, enclosure, mesh))
        hand = model.frames[model.getFrameId("panda_hand")]
        hands.append((hand.parentJoint + shift, (hand.placement.homogeneous @ [0.0, 0.0, 0.1, 1.0])[:3]))
    things += [Thing(name, 0, np.eye(4), *made) for name, made in _objects().items()]
    disabled = set()
    for a, b in re.findall(
        r'disable_collisions link1="(\w+)" link2="(\w+)"', (PANDA / "srdf/panda.srdf").read_text()
    ):
        disabled |= {(a, b), (b, a)}

    def checked(first: str, second: str) -> bool:
        side, _, link = first.partition(".")
        other, dot, other_link = second.partition(".")
        return not dot or side != other or (link, other_link) not in disabled

    return _arrange(
        "two Pandas",
        joined(*trees),
        things,
        checked,
        hands=tuple(hands),
        front=0.0,
        swept=np.arange(trees[0].size),
        geometry=PANDA_TOLERANCE,
    )


def _panda_model():  # type: ignore[no-untyped-def]
    import pinocchio as pin

    model = pin.buildModelFromUrdf(str(PANDA / "urdf/panda.urdf"))
    q = pin.neutral(model)
    q[7:] = 0.04
    fingers = [model.getJointId(f"panda_finger_joint{i}") for i in (1, 2)]
    return pin.buildReducedModel(model, fingers, q)


def _tree(model, base: Array) -> KinematicTree:  # type: ignore[no-untyped-def]
    """The tree of a model whose joints all turn about z."""
    count = model.njoints
    placement = np.array([np.concatenate([m.rotation.ravel(), m.translation]) for m in model.jointPlacements])
    placement[0] = np.concatenate([np.eye(3).ravel(), np.zeros(3)])
    placement[1, 9:] += base
    ratio = np.ones(count)
    ratio[0] = 0.0
    return KinematicTree(
        np.array(list(model.parents), np.int64),
        np.full(count, REVOLUTE, np.int64),
        np.array([0, *range(count - 1)], np.int64),
        ratio,
        np.zeros(count),
        placement,
        model.lowerPositionLimit.copy(),
        model.upperPositionLimit.copy(),
        model.velocityLimit.copy(),
    )


def _panda_link(name: str) -> tuple[Enclosure, Triangles]:
    file = name.removeprefix("panda_").replace("left", "").replace("right", "")
    mesh = load_mesh(PANDA / "meshes/collision" / f"{file}.stl")
    try:
        made = enclosing_parts(mesh, PANDA_TOLERANCE)
    except MeshError:  # it is open, and has no inside
        made = enclosing_parts(hull_of(mesh), PANDA_TOLERANCE)
    return made, (mesh.vertices, mesh.faces)


def _triangles(mesh: trimesh.Trimesh) -> Triangles:
    return np.ascontiguousarray(mesh.vertices, np.float64), np.ascontiguousarray(mesh.faces, np.int64)


def _objects() -> dict[str, tuple[Enclosure, Triangles]]:
    """Six objects and the table, as they stand in the world."""
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
        whole = trimesh.util.concatenate(meshes)
        triangles = _triangles(whole)
        made[name] = enclosing_parts(Mesh(*triangles), PANDA_TOLERANCE), triangles
    return made


def scenes(which: str) -> list[Arrangement]:
    """The scenes to measure: `generated`, `pandas` or `both`."""
    makers = {"generated": [bar], "pandas": [pandas], "both": [bar, pandas]}
    return [make() for make in makers[which]]
